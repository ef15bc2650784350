"""Bounded least squares by Levenberg and Marquardt, for residuals that a simulation gives.

SciPy's solver is not used because a search wants what it does not offer: a few steps only, from many starts, with the
derivatives after the known parameters carried over from the fit that came before instead of simulated again.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mmt_drake.errors import MmtError
from mmt_drake.numeric.arrays import Array, Flags

_DIFFERENCE = 1e-3  # of a parameter's scale: friction makes a residual rough below that
_WIDE = 0.03  # the same after a parameter in which the residual is rougher
CONVERGED = 3e-4  # relative decrease of the sum of squares
_LONGEST = 2.0  # of a parameter's scale: the longest step
_LEAST_LEFT = 0.3
"""In one step a parameter that is positive keeps so much of itself: a scale of speed or time that is thrown to next to
nothing is one that the data say no more of."""
_MOST_DAMPING, _TRUSTED = 1e8, 64.0
"""The most damping; and by so much it may grow before a Jacobian that was carried on is given up."""
_IDLE = 1e-4
"""A parameter is left where it is while even the longest step of it would change the residual by no more than this part
of it: its Gauss-Newton step, nothing over nothing, would dwarf all others."""


@dataclass(frozen=True)
class Minimum:
    """The end of a fit by least squares.

    Attributes:
        x: (k,) the parameters.
        residual: (n,) there.
        jacobian: (n, k) there, or near by where columns were carried over.
        converged: whether the last step changed next to nothing.
        simulations: how often the residual was evaluated.
    """

    x: Array
    residual: Array
    jacobian: Array
    converged: bool
    simulations: int

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.residual @ self.residual)


def minimise(
    residual: Callable[[Array], Array],
    start: Array,
    low: Array,
    high: Array,
    scale: Array,
    *,
    steps: int = 30,
    known: Array | None = None,
    pull: Array | None = None,
    converged_at: float = CONVERGED,
    secant: bool = False,
    rough: Flags | None = None,
) -> Minimum:
    """Least squares within bounds.

    Args:
        residual: x (k,) -> (n,). A `MmtError`, or a number that is not finite, counts as a step too far.
        start: (k,) within the bounds.
        low, high: (k,) bounds.
        scale: (k,) natural size of each parameter.
        steps: at most so many.
        known: (n, k) derivatives that are used as they are; NaN in the columns of the others.
        pull: (k,) slope of a term, linear in x, that is minimised beside half the sum of squares; none by default.
        converged_at: relative decrease of the sum of squares in a step, below which the fit ends.
        secant: whether the Jacobian is carried on from step to step (Broyden's rank-one update) and simulated anew
            only where it leads no further. A step then costs one simulation in the place of k + 1; where the fit ends
            the Jacobian is near by.
        rough: (k,) parameters in which the residual is rough: derivatives after them are taken over wide differences,
            and over the usual ones from where these lead no further; none by default.

    Raises:
        MmtError: the residual cannot be evaluated at the start.
    """
    x = np.clip(start, low, high)
    spans = np.full(len(x), _DIFFERENCE)
    if rough is not None:
        spans[rough] = _WIDE
    r = _attempt(residual, x)
    if r is None:
        raise MmtError("the simulation diverges at the start of a fit")
    uphill = np.zeros(len(x)) if pull is None else 2.0 * pull
    cost = float(r @ r + uphill @ x)
    simulations, damping, converged = 1, 1e-3, False
    jacobian = np.zeros((len(r), len(x)))
    carried = False
    for _ in range(steps):
        if not carried:
            simulations += _differences(residual, x, r, low, high, scale, spans, known, jacobian)
        gradient = jacobian.T @ r + 0.5 * uphill * scale
        held = ((x <= low) & (gradient > 0.0)) | ((x >= high) & (gradient < 0.0))
        idle = _LONGEST * np.linalg.norm(jacobian, axis=0) <= _IDLE * np.linalg.norm(r)
        free = ~(held | idle)
        active = jacobian[:, free]
        normal = active.T @ active
        size = np.maximum(np.diag(normal), 1e-300)
        better: tuple[Array, Array] | None = None
        most_damping = min(_MOST_DAMPING, _TRUSTED * damping) if carried else _MOST_DAMPING
        while free.any() and better is None and damping < most_damping:
            step = np.linalg.solve(normal + damping * np.diag(size), -gradient[free])
            step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
            candidate = x.copy()
            lowest = np.where(low > 0.0, np.maximum(low, _LEAST_LEFT * x), low)
            candidate[free] = np.clip(x[free] + scale[free] * step, lowest[free], high[free])
            r_candidate = _attempt(residual, candidate)
            simulations += 1
            if r_candidate is not None and float(r_candidate @ r_candidate + uphill @ candidate) < cost:
                better = candidate, r_candidate
            else:
                damping *= 8.0
        simulated, carried = not carried, False
        if better is not None:
            moved, change = (better[0] - x) / scale, better[1] - r
            x, r = better
            left = float(r @ r + uphill @ x)
            decrease, cost = cost - left, left
            damping = max(damping / 6.0, 1e-9)
            if decrease >= converged_at * float(r @ r):
                carried = secant
                if carried:
                    jacobian += np.outer(change - jacobian @ moved, moved / (moved @ moved))
                continue
        if simulated:
            if (spans == _DIFFERENCE).all():
                converged = True
                break
            spans[:], damping = _DIFFERENCE, 1e-3
    return Minimum(x, r, jacobian / scale, converged, simulations)


def stay(residual: Callable[[Array], Array], x: Array, low: Array, high: Array, scale: Array) -> Minimum:
    """No step at all: residual and derivatives at x; arguments and errors as `minimise`."""
    r = _attempt(residual, x)
    if r is None:
        raise MmtError("the simulation diverges at the start of a fit")
    jacobian = np.zeros((len(r), len(x)))
    count = _differences(residual, x, r, low, high, scale, np.full(len(x), _DIFFERENCE), None, jacobian)
    return Minimum(x, r, jacobian / scale, False, 1 + count)


def _attempt(residual: Callable[[Array], Array], x: Array) -> Array | None:
    try:
        r = residual(x)
    except (MmtError, RuntimeError):
        return None
    return r if np.isfinite(r @ r) else None


def _differences(
    residual: Callable[[Array], Array],
    x: Array,
    r: Array,
    low: Array,
    high: Array,
    scale: Array,
    spans: Array,
    known: Array | None,
    jacobian: Array,
) -> int:
    """Fill the derivatives after x / scale by one-sided differences of `spans`; returns the number of simulations."""
    count = 0
    for j in range(len(x)):
        if known is not None and np.isfinite(known[0, j]):
            jacobian[:, j] = known[:, j] * scale[j]
            continue
        for h in (spans[j] * scale[j], -spans[j] * scale[j]):
            if not low[j] <= x[j] + h <= high[j]:
                continue
            moved = x.copy()
            moved[j] += h
            r_moved = _attempt(residual, moved)
            count += 1
            if r_moved is not None:
                jacobian[:, j] = (r_moved - r) * (scale[j] / h)
                break
        else:
            jacobian[:, j] = 0.0
    return count
