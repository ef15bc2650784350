"""Both tangential axes of the object over a window of samples, with the plant's own kernel."""

from numba import njit

from mmt_drake.estimation.output_error.unsure_touches import since_touch
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, read_motion, touch
from mmt_drake.model.forces import Spring, Surroundings, constants, contact_forces, level_spring
from mmt_drake.model.hermite import Cubic, cubic, velocity_at
from mmt_drake.model.parameters import Constants
from mmt_drake.model.tangential import advance_object
from mmt_drake.numeric.arrays import Array


@njit(error_model="numpy", forceinline=True)
def _felt(
    state: Array, s: float, along: Cubic, across: Cubic, level: Cubic, spring: Spring, c: Constants
) -> tuple[float, float]:
    """Force on the probe along both axes, in contact [N]."""
    x, y = read_motion(state, 0), read_motion(state, AXIS_SIZE)
    first = Surroundings(along, level, state[ANCHOR], True, 0.0, spring)
    return contact_forces(x, y, s, first, Surroundings(across, level, state[AXIS_SIZE + ANCHOR], True, 0.0, spring), c)


@njit(cache=True, error_model="numpy", nogil=True)
def replay_window(
    h: float,
    parts: int,
    probe: Array,
    probe_rate: Array,
    contact: Array,
    switch: Array,
    higher: Array,
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
        higher: (n,) by how much the surface that is touched there is higher than contact says [m]: the contact spring
            is anchored where the probe was on it.
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
        along = Cubic(probe[0, 0], probe_rate[0, 0], 0.0, 0.0)
        across = Cubic(probe[1, 0], probe_rate[1, 0], 0.0, 0.0)
        level = Cubic(probe[2, 0], probe_rate[2, 0], 0.0, 0.0)
        force[0, 0], force[1, 0] = _felt(state, 0.0, along, across, level, spring, c)
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
                    if higher[k] != 0.0:
                        before = since_touch(higher[k], velocity_at(level, change))
                        state[ANCHOR] -= before * velocity_at(along, change)
                        state[AXIS_SIZE + ANCHOR] -= before * velocity_at(across, change)
                touching, s, change = later, max(s, change), 2.0 * h
            advance_object(state, 0, s, end, along, across, level, touching, 0.0, *both)
            if touching:
                at = (k - 1) * parts + j + 1
                force[0, at], force[1, at] = _felt(state, end, along, across, level, spring, c)
