"""The normal axis of a flexible object with more than a spring and a damper along it: laws, and what its sensor adds.

It is the contact of `mmt_drake.model.kelvin_voigt` along z, in contact alone: the probe's height is its position, and
the laws are those of a contact spring, counted as there. At each touch they forget the last one.
"""

import numpy as np
from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MEMORY, READING, remember, sense, settle, touch
from mmt_drake.model.forces import ALONE, BodyMotion, Surroundings, constants, level_spring, stored_in_laws
from mmt_drake.model.hermite import Cubic, cubic, position_at, velocity_at
from mmt_drake.model.kelvin_voigt import spring_force
from mmt_drake.model.memory import read_memory, write_memory
from mmt_drake.model.parameters import Constants
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy")
def pressed(state: Array, at: int, height: Cubic, s: float, t: float, c: Constants) -> float:
    """Force on the probe along the normal [N] where it is s [s] after the latest sample, in contact.

    Args:
        state: of the object; the axis begins at `at`.
        at: see `state`.
        height: of the probe [m].
        s: see above.
        t: time since the first sample [s].
        c: of the axis.
    """
    return spring_force(_probe_at(state, at, height, s), 0.0, t, c)


@njit(error_model="numpy")
def stored_in_normal_laws(state: Array, at: int, height: Cubic, s: float, t: float, c: Constants) -> float:
    """The energy that the laws of the axis hold, in contact [J]; arguments as of `pressed`."""
    return 0.0 if c.laws == 0 else stored_in_laws(_probe_at(state, at, height, s), 0.0, _nothing_else(t, c), c, ALONE)


@njit(error_model="numpy", forceinline=True)
def _probe_at(state: Array, at: int, height: Cubic, s: float) -> BodyMotion:
    """The probe as what moves the axis."""
    v = velocity_at(height, s)
    return BodyMotion(position_at(height, s), v, np.sign(v), read_memory(state, at + MEMORY))


@njit(error_model="numpy", forceinline=True)
def _nothing_else(start: float, c: Constants) -> Surroundings:
    """Nothing acts but the axis itself, in contact; counted from `start` [s]."""
    nothing = Cubic(0.0, 0.0, 0.0, 0.0)
    return Surroundings(nothing, nothing, c.rest, True, start, level_spring(c))


@njit(error_model="numpy")
def press(state: Array, at: int, height: Cubic, s: float, s_end: float, start: float, c: Constants) -> Cubic:
    """Advance the laws of the axis through a stretch of contact; the load on the way, as a line.

    Args:
        state: of the object; the axis begins at `at`.
        at: see `state`.
        height: of the probe [m].
        s, s_end: the stretch of time [s] after the latest sample.
        start: time of that since the first sample [s].
        c: of the axis.
    """
    first = pressed(state, at, height, s, start + s, c)
    if not s < s_end:
        return Cubic(first, 0.0, 0.0, 0.0)
    if c.remembers:
        q = read_memory(state, at + MEMORY)
        write_memory(state, at + MEMORY, remember(q, s, s_end, height, _nothing_else(start, c), c))
    slope = (pressed(state, at, height, s_end, start + s_end, c) - first) / (s_end - s)
    return Cubic(first - slope * s, slope, 0.0, 0.0)


@njit(error_model="numpy")
def touch_normal(state: Array, at: int, height: Cubic, s: float, c: Constants) -> None:
    """Make the laws of the axis forget the last touch; arguments as of `press`."""
    touch(state, at, height, s, c)
    state[at + ANCHOR] = 0.0  # its spring is anchored at the surface


@njit(error_model="numpy")
def begin_normal(state: Array, at: int, height: float, c: Constants) -> None:
    """Let the axis begin in contact, the probe at a height [m]; other arguments as of `press`."""
    settle(state, at, height, _nothing_else(0.0, c), c)


@njit(cache=True, error_model="numpy", nogil=True)
def replay_normal(
    time: Array, height: Array, height_rate: Array, starts_in: bool, changes: Array, p: Array, force: Array
) -> None:
    """The force along the normal over a whole recording, as it is.

    Args:
        time: (n,) sample times [s], increasing.
        height, height_rate: (n,) of the probe above the surface [m], [m/s].
        starts_in: whether the probe touches at the first sample.
        changes: (c,) times of touch and release in turn [s], increasing.
        p: kernel vector of the axis.
        force: (n,) to be filled with the force on the probe [N].
    """
    state, c = np.zeros(AXIS_SIZE), constants(p)
    contact, change = starts_in, 0
    if starts_in:
        begin_normal(state, 0, height[0], c)
    while change < len(changes) and changes[change] <= time[0]:
        change += 1
    for k in range(len(time)):
        if k > 0:
            start, h = time[k - 1] - time[0], time[k] - time[k - 1]
            path, s = cubic(height[k - 1], height_rate[k - 1], height[k], height_rate[k], h), 0.0
            while change < len(changes) and changes[change] <= time[k]:
                s_change = changes[change] - time[k - 1]
                if contact:
                    press(state, 0, path, s, s_change, start, c)
                else:
                    touch_normal(state, 0, path, s_change, c)
                contact, s = not contact, s_change
                change += 1
            if contact:
                press(state, 0, path, s, h, start, c)
        here = Cubic(height[k], height_rate[k], 0.0, 0.0)
        force[k] = pressed(state, 0, here, 0.0, time[k] - time[0], c) if contact else 0.0


@njit(cache=True, error_model="numpy", nogil=True)
def read_normal(time: Array, height_rate: Array, force: Array, p: Array, reading: Array) -> None:
    """What the force sensor makes of the force along the normal.

    Args:
        time: (n,) sample times [s], increasing.
        height_rate: (n,) of the probe above the surface [m/s].
        force: (n,) that acts on it [N].
        p: kernel vector of the axis.
        reading: (n,) to be filled with what it reads [N].
    """
    state, c, h = np.zeros(AXIS_SIZE), constants(p), 0.0
    for k in range(len(time)):
        if k > 0:
            h = time[k] - time[k - 1]
        sense(state, 0, force[k], force[k], height_rate[k], time[k] - time[0], h, c)
        reading[k] = state[READING]
