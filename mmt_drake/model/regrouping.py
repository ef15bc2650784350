"""The regrouping of the thesis's eq. 30, both ways: (m, k1, k2, b1, b2, Fc) <-> (a ... g).

**Why there are seven.** The flexible box answers a motion X(s) with the force (eliminate the body from figure 3)

    F = -K (M + B) / (M + B + K) X,    K = k2 + b2 s,   B = k1 + b1 s,   M = m s^2.

With numerator and denominator divided by S = k1 + k2 these are a s^3 + b s^2 + c s + d and e s^2 + f s + 1, and eq. 7
is F's differential equation: six coefficients, five unknowns. Friction stands apart: Fc = g S / k2.

**The way back.** One equation left out: the closed forms of `regrouping_roots`, then Newton steps on the five equations
themselves. All six: least squares (Gauss-Newton) from the closed forms' roots. By default the misfit of an equation
counts as what its term does to the force at `REFERENCE_HZ`, where a hand moves: a w^3, b w^2, c w and d against the
largest of these four, e w^2, f w and 1 against the largest of those three. Any other weight W of the cost r' W r (6x6,
symmetric) may be handed in; the inverse of the recursive estimator's P for a ... f weighs by how well each combination
of them is known.

**Twins.** There are several roots. With k1 = 0 and b1 = b2 two of them satisfy all six equations and are one and the
same H(s): (m, k1, k2, b1, b2) = (1, 0, 500, 60, 60) and (1.1613, 580.6, 0, 79.35, 60). Force alone cannot tell such
twins apart. Of the admissible roots the one is taken whose k2 is nearest the stiffness along the normal (the object is
one material); where all six equations are used, only among those that explain them about as well as the best does
(`TWIN_MISFIT`).
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mmt_drake.errors import BadInput, MmtError
from mmt_drake.model.linear import is_stable
from mmt_drake.model.regrouping_equations import REFERENCE_OMEGA, band_weight, cost_of, refine, residual
from mmt_drake.model.regrouping_equations import regroup as regroup
from mmt_drake.model.regrouping_roots import closed_forms
from mmt_drake.numeric.arrays import Array

#: Ways of solving eq. 30: all of a ... f by least squares, or one of them left out.
Equations = Literal["all", "without_a", "without_b", "without_c", "without_d", "without_e", "without_f"]
EQUATIONS: tuple[Equations, ...] = get_args(Equations)
"""The choices of a back-solve among eq. 30 (g is always used); the index is the compiled core's `left_out`."""

TWIN_MISFIT = 0.02
"""Roots whose misfit is no more than this above the best one's explain the coefficients equally well."""
NEGATIVE_SHARE = 0.1
"""Admissible are k1 >= -0.1 (k1 + k2), b1 >= -0.1 (b1 + b2): what is 0 in truth is estimated on either side of 0."""
NEGATIVE_FRICTION = 0.1
"""Admissible is Fc >= -0.1 N, for the same reason."""

SOLVED, NOT_FINITE, NOT_POSITIVE, NO_REAL_ROOT, NOT_ADMISSIBLE = range(5)
"""Status of the compiled back-solve."""
_REASON = {
    NOT_POSITIVE: "a, e and f must be positive: b2 = a/e, m/S = e, (b1 + b2)/S = f",
    NO_REAL_ROOT: "the equations used have no real root and their misfit no minimum near",
    NOT_ADMISSIBLE: "every root has a negative mass, stiffness, damping or friction",
}

MAX_ROOTS = 3
ROOT_SIZE = 8
"""Columns of a root: m, k1, k2, b1, b2, Fc, misfit, admissible (0.0 or 1.0)."""
SCRATCH_SIZE = 160
"""Length of the work space of the compiled back-solve."""
TINY = 1e-9
"""A k2 below this share of k1 + k2 is 0: no contact spring, hence no friction to be felt and none to be found."""


class NoPhysicalSolution(MmtError):
    """No physical (m, k1, k2, b1, b2, Fc) has the a ... g given; the message says why."""


@njit(cache=True, error_model="numpy")
def _admissible(t: Array, root: Array) -> bool:
    """Write Fc to m, k1, k2, b1, b2, Fc in `root`; whether a body may have them, see `Root.admissible`."""
    m, k1, k2, b1, b2 = root[0], root[1], root[2], root[3], root[4]
    S = k1 + k2
    root[5] = t[6] * S / k2 if abs(k2) > TINY * abs(S) else np.nan
    physical = m > 0.0 and is_stable(m, k1, k2, b1, b2) and k2 > TINY * S and b2 > 0.0
    physical = physical and k1 >= -NEGATIVE_SHARE * S and b1 >= -NEGATIVE_SHARE * (b1 + b2)
    return physical and root[5] >= -NEGATIVE_FRICTION


@njit(cache=True, error_model="numpy")
def follow_root(t: Array, weight: Array, root: Array, scratch: Array) -> bool:
    """Take a root of eq. 30 along with a ... g that have changed a little; allocates nothing.

    Args:
        t: a ... g (7), finite.
        weight: as for `back_solve_core`.
        root: m, k1, k2, b1, b2, Fc of the a ... g before, changed.
        scratch: work space (`SCRATCH_SIZE`).

    Returns:
        Whether there still is an admissible root near; if not, `root` is spoilt.
    """
    if not refine(root[:5], t, weight, scratch):
        return False
    return np.isfinite(root[0] + root[1] + root[2] + root[3] + root[4]) and _admissible(t, root)


@njit(cache=True, error_model="numpy")
def back_solve_core(
    t: Array, left_out: int, weight: Array, normal_k: float, roots: Array, scratch: Array
) -> tuple[int, int, int]:
    """Solve eq. 30 for (m, k1, k2, b1, b2, Fc); allocates nothing.

    Args:
        t: a ... g (7).
        left_out: index into `EQUATIONS`.
        weight: W of the least squares (6x6): `band_weight`, or the inverse covariance of a ... f with none left out.
        normal_k: stiffness along the normal [N/m], which chooses between roots; NaN: the least misfit does.
        roots: receives the roots found (`MAX_ROOTS` x `ROOT_SIZE`).
        scratch: work space (`SCRATCH_SIZE`).

    Returns:
        Status (`SOLVED` ... `NOT_ADMISSIBLE`), row of `roots` chosen (-1: none), number of roots.
    """
    for i in range(7):
        if not np.isfinite(t[i]):
            return NOT_FINITE, -1, 0
    if (t[0] <= 0.0 and left_out != 1) or (t[4] <= 0.0 and left_out != 5) or (t[5] <= 0.0 and left_out != 6):
        return NOT_POSITIVE, -1, 0
    r, x, work = scratch[0:6], scratch[6:9], scratch[9:]
    band = work[106:142].reshape((6, 6))
    band_weight(t, 0, band)
    count = closed_forms(t, left_out, REFERENCE_OMEGA, roots, x)
    kept = 0
    best = np.inf
    for i in range(count):
        row = roots[i]
        if not np.isfinite(row[0] + row[1] + row[2] + row[3] + row[4]) or row[1] + row[2] == 0.0:
            continue
        if not refine(row[:5], t, weight, work):
            continue
        m, k1, k2, b1, b2 = row[0], row[1], row[2], row[3], row[4]
        S = k1 + k2
        if not np.isfinite(m + S + b1 + b2):
            continue
        twice = False
        for j in range(kept):
            alike = abs(roots[j, 2] - k2) < 1e-5 * abs(S) and abs(roots[j, 1] - k1) < 1e-5 * abs(S)
            twice = twice or (alike and abs(roots[j, 0] - m) < 1e-2 * abs(m) and abs(roots[j, 4] - b2) < 1e-2 * abs(b2))
        if twice:
            continue
        out = roots[kept]
        out[0], out[1], out[2], out[3], out[4] = m, k1, k2, b1, b2
        physical = _admissible(t, out)
        residual(out[:5], t, r)
        out[6] = np.sqrt(cost_of(r, band) / 6.0)
        out[7] = 1.0 if physical else 0.0
        if physical:
            best = min(best, out[6])
        kept += 1
    if kept == 0:
        return NO_REAL_ROOT, -1, 0
    chosen = -1
    for i in range(kept):
        if roots[i, 7] == 0.0 or (left_out == 0 and roots[i, 6] > best + TWIN_MISFIT):
            continue
        by = 6 if np.isnan(normal_k) else 2
        target = 0.0 if np.isnan(normal_k) else normal_k
        off, least = abs(roots[i, by] - target), np.inf if chosen < 0 else abs(roots[chosen, by] - target)
        # Roots with one and the same k2 are told apart by their misfit alone.
        if off < least if abs(off - least) > 1e-5 * abs(target) else roots[i, 6] < roots[chosen, 6]:
            chosen = i
    return (SOLVED if chosen >= 0 else NOT_ADMISSIBLE), chosen, kept


@dataclass(frozen=True)
class Root:
    """One solution of eq. 30.

    Attributes:
        m, k1, k2, b1, b2, Fc: kg, N/m, N/m, N s/m, N s/m, N. Fc is NaN where k2 is 0.
        misfit: RMS misfit of all six equations a ... f, the one left out included, each as weighed by `band_weight`.
        admissible: m, k2, b2 positive, stable in contact; k1, b1 and Fc not negative but for scatter
            (`NEGATIVE_SHARE`, `NEGATIVE_FRICTION`).
    """

    m: float
    k1: float
    k2: float
    b1: float
    b2: float
    Fc: float
    misfit: float
    admissible: bool


@dataclass(frozen=True)
class BackSolution:
    """The root taken and the others, twins among them; all that the equations have."""

    chosen: Root
    others: tuple[Root, ...]


def back_solve(regrouped: ArrayLike, *, equations: str = "all", normal_k: float | None = None) -> BackSolution:
    """Solve the thesis's eq. 30 for the box's parameters.

    Args:
        regrouped: a ... g (7), units as `regroup`.
        equations: entry of `EQUATIONS`: all of them by least squares, or one of a ... f left out.
        normal_k: stiffness along the normal [N/m]; without it the root with the least misfit is taken.

    Raises:
        BadInput: not 7 finite numbers, an unknown `equations`.
        NoPhysicalSolution: nothing physical has these a ... g.
    """
    t = np.asarray(regrouped, dtype=float)
    if t.shape != (7,) or not np.all(np.isfinite(t)):
        raise BadInput("regrouped parameters", found=regrouped, expected="7 finite numbers a ... g")
    if equations not in EQUATIONS:
        raise BadInput("equations of eq. 30", found=equations, expected=f"one of {', '.join(EQUATIONS)}")
    left_out = EQUATIONS.index(equations)
    W = np.zeros((6, 6))
    band_weight(t, left_out, W)
    if normal_k is not None and not np.isfinite(normal_k):
        raise BadInput("normal_k", found=normal_k, expected="a finite stiffness in N/m, or None")
    roots, scratch = np.zeros((MAX_ROOTS, ROOT_SIZE)), np.zeros(SCRATCH_SIZE)
    status, chosen, count = back_solve_core(t, left_out, W, np.nan if normal_k is None else normal_k, roots, scratch)
    if status != SOLVED:
        raise NoPhysicalSolution(f"eq. 30, {equations}, a ... g = {t.tolist()}: {_REASON[status]}")
    rows = roots[:count].tolist()
    solved = [Root(m, k1, k2, b1, b2, Fc, misfit, good > 0.0) for m, k1, k2, b1, b2, Fc, misfit, good in rows]
    return BackSolution(solved[chosen], tuple(root for i, root in enumerate(solved) if i != chosen))
