"""A mass on a spring and a damper, m x'' + b x' + k x = F, stepped exactly under a held force."""

import numpy as np
from scipy.linalg import expm

from mmt_drake.numeric.arrays import Array


def exact_step(mass: float, damping: float, stiffness: float, period: float) -> tuple[Array, Array]:
    """The exact step over a period [s] of a held force: (2, 2) for position and rate, (2,) for the force.

    Args:
        mass: m [kg], > 0.
        damping: b [N s/m].
        stiffness: k [N/m].
        period: of the step [s].
    """
    rate = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1.0 / mass], [0.0, 0.0, 0.0]])
    step = expm(period * rate)
    return np.ascontiguousarray(step[:2, :2]), np.ascontiguousarray(step[:2, 2])
