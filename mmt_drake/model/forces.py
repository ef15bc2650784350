"""One body with friction on one axis: the equation of motion.

A tangential axis of the flexible object, a driven body and the output of a transmission are all this::

    m v' = -k1 x - b1 v + [k2 d + b2 (v_p - v)] + [gain u + offset - G(x)] + laws - friction

The first bracket is the contact spring and damper, there while the probe (position p, velocity v_p) holds the
body, with d = p - x - anchor. The second is there where something drives the body by an input u, under gravity
G(x) = pendulum sin x; a constant gravity is part of the offset. A transmission's probe is where its input would
have the output. Laws (`mmt_drake.model.laws`) are what effects add.
"""

import math
from typing import Any, NamedTuple

from numba import njit
from numba.extending import overload

from mmt_drake.model.hermite import Cubic, position_at, velocity_at
from mmt_drake.model.law_table import (
    ENTRY,
    entries_of,
    evaluate,
    memory_of,
    read_the_plane,
    remembers,
    share_of,
    slot_of,
    stored_by,
)
from mmt_drake.model.laws import NOTHING, At, Memory, Slot, norm
from mmt_drake.model.parameters import (
    FD,
    FS,
    GAP,
    LAW_TABLE,
    LAWS,
    NORMAL_AXIS,
    NORMAL_B,
    NORMAL_K,
    PLANAR,
    Constants,
    M,
)
from mmt_drake.numeric.arrays import Array, fixed_tuple

# Slots as plain numbers, for the kernels.
_DRIVE, _BODY, _CONTACT, _FRICTION, _INERTIA, _SENSOR = (int(slot) for slot in Slot)


class Spring(NamedTuple):
    """The contact spring as it acts on one axis of a body.

    Attributes:
        k, b: force on it per deflection along the axis [N/m], and per rate [N s/m]: on a level surface k2 and b2.
        push: what else the contact pushes it by [N]: of a slope, and of what happens across the axis.
    """

    k: float
    b: float
    push: Cubic


class Surroundings(NamedTuple):
    """The surroundings of a body between two samples, as they act on it.

    Attributes:
        probe: the probe's motion [m], or the input that drives the body.
        height: of the probe above the surface [m]; for a body that an input moves its load [N], NaN: its controller's.
        anchor: probe less body where the contact spring is unstretched [m].
        contact: whether the probe holds the contact spring.
        start: time of the first of the two samples since the first of all [s].
        spring: the contact's; of a body that an input moves nobody reads it.
    """

    probe: Cubic
    height: Cubic
    anchor: float
    contact: bool
    start: float
    spring: Spring


class BodyMotion(NamedTuple):
    """A body at an instant.

    Attributes:
        x, v: displacement [m] and velocity [m/s].
        mode: 0 at rest, else the direction in which it slides, -1 or 1.
        q: memory of its laws.
    """

    x: float
    v: float
    mode: float
    q: Memory


class Beside(NamedTuple):
    """The other axis of the plane, as far as what acts on this one depends on it.

    Attributes:
        v: velocity of the body [m/s].
        d, d_rate: deflection of the contact spring, clearance and all, and its rate [m], [m/s].
        q: memory of the laws.
    """

    v: float
    d: float
    d_rate: float
    q: Memory


ALONE = Beside(0.0, 0.0, 0.0, NOTHING)
"""There is no other axis, or it does not matter."""


class Stretch(NamedTuple):
    """What is left of the contact spring's deflection by the clearance.

    Attributes:
        d, rate: along this axis [m], [m/s].
        d_across, rate_across: along the other.
    """

    d: float
    rate: float
    d_across: float
    rate_across: float


class Forces(NamedTuple):
    """The forces on a body at an instant, and the mass that they accelerate.

    Attributes:
        drive: all forces but friction [N].
        sliding, hold: friction while sliding in the body's direction, and what must be overcome to do so [N].
        inverse_mass: [1/kg].
        rates: of the memory.
        decay: the fastest of the memory [1/s].
    """

    drive: float
    sliding: float
    hold: float
    inverse_mass: float
    rates: Memory
    decay: float


_BEHIND_NORMAL = NORMAL_B + 1


def _numbers(p: Array) -> Any:
    return tuple(p[:LAWS].tolist())


@overload(_numbers, strict=False)
def _compiled_numbers(p: Any) -> Any:
    return lambda p: fixed_tuple(p, LAWS)


@njit(error_model="numpy", forceinline=True)
def constants(p: Array) -> Constants:
    """A kernel vector in plain numbers."""
    address, has_memory, across = 0, False, p[GAP] != 0.0
    smooth = p[FS] == 0.0 and p[FD] == 0.0
    if p[LAWS] != 0.0:
        address = p.ctypes.data
        has_memory = remembers(address, LAW_TABLE)
        first, end = entries_of(_FRICTION, _FRICTION, address, LAW_TABLE)
        smooth = smooth and first == end
        across = across or read_the_plane(address, LAW_TABLE)
    planar = p[PLANAR] != 0.0
    flags = (has_memory, smooth, planar and (across or not smooth), planar and across)
    own = _numbers(p)
    normal = (-1.0, 0.0) if p[NORMAL_AXIS] != 0.0 else (p[NORMAL_K], p[NORMAL_B])
    numbers = (*own[:NORMAL_K], *normal, *own[_BEHIND_NORMAL:], address, 1.0 / p[M], *flags)
    return Constants(*numbers)


@njit(error_model="numpy", forceinline=True)
def normal_force(z: float, vz: float, p: Constants) -> float:
    """Force on the probe along the surface normal, in contact [N] (eq. 8)."""
    return -p.normal_k * z - p.normal_b * vz


@njit(error_model="numpy", forceinline=True)
def through_gap(d: float, d_rate: float, beside: Beside, p: Constants) -> Stretch:
    """What of a deflection and its rate reaches the contact spring and damper across a clearance: none inside it."""
    half = 0.5 * p.gap
    if half == 0.0:
        return Stretch(d, d_rate, beside.d, beside.d_rate)
    far = norm(d, beside.d)
    if far <= half:
        return Stretch(0.0, 0.0, 0.0, 0.0)
    part = (far - half) / far
    return Stretch(part * d, d_rate, part * beside.d, beside.d_rate)


@njit(error_model="numpy", forceinline=True)
def level_spring(p: Constants) -> Spring:
    """The contact spring on a level surface, where its axes and those of the normal have nothing in common."""
    return Spring(p.k2, p.b2, Cubic(0.0, 0.0, 0.0, 0.0))


@njit(error_model="numpy", forceinline=True)
def contact_push(stretch: Stretch, s: float, spring: Spring) -> float:
    """Force of the contact on the body [N]; on a level surface the probe feels its negative."""
    return spring.k * stretch.d + spring.b * stretch.rate + position_at(spring.push, s)


@njit(error_model="numpy", forceinline=True)
def whole_deflection(x: float, v: float, s: float, around: Surroundings, p: Constants) -> tuple[float, float]:
    """Of the contact spring and its clearance, and its rate [m], [m/s]; a driven body's spring is that to the world."""
    if p.driven:
        return x - around.anchor, v
    return position_at(around.probe, s) - x - around.anchor, velocity_at(around.probe, s) - v


@njit(error_model="numpy", forceinline=True)
def beside(body: BodyMotion, s: float, around: Surroundings, p: Constants) -> Beside:
    """What the other axis has to know of one; nothing where nothing looks at it."""
    if not p.looks_across:
        return ALONE
    d, d_rate = whole_deflection(body.x, body.v, s, around, p)
    return Beside(body.v, d, d_rate, body.q)


@njit(error_model="numpy", forceinline=True)
def deflection(x: float, v: float, s: float, around: Surroundings, p: Constants, other: Beside) -> Stretch:
    """Of the contact spring."""
    d, d_rate = whole_deflection(x, v, s, around, p)
    return through_gap(d, d_rate, other, p)


@njit(error_model="numpy", forceinline=True)
def knowledge(body: BodyMotion, stretch: Stretch, s: float, around: Surroundings, p: Constants, other: Beside) -> At:
    """What laws know of a body whose spring has a deflection."""
    load = 0.0
    if around.contact:
        load = normal_force(position_at(around.height, s), velocity_at(around.height, s), p)
        if p.loaded != 0.0:
            load = abs(load)
        elif load < 0.0:  # and not `max`: NaN stays
            load = 0.0
    push = p.gain * position_at(around.probe, s) if p.driven else 0.0
    here = (around.start + s, body.x, body.v, stretch.d, stretch.rate, load, body.mode, push, 0.0, 0.0)
    return At(*here, other.v, stretch.d_across, stretch.rate_across)


@njit(error_model="numpy", forceinline=True)
def forces(body: BodyMotion, s: float, around: Surroundings, p: Constants, other: Beside) -> Forces:
    """The forces on a body s [s] after the first sample."""
    return forces_in_plane(body, body.v, s, around, p, other)


@njit(error_model="numpy", forceinline=True)
def forces_in_plane(
    body: BodyMotion, rubbing: float, s: float, around: Surroundings, p: Constants, other: Beside
) -> Forces:
    """`forces` on one axis of a body whose laws of friction look at another velocity: it slides that fast [m/s]."""
    stretch = deflection(body.x, body.v, s, around, p, other)
    drive = -p.b1 * body.v
    if p.driven:
        drive += p.gain * position_at(around.probe, s) + p.offset - p.k1 * stretch.d
        if p.pendulum != 0.0:
            drive -= p.pendulum * math.sin(body.x)
    else:
        drive -= p.k1 * body.x
        if around.contact:
            drive += contact_push(stretch, s, around.spring)
        if p.loaded != 0.0:
            drive += p.loaded * position_at(around.height, s)
    if p.laws == 0:
        return Forces(drive, p.Fd, p.Fs, p.inverse_mass, NOTHING, 0.0)
    at = knowledge(body, stretch, s, around, p, other)
    return _with_laws(drive, at, rubbing, body.q, other.q, around.contact, p)


@njit(error_model="numpy", forceinline=True)
def _driven_by(force: float, at: At) -> At:
    """The knowledge of laws about a body that another force drives; it is the load, too, where none was recorded."""
    load = abs(force) if math.isnan(at.load) else at.load
    return At(at.t, at.x, at.v, at.d, at.d_rate, load, at.direction, force, at.normal_force, at.h, 0.0, 0.0, 0.0)


@njit(error_model="numpy", forceinline=True)
def _at_velocity(at: At, v: float) -> At:
    """The knowledge of laws of friction about a body that slides fast in another direction, too."""
    before, behind = (at.t, at.x), (at.d, at.d_rate, at.load, at.direction, at.force, at.normal_force, at.h)
    return At(*before, v, *behind, at.v_across, at.d_across, at.d_rate_across)


@njit(error_model="numpy")
def _with_laws(drive: float, at: At, rubbing: float, q: Memory, across: Memory, contact: bool, p: Constants) -> Forces:
    """The forces with what all laws add, each evaluated once; those of friction at the velocity `rubbing`."""
    sliding, hold, mass, decay = p.Fd, p.Fs, p.m, 0.0
    r0, r1, r2, r3 = NOTHING
    spring = -1.0 if p.driven else 1.0  # on the body, counted along its deflection
    first, end = entries_of(_DRIVE, _INERTIA, p.laws, LAW_TABLE)
    for entry in range(first, end, ENTRY):
        slot = slot_of(p.laws, entry)
        if slot == _CONTACT and not contact:
            continue
        known = _at_velocity(at, rubbing) if slot == _FRICTION else at
        value, second, third, rate = evaluate(p.laws, entry, known, q, across)
        share = share_of(p.laws, entry)
        value *= share
        if slot == _DRIVE:
            at, value = _driven_by(value, at), value - at.force
        if slot == _FRICTION:
            sliding += value
            hold += share * second
        elif slot == _INERTIA:
            mass += value
        else:
            drive += spring * value if slot == _CONTACT else value
            decay = max(decay, rate)
            k = memory_of(p.laws, entry)
            if k == 0:
                r0, r1 = second, third
            elif k == 2:
                r2, r3 = second, third
    return Forces(drive, sliding, hold, 1.0 / mass, (r0, r1, r2, r3), decay)


@njit(error_model="numpy", forceinline=True)
def contact_force(body: BodyMotion, s: float, around: Surroundings, p: Constants, other: Beside) -> float:
    """Of the contact spring and damper and what laws put beside them on the probe, in contact [N]."""
    stretch = deflection(body.x, body.v, s, around, p, other)
    push = contact_push(stretch, s, around.spring)
    if p.laws != 0:
        push += _law_push(knowledge(body, stretch, s, around, p, other), body.q, other.q, p)
    return -push


@njit(error_model="numpy", forceinline=True)
def contact_forces(
    x: BodyMotion, y: BodyMotion, s: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[float, float]:
    """`contact_force` along both axes of the plane."""
    felt = contact_force(x, s, along, p, beside(y, s, across, p))
    return felt, contact_force(y, s, across, p, beside(x, s, along, p))


@njit(error_model="numpy")
def law_push(body: BodyMotion, s: float, around: Surroundings, p: Constants, other: Beside) -> float:
    """Force on the body of what laws put beside the contact spring, in contact [N]."""
    stretch = deflection(body.x, body.v, s, around, p, other)
    return _law_push(knowledge(body, stretch, s, around, p, other), body.q, other.q, p)


@njit(error_model="numpy")
def _law_push(at: At, q: Memory, across: Memory, p: Constants) -> float:
    push = 0.0
    first, end = entries_of(_CONTACT, _CONTACT, p.laws, LAW_TABLE)
    for entry in range(first, end, ENTRY):
        value, _, _, _ = evaluate(p.laws, entry, at, q, across)
        push += share_of(p.laws, entry) * value
    return push


@njit(error_model="numpy")
def stored_in_laws(body: BodyMotion, s: float, around: Surroundings, p: Constants, other: Beside) -> float:
    """The energy that the laws on a body hold along an axis [J]; those of a contact hold none off it."""
    at, energy = knowledge(body, deflection(body.x, body.v, s, around, p, other), s, around, p, other), 0.0
    first, end = entries_of(_BODY, _CONTACT if around.contact else _BODY, p.laws, LAW_TABLE)
    for entry in range(first, end, ENTRY):
        energy += stored_by(p.laws, entry, at, body.q, other.q)
    return energy
