"""The linear part of the flexible object: transfer function, eigenvalues, stability."""

from __future__ import annotations

import cmath

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.parameters import BoxParameters


def transfer_function(p: BoxParameters, s: complex | NDArray[np.complex128]) -> complex | NDArray[np.complex128]:
    """H(s) = -F/x in contact without friction [N/m].

    H(s) = (m s^2 + b1 s + k1)(k2 + b2 s) / (m s^2 + (b1 + b2) s + k1 + k2), from figure 3 of the thesis.

    Args:
        p: structural parameters; Fc is ignored.
        s: complex frequency [rad/s], scalar or array.
    """
    return (p.m * s * s + p.b1 * s + p.k1) * (p.k2 + p.b2 * s) / (p.m * s * s + (p.b1 + p.b2) * s + p.k1 + p.k2)


def eigenvalues(p: BoxParameters, *, contact: bool = True) -> tuple[complex, complex]:
    """Roots of the body's characteristic polynomial [rad/s].

    In contact m s^2 + (b1 + b2) s + k1 + k2, off contact m s^2 + b1 s + k1.
    """
    b = p.b1 + p.b2 if contact else p.b1
    k = p.k1 + p.k2 if contact else p.k1
    root = cmath.sqrt(b * b - 4.0 * p.m * k)
    return (-b + root) / (2.0 * p.m), (-b - root) / (2.0 * p.m)


@njit(cache=True)
def is_stable(m: float, k1: float, k2: float, b1: float, b2: float) -> bool:
    """Whether both eigenvalues in contact have a negative real part (Routh: all coefficients of one sign)."""
    return (m > 0.0 and b1 + b2 > 0.0 and k1 + k2 > 0.0) or (m < 0.0 and b1 + b2 < 0.0 and k1 + k2 < 0.0)
