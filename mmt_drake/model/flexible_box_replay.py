"""A flexible box over a whole recording whose touches and releases are known, one tangential axis or both."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION, READING, VELOCITY, advance_body, read_motion, sense, touch
from mmt_drake.model.forces import (
    ALONE,
    Surroundings,
    constants,
    contact_force,
    contact_forces,
    level_spring,
    normal_force,
)
from mmt_drake.model.hermite import Cubic, cubic
from mmt_drake.model.parameters import Constants
from mmt_drake.model.tangential import advance_object
from mmt_drake.model.turned import in_force_frame
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy", forceinline=True)
def _path(probe: Array, rate: Array, i: int, k: int, h: float) -> Cubic:
    """Of the probe along an axis from sample k - 1 to k, h [s] later."""
    return cubic(probe[i, k - 1], rate[i, k - 1], probe[i, k], rate[i, k], h)


@njit(error_model="numpy", forceinline=True)
def _around(state: Array, at: int, probe: float, rate: float, over: Cubic, t: float, c: Constants) -> Surroundings:
    """What acts along the axis that begins at `at` in the state, in contact."""
    return Surroundings(Cubic(probe, rate, 0.0, 0.0), over, state[at + ANCHOR], True, t, level_spring(c))


def _over(axes: int) -> Callable[..., None]:
    """`replay_axis` or `replay_plane`; compiled each for itself, as one for both is slower by a third."""

    @njit(cache=True, error_model="numpy", nogil=True)
    def replay(
        time: Array,
        probe: Array,
        probe_rate: Array,
        height: Array,
        height_rate: Array,
        starts_in: bool,
        changes: Array,
        p: Array,
        force: Array,
        body: Array,
        body_rate: Array,
    ) -> None:
        state = np.zeros(axes * AXIS_SIZE)
        for i in range(axes):
            state[AXIS_SIZE * i + ANCHOR] = probe[i, 0]
        c = constants(p)
        spring = level_spring(c)
        both = (spring, spring, c, p.ctypes.data, len(p))
        contact, change, begin_at = starts_in, 0, time[0]
        while change < len(changes) and changes[change] <= begin_at:
            change += 1
        for k in range(len(time)):
            h = 0.0
            if k > 0:
                h = time[k] - time[k - 1]
                start = time[k - 1] - begin_at
                along, across = _path(probe, probe_rate, 0, k, h), _path(probe, probe_rate, axes - 1, k, h)
                above = cubic(height[k - 1], height_rate[k - 1], height[k], height_rate[k], h)
                s = 0.0
                while True:  # to each change of the contact, then to the sample: once, as it is long to compile
                    changing = change < len(changes) and changes[change] <= time[k]
                    s_end = changes[change] - time[k - 1] if changing else h
                    if axes == 1:
                        advance_body(state, 0, s, s_end, along, above, contact, start, spring, c)
                    else:
                        advance_object(state, 0, s, s_end, along, across, above, contact, start, *both)
                    if not changing:
                        break
                    contact = not contact
                    if contact:
                        touch(state, 0, along, s_end, c)
                        if axes == 2:
                            touch(state, AXIS_SIZE, across, s_end, c)
                    s = s_end
                    change += 1
            normal = normal_force(height[k], height_rate[k], c) if contact else 0.0
            felt, other = 0.0, 0.0
            if contact:
                over = Cubic(height[k], height_rate[k], 0.0, 0.0)
                t, x = time[k] - begin_at, read_motion(state, 0)
                first = _around(state, 0, probe[0, k], probe_rate[0, k], over, t, c)
                if axes == 1:
                    felt = contact_force(x, 0.0, first, c, ALONE)
                else:
                    second = _around(state, AXIS_SIZE, probe[1, k], probe_rate[1, k], over, t, c)
                    felt, other = contact_forces(x, read_motion(state, AXIS_SIZE), 0.0, first, second, c)
            if axes == 2 and c.normal_axis != 0.0:
                felt, other, normal = in_force_frame(p, int(c.normal_axis), felt, other, normal)
            if len(force) > axes:
                force[axes, k] = normal
            for i in range(axes):
                at = AXIS_SIZE * i
                sense(state, at, felt if i == 0 else other, normal, probe_rate[i, k], time[k] - begin_at, h, c)
                force[i, k] = state[at + READING]
                body[i, k], body_rate[i, k] = state[at + POSITION], state[at + VELOCITY]

    return replay


replay_axis: Final = _over(1)
"""One tangential axis free-running over a whole recording, at rest first.

One axis alone knows nothing of the other: its friction is that of an axis whatever the model says.

Args:
    time: (n,) sample times [s], increasing.
    probe, probe_rate: (1, n) of the probe along the axis [m], [m/s].
    height, height_rate: (n,) along the surface normal [m], [m/s].
    starts_in: whether the probe touches at the first sample.
    changes: (c,) times of touch and release in turn [s], increasing.
    p: kernel vector.
    force: (1, n) to be filled with the force that the sensor reads [N].
    body, body_rate: (1, n) to be filled with the body's displacement and its rate [m], [m/s].
"""
replay_plane: Final = _over(2)
"""`replay_axis` for x and y at once, whose friction may be a vector: probe, force and body are (2, n).

A third row of `force` is filled with what the sensor feels along its normal axis, before its laws [N]. Only both axes
together know what a sensor that is askew feels along either.
"""
