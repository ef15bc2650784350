"""Eq. 30 of the thesis forward, its derivatives and its least squares, compiled; `regrouping` is the front."""

import numpy as np
from numba import njit

from mmt_drake.model.cholesky import cholesky_factor, cholesky_solve
from mmt_drake.numeric.arrays import Array, assign

REFERENCE_HZ = 1.0
"""Frequency at which the misfits of the six equations are weighed against each other [Hz]."""
REFERENCE_OMEGA = 2.0 * np.pi * REFERENCE_HZ
_MOST_STEPS = 30
_CONVERGED = 1e-5
"""Largest last step, as share of k1 + k2 (of m, b: of what has that stiffness at the reference frequency)."""


@njit(cache=True, error_model="numpy")
def regroup(
    m: float, k1: float, k2: float, b1: float, b2: float, Fc: float
) -> tuple[float, float, float, float, float, float, float]:
    """The thesis's eq. 30.

    Args:
        m, k1, k2, b1, b2, Fc: kg, N/m, N/m, N s/m, N s/m, N. With k1 + k2 = 0 nothing returned is finite.

    Returns:
        a, b, c, d, e, f, g in N s^3/m, N s^2/m, N s/m, N/m, s^2, s, N.
    """
    S = k1 + k2
    return m * b2 / S, (m * k2 + b1 * b2) / S, (k1 * b2 + k2 * b1) / S, k1 * k2 / S, m / S, (b1 + b2) / S, k2 * Fc / S


@njit(cache=True, error_model="numpy")
def band_weight(t: Array, left_out: int, out: Array) -> None:
    """The default weight (6x6, diagonal, into `out`) for a ... g in `t` (7); a row left out is 0."""
    w = REFERENCE_OMEGA
    over = max(abs(t[0]) * w**3, abs(t[1]) * w * w, abs(t[2]) * w, abs(t[3]))
    under = max(abs(t[4]) * w * w, abs(t[5]) * w, 1.0)
    out[:, :] = 0.0
    for i in range(6):
        scale = w ** (3 - i) / over if i < 4 else w ** (6 - i) / under
        out[i, i] = scale * scale if i != left_out - 1 else 0.0


@njit(cache=True, error_model="numpy")
def residual(p: Array, t: Array, r: Array) -> None:
    """Write by how much m, k1, k2, b1, b2 in p miss a ... f in t (eq. 30) to r (6,)."""
    values = regroup(p[0], p[1], p[2], p[3], p[4], 0.0)
    r[0], r[1], r[2] = values[0] - t[0], values[1] - t[1], values[2] - t[2]
    r[3], r[4], r[5] = values[3] - t[3], values[4] - t[4], values[5] - t[5]


@njit(cache=True, error_model="numpy")
def cost_of(r: Array, weight: Array) -> float:
    """The weighted square r' W r of a residual (6,)."""
    total = 0.0
    for i in range(6):
        for j in range(6):
            total += r[i] * weight[i, j] * r[j]
    return total


@njit(cache=True, error_model="numpy")
def jacobian(p: Array, J: Array) -> None:
    """Derivatives of a ... f (rows) by m, k1, k2, b1, b2 (columns)."""
    m, k1, k2, b1, b2 = p[0], p[1], p[2], p[3], p[4]
    u = 1.0 / (k1 + k2)
    a, b, c, d, e, f, _ = regroup(m, k1, k2, b1, b2, 0.0)
    J[0, 0], J[0, 1], J[0, 2], J[0, 3], J[0, 4] = b2 * u, -a * u, -a * u, 0.0, m * u
    J[1, 0], J[1, 1], J[1, 2], J[1, 3], J[1, 4] = k2 * u, -b * u, (m - b) * u, b2 * u, b1 * u
    J[2, 0], J[2, 1], J[2, 2], J[2, 3], J[2, 4] = 0.0, (b2 - c) * u, (b1 - c) * u, k2 * u, k1 * u
    J[3, 0], J[3, 1], J[3, 2], J[3, 3], J[3, 4] = 0.0, (k2 - d) * u, (k1 - d) * u, 0.0, 0.0
    J[4, 0], J[4, 1], J[4, 2], J[4, 3], J[4, 4] = u, -e * u, -e * u, 0.0, 0.0
    J[5, 0], J[5, 1], J[5, 2], J[5, 3], J[5, 4] = 0.0, -f * u, -f * u, u, u


@njit(cache=True, error_model="numpy")
def refine(p: Array, t: Array, weight: Array, scratch: Array) -> bool:
    """Gauss-Newton with Levenberg's damping on r' W r, from `p` (m, k1, k2, b1, b2) to the minimum nearby, in place.

    False where it has not arrived after `_MOST_STEPS`: there is no minimum near.
    """
    J, WJ = scratch[0:30].reshape((6, 5)), scratch[30:60].reshape((6, 5))
    A, step, candidate, r = scratch[60:85].reshape((5, 5)), scratch[85:90], scratch[90:95], scratch[95:101]
    scale = scratch[101:106]  # unknowns of one size: stiffness, and what makes that of it at the reference frequency
    scale[1] = scale[2] = abs(p[1] + p[2])
    scale[3] = scale[4] = scale[1] / REFERENCE_OMEGA
    scale[0] = scale[3] / REFERENCE_OMEGA
    residual(p, t, r)
    cost = cost_of(r, weight)
    damping = 1e-12
    fresh = True
    trace = 0.0
    for _ in range(_MOST_STEPS):
        if fresh:
            jacobian(p, J)
            WJ[:, :] = 0.0
            for i in range(6):
                for k in range(5):
                    J[i, k] *= scale[k]
            for i in range(6):
                for j in range(6):
                    if weight[i, j] != 0.0:  # mostly diagonal
                        for k in range(5):
                            WJ[i, k] += weight[i, j] * J[j, k]
            trace = 0.0
            for i in range(6):
                for k in range(5):
                    trace += J[i, k] * WJ[i, k]
        residual(p, t, r)
        A[:, :] = 0.0
        step[:] = 0.0
        for i in range(6):
            for k in range(5):
                step[k] -= WJ[i, k] * r[i]
                for n in range(5):
                    A[k, n] += J[i, k] * WJ[i, n]
        for k in range(5):
            A[k, k] += damping * trace
        fresh = cholesky_factor(A)
        if fresh:
            cholesky_solve(A, step)
            size = 0.0
            for k in range(5):
                candidate[k] = p[k] + scale[k] * step[k]
                size = max(size, abs(step[k]))
            residual(candidate, t, r)
            candidate_cost = cost_of(r, weight)
            fresh = candidate_cost <= cost
            if fresh:
                assign(p, candidate)
                cost = candidate_cost
            if size < _CONVERGED and damping < 1e-6:  # a damped step is small without being the last
                return True
        damping = max(1e-12, 0.01 * damping) if fresh else 100.0 * damping
    return False
