"""The linear part of the flexible object: transfer function, stability, state space."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.parameters import BoxParameters
from mmt_drake.numeric.arrays import Array


def transfer_function(p: BoxParameters, s: complex | NDArray[np.complex128]) -> complex | NDArray[np.complex128]:
    """H(s) = -F/x in contact without friction [N/m].

    H(s) = (m s^2 + b1 s + k1)(k2 + b2 s) / (m s^2 + (b1 + b2) s + k1 + k2), from figure 3 of the thesis.

    Args:
        p: structural parameters; Fc is ignored.
        s: complex frequency [rad/s], scalar or array.
    """
    return (p.m * s * s + p.b1 * s + p.k1) * (p.k2 + p.b2 * s) / (p.m * s * s + (p.b1 + p.b2) * s + p.k1 + p.k2)


@njit(cache=True)
def is_stable(m: float, k1: float, k2: float, b1: float, b2: float) -> bool:
    """True where both eigenvalues in contact have a negative real part (Routh: all coefficients of one sign)."""
    return (m > 0.0 and b1 + b2 > 0.0 and k1 + k2 > 0.0) or (m < 0.0 and b1 + b2 < 0.0 and k1 + k2 < 0.0)


def state_space(p: BoxParameters) -> tuple[Array, Array, Array, Array]:
    """A (2, 2), B (2, 2), C (1, 2), D (1, 2) of the object in contact without friction.

    The state is the body's position and velocity, the input the probe's, the output the force that pushes the probe
    along, -F; C (s - A)^-1 B + D, its two columns taken 1 to s, is `transfer_function`.
    """
    A = np.array([[0.0, 1.0], [-(p.k1 + p.k2) / p.m, -(p.b1 + p.b2) / p.m]])
    B = np.array([[0.0, 0.0], [p.k2 / p.m, p.b2 / p.m]])
    D = np.array([[p.k2, p.b2]])
    return A, B, -D, D
