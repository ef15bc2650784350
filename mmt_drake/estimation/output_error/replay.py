"""One tangential axis of the object over a window of samples, with the plant's own kernel."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import ANCHOR, POSITION, advance_axis, contact_force, read_motion, write_motion
from mmt_drake.model.forces import Surroundings, constants
from mmt_drake.model.hermite import Cubic, cubic, position_at

Array = NDArray[np.float64]


@njit(cache=True, error_model="numpy", nogil=True)
def replay_window(
    h: float, probe: Array, probe_rate: Array, contact: Array, switch: Array, p: Array, axis: Array, force: Array
) -> None:
    """Free-running simulation from a given state.

    Args:
        h: time between samples [s].
        probe, probe_rate: (n,) of the probe along the axis [m], [m/s].
        contact: (n,) 0 or 1.
        switch: (n,) where the contact differs from the sample before: the share of h from that one to the change.
        p: kernel vector without laws.
        axis: (AXIS_SIZE,) state of the body at the first sample, advanced to the last.
        force: (n,) to be filled with the force on the probe [N].

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis`.
    """
    c = constants(p)
    level = Cubic(0.0, 0.0, 0.0, 0.0)  # without laws the height does not matter
    for k in range(probe.size):
        touching = contact[k] != 0.0
        if k > 0:
            along = cubic(probe[k - 1], probe_rate[k - 1], probe[k], probe_rate[k], h)
            before = contact[k - 1] != 0.0
            s = h if touching == before else switch[k] * h
            if s > 0.0:
                around = Surroundings(along, level, axis[ANCHOR], before, 0.0)
                write_motion(axis, 0, advance_axis(read_motion(axis, 0), 0.0, s, around, c))
            if touching and not before:
                axis[ANCHOR] = position_at(along, s) - axis[POSITION]
            if s < h:
                around = Surroundings(along, level, axis[ANCHOR], touching, 0.0)
                write_motion(axis, 0, advance_axis(read_motion(axis, 0), s, h, around, c))
        force[k] = 0.0
        if touching:
            here = Surroundings(Cubic(probe[k], probe_rate[k], 0.0, 0.0), level, axis[ANCHOR], True, 0.0)
            force[k] = contact_force(axis, 0, here, 0.0, c)
