"""Both tangential axes of the object over a window of samples, with the plant's own kernel."""

from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, contact_force, touch
from mmt_drake.model.forces import Surroundings, constants, level_spring
from mmt_drake.model.hermite import Cubic, cubic
from mmt_drake.model.tangential import advance_object
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
    state: Array,
    force: Array,
) -> None:
    """Free-running simulation from a given state.

    Args:
        h: time between samples [s].
        parts: ticks from one sample to the next; the body is advanced from tick to tick, as a plant would be.
        probe, probe_rate: (3, n) of the probe in the middle of each sample [m], [m/s].
        contact: (n,) 0 or 1.
        switch: (n,) where the contact differs from the sample before: the share of h from that one to the change.
        p: kernel vector.
        state: (2 AXIS_SIZE,) of the body in the middle of the first sample, advanced to that of the last.
        force: (2, (n - 1) parts + 1) to be filled with the force on the probe at each tick [N]; 0 off contact.

    Raises:
        RuntimeError: see `mmt_drake.model.body.advance_axis` and `mmt_drake.model.plane.advance_axes`.
    """
    c = constants(p)
    spring = level_spring(c)
    both = (spring, spring, c, p.ctypes.data, len(p))
    force[:] = 0.0
    n = len(contact)
    if n > 0 and contact[0] != 0.0:
        for i in range(2):
            along = Cubic(probe[i, 0], probe_rate[i, 0], 0.0, 0.0)
            level = Cubic(probe[2, 0], probe_rate[2, 0], 0.0, 0.0)
            around = Surroundings(along, level, state[AXIS_SIZE * i + ANCHOR], True, 0.0, spring)
            force[i, 0] = contact_force(state, AXIS_SIZE * i, around, 0.0, c)
    for k in range(1, n):
        along = cubic(probe[0, k - 1], probe_rate[0, k - 1], probe[0, k], probe_rate[0, k], h)
        across = cubic(probe[1, k - 1], probe_rate[1, k - 1], probe[1, k], probe_rate[1, k], h)
        level = cubic(probe[2, k - 1], probe_rate[2, k - 1], probe[2, k], probe_rate[2, k], h)
        touching, later = contact[k - 1] != 0.0, contact[k] != 0.0
        change = switch[k] * h if touching != later else 2.0 * h
        for j in range(parts):
            s, end = j * h / parts, (j + 1) * h / parts if j < parts - 1 else h
            if change <= end:
                advance_object(state, 0, s, max(s, change), along, across, level, touching, 0.0, *both)
                if later:
                    touch(state, 0, along, change, c)
                    touch(state, AXIS_SIZE, across, change, c)
                touching, s, change = later, max(s, change), 2.0 * h
            advance_object(state, 0, s, end, along, across, level, touching, 0.0, *both)
            if touching:
                at = (k - 1) * parts + j + 1
                around = Surroundings(along, level, state[ANCHOR], True, 0.0, spring)
                force[0, at] = contact_force(state, 0, around, end, c)
                around = Surroundings(across, level, state[AXIS_SIZE + ANCHOR], True, 0.0, spring)
                force[1, at] = contact_force(state, AXIS_SIZE, around, end, c)
