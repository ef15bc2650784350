"""Cholesky factors of small symmetric positive definite matrices for compiled code that must not allocate."""

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array


@njit(cache=True)
def cholesky_factor(A: Array) -> bool:
    """Replace the lower triangle of A (n x n) by L of A = L L'; False, A spoilt, where A is not positive definite."""
    for j in range(A.shape[0]):
        for i in range(j, A.shape[0]):
            value = A[i, j]
            for k in range(j):
                value -= A[i, k] * A[j, k]
            if i > j:
                A[i, j] = value / A[j, j]
            elif value > 0.0:
                A[j, j] = np.sqrt(value)
            else:
                return False
    return True


@njit(cache=True)
def cholesky_solve(L: Array, y: Array) -> None:
    """Replace y (n) by the solution x of L L' x = y."""
    n = y.size
    for i in range(n):
        for k in range(i):
            y[i] -= L[i, k] * y[k]
        y[i] /= L[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            y[i] -= L[k, i] * y[k]
        y[i] /= L[i, i]
