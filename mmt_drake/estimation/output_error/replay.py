"""One tangential axis of the object over a window of samples, with the plant's own kernel."""

from numba import njit

from mmt_drake.model.body import ANCHOR, POSITION, advance_axis, contact_force, read_motion, write_motion
from mmt_drake.model.forces import Surroundings, constants
from mmt_drake.model.hermite import Cubic, cubic, position_at
from mmt_drake.numeric.arrays import Array


@njit(cache=True, error_model="numpy", nogil=True)
def replay_window(
    h: float,
    parts: int,
    probe: Array,
    probe_rate: Array,
    contact: Array,
    switch: Array,
    p: Array,
    axis: Array,
    force: Array,
) -> None:
    """Free-running simulation from a given state.

    A sample is a mean over ticks, and so is its force: where friction stops the body, the force jumps within a sample.

    Args:
        h: time between samples [s].
        parts: ticks in a sample, an odd number; the body is advanced from one to the next, as a plant would be.
        probe, probe_rate: (n,) of the probe along the axis, in the middle of each sample [m], [m/s].
        contact: (n,) 0 or 1.
        switch: (n,) where the contact differs from the sample before: the share of h from that one to the change.
        p: kernel vector without laws.
        axis: (AXIS_SIZE,) state of the body in the middle of the first sample, advanced to that of the last.
        force: (n,) to be filled with the force on the probe [N].

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis`.
    """
    c = constants(p)
    level = Cubic(0.0, 0.0, 0.0, 0.0)  # without laws the height does not matter
    force[:] = 0.0
    begun = (parts + 1) // 2  # ticks of a sample when its middle is reached
    if probe.size > 0 and contact[0] != 0.0:
        along = Cubic(probe[0], probe_rate[0], 0.0, 0.0)
        force[0] = contact_force(axis, 0, Surroundings(along, level, axis[ANCHOR], True, 0.0), 0.0, c) / begun
    for k in range(1, probe.size):
        along = cubic(probe[k - 1], probe_rate[k - 1], probe[k], probe_rate[k], h)
        touching, later = contact[k - 1] != 0.0, contact[k] != 0.0
        change = switch[k] * h if touching != later else 2.0 * h
        for j in range(parts):
            s, end = j * h / parts, (j + 1) * h / parts if j < parts - 1 else h
            if change <= end:
                around = Surroundings(along, level, axis[ANCHOR], touching, 0.0)
                write_motion(axis, 0, advance_axis(read_motion(axis, 0), s, max(s, change), around, c))
                if later:
                    axis[ANCHOR] = position_at(along, change) - axis[POSITION]
                touching, s, change = later, max(s, change), 2.0 * h
            around = Surroundings(along, level, axis[ANCHOR], touching, 0.0)
            write_motion(axis, 0, advance_axis(read_motion(axis, 0), s, end, around, c))
            if touching:
                at = k if j >= parts // 2 else k - 1
                whole = parts if 0 < at < probe.size - 1 else begun
                force[at] += contact_force(axis, 0, around, end, c) / whole
