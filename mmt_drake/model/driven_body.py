"""A driven body: input in, position out. The equation stands in `mmt_drake.model.body`."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import AXIS_SIZE, POSITION, VELOCITY, advance_axis
from mmt_drake.model.hermite import Cubic

Array = NDArray[np.float64]

# Layout of the state vector.
TIME = 0  # [s] of the latest sample
INPUT = 1  # at that sample
BODY = 2
STATE_SIZE = BODY + AXIS_SIZE


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, u: float, position: float) -> None:
    """The body at rest at `position` at time t [s], under the input u; `state` (STATE_SIZE,) is filled."""
    state[:] = 0.0
    state[TIME] = t
    state[INPUT] = u
    state[BODY + POSITION] = position


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, u: float, p: Array) -> None:
    """Advance the body to time t [s], where the input is u, in place; between samples the input is linear.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: not before the state's time; equal to it only replaces the input.
        u: in the recording's unit.
        p: kernel vector of a `DrivenBodyModel`.
    """
    h = t - state[TIME]
    if h > 0.0:
        line = Cubic(state[INPUT], (u - state[INPUT]) / h, 0.0, 0.0)
        advance_axis(state, BODY, False, 0.0, h, line, p)
    state[TIME] = t
    state[INPUT] = u


@njit(cache=True, error_model="numpy")
def replay(time: Array, u: Array, start: float, p: Array, state: Array, output: Array, rate: Array) -> None:
    """Free-running simulation over a whole recording, at rest at `start` at the first sample.

    Args:
        time: (n,) sample times [s], increasing.
        u: (n,) input.
        start: first position.
        p: kernel vector of a `DrivenBodyModel`.
        state: (STATE_SIZE,) scratch.
        output, rate: (n,) to be filled with the position and its derivative.
    """
    begin(state, time[0], u[0], start)
    for k in range(len(time)):
        if k > 0:
            advance(state, time[k], u[k], p)
        output[k] = state[BODY + POSITION]
        rate[k] = state[BODY + VELOCITY]
