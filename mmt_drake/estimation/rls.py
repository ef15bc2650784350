"""Recursive least squares, the thesis's eq. 4-5, compiled and in place."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def dot(x: Array, y: Array) -> float:
    """Inner product of two short vectors."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@njit(cache=True, error_model="numpy")
def rls_update(theta: Array, P: Array, psi: Array, y: float, forgetting: float, gain: Array) -> None:
    """One row y = psi' theta of the thesis's eq. 4-5, with exponential forgetting.

    theta += P psi (y - psi' theta) / (lambda + psi' P psi);  P = (P - P psi psi' P / (lambda + psi' P psi)) / lambda

    lambda = 1 is eq. 4-5. Then psi = 0 changes nothing, which is how the thesis pauses; with lambda < 1 it would
    inflate P, so whoever pauses does not call. Several rows of one instant: lambda with the first, 1 with the others.

    Args:
        theta: estimate (n), changed.
        P: its covariance in units of the equation error's variance (n x n), changed; stays exactly symmetric.
        psi: regressor (n).
        y: output.
        forgetting: lambda in (0, 1].
        gain: work space (n).
    """
    n = theta.size
    scale = forgetting
    for i in range(n):
        gain[i] = dot(P[i], psi)
        scale += psi[i] * gain[i]
    error = (y - dot(psi, theta)) / scale
    for i in range(n):
        theta[i] += gain[i] * error
        for j in range(i, n):
            P[i, j] = (P[i, j] - gain[i] * gain[j] / scale) / forgetting
            P[j, i] = P[i, j]
