"""One body with friction on one axis: the equation of motion and its compiled integration.

A tangential axis of the flexible object and a driven body are both this::

    m v' = -k1 x - b1 v + [k2 d + b2 (v_p - v)] + [gain u + offset - G(x)] + laws - friction

The first bracket is the contact spring and damper, there while the probe (position p, velocity v_p) holds the
body, with d = p - x - anchor. The second is there where something drives the body by an input u, under gravity
G(x) = pendulum sin x; a constant gravity is part of the offset. Laws (`mmt_drake.model.laws`) are what effects add.

Friction is set-valued at rest, so the integration knows two modes. *Sliding* in one direction the equation is smooth
and a classical Runge-Kutta step (order 4) is taken, the input being evaluated inside the step. The step ends where the
body would stick or turn, and there the mode changes. *Stuck*, the body waits until the drive passes the break-away
level; laws with a memory go on meanwhile.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.hermite import Cubic, cubic, position_at, velocity_at
from mmt_drake.model.laws import ENTRY, At, Memory, Slot, evaluate, memory_of, slot_of
from mmt_drake.model.parameters import (
    B1,
    B2,
    DRIVEN,
    FD,
    FS,
    GAIN,
    GAP,
    K1,
    K2,
    LAW_TABLE,
    LAWS,
    MAX_STEP,
    NORMAL_B,
    NORMAL_K,
    OFFSET,
    PENDULUM,
    VD,
    M,
)

Array = NDArray[np.float64]

# Layout of a body's state.
POSITION, VELOCITY, ANCHOR, MODE = range(4)  # mode: 0 stuck, else the direction of sliding
MEMORY = 4  # (4) of laws on the body
SENSOR_MEMORY = 8  # (4) of laws in the sensor
READING = 12  # what the force sensor reads [N]
AXIS_SIZE = 13

BISECTIONS = 40  # halve a step of 1 ms to 1e-15 s
_MOST_EVENTS = 1000  # mode changes within one sample interval, which no physical friction makes
_STEP_TIMES_DECAY = 1.5  # a Runge-Kutta step holds at most this much of a law's fastest decay
_MOST_DECAYS = 50.0  # of a law's memory within one step of the body; beyond, the law or its state is absurd
_EDGE_STEPS = 32.0  # of those within reach of the edge of a clearance there are so many in the place of one

# Slots as plain numbers, for the kernels.
_BODY, _CONTACT, _FRICTION, _INERTIA, _SENSOR = (int(slot) for slot in Slot)
_EMPTY = (0.0, 0.0, 0.0, 0.0)


class Surroundings(NamedTuple):
    """What acts on a body between two samples.

    Attributes:
        probe: the probe's motion [m], or the input that drives the body.
        height: of the probe above the surface [m]; for a driven body less its normal load [N].
        anchor: probe less body where the contact spring is unstretched [m].
        contact: whether the probe holds the contact spring.
        start: time of the first of the two samples since the first of all [s].
    """

    probe: Cubic
    height: Cubic
    anchor: float
    contact: bool
    start: float


@njit(inline="always")
def normal_force(z: float, vz: float, p: Array) -> float:
    """Force on the probe along the surface normal, in contact [N] (eq. 8)."""
    return -p[NORMAL_K] * z - p[NORMAL_B] * vz


@njit(inline="always")
def through_gap(d: float, d_rate: float, p: Array) -> tuple[float, float]:
    """Deflection and rate that reach the contact spring and damper across a clearance: none inside it."""
    half = 0.5 * p[GAP]
    if half == 0.0:
        return d, d_rate
    if abs(d) <= half:
        return 0.0, 0.0
    return d - math.copysign(half, d), d_rate


@njit(inline="always")
def contact_push(d: float, d_rate: float, p: Array) -> float:
    """Force of the contact spring and damper on the body [N]; the probe feels its negative."""
    return p[K2] * d + p[B2] * d_rate


@njit(inline="always")
def deflection(x: float, v: float, s: float, around: Surroundings, p: Array) -> tuple[float, float]:
    """Of the contact spring, and its rate [m], [m/s]; a driven body's spring is the one to the world."""
    if p[DRIVEN] != 0.0:
        return through_gap(x - around.anchor, v, p)
    d = position_at(around.probe, s) - x - around.anchor
    return through_gap(d, velocity_at(around.probe, s) - v, p)


@njit(error_model="numpy")
def _at(x: float, v: float, direction: float, s: float, around: Surroundings, p: Array) -> At:
    d, d_rate = deflection(x, v, s, around, p)
    load = 0.0
    if around.contact:
        load = max(normal_force(position_at(around.height, s), velocity_at(around.height, s), p), 0.0)
    return At(around.start + s, x, v, d, d_rate, load, direction, 0.0, 0.0, 0.0)


@njit(error_model="numpy")
def laws(slot: int, at: At, q: Memory, p: Array) -> tuple[float, float, Memory, float]:
    """Sum of the laws of a slot: first number, second number, rates of the memory, fastest decay."""
    value, second, fastest = 0.0, 0.0, 0.0
    r0, r1, r2, r3 = _EMPTY
    for i in range(int(p[LAWS])):
        entry = LAW_TABLE + ENTRY * i
        if slot_of(p, entry) == slot:
            a, b, c, rate = evaluate(p, entry, at, q)
            value += a
            second += b
            fastest = max(fastest, rate)
            k = memory_of(p, entry)
            if k == 0:
                r0, r1 = b, c
            elif k == 2:
                r2, r3 = b, c
    return value, second, (r0, r1, r2, r3), fastest


@njit(error_model="numpy")
def _has(slot: int, p: Array) -> bool:
    """Whether a slot has a law: where it has none, there is no need to know what a law would."""
    for i in range(int(p[LAWS])):  # noqa: SIM110
        if slot_of(p, LAW_TABLE + ENTRY * i) == slot:
            return True
    return False


@njit(error_model="numpy", forceinline=True)
def _moved(q: Memory, h: float, rate: Memory) -> Memory:
    if q is None:
        return q
    return q[0] + h * rate[0], q[1] + h * rate[1], q[2] + h * rate[2], q[3] + h * rate[3]


@njit(error_model="numpy", forceinline=True)
def _both(a: Memory, b: Memory) -> Memory:
    if a is None:
        return a
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@njit(error_model="numpy")
def _law_forces(
    x: float, v: float, direction: float, q: Memory, s: float, around: Surroundings, p: Array
) -> tuple[float, Memory, float]:
    """Force of all laws on the body [N], the rates of their memory, their fastest decay [1/s]."""
    force, rates, fastest = 0.0, _EMPTY, 0.0
    if not (_has(_BODY, p) or _has(_CONTACT, p)):
        return force, rates, fastest
    at = _at(x, v, direction, s, around, p)
    force, _, rates, fastest = laws(_BODY, at, q, p)
    if around.contact:
        push, _, more, faster = laws(_CONTACT, at, q, p)
        force += -push if p[DRIVEN] != 0.0 else push
        rates, fastest = _both(rates, more), max(fastest, faster)
    return force, rates, fastest


@njit(error_model="numpy", forceinline=True)
def forces(
    x: float, v: float, direction: float, q: Memory, s: float, around: Surroundings, p: Array
) -> tuple[float, Memory, float]:
    """All forces but friction on a body at x, v [m], [m/s], s [s] after the first sample.

    Returns:
        The force [N], the rates of the memory, the fastest decay [1/s].
    """
    force = -p[B1] * v
    if p[DRIVEN] != 0.0:
        d, _ = deflection(x, v, s, around, p)
        force += p[GAIN] * position_at(around.probe, s) + p[OFFSET] - p[PENDULUM] * math.sin(x) - p[K1] * d
    else:
        force -= p[K1] * x
        if around.contact:
            d, d_rate = deflection(x, v, s, around, p)
            force += contact_push(d, d_rate, p)
    if q is None:
        return force, q, 0.0
    added, rates, fastest = _law_forces(x, v, direction, q, s, around, p)
    return force + added, rates, fastest


@njit(error_model="numpy")
def _law_friction(
    x: float, v: float, direction: float, s: float, around: Surroundings, p: Array
) -> tuple[float, float]:
    if not _has(_FRICTION, p):
        return 0.0, 0.0
    sliding, hold, _, _ = laws(_FRICTION, _at(x, v, direction, s, around, p), _EMPTY, p)
    return sliding, hold


@njit(error_model="numpy")
def _law_mass(x: float, v: float, s: float, around: Surroundings, p: Array) -> float:
    if not _has(_INERTIA, p):
        return 0.0
    added, _, _, _ = laws(_INERTIA, _at(x, v, 0.0, s, around, p), _EMPTY, p)
    return added


@njit(error_model="numpy", forceinline=True)
def friction(
    x: float, v: float, direction: float, q: Memory, s: float, around: Surroundings, p: Array
) -> tuple[float, float]:
    """Level while sliding in a direction, and level to break away in it [N]."""
    if q is None:
        return p[FD], p[FS]
    sliding, hold = _law_friction(x, v, direction, s, around, p)
    return sliding + p[FD], hold + p[FS]


@njit(error_model="numpy", forceinline=True)
def _rates(
    x: float, v: float, mode: float, q: Memory, s: float, around: Surroundings, p: Array
) -> tuple[float, Memory, float]:
    """Acceleration [m/s^2] of a body that slides in the direction `mode`, rates of the memory, fastest decay."""
    force, rates, fastest = forces(x, v, mode, q, s, around, p)
    sliding, _ = friction(x, v, mode, q, s, around, p)
    mass = p[M]
    if q is not None:
        mass += _law_mass(x, v, s, around, p)
    return (force - mode * sliding) / mass, rates, fastest


@njit(error_model="numpy", forceinline=True)
def _pull(x: float, q: Memory, s: float, around: Surroundings, p: Array) -> tuple[float, float]:
    """What friction has to hold of a body at rest [N], and the level that it can hold that way [N]."""
    force, _, _ = forces(x, 0.0, 0.0, q, s, around, p)
    _, hold = friction(x, 0.0, math.copysign(1.0, force), q, s, around, p)
    return force, hold


@njit(error_model="numpy", forceinline=True)
def _may_stick(x: float, v: float, q: Memory, s: float, around: Surroundings, p: Array) -> bool:
    """Karnopp's condition; what has to be held is the drive of a body at rest."""
    if abs(v) >= p[VD]:
        return False
    force, hold = _pull(x, q, s, around, p)
    return abs(force) < hold


@njit(error_model="numpy", forceinline=True)
def _slide(
    x: float, v: float, mode: float, q: Memory, s: float, h: float, around: Surroundings, p: Array
) -> tuple[float, float, Memory]:
    """One Runge-Kutta step of order 4 while sliding in the direction `mode`: (x, v, memory) at s + h."""
    half = 0.5 * h
    a1, r1, _ = _rates(x, v, mode, q, s, around, p)
    v2 = v + half * a1
    a2, r2, _ = _rates(x + half * v, v2, mode, _moved(q, half, r1), s + half, around, p)
    v3 = v + half * a2
    a3, r3, _ = _rates(x + half * v2, v3, mode, _moved(q, half, r2), s + half, around, p)
    v4 = v + h * a3
    a4, r4, _ = _rates(x + h * v3, v4, mode, _moved(q, h, r3), s + h, around, p)
    q = _moved(_moved(q, h / 6.0, _both(r1, r4)), h / 3.0, _both(r2, r3))
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4), q


@njit(error_model="numpy")
def _forced_rates(q: Memory, s: float, place: Cubic, around: Surroundings, p: Array) -> tuple[Memory, float]:
    v = velocity_at(place, s)
    _, rates, fastest = forces(position_at(place, s), v, np.sign(v), q, s, around, p)
    return rates, fastest


@njit(error_model="numpy")
def _limited(h: float, fastest: float) -> float:
    """A step of at most h [s] under a decay [1/s]."""
    if fastest * h <= _STEP_TIMES_DECAY:
        return h
    if not fastest * h < _MOST_DECAYS:
        raise RuntimeError("the memory of a law decays more than 50 times within one step")
    return _STEP_TIMES_DECAY / fastest


@njit(error_model="numpy")
def remember(q: Memory, s: float, s_end: float, place: Cubic, around: Surroundings, p: Array) -> Memory:
    """Advance the memory of the laws while the body moves as told.

    Args:
        q: at s.
        s, s_end: the stretch of time [s] after the first sample.
        place: where the body is [m].
        around: what acts on it.
        p: kernel vector.
    """
    while s < s_end:
        r1, fastest = _forced_rates(q, s, place, around, p)
        h = _limited(min(s_end - s, p[MAX_STEP]), fastest)
        half = 0.5 * h
        r2, _ = _forced_rates(_moved(q, half, r1), s + half, place, around, p)
        r3, _ = _forced_rates(_moved(q, half, r2), s + half, place, around, p)
        r4, _ = _forced_rates(_moved(q, h, r3), s + h, place, around, p)
        q = _moved(_moved(q, h / 6.0, _both(r1, r4)), h / 3.0, _both(r2, r3))
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return q


@njit(error_model="numpy")
def _remembers(p: Array) -> bool:
    """Whether a law on the body has a memory."""
    for i in range(int(p[LAWS])):
        entry = LAW_TABLE + ENTRY * i
        if memory_of(p, entry) >= 0 and slot_of(p, entry) != _SENSOR:
            return True
    return False


@njit(error_model="numpy")
def _wait_step(h: float, q: Memory, p: Array) -> float:
    """How much of h [s] a stuck body may wait in one step."""
    if q is None:
        return h
    return min(h, p[MAX_STEP]) if _remembers(p) else h


@njit(error_model="numpy")
def _wait(q: Memory, s: float, s_end: float, place: Cubic, around: Surroundings, p: Array) -> Memory:
    if q is None:
        return q
    return remember(q, s, s_end, place, around, p) if _remembers(p) else q


@njit(error_model="numpy")
def _is_smooth(q: Memory, p: Array) -> bool:
    """Whether there is no set-valued friction."""
    if q is not None and _has(_FRICTION, p):
        return False
    return p[FS] == 0.0 and p[FD] == 0.0


@njit(error_model="numpy")
def _short_at_edge(h: float, x: float, v: float, s: float, around: Surroundings, p: Array) -> float:
    """A step of at most h [s], short where it may reach the edge of the clearance: there the damper's force jumps."""
    if p[DRIVEN] != 0.0 or not around.contact:
        return h
    d = position_at(around.probe, s) - x - around.anchor
    reach = 1.5 * h * abs(velocity_at(around.probe, s) - v)
    return h / _EDGE_STEPS if abs(abs(d) - 0.5 * p[GAP]) <= reach else h


@njit(error_model="numpy")
def _bounded_step(
    h: float, x: float, v: float, mode: float, q: Memory, s: float, around: Surroundings, p: Array
) -> float:
    """A step of at most h [s] that the memory of the laws can follow, and short where a clearance closes or opens."""
    if p[GAP] != 0.0:
        h = _short_at_edge(h, x, v, s, around, p)
    if q is None or not (_has(_BODY, p) or _has(_CONTACT, p)):
        return h
    _, _, fastest = _rates(x, v, mode, q, s, around, p)
    return _limited(h, fastest)


@njit(error_model="numpy", forceinline=True)
def _between(q0: Memory, q1: Memory, part: float) -> Memory:
    if q0 is None:
        return q0
    return (
        q0[0] + part * (q1[0] - q0[0]),
        q0[1] + part * (q1[1] - q0[1]),
        q0[2] + part * (q1[2] - q0[2]),
        q0[3] + part * (q1[3] - q0[3]),
    )


@njit(error_model="numpy")
def _break_away(
    x: float, q: Memory, s: float, s_end: float, around: Surroundings, p: Array
) -> tuple[float, float, Memory]:
    """When a stuck body lets go within [s, s_end], in which direction, and its memory then; s_end, 0 if it does not."""
    force, hold = _pull(x, q, s, around, p)
    if abs(force) > hold:
        return s, math.copysign(1.0, force), q
    place = Cubic(x, 0.0, 0.0, 0.0)
    while s < s_end:
        h = _wait_step(s_end - s, q, p)
        q1 = _wait(q, s, s + h, place, around, p)
        force, hold = _pull(x, q1, s + h, around, p)
        if abs(force) > hold:
            low, high = 0.0, h
            for _ in range(BISECTIONS):
                mid = 0.5 * (low + high)
                force, hold = _pull(x, _between(q, q1, mid / h), s + mid, around, p)
                if abs(force) > hold:
                    high = mid
                else:
                    low = mid
            force, _ = _pull(x, _between(q, q1, high / h), s + high, around, p)
            return s + high, math.copysign(1.0, force), _between(q, q1, high / h)
        q = q1
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return s_end, 0.0, q


@njit(error_model="numpy")
def _end_of_slide(
    x: float,
    v: float,
    q: Memory,
    x1: float,
    v1: float,
    q1: Memory,
    mode: float,
    s: float,
    h: float,
    around: Surroundings,
    p: Array,
) -> float:
    """How long after s, within a step of h to (x1, v1, q1), a sliding body turns or sticks.

    The body's motion inside the step is the cubic through its ends.
    """
    position = cubic(x, v, x1, v1, h)
    a, _, _ = _rates(x, v, mode, q, s, around, p)
    a1, _, _ = _rates(x1, v1, mode, q1, s + h, around, p)
    velocity = cubic(v, a, v1, a1, h)
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        v_mid = position_at(velocity, mid)
        stuck = v_mid * mode < 0.0 or _may_stick(
            position_at(position, mid), v_mid, _between(q, q1, mid / h), s + mid, around, p
        )
        if stuck:
            high = mid
        else:
            low = mid
    return high


@njit(error_model="numpy")
def _advance(
    x: float, v: float, mode: float, q: Memory, s: float, s_end: float, around: Surroundings, p: Array
) -> tuple[float, float, float, Memory]:
    smooth = _is_smooth(q, p)
    h_max = s_end - s
    if h_max > p[MAX_STEP]:
        h_max /= math.ceil(h_max / p[MAX_STEP])
    events = 0
    while s < s_end:
        if mode == 0.0 and not smooth:
            v = 0.0
            s, mode, q = _break_away(x, q, s, s_end, around, p)
            if mode == 0.0:
                break
        h = _bounded_step(h_max, x, v, mode, q, s, around, p)
        last = s + h >= s_end - 1e-9 * h
        if last:
            h = s_end - s
        x1, v1, q1 = _slide(x, v, mode, q, s, h, around, p)
        if not smooth and (v1 * mode < 0.0 or _may_stick(x1, v1, q1, s + h, around, p)):
            events += 1
            if events > _MOST_EVENTS:
                raise RuntimeError("the body sticks and slides more than 1000 times within one step")
            h = _end_of_slide(x, v, q, x1, v1, q1, mode, s, h, around, p)
            last = False
            x1, _, q1 = _slide(x, v, mode, q, s, h, around, p)
            # It stops there: held by friction, or to turn because the drive beats friction the other way.
            v1 = 0.0
            force, hold = _pull(x1, q1, s + h, around, p)
            mode = 0.0 if abs(force) <= hold else math.copysign(1.0, force)
        x, v, q = x1, v1, q1
        s = s_end if last else s + h
    return x, v, mode, q


@njit(cache=True, error_model="numpy")
def advance_axis(state: Array, at: int, s: float, s_end: float, around: Surroundings, p: Array) -> None:
    """Advance a body from s to s_end [s] after the latest sample, in place.

    Args:
        state: holds the body's position, velocity, mode and memory.
        at: where they begin in it.
        s, s_end: the stretch of time within the sample interval.
        around: what acts on it.
        p: kernel vector.

    Raises:
        RuntimeError: the body would stick and slide without end.
    """
    x, v, mode = state[at + POSITION], state[at + VELOCITY], state[at + MODE]
    # `None` for the memory compiles a version without laws.
    if p[LAWS] == 0.0:
        x, v, mode, _ = _advance(x, v, mode, None, s, s_end, around, p)
    else:
        x, v, mode, q = _advance(x, v, mode, read_memory(state, at + MEMORY), s, s_end, around, p)
        write_memory(state, at + MEMORY, q)
    state[at + POSITION], state[at + VELOCITY], state[at + MODE] = x, v, mode


@njit(inline="always")
def read_memory(state: Array, at: int) -> Memory:
    """The memory that begins at `at` in the state."""
    return state[at], state[at + 1], state[at + 2], state[at + 3]


@njit(inline="always")
def write_memory(state: Array, at: int, q: Memory) -> None:
    """Put the memory where it begins at `at` in the state."""
    state[at], state[at + 1], state[at + 2], state[at + 3] = q


@njit(error_model="numpy")
def advance_memory(state: Array, at: int, h: float, place: Cubic, around: Surroundings, p: Array) -> None:
    """Advance the memory of the body that begins at `at` by h [s] from the latest sample while it moves as told."""
    if _remembers(p):
        q = read_memory(state, at + MEMORY)
        write_memory(state, at + MEMORY, remember(q, 0.0, h, place, around, p))


@njit(error_model="numpy")
def forget_contact(state: Array, at: int, p: Array) -> None:
    """Empty the memory of contact laws of the body that begins at `at`: the contact spring is new at a touch."""
    for i in range(int(p[LAWS])):
        entry = LAW_TABLE + ENTRY * i
        k = memory_of(p, entry)
        if k >= 0 and slot_of(p, entry) == _CONTACT:
            state[at + MEMORY + k] = state[at + MEMORY + k + 1] = 0.0


@njit(error_model="numpy", forceinline=True)
def contact_force(state: Array, at: int, around: Surroundings, s: float, p: Array) -> float:
    """Force of the body that begins at `at` on the probe, s [s] after the first sample, in contact [N]."""
    x, v = state[at + POSITION], state[at + VELOCITY]
    d, d_rate = deflection(x, v, s, around, p)
    push = contact_push(d, d_rate, p)
    if p[LAWS] != 0.0:
        push += _law_push(state, at, around, s, p)
    return -push


@njit(error_model="numpy")
def _law_push(state: Array, at: int, around: Surroundings, s: float, p: Array) -> float:
    x, v, mode = state[at + POSITION], state[at + VELOCITY], state[at + MODE]
    push, _, _, _ = laws(_CONTACT, _at(x, v, mode, s, around, p), read_memory(state, at + MEMORY), p)
    return push


@njit(error_model="numpy", forceinline=True)
def sense(state: Array, at: int, force: float, normal: float, t: float, h: float, p: Array) -> None:
    """Let the force sensor read a force: laws in their order, each reading what the one before it made of it.

    Args:
        state: receives the reading and the sensor's new memory.
        at: where the body begins in it.
        force: tangential force on the probe [N].
        normal: force along the surface normal [N].
        t: time since the first sample [s].
        h: time since the previous sample [s]; 0 at the first.
        p: kernel vector.
    """
    if p[LAWS] != 0.0:
        force = _law_reading(state, at, force, normal, t, h, p)
    state[at + READING] = force


@njit(error_model="numpy")
def _law_reading(state: Array, at: int, force: float, normal: float, t: float, h: float, p: Array) -> float:
    q = read_memory(state, at + SENSOR_MEMORY)
    for i in range(int(p[LAWS])):
        entry = LAW_TABLE + ENTRY * i
        if slot_of(p, entry) == _SENSOR:
            zero = 0.0
            force, q0, q1, _ = evaluate(p, entry, At(t, zero, zero, zero, zero, zero, zero, force, normal, h), q)
            k = memory_of(p, entry)
            if k >= 0:
                state[at + SENSOR_MEMORY + k], state[at + SENSOR_MEMORY + k + 1] = q0, q1
    return force
