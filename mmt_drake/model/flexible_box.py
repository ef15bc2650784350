"""The flexible object on the table: equations of motion and their compiled integration.

One tangential axis (figure 3 of the thesis; x and y are alike, and independent but for friction in the plane)::

    m v_m' = k2 d + b2 (v - v_m) - k1 x_m - b1 v_m - friction        in contact
    m v_m' =                     - k1 x_m - b1 v_m - friction        off contact
    F      = -(k2 d + b2 (v - v_m)),   d = x - x_m - (x - x_m at touch)

The normal axis is the Kelvin-Voigt contact of eq. 8, F_z = -k z - b v_z for z < 0, and free space
is eq. 9, F = 0. With laws along it, it is that of `mmt_drake.model.normal_axis`.

This is a level surface; on any other `mmt_drake.model.on_surface` moves the object, of the same state.

Touch and release are located within a step, so a result depends on the sampling of the motion only through its
interpolation. How a body with friction is integrated stands in `mmt_drake.model.body`, with friction that is a vector
in `mmt_drake.model.plane`.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.model.body import (
    ANCHOR,
    AXIS_SIZE,
    BISECTIONS,
    POSITION,
    READING,
    VELOCITY,
    read_motion,
    sense,
    touch,
)  # fmt: skip
from mmt_drake.model.forces import (
    Spring,
    Surroundings,
    beside,
    constants,
    contact_forces,
    law_push,
    level_spring,
    normal_force,
)
from mmt_drake.model.hermite import Cubic, cubic, position_at
from mmt_drake.model.local_contact import Facet, Touch, axes_of, force_of, height_above, is_level, touching
from mmt_drake.model.normal_axis import begin_normal, press, pressed, stored_in_normal_laws, touch_normal
from mmt_drake.model.parameters import B2, K1, NORMAL_B, NORMAL_K, Constants
from mmt_drake.model.tangential import advance_object
from mmt_drake.model.turned import TURN_SIZE, in_force_frame
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import Vector, dot, get, minus, plus, times

# Layout of the state vector.
_next = Layout()
TIME = _next()  # [s] of the latest sample
PROBE = _next(6)  # position [m] and velocity [m/s] at that sample
CONTACT = _next()  # 0 or 1
BEGAN = _next()  # [s], time of the first sample
ANCHOR_Z = _next()  # height of the tip where the contact spring is unstretched [m]; 0 on a level surface
FACET = _next(6)  # under the tip at that sample: n, c, world, mu of `local_contact.Facet`
BODY = _next(2 * AXIS_SIZE)  # two axes of `mmt_drake.model.body`
NORMAL = _next(AXIS_SIZE)  # the third, behind those, if there is more than a spring and a damper along it
STATE_SIZE = _next.size

#: `contact` argument of `advance`: contact is where the probe is below the surface.
CONTACT_BY_GEOMETRY = -1.0


@njit(error_model="numpy")
def crossing(height: Cubic, h: float) -> float:
    """Time after the sample at which the probe's height above the surface changes sign within h [s]."""
    above = height.x0 >= 0.0
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        if (position_at(height, mid) >= 0.0) == above:
            low = mid
        else:
            high = mid
    return high


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, motion: Array, contact: float, p: Array) -> None:
    """The object at rest under the probe's first sample, in place.

    Args:
        state: (STATE_SIZE,) to be filled.
        t: time of the first sample [s].
        motion: (6,) position [m] and velocity [m/s] of the probe.
        contact: 0 or 1, or CONTACT_BY_GEOMETRY.
        p: kernel vector.
    """
    state[:] = 0.0
    state[TIME] = state[BEGAN] = t
    state[FACET + 2], state[FACET + 4], state[FACET + 5] = 1.0, 1.0, math.inf
    touching = motion[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    state[CONTACT] = 1.0 if touching else 0.0
    for i in range(6):
        state[PROBE + i] = motion[i]
    for i in range(2):
        state[BODY + AXIS_SIZE * i + ANCHOR] = motion[i]
    c = constants(p)
    if touching and c.normal_axis != 0.0:
        begin_normal(state, NORMAL, motion[2], normal_constants(p, c))
    _read_sensor(state, 0.0, p, c)


@njit(cache=True, error_model="numpy")
def advance(
    state: Array, t: float, motion: Array, contact: float, p: Array, push_x: float = 0.0, push_y: float = 0.0
) -> None:
    """Advance the object to the probe's next sample, in place; t must not lie before the state's time.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: time of the sample [s]; equal to the state's time only replaces the sample.
        motion: (6,) position [m] and velocity [m/s] of the probe there.
        contact: CONTACT_BY_GEOMETRY (z < 0, touch and release located between samples), or 0 or 1 as
            a detector or a recording has it (then touch and release fall on the surface crossing if
            there is one in this interval, else on the sample).
        p: kernel vector.
        push_x, push_y: what beside the probe pushes the body all the time, in contact or not [N].
    """
    h = t - state[TIME]
    before = state[CONTACT] != 0.0
    after = motion[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    z0 = state[PROBE + 2]
    s_switch = h
    height = Cubic(motion[2], motion[5], 0.0, 0.0)
    if h > 0.0:
        height = cubic(z0, state[PROBE + 5], motion[2], motion[5], h)
    if before != after and h > 0.0 and (z0 < 0.0) == before and (motion[2] < 0.0) == after:
        s_switch = crossing(height, h)
    start, c = state[TIME] - state[BEGAN], constants(p)
    along, across = path_of_probe(state, motion, 0, h), path_of_probe(state, motion, 1, h)
    load = height
    for part in range(2):  # before the contact changes and after it: a loop, as what it calls is long to compile
        s, s_end, touches = (0.0, s_switch, before) if part == 0 else (s_switch, h, after)
        if part == 1 and after and not before:
            touch(state, BODY, along, s_switch, c)
            touch(state, BODY + AXIS_SIZE, across, s_switch, c)
            if c.normal_axis != 0.0:
                touch_normal(state, NORMAL, height, s_switch, normal_constants(p, c))
        if s < s_end:
            if c.normal_axis != 0.0 and touches:
                load = press(state, NORMAL, height, s, s_end, start, normal_constants(p, c))
            _move(state, s, s_end, along, across, load, touches, start, push_x, push_y, c, p)
    state[TIME] = t
    state[CONTACT] = 1.0 if after else 0.0
    for i in range(6):
        state[PROBE + i] = motion[i]
    _read_sensor(state, h, p, c)


@njit(error_model="numpy", forceinline=True)
def _move(
    state: Array,
    s: float,
    s_end: float,
    along: Cubic,
    across: Cubic,
    load: Cubic,
    touches: bool,
    start: float,
    push_x: float,
    push_y: float,
    c: Constants,
    p: Array,
) -> None:
    """Advance the body from s to s_end, pushed by the probe where that touches and by a force [N].

    A contact pushes, so one is made where the probe does not touch: without stiffness, with a tip that goes as the
    body goes at first.
    """
    anchors = state[BODY + ANCHOR], state[BODY + AXIS_SIZE + ANCHOR]
    k, b, held = c.k2, c.b2, touches
    drifts = not touches and (push_x != 0.0 or push_y != 0.0)
    if drifts:
        k, b, held, load = 0.0, 0.0, True, Cubic(0.0, 0.0, 0.0, 0.0)
        state[BODY + ANCHOR] = state[BODY + AXIS_SIZE + ANCHOR] = 0.0
        (x0, y0, _), (vx, vy, _) = body_of(state)
        along, across = Cubic(x0 - vx * s, vx, 0.0, 0.0), Cubic(y0 - vy * s, vy, 0.0, 0.0)
    first, second = Spring(k, b, Cubic(push_x, 0.0, 0.0, 0.0)), Spring(k, b, Cubic(push_y, 0.0, 0.0, 0.0))
    both = (first, second, c, p.ctypes.data, len(p))
    advance_object(state, BODY, s, s_end, along, across, load, held, start, *both)
    if drifts:
        state[BODY + ANCHOR], state[BODY + AXIS_SIZE + ANCHOR] = anchors


@njit(error_model="numpy", forceinline=True)
def path_of_probe(state: Array, motion: Array, i: int, h: float) -> Cubic:
    """Of the probe along x (0), y (1) or z (2) from the latest sample to the next, h [s] later."""
    if h > 0.0:
        return cubic(state[PROBE + i], state[PROBE + 3 + i], motion[i], motion[3 + i], h)
    return Cubic(motion[i], motion[3 + i], 0.0, 0.0)


@njit(error_model="numpy", forceinline=True)
def normal_constants(p: Array, c: Constants) -> Constants:
    """Those of the normal axis, which stands in the kernel vector for itself, with the body's normal_k and normal_b."""
    own = p[int(c.normal_axis) + TURN_SIZE :]
    own[K1], own[B2] = p[NORMAL_K], p[NORMAL_B]
    return constants(own)


@njit(error_model="numpy")
def stored_along_normal(state: Array, p: Array) -> float:
    """The energy that laws along the normal hold at the latest sample, in contact [J]."""
    own = normal_constants(p, constants(p))
    return stored_in_normal_laws(state, NORMAL, _above(state), 0.0, state[TIME] - state[BEGAN], own)


@njit(error_model="numpy")
def _above(state: Array) -> Cubic:
    """The tip's height above the surface at the latest sample [m], and its rate."""
    facet = facet_of(state)
    if is_level(facet):
        return Cubic(state[PROBE + 2], state[PROBE + 5], 0.0, 0.0)
    return Cubic(height_above(facet, tip_of(state)), dot(facet.n, get(state, PROBE + 3)), 0.0, 0.0)


@njit(error_model="numpy")
def _along_normal(state: Array, height: Cubic, p: Array, c: Constants) -> float:
    """Force along the normal at the latest sample, in contact, where the kernel vector says more of it [N]."""
    return pressed(state, NORMAL, height, 0.0, state[TIME] - state[BEGAN], normal_constants(p, c))


@njit(error_model="numpy", forceinline=True)
def _forces(state: Array, p: Array, c: Constants) -> tuple[float, float, float]:
    """Force on the probe at the latest sample [N]."""
    if state[CONTACT] == 0.0:
        return 0.0, 0.0, 0.0
    t = state[TIME] - state[BEGAN]
    height = Cubic(state[PROBE + 2], state[PROBE + 5], 0.0, 0.0)
    if c.normal_axis != 0.0:
        height = Cubic(_along_normal(state, height, p, c), 0.0, 0.0, 0.0)
    x, y = read_motion(state, BODY), read_motion(state, BODY + AXIS_SIZE)
    along, across = _around(state, 0, height, t, c), _around(state, 1, height, t, c)
    felt_x, felt_y = contact_forces(x, y, 0.0, along, across, c)
    return felt_x, felt_y, normal_force(height.x0, height.v0, c)


@njit(error_model="numpy", forceinline=True)
def _around(state: Array, i: int, height: Cubic, t: float, c: Constants) -> Surroundings:
    """What acts along x (0) or y (1) on a level surface, in contact."""
    probe = Cubic(state[PROBE + i], state[PROBE + 3 + i], 0.0, 0.0)
    return Surroundings(probe, height, state[BODY + AXIS_SIZE * i + ANCHOR], True, t, level_spring(c))


@njit(error_model="numpy", forceinline=True)
def _read_sensor(state: Array, h: float, p: Array, c: Constants) -> None:
    """Let the force sensor read the latest sample, h [s] after the one before."""
    x, y, z = _forces(state, p, c)
    t = state[TIME] - state[BEGAN]
    if c.normal_axis != 0.0:
        x, y, z = in_force_frame(p, int(c.normal_axis), x, y, z)
    sense(state, BODY, x, z, state[PROBE + 3], t, h, c)
    sense(state, BODY + AXIS_SIZE, y, z, state[PROBE + 4], t, h, c)
    if c.normal_axis != 0.0:
        sense(state, NORMAL, z, z, state[PROBE + 5], t, h, normal_constants(p, c))
    else:
        state[NORMAL + READING] = z


@njit(error_model="numpy", forceinline=True)
def facet_of(state: Array) -> Facet:
    """The plane under the tip at the latest sample."""
    return Facet(get(state, FACET), state[FACET + 3], state[FACET + 4], state[FACET + 5])


@njit(error_model="numpy", forceinline=True)
def body_of(state: Array) -> tuple[Vector, Vector]:
    """Where the body is, and its velocity [m], [m/s]; their third numbers are 0."""
    x, y = BODY, BODY + AXIS_SIZE
    return (state[x + POSITION], state[y + POSITION], 0.0), (state[x + VELOCITY], state[y + VELOCITY], 0.0)


@njit(error_model="numpy", forceinline=True)
def deflection_of(state: Array) -> Vector:
    """Of the contact spring at the latest sample [m]."""
    anchor = (state[BODY + ANCHOR], state[BODY + AXIS_SIZE + ANCHOR], state[ANCHOR_Z])
    return minus(minus(get(state, PROBE), body_of(state)[0]), anchor)


@njit(error_model="numpy", forceinline=True)
def tip_of(state: Array) -> Vector:
    """The tip at the latest sample, from the body where that carries the surface [m]."""
    return get(state, PROBE) if state[FACET + 4] != 0.0 else minus(get(state, PROBE), body_of(state)[0])


@njit(error_model="numpy")
def touch_of(state: Array, c: Constants) -> Touch:
    """The contact at the latest sample, on any surface."""
    rate, velocity = get(state, PROBE + 3), body_of(state)[1]
    return touching(facet_of(state), tip_of(state), rate, deflection_of(state), velocity, c)


@njit(error_model="numpy")
def axes_of_laws(state: Array) -> tuple[Vector, Vector]:
    """Along which laws act on the two axes of the body: the plane's where the surface stays, else the table's."""
    facet = facet_of(state)
    if is_level(facet) or facet.world == 0.0:
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    return axes_of(facet)


@njit(error_model="numpy")
def around_axis(state: Array, i: int, axis: Vector, p: Array, c: Constants) -> Surroundings:
    """What acts along an axis on the body, of which it is the first (0) or the second (1), at the latest sample."""
    tip, rate, height = get(state, PROBE), get(state, PROBE + 3), _above(state)
    if c.normal_axis != 0.0 and state[CONTACT] != 0.0:
        height = Cubic(_along_normal(state, height, p, c), 0.0, 0.0, 0.0)
    x = state[BODY + AXIS_SIZE * i + POSITION]
    probe, anchor = dot(axis, tip), dot(axis, tip) - x - dot(axis, deflection_of(state))
    t, contact = state[TIME] - state[BEGAN], state[CONTACT] != 0.0
    return Surroundings(Cubic(probe, dot(axis, rate), 0.0, 0.0), height, anchor, contact, t, level_spring(c))


@njit(error_model="numpy")
def _push_of_laws(state: Array, p: Array, c: Constants) -> Vector:
    """By which laws of a contact push the body, on a surface that is not level [N]."""
    first, second = axes_of_laws(state)
    x, y = read_motion(state, BODY), read_motion(state, BODY + AXIS_SIZE)
    along, across = around_axis(state, 0, first, p, c), around_axis(state, 1, second, p, c)
    push_x = law_push(x, 0.0, along, c, beside(y, 0.0, across, c))
    return plus(times(push_x, first), times(law_push(y, 0.0, across, c, beside(x, 0.0, along, c)), second))


@njit(cache=True, error_model="numpy")
def force_on_probe(state: Array, p: Array, force: Array) -> None:
    """Write the (3,) force that the object exerts on the probe at the latest sample [N]."""
    c = constants(p)
    if is_level(facet_of(state)):
        force[0], force[1], force[2] = _forces(state, p, c)
    elif state[CONTACT] != 0.0:
        touch = touch_of(state, c)
        if c.normal_axis != 0.0:
            touch = Touch(_along_normal(state, _above(state), p, c), touch.tangential, touch.limited)
        felt = force_of(touch, get(state, FACET))
        force[0], force[1], force[2] = felt if c.laws == 0 else minus(felt, _push_of_laws(state, p, c))
    else:
        force[0] = force[1] = force[2] = 0.0


@njit(cache=True, error_model="numpy")
def reading(state: Array, p: Array, force: Array) -> None:
    """Write the (3,) force that the sensor reads at the latest sample [N]; without sensor effects the true one."""
    if not is_level(facet_of(state)):  # where no sensor has effects
        force_on_probe(state, p, force)
        return
    for i in range(3):
        force[i] = state[BODY + AXIS_SIZE * i + READING]


@njit(cache=True, error_model="numpy")
def replay(time: Array, position: Array, velocity: Array, contact: Array, p: Array, force: Array, body: Array) -> None:
    """Free-running simulation over a whole recording, at rest at the first sample.

    Args:
        time: (n,) sample times [s], increasing.
        position, velocity: (n, 3) of the probe [m], [m/s].
        contact: (n,) of 0 and 1, or of CONTACT_BY_GEOMETRY.
        p: kernel vector.
        force: (n, 3) to be filled with the force that the sensor reads [N].
        body: (n, 4) to be filled with x_m, y_m [m] and their rates [m/s].
    """
    replay_part(np.empty(STATE_SIZE), 0, len(time), time, position, velocity, contact, p, force, body)


@njit(cache=True, error_model="numpy")
def replay_part(
    state: Array,
    first: int,
    end: int,
    time: Array,
    position: Array,
    velocity: Array,
    contact: Array,
    p: Array,
    force: Array,
    body: Array,
) -> None:
    """`replay` of the samples from `first` to before `end`, the state (STATE_SIZE,) being that after those before."""
    motion = np.empty(6)  # rows of arrays as arguments would cost as much as the integration
    for k in range(first, end):
        for i in range(3):
            motion[i], motion[3 + i] = position[k, i], velocity[k, i]
        if k == 0:
            begin(state, time[k], motion, contact[k], p)
        else:
            advance(state, time[k], motion, contact[k], p)
        for i in range(3):
            force[k, i] = state[BODY + AXIS_SIZE * i + READING]
        for i in range(2):
            body[k, i] = state[BODY + AXIS_SIZE * i + POSITION]
            body[k, 2 + i] = state[BODY + AXIS_SIZE * i + VELOCITY]
