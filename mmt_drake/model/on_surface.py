"""The flexible object under a surface of any shape: `flexible_box` in the frame of the plane that touches it.

Who calls says at each sample which plane touches the surface under the tip (`local_contact.Facet`). In between the
plane half way from one to the next stands for the surface, and along it the contact acts on both axes of the body,
which are integrated as on a level surface. Where a slope ties them together each sees the other first going on as it
went, then as it has gone so. All is of second order in the time between samples, and exact where the plane stays;
slipping begins and ends at a sample.
"""

import math

from numba import njit

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION, read_motion, touch, write_motion
from mmt_drake.model.forces import constants
from mmt_drake.model.hermite import Cubic, cubic, position_at
from mmt_drake.model.local_contact import (
    Facet,
    Paths,
    axes_of,
    between_facets,
    carried,
    direction,
    height_above,
    is_level,
    local_path,
    shifted,
    spring_of,
    touching,
    turned,
)
from mmt_drake.model.normal_axis import begin_normal, press, touch_normal
from mmt_drake.model.parameters import NORMAL_AXIS, Constants, accurate_step
from mmt_drake.model.tangential import advance_object
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import ZERO, Vector, dot, get, minus, plus, times

_X, _Y = box.BODY, box.BODY + AXIS_SIZE


@njit(error_model="numpy", forceinline=True)
def put_facet(state: Array, facet: Facet) -> None:
    """Make a plane the one under the tip at the latest sample."""
    at = box.FACET
    state[at], state[at + 1], state[at + 2] = facet.n
    state[at + 3], state[at + 4], state[at + 5] = facet.c, facet.world, facet.mu


@njit(error_model="numpy", forceinline=True)
def _put_anchor(state: Array, tip: Vector, d: Vector) -> None:
    state[_X + ANCHOR] = tip[0] - state[_X + POSITION] - d[0]
    state[_Y + ANCHOR] = tip[1] - state[_Y + POSITION] - d[1]
    state[box.ANCHOR_Z] = tip[2] - d[2]


@njit(cache=True, error_model="numpy")
def begin_on(state: Array, t: float, motion: Array, contact: float, facet: Facet, p: Array) -> None:
    """The object at rest under the probe's first sample, in place; see `flexible_box.begin`."""
    box.begin(state, t, motion, contact, p)
    if is_level(facet):
        return
    put_facet(state, facet)
    if contact == box.CONTACT_BY_GEOMETRY:
        state[box.CONTACT] = 1.0 if height_above(facet, get(motion, 0)) < 0.0 else 0.0
    if state[box.CONTACT] != 0.0 and p[NORMAL_AXIS] != 0.0:
        above = height_above(facet, get(motion, 0))
        begin_normal(state, box.NORMAL, above, box.normal_constants(p, constants(p)))
    _put_anchor(state, get(motion, 0), ZERO)


@njit(error_model="numpy")
def predicted(state: Array, t: float, motion: Array, world: float) -> Vector:
    """Where the tip of a sample at time t [s] will be, from the body where that carries the surface [m].

    There the plane that touches the surface is to be found; the body is taken to go on as it goes.

    Args:
        state: of the object at the sample before.
        t: [s].
        motion: (6,) of the probe.
        world: of the surface, see `Facet`.
    """
    if world != 0.0:
        return get(motion, 0)
    position, velocity = box.body_of(state)
    return minus(get(motion, 0), plus(position, times(t - state[box.TIME], velocity)))


@njit(cache=True, error_model="numpy")
def advance_on(state: Array, t: float, motion: Array, contact: float, facet: Facet, p: Array) -> None:
    """Advance the object to the probe's next sample, in place; see `flexible_box.advance`, which a level surface takes.

    Args:
        state: (STATE_SIZE,) as left by `begin_on` or by the previous call.
        t: time of the sample [s].
        motion: (6,) position [m] and velocity [m/s] of the probe there.
        contact: as in `flexible_box.advance`.
        facet: the plane that touches the surface at `predicted`.
        p: kernel vector; its laws act along the two axes of the body, and are not limited where the tip slips. Along
            the normal it says more only where the surface stays and the tip does not slip.
    """
    before = box.facet_of(state)
    if is_level(facet) and is_level(before):
        box.advance(state, t, motion, contact, p)
        return
    c, h = constants(p), t - state[box.TIME]
    tip, rate = get(motion, 0), get(motion, 3)
    was_in = state[box.CONTACT] != 0.0
    position, velocity = box.body_of(state)
    moves = velocity if facet.world == 0.0 else ZERO
    lies = position if facet.world == 0.0 else ZERO
    above0 = height_above(before, minus(get(state, box.PROBE), lies))
    above1 = height_above(facet, minus(tip, plus(lies, times(h, moves))))
    is_in = above1 < 0.0 if contact == box.CONTACT_BY_GEOMETRY else contact != 0.0
    if h > 0.0:
        sinking0, sinking1 = minus(get(state, box.PROBE + 3), moves), minus(rate, moves)
        height = cubic(above0, dot(before.n, sinking0), above1, dot(facet.n, sinking1), h)
        s_switch = h
        if was_in != is_in and (above0 < 0.0) == was_in and (above1 < 0.0) == is_in:
            s_switch = box.crossing(height, h)
        _move(state, motion, h, s_switch, is_in, between_facets(before, facet), height, c, p)
    elif is_in and not was_in:
        _put_anchor(state, tip, ZERO)
    for i in range(6):
        state[box.PROBE + i] = motion[i]
    state[box.TIME] = t
    state[box.CONTACT] = 1.0 if is_in else 0.0
    put_facet(state, facet)
    if is_in:
        d = turned(box.deflection_of(state), facet.n)
        _put_anchor(state, tip, d)
        _put_anchor(state, tip, carried(d, box.touch_of(state, c), h, c.k2, c.b2))


@njit(error_model="numpy")
def _move(
    state: Array,
    motion: Array,
    h: float,
    s_switch: float,
    is_in: bool,
    facet: Facet,
    height: Cubic,
    c: Constants,
    p: Array,
) -> None:
    """Move body and deflection over h [s] along a plane; the anchor is left as for a tip at the end of its paths."""
    was_in = state[box.CONTACT] != 0.0
    tip0, d = get(state, box.PROBE), turned(box.deflection_of(state), facet.n)
    position, velocity = box.body_of(state)
    slips, way = False, ZERO
    if was_in and facet.mu != math.inf:
        now = touching(facet, box.tip_of(state), get(state, box.PROBE + 3), d, velocity, c)
        slips = now.limited < 1.0
        way = direction(now) if now.normal > 0.0 else ZERO
    paths = Paths(
        box.path_of_probe(state, motion, 0, h), box.path_of_probe(state, motion, 1, h),
        box.path_of_probe(state, motion, 2, h),
    )  # fmt: skip
    first, second = axes_of(facet)
    if facet.world != 0.0:
        along, across_it = local_path(paths, first), local_path(paths, second)
        start_x, start_y = dot(first, tip0), dot(second, tip0)
        state[_X + ANCHOR] = start_x - position[0] - dot(first, d)
        state[_Y + ANCHOR] = start_y - position[1] - dot(second, d)
    else:
        along, across_it = paths.x, paths.y
        _put_anchor(state, tip0, d)
    for part in range(2):  # before the contact changes and after it
        if part == 1 and is_in and not was_in:
            touch(state, _X, along, s_switch, c)
            touch(state, _Y, across_it, s_switch, c)
            if c.normal_axis != 0.0:
                touch_normal(state, box.NORMAL, height, s_switch, box.normal_constants(p, c))
            state[box.ANCHOR_Z] = position_at(paths.z, s_switch)
        s, s_end, held = (0.0, s_switch, was_in) if part == 0 else (s_switch, h, is_in)
        if s < s_end:
            load = height
            if c.normal_axis != 0.0 and held:
                start = state[box.TIME] - state[box.BEGAN]
                load = press(state, box.NORMAL, height, s, s_end, start, box.normal_constants(p, c))
            _push(state, s, s_end, along, across_it, paths, facet, load, held, slips and part == 0, way, c, p)
    tip = get(motion, 0)
    if facet.world != 0.0:
        dx = dot(first, tip) - state[_X + POSITION] - state[_X + ANCHOR]
        dy = dot(second, tip) - state[_Y + POSITION] - state[_Y + ANCHOR]
        _put_anchor(state, tip, plus(times(dx, first), times(dy, second)))
    else:
        d = (
            tip[0] - state[_X + POSITION] - state[_X + ANCHOR],
            tip[1] - state[_Y + POSITION] - state[_Y + ANCHOR],
            tip[2] - state[box.ANCHOR_Z],
        )
        _put_anchor(state, tip, minus(d, times(dot(d, facet.n), facet.n)))


@njit(error_model="numpy")
def _push(
    state: Array,
    s: float,
    s_end: float,
    along: Cubic,
    across_it: Cubic,
    paths: Paths,
    facet: Facet,
    load: Cubic,
    contact: bool,
    slips: bool,
    way: Vector,
    c: Constants,
    p: Array,
) -> None:
    """Advance the body from s to s_end [s] after the latest sample, in steps that follow the stiffer of the springs."""
    longest = accurate_step(c.m, c.k1, max(c.k2, c.normal_k), c.b1, max(c.b2, c.normal_b))
    steps = max(1, math.ceil((s_end - s) / longest - 1e-9))
    tied = contact and facet.world == 0.0 and (facet.n[0] != 0.0 or facet.n[1] != 0.0)
    start = state[box.TIME] - state[box.BEGAN]
    h = (s_end - s) / steps
    if not tied and not slips:
        steps, h = 1, s_end - s
    for k in range(steps):
        s0 = s + k * h
        s1 = s_end if k == steps - 1 else s0 + h
        x0, y0 = read_motion(state, _X), read_motion(state, _Y)
        to_x, to_y = shifted(Cubic(x0.x, x0.v, 0.0, 0.0), s0), shifted(Cubic(y0.x, y0.v, 0.0, 0.0), s0)
        anchor = (state[_X + ANCHOR], state[_Y + ANCHOR], state[box.ANCHOR_Z])
        for again in range(3 if tied else 1):
            if again > 0:
                x1, y1 = read_motion(state, _X), read_motion(state, _Y)
                if s1 > s0:
                    to_x = shifted(cubic(x0.x, x0.v, x1.x, x1.v, s1 - s0), s0)
                    to_y = shifted(cubic(y0.x, y0.v, y1.x, y1.v, s1 - s0), s0)
                write_motion(state, _X, x0)
                write_motion(state, _Y, y0)
            first = spring_of(facet, 0, paths, to_y, anchor, slips, way, c)
            second = spring_of(facet, 1, paths, to_x, anchor, slips, way, c)
            both = (first, second, c, p.ctypes.data, len(p))
            advance_object(state, box.BODY, s0, s1, along, across_it, load, contact, start, *both)
