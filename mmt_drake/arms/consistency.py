"""Inertial numbers that a real body can have: the nearest to those that a fit found."""

from __future__ import annotations

import numpy as np
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from mmt_drake.errors import MmtError
from mmt_drake.numeric.arrays import Array

_LEAST = 1e-6
"""Least eigenvalue of a link's pseudo-inertia, each of its axes in a unit of its own."""
_SMALL = 1e-6
"""Units of second moments are no smaller than this part of the greatest one, or of the mass."""


def pseudo_inertia(numbers: Array) -> Array:
    """The pseudo-inertia of a link's ten numbers, (4, 4): positive definite for every body that can be.

    Wensing, Kim and Slotine 2018, IEEE Robotics and Automation Letters 3(1).
    """
    m, x, y, z, xx, yy, zz, xy, xz, yz = numbers
    half = 0.5 * (xx + yy + zz)
    return np.array([[half - xx, -xy, -xz, x], [-xy, half - yy, -yz, y], [-xz, -yz, half - zz, z], [x, y, z, m]])


def is_consistent(numbers: Array) -> bool:
    """Whether a body can have these ten numbers."""
    return bool(np.linalg.eigvalsh(pseudo_inertia(numbers)).min() > 0.0)


def nearest_consistent(found: Array, weight: Array, believed: Array) -> Array:
    """The consistent numbers nearest to those found, (links, 10).

    Args:
        found: (links, 10).
        weight: (10 links, 10 links) how dear the square of a step away from these is.
        believed: (links, 10), sizes of the links.

    Raises:
        MmtError: the solver finds none.
    """
    if all(is_consistent(numbers) for numbers in found):
        return found
    program = MathematicalProgram()
    steps = program.NewContinuousVariables(found.size, "step")
    scale = 1.0 / np.sqrt(np.maximum(np.diag(weight), 1e-12 * np.diag(weight).max()))
    matrix = weight * np.outer(scale, scale)
    program.AddQuadraticCost(matrix + 1e-9 * np.eye(found.size), np.zeros(found.size), steps, is_convex=True)
    basis = [pseudo_inertia(row) for row in np.eye(10)]
    for link, numbers in enumerate(found):
        # Mass and moments in units of their own: moments of a body as small as a hand are a thousandth of its mass.
        diagonal = np.abs(np.diag(pseudo_inertia(believed[link])))
        unit = np.sqrt(np.maximum(diagonal, max(_SMALL * float(diagonal.max()), 1e-9)))
        units = np.outer(unit, unit)
        own = slice(10 * link, 10 * link + 10)
        whole = pseudo_inertia(numbers) / units - _LEAST * np.eye(4)
        parts = [basis[i] * scale[own][i] for i in range(10)]
        program.AddLinearMatrixInequalityConstraint([whole, *(part / units for part in parts)], steps[own])
    result = ClarabelSolver().Solve(program)
    if not result.is_success():
        raise MmtError("no consistent inertial numbers were found near those of the fit")
    moved: Array = found + (result.GetSolution(steps) * scale).reshape(found.shape)
    return moved
