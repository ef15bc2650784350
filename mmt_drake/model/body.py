"""One body with friction on one axis: its state, and the compiled integration of its equation of motion.

The equation stands in `mmt_drake.model.forces`. Friction is set-valued at rest, so the integration knows two modes.
*Sliding* in one direction the equation is smooth and a classical Runge-Kutta step (order 4) is taken, the input being
evaluated inside the step. The step ends where the body would stick or turn, and there the mode changes. *Stuck*, the
body waits until the drive passes the break-away level; laws with a memory go on meanwhile.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.model.forces import (
    ALONE,
    Beside,
    BodyMotion,
    Forces,
    Spring,
    Stretch,
    Surroundings,
    deflection,
    forces,
    knowledge,
    whole_deflection,
)
from mmt_drake.model.hermite import Cubic, cubic, position_at, velocity_at
from mmt_drake.model.law_table import ENTRY, entries_of, evaluate, memory_of
from mmt_drake.model.laws import NOTHING, At, Memory, Slot, norm
from mmt_drake.model.memory import after_step, between, moved, read_memory, write_memory
from mmt_drake.model.parameters import LAW_TABLE, Constants
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

# Layout of a body's state.
_next = Layout()
POSITION, VELOCITY, ANCHOR = _next(), _next(), _next()
MODE = _next()  # 0 stuck, else the direction of sliding
MEMORY_SIZE = 4
MEMORY = _next(MEMORY_SIZE)  # of laws on the body
SENSOR_MEMORY = _next(4)  # of laws in the sensor
READING = _next()  # what the force sensor reads [N]
AXIS_SIZE = _next.size

BISECTIONS = 40  # halve a step of 1 ms to 1e-15 s
_MOST_STEPS = 1e7  # within one sample interval: a second of work, in which no Ctrl-C is heard
_MOST_EVENTS = 1000  # mode changes within one sample interval, which no physical friction makes
_MOST_SLIPS = 20  # of a creeping body within an integration step; beyond, it rests for the next
_AT_LEVEL = 1.0 + 1e-6  # times what holds a body: still held, to rounding
_STEP_TIMES_DECAY = 1.5  # a Runge-Kutta step holds at most this much of a law's fastest decay
_MOST_DECAYS = 50.0  # of a law's memory within one step of the body; beyond, the law or its state is absurd
_EDGE_STEPS = 32.0  # of those within reach of the edge of a clearance there are so many for one

# Slots as plain numbers, for the kernels.
_CONTACT, _SENSOR = int(Slot.CONTACT), int(Slot.SENSOR)


@njit(error_model="numpy", forceinline=True)
def _acceleration(body: BodyMotion, acting: Forces) -> float:
    """Of a body that slides [m/s^2]."""
    return (acting.drive - body.mode * acting.sliding) * acting.inverse_mass


@njit(error_model="numpy", forceinline=True)
def _slide(body: BodyMotion, first: Forces, s: float, h: float, around: Surroundings, p: Constants) -> BodyMotion:
    """A body that slides after a Runge-Kutta step of order 4; `first` acts on it at s."""
    half = 0.5 * h
    x, v, mode, q = body
    a1 = _acceleration(body, first)
    body2 = BodyMotion(x + half * v, v + half * a1, mode, moved(q, half, first.rates))
    second = forces(body2, s + half, around, p, ALONE)
    a2 = _acceleration(body2, second)
    body3 = BodyMotion(x + half * body2.v, v + half * a2, mode, moved(q, half, second.rates))
    third = forces(body3, s + half, around, p, ALONE)
    a3 = _acceleration(body3, third)
    body4 = BodyMotion(x + h * body3.v, v + h * a3, mode, moved(q, h, third.rates))
    fourth = forces(body4, s + h, around, p, ALONE)
    a4 = _acceleration(body4, fourth)
    return BodyMotion(
        x + h / 6.0 * (v + 2.0 * body2.v + 2.0 * body3.v + body4.v),
        v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        mode,
        after_step(q, h, first.rates, second.rates, third.rates, fourth.rates),
    )


@njit(error_model="numpy")
def pull_at_rest(
    x: float, q: Memory, s: float, around: Surroundings, p: Constants, other: Beside
) -> tuple[float, float]:
    """The force that friction has to hold of a body at rest [N], and the level that it can hold that way [N]."""
    pull = forces(BodyMotion(x, 0.0, 0.0, q), s, around, p, other).drive
    return pull, forces(BodyMotion(x, 0.0, math.copysign(1.0, pull), q), s, around, p, other).hold


@njit(error_model="numpy", forceinline=True)
def _may_stick(body: BodyMotion, s: float, around: Surroundings, p: Constants) -> bool:
    """Karnopp's condition; what has to be held is the drive of a body at rest."""
    if abs(body.v) >= p.v_d:
        return False
    pull, hold = pull_at_rest(body.x, body.q, s, around, p, ALONE)
    return abs(pull) < hold


@njit(error_model="numpy")
def limited(h: float, decay: float) -> float:
    """A step of at most h [s] under a decay [1/s]."""
    if decay * h <= _STEP_TIMES_DECAY:
        return h
    if not decay * h < _MOST_DECAYS:
        raise RuntimeError("the memory of a law decays more than 50 times within one step")
    return _STEP_TIMES_DECAY / decay


@njit(error_model="numpy", forceinline=True)
def _acting_along(q: Memory, s: float, path: Cubic, around: Surroundings, p: Constants) -> Forces:
    """The forces on a body that moves along a path."""
    v = velocity_at(path, s)
    return forces(BodyMotion(position_at(path, s), v, np.sign(v), q), s, around, p, ALONE)


@njit(error_model="numpy")
def remember(q: Memory, s: float, s_end: float, path: Cubic, around: Surroundings, p: Constants) -> Memory:
    """Advance the memory of the laws while the body moves along a path.

    Args:
        q: at s.
        s, s_end: the stretch of time [s] after the first sample.
        path: of the body [m].
        around: what acts on it.
        p: of the body.
    """
    while s < s_end:
        first = _acting_along(q, s, path, around, p)
        h = limited(min(s_end - s, p.max_step), first.decay)
        half = 0.5 * h
        second = _acting_along(moved(q, half, first.rates), s + half, path, around, p)
        third = _acting_along(moved(q, half, second.rates), s + half, path, around, p)
        fourth = _acting_along(moved(q, h, third.rates), s + h, path, around, p)
        q = after_step(q, h, first.rates, second.rates, third.rates, fourth.rates)
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return q


@njit(error_model="numpy", forceinline=True)
def short_at_edge(h: float, body: BodyMotion, s: float, around: Surroundings, p: Constants, other: Beside) -> float:
    """A step of at most h [s], short where it may reach the edge of the clearance: there the damper's force jumps."""
    if p.driven or not around.contact:
        return h
    d, d_rate = whole_deflection(body.x, body.v, s, around, p)
    reach = 1.5 * h * norm(d_rate, other.d_rate)
    return h / _EDGE_STEPS if abs(norm(d, other.d) - 0.5 * p.gap) <= reach else h


@njit(error_model="numpy")
def break_away(
    x: float, q: Memory, s: float, s_end: float, around: Surroundings, p: Constants
) -> tuple[float, float, Memory]:
    """Time within [s, s_end] at which a stuck body lets go, its direction and memory then; s_end, 0 if it does not."""
    pull, hold = pull_at_rest(x, q, s, around, p, ALONE)
    if abs(pull) > hold:
        return s, math.copysign(1.0, pull), q
    path = Cubic(x, 0.0, 0.0, 0.0)
    while s < s_end:
        h, q1 = s_end - s, q
        if p.remembers:
            h = min(h, p.max_step)
            q1 = remember(q, s, s + h, path, around, p)
        pull, hold = pull_at_rest(x, q1, s + h, around, p, ALONE)
        if abs(pull) > hold:
            low, high = 0.0, h
            for _ in range(BISECTIONS):
                mid = 0.5 * (low + high)
                pull, hold = pull_at_rest(x, between(q, q1, mid / h), s + mid, around, p, ALONE)
                if abs(pull) > hold:
                    high = mid
                else:
                    low = mid
            q = between(q, q1, high / h)
            pull, _ = pull_at_rest(x, q, s + high, around, p, ALONE)
            return s + high, math.copysign(1.0, pull), q
        q = q1
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return s_end, 0.0, q


@njit(error_model="numpy")
def _end_of_slide(
    body: BodyMotion, a: float, body1: BodyMotion, s: float, h: float, around: Surroundings, p: Constants
) -> float:
    """Time after s, within a step of h, at which a sliding body turns or sticks.

    The body's motion inside the step is the cubic through its ends, `body` with acceleration a and `body1`.
    """
    position = cubic(body.x, body.v, body1.x, body1.v, h)
    velocity = cubic(body.v, a, body1.v, _acceleration(body1, forces(body1, s + h, around, p, ALONE)), h)
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        q = between(body.q, body1.q, mid / h)
        inside = BodyMotion(position_at(position, mid), position_at(velocity, mid), body.mode, q)
        if inside.v * inside.mode < 0.0 or _may_stick(inside, s + mid, around, p):
            high = mid
        else:
            low = mid
    return high


@njit(cache=True, error_model="numpy")
def advance_axis(body: BodyMotion, s: float, s_end: float, around: Surroundings, p: Constants) -> BodyMotion:
    """Advance a body from s to s_end [s] after the latest sample.

    Args:
        body: at s.
        s, s_end: the stretch of time within the sample interval.
        around: what acts on it.
        p: of the body.

    Returns:
        The body at s_end.

    Raises:
        RuntimeError: the body would stick and slide without end, its laws decay too fast to follow, or the stretch is
            ten million steps long.
    """
    h_max = s_end - s
    if h_max > p.max_step:
        if not h_max <= _MOST_STEPS * p.max_step:
            raise RuntimeError("two samples more than ten million integration steps apart")
        h_max /= math.ceil(h_max / p.max_step)
    events, began = 0, s
    while s < s_end:
        if body.mode == 0.0 and not p.smooth:
            s, mode, q = break_away(body.x, body.q, s, s_end, around, p)
            body = BodyMotion(body.x, 0.0, mode, q)
            if mode == 0.0:
                break
        acting = forces(body, s, around, p, ALONE)
        h = h_max if p.gap == 0.0 else short_at_edge(h_max, body, s, around, p, ALONE)
        h = limited(h, acting.decay)
        last = s + h >= s_end - 1e-9 * h
        if last:
            h = s_end - s
        body1 = _slide(body, acting, s, h, around, p)
        if not p.smooth and (body1.v * body1.mode < 0.0 or _may_stick(body1, s + h, around, p)):
            events += 1
            if events > _MOST_EVENTS:
                raise RuntimeError("the body sticks and slides more than 1000 times within one step")
            h = _end_of_slide(body, _acceleration(body, acting), body1, s, h, around, p)
            last = False
            x, _, _, q = _slide(body, acting, s, h, around, p)
            # It stops there: held by friction, or to turn because the drive beats friction the other way.
            pull, hold = pull_at_rest(x, q, s + h, around, p, ALONE)
            body1 = BodyMotion(x, 0.0, 0.0 if abs(pull) <= hold else math.copysign(1.0, pull), q)
            if abs(pull) <= _AT_LEVEL * hold and events * h_max > _MOST_SLIPS * (s + h - began + h_max):
                # A probe that creeps at the break-away level makes it slip by less than an atom's width, ever again.
                rest = min(h_max, s_end - s - h)
                if p.remembers:
                    q = remember(q, s + h, s + h + rest, Cubic(x, 0.0, 0.0, 0.0), around, p)
                body1, h = BodyMotion(x, 0.0, 0.0, q), h + rest
                last = s + h >= s_end - 1e-9 * h_max
        body = body1
        s = s_end if last else s + h
    return body


@njit(error_model="numpy", forceinline=True)
def read_motion(state: Array, at: int) -> BodyMotion:
    """Of the body that begins at `at` in the state."""
    return BodyMotion(state[at + POSITION], state[at + VELOCITY], state[at + MODE], read_memory(state, at + MEMORY))


@njit(error_model="numpy", forceinline=True)
def write_motion(state: Array, at: int, body: BodyMotion) -> None:
    """Put the body where it begins at `at` in the state."""
    state[at + POSITION], state[at + VELOCITY], state[at + MODE] = body.x, body.v, body.mode
    write_memory(state, at + MEMORY, body.q)


@njit(error_model="numpy")
def advance_memory(state: Array, at: int, h: float, path: Cubic, around: Surroundings, p: Constants) -> None:
    """Advance the memory of the body that begins at `at` by h [s] from the latest sample along its path."""
    q = read_memory(state, at + MEMORY)
    write_memory(state, at + MEMORY, remember(q, 0.0, h, path, around, p))


@njit(error_model="numpy", forceinline=True)
def advance_body(
    state: Array,
    at: int,
    s: float,
    s_end: float,
    path: Cubic,
    height: Cubic,
    contact: bool,
    start: float,
    spring: Spring,
    p: Constants,
) -> None:
    """`advance_axis` for the body that begins at `at` in the state; `path` to `spring` as in `Surroundings`."""
    around = Surroundings(path, height, state[at + ANCHOR], contact, start, spring)
    write_motion(state, at, advance_axis(read_motion(state, at), s, s_end, around, p))


@njit(error_model="numpy")
def touch(state: Array, at: int, path: Cubic, s: float, p: Constants) -> None:
    """Make the contact spring of the body that begins at `at` anew where the probe is at s: laws forget the last."""
    state[at + ANCHOR] = position_at(path, s) - state[at + POSITION]
    if p.remembers:
        first, end = entries_of(_CONTACT, _CONTACT, p.laws, LAW_TABLE)
        for entry in range(first, end, ENTRY):
            k = memory_of(p.laws, entry)
            if k >= 0:
                state[at + MEMORY + k] = state[at + MEMORY + k + 1] = 0.0


@njit(error_model="numpy")
def settle(state: Array, at: int, x: float, around: Surroundings, p: Constants) -> None:
    """Let what relaxes beside the contact spring of the body that begins at `at` have given way to it being at x [m].

    A recording may begin in the middle of a press: held for long, as far as it tells. Each memory goes to where it
    would decay to with the body at rest, in one step of Newton's method: it decays at one rate.
    """
    if p.remembers:
        q = read_memory(state, at + MEMORY)
        d, _, _, _ = deflection(x, 0.0, 0.0, around, p, ALONE)
        here = knowledge(BodyMotion(x, 0.0, 0.0, q), Stretch(d, 0.0, 0.0, 0.0), 0.0, around, p, ALONE)
        first, end = entries_of(_CONTACT, _CONTACT, p.laws, LAW_TABLE)
        for entry in range(first, end, ENTRY):
            k = memory_of(p.laws, entry)
            if k >= 0:
                _, r0, r1, rate = evaluate(p.laws, entry, here, q, NOTHING)
                if rate > 0.0:
                    state[at + MEMORY + k] += r0 / rate
                    state[at + MEMORY + k + 1] += r1 / rate


@njit(error_model="numpy", forceinline=True)
def sense(state: Array, at: int, force: float, normal: float, rate: float, t: float, h: float, p: Constants) -> None:
    """Let the force sensor read a force: laws in their order, each reading what the one before it made of it.

    Args:
        state: receives the reading and the sensor's new memory.
        at: where the body begins in it.
        force: tangential force on the probe [N].
        normal: force along the surface normal [N].
        rate: of the probe along the axis that is read [m/s].
        t: time since the first sample [s].
        h: time since the previous sample [s]; 0 at the first.
        p: of the body.
    """
    if p.laws != 0:
        force = _law_reading(state, at, force, normal, rate, t, h, p)
    state[at + READING] = force


@njit(error_model="numpy")
def _law_reading(
    state: Array, at: int, force: float, normal: float, rate: float, t: float, h: float, p: Constants
) -> float:
    q = read_memory(state, at + SENSOR_MEMORY)
    first, end = entries_of(_SENSOR, _SENSOR, p.laws, LAW_TABLE)
    for entry in range(first, end, ENTRY):
        zero = 0.0
        here = At(t, zero, rate, zero, zero, zero, zero, force, normal, h, zero, zero, zero)
        force, q0, q1, _ = evaluate(p.laws, entry, here, q, NOTHING)
        k = memory_of(p.laws, entry)
        if k >= 0:
            state[at + SENSOR_MEMORY + k], state[at + SENSOR_MEMORY + k + 1] = q0, q1
    return force
