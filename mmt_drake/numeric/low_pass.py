"""A low pass of first order, sample by sample."""

from math import expm1

from numba import njit


@njit(error_model="numpy")
def low_passed(y: float, before: float, value: float, steps: float) -> float:
    """The next y of tau y' = u - y, exact for an input u that is linear between samples.

    Args:
        y: output at the sample before.
        before, value: input at the sample before and at this one.
        steps: time between them over tau, > 0.
    """
    passed = -expm1(-steps)
    return y + passed * (before - y) + (1.0 - passed / steps) * (value - before)
