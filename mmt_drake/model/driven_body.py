"""A driven body: input in, position out. The equation stands in `mmt_drake.model.forces`."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import AXIS_SIZE, POSITION, VELOCITY, advance_axis, read_motion, write_motion
from mmt_drake.model.forces import Surroundings, constants
from mmt_drake.model.hermite import Cubic
from mmt_drake.numeric.layout import Layout

Array = NDArray[np.float64]

# Layout of the state vector.
_next = Layout()
TIME = _next()  # [s] of the latest sample
INPUT = _next()  # at that sample
LOAD = _next()  # [N], at that sample
BEGAN = _next()  # [s], time of the first sample
BODY = _next(AXIS_SIZE)
STATE_SIZE = _next.size


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, u: float, load: float, position: float) -> None:
    """The body at rest at `position` at time t [s], under input u and normal load [N]; fills `state` (STATE_SIZE,)."""
    state[:] = 0.0
    state[TIME] = state[BEGAN] = t
    state[INPUT] = u
    state[LOAD] = load
    state[BODY + POSITION] = position


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, u: float, load: float, p: Array) -> None:
    """Advance the body to time t [s], where the input is u, in place; between samples input and load are linear.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: not before the state's time; equal to it only replaces input and load.
        u: in the recording's unit.
        load: normal load of its bearing [N], for friction that depends on it.
        p: kernel vector of a `DrivenBodyModel`.
    """
    h = t - state[TIME]
    if h > 0.0:
        line = Cubic(state[INPUT], (u - state[INPUT]) / h, 0.0, 0.0)
        normal = Cubic(state[LOAD], (load - state[LOAD]) / h, 0.0, 0.0)
        around = Surroundings(line, normal, 0.0, True, state[TIME] - state[BEGAN])
        write_motion(state, BODY, advance_axis(read_motion(state, BODY), 0.0, h, around, constants(p)))
    state[TIME] = t
    state[INPUT] = u
    state[LOAD] = load


@njit(cache=True, error_model="numpy", nogil=True)
def replay(
    time: Array, u: Array, load: Array, start: float, p: Array, state: Array, output: Array, rate: Array
) -> None:
    """Free-running simulation over a whole recording, at rest at `start` at the first sample.

    Args:
        time: (n,) sample times [s], increasing.
        u: (n,) input.
        load: (n,) normal load [N].
        start: first position.
        p: kernel vector of a `DrivenBodyModel`.
        state: (STATE_SIZE,) scratch.
        output, rate: (n,) to be filled with the position and its derivative.
    """
    begin(state, time[0], u[0], load[0], start)
    replay_part(0, len(time), time, u, load, p, state, output, rate)


@njit(cache=True, error_model="numpy", nogil=True)
def replay_part(
    first: int, end: int, time: Array, u: Array, load: Array, p: Array, state: Array, output: Array, rate: Array
) -> None:
    """`replay` of the samples from `first` to before `end`, the state being that at `begin` or after those before."""
    for k in range(first, end):
        if k > 0:
            advance(state, time[k], u[k], load[k], p)
        output[k] = state[BODY + POSITION]
        rate[k] = state[BODY + VELOCITY]
