"""A motion or an input as it was some time ago: what a model answers to whose force is recorded late.

Before the first sample the motion rests where that sample is, with no velocity; an input has its first value.
"""

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.low_pass import low_passed


def delayed_motion(time: Array, position: Array, velocity: Array, delay: float) -> tuple[Array, Array]:
    """Position and velocity at time - delay, each linear between its own samples.

    A cubic through both would take its velocity from the differences of positions, and their noise with it.

    Args:
        time: (n,) [s], increasing, n >= 2.
        position, velocity: (n, 3) [m], [m/s].
        delay: [s], >= 0; 0 gives the arrays themselves.
    """
    if delay == 0.0:
        return position, velocity
    late = time - delay
    at = [np.column_stack([np.interp(late, time, column) for column in values.T]) for values in (position, velocity)]
    at[1][late < time[0]] = 0.0
    return at[0], at[1]


def delayed_input(time: Array, values: Array, delay: float) -> Array:
    """(n,) values at time - delay [s], of either sign, linear between samples."""
    return np.interp(time - delay, time, values) if delay != 0.0 else values


def input_behind(time: Array, values: Array, delay: float, lag: float) -> Array:
    """(n,) values behind a delay [s] of either sign and then a first-order lag [s]."""
    late = delayed_input(time, values, delay)
    return lagged(time, late, lag) if lag != 0.0 else late


@njit(cache=True, error_model="numpy")
def lagged(time: Array, values: Array, lag: float) -> Array:
    """(n,) y with lag y' = values - y, exact for values that are linear between samples; settled at the first one.

    Args:
        time: (n,) [s], increasing.
        values: (n,).
        lag: time constant [s], > 0.
    """
    y = np.empty_like(values)
    y[0] = values[0]
    for k in range(1, len(values)):
        y[k] = low_passed(y[k - 1], values[k - 1], values[k], (time[k] - time[k - 1]) / lag)
    return y


def delayed_flag(time: Array, flag: Array, delay: float) -> Array:
    """(n,) flags at time - delay [s], each kept until the next."""
    if delay == 0.0:
        return flag
    latest = np.searchsorted(time, time - delay, side="right") - 1
    return flag[np.maximum(latest, 0)]
