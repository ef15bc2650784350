"""Estimates as they cross the network: what may be wrong with one, and the kernel vector that it makes."""

import math

from numba import njit

from mmt_drake.model.parameters import B1, B2, FD, FS, K1, K2, MAX_STEP, PLANAR, THETA_AT, VD, M, accurate_step
from mmt_drake.numeric.arrays import Array

#: What may be wrong with an estimate, see `flaw_of_theta`.
NO_FLAW, NO_MODEL, TOO_STIFF = range(3)


@njit(cache=True)
def flaw_of_theta(theta: Array, least_step: float) -> int:
    """The reason why an estimate cannot be integrated.

    Args:
        theta: (10,) in the order of `mmt_drake.model.parameters.THETA`.
        least_step: smallest step that may be needed [s].

    Returns:
        NO_FLAW; NO_MODEL: a number that is not finite, or a mass that is not positive; TOO_STIFF: a smaller step.
    """
    for i in range(len(theta)):
        if not math.isfinite(theta[i]):
            return NO_MODEL
    m, k1, k2, b1, b2 = theta[0], theta[1], theta[2], theta[3], theta[4]
    if not m > 0.0:
        return NO_MODEL
    return TOO_STIFF if accurate_step(m, k1, k2, b1, b2) < least_step else NO_FLAW


@njit(cache=True)
def write_theta(theta: Array, max_step: float, planar: float, p: Array) -> None:
    """Make `p` the kernel vector of an estimate without a flaw; a negative Fc counts as none, an Fs below Fc as Fc.

    Args:
        theta: (10,) in the order of `mmt_drake.model.parameters.THETA`.
        max_step: upper bound on the integration step [s].
        planar: of the kernel vector (`mmt_drake.model.plane_call.planar`).
        p: (KERNEL_SIZE,).
    """
    p[:] = 0.0
    p[PLANAR] = planar
    for i in range(len(THETA_AT)):
        p[THETA_AT[i]] = theta[i]
    p[FD] = max(p[FD], 0.0)
    p[FS], p[VD] = max(p[FS], p[FD]), max(p[VD], 0.0)
    p[MAX_STEP] = min(max_step, accurate_step(p[M], p[K1], p[K2], p[B1], p[B2]))


@njit(cache=True)
def adopt_theta(theta: Array, max_step: float, least_step: float, planar: float, p: Array) -> bool:
    """`write_theta` for an estimate without a flaw, see `flaw_of_theta`; otherwise `p` stays.

    Returns:
        Whether the estimate can be integrated.
    """
    if flaw_of_theta(theta, least_step) != NO_FLAW:
        return False
    write_theta(theta, max_step, planar, p)
    return True
