"""The operator's own copy of a carried object: one compiled tick of what is felt off the table.

On the table the force is that of the renderer there, with contact held as long as the grip is closed. It leaves the
table where that force pulls with more than the weight, as the object itself does (`mmt_drake.model.grasped_box`), so
nothing waits for the network; what comes over it are numbers: springs and dampers of the contact, mass, centre and
damping, of which the object in the air takes up new ones with a lag of `TAKE_UP_S`. Until its centre is told it swings
about one that is believed beforehand. Where what is told differs from what it swings about, the last seconds of the
hand's way are swung again with the new numbers, so that it does not go on for seconds with the swing of another object;
the step of the force that this makes fades within the same lag. An object that the telerobot says
it does not hold is let go. It comes back with the next closing of the grip, or when the telerobot holds it on the
table.

Mass is not made from acceleration: it hangs from the grasp's spring and damper, a virtual coupling (Colgate, Stanley,
Brown, "Issues in the haptic display of tool use", IROS 1995), whose step makes no energy whatever its numbers. The
tip's way is that of its positions; its velocity is not read. A force that is held from tick to tick may still give a
little more than it takes, and numbers that change too: so the whole force is scaled down to what the hand has put in
and not got back, as `mmt_drake.rendering.updates.covered` does. Of what was burnt as much counts as its `RESERVE`.
"""

import math
from typing import Final

from numba import njit

from mmt_drake.estimation.carried import CARRIED, FREE, GONE, ON_TABLE, SLIPS
from mmt_drake.model import carried
from mmt_drake.model.grasped_box import LEAST_GRIP
from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.rendering import updates
from mmt_drake.rendering.finite import all_finite, share_held

TAKE_UP_S: Final = 0.2
NO_SWING: Final = 0.005
"""Centre of an object of which none is known [m]: it swings too fast to be felt."""
ZETA: Final = 0.05
"""Damping ratio that is believed beforehand."""
_EVERY, _ROOM = 8, 512  # ticks from one place of the hand that is kept to the next; so many are kept
_OTHER = 0.03  # of the centre: told to be another one
OPEN, HELD, LIFTED, LET_GO = range(4)
"""What the operator's copy is: not held; on the table, held; off it; not held by a grip that is closed."""
_MOST = (50.0, 1e4, 1e3, 1e4, 1e3, 0.5, 1.0)
_LEAST = (1e-3, 1.0, 0.0, 1.0, 0.0, NO_SWING, 0.0)

_M, _K2, _B2 = (THETA.index(name) for name in ("m", "k2", "b2"))
_NORMAL_K, _NORMAL_B = (THETA.index(name) for name in ("normal_k", "normal_b"))

PORT_SIZES: Final = {"force": 3, "carries": 1}
_, CARRIES, MEMORY = map(Layout(), (*PORT_SIZES.values(), 0))
# The memory: the object in the air, its numbers and those that arrived last, what the copy is, the tip at the last
# tick, whether there was one, the force since then, energy that the hand has put in and may get back [J], when the
# motion could be used last [s].
_next = Layout()
_AIR, _P, _TARGET = _next(carried.CARRIED_SIZE), _next(carried.NUMBERS), _next(carried.NUMBERS)
MODE, _TIP, _BEGUN, _FELT, _TANK, _WHEN = _next(), _next(3), _next(), _next(3), _next(), _next()
# Whose numbers these are, whether the telerobot has told them of it, its ticks in the air, what is left of a step of
# the force, and the hand's way in the air along x and y.
_THING, _IS_TOLD, _COUNT, _STEP, _WAY = _next(), _next(), _next(), _next(2), _next(2 * _ROOM)
MEMORY_SIZE = _next.size


@njit(cache=True)
def _arrive(memory: Array, theta: Array, load: Array, thing: float, believed: float) -> None:
    """Keep the numbers that have arrived, as far as they can be used and are of what is held."""
    target = memory[_TARGET : _TARGET + carried.NUMBERS]
    if memory[MODE] == OPEN and thing > 0.0 and thing != memory[_THING]:
        memory[_THING], memory[_IS_TOLD], target[carried.CENTRE] = thing, 0.0, 0.0
    if load[0] in (CARRIED, SLIPS):
        memory[_IS_TOLD] = 1.0
    is_told = thing == 0.0 or memory[_IS_TOLD] != 0.0
    for i in range(carried.NUMBERS):
        if i == carried.MASS:
            told = load[1] if load[1] > 0.0 and is_told else theta[_M]
        elif i == carried.CENTRE:
            told = load[2] if load[2] > 0.0 and is_told else (target[i] if target[i] > 0.0 else believed)
        elif i == carried.ZETA:
            told = load[3] if load[2] > 0.0 and is_told else ZETA
        else:
            told = theta[_K2 if i == 1 else _B2 if i == 2 else _NORMAL_K if i == 3 else _NORMAL_B]
        if math.isfinite(told):
            target[i] = min(max(told, _LEAST[i]), _MOST[i])


@njit(cache=True)
def _known(memory: Array) -> bool:
    return memory[_TARGET] > 0.0 and memory[_TARGET + carried.NORMAL_K] > 0.0


@njit(cache=True)
def _change(now: Array, tip: Array, force: Array, grip: float, touches: float, load: Array, top: float) -> None:
    """What the copy becomes, by the grip, the contact and the force on the table."""
    air, p = now[_AIR : _AIR + carried.CARRIED_SIZE], now[_P : _P + carried.NUMBERS]
    not_there = load[0] == GONE or (load[0] == FREE and load[4] >= LEAST_GRIP)
    closes = now[MODE] == OPEN and _known(now) and load[0] != CARRIED
    if not grip >= LEAST_GRIP:  # nor is NaN
        now[MODE] = OPEN
    elif touches != 0.0 and (closes or (now[MODE] == LET_GO and load[0] == ON_TABLE)):  # closed before it came down
        now[MODE] = HELD
    if now[MODE] in (HELD, LIFTED) and not_there:
        now[MODE] = LET_GO
    if now[MODE] == HELD:
        assign(p, now[_TARGET : _TARGET + carried.NUMBERS])
        if force[2] < -p[carried.MASS] * carried.GRAVITY:
            place = tip[0] + force[0] / p[carried.K], tip[1] + force[1] / p[carried.K]
            air[carried.ANCHOR_Z] = top
            now[_COUNT] = now[_STEP] = now[_STEP + 1] = 0.0
            carried.lift(air, place, (0.0, 0.0), (0.0, 0.0))
            air[carried.HEIGHT] = 1e-9  # off it
            now[MODE] = LIFTED


@njit(cache=True)
def _carried_elsewhere(now: Array, grip: float, load: Array) -> bool:
    """Whether the telerobot carries what the closed grip never took hold of: nobody knows here where it hangs."""
    return grip >= LEAST_GRIP and now[MODE] in (OPEN, LET_GO) and load[0] in (CARRIED, SLIPS)


@njit(cache=True)
def carried_force(
    memory: Array,
    t: float,
    h: float,
    motion: Array,
    force: Array,
    grip: float,
    touches: float,
    theta: Array,
    load: Array,
    top: float,
    thing: float,
    believed: float,
    rule: Array,
    out: Array,
) -> None:
    """One tick.

    Args:
        memory: (MEMORY_SIZE,) of the last tick; zeros before the first.
        t: [s].
        h: length of a tick [s].
        motion: (3,) or longer: where the hand is [m].
        force: (3,) of the object on the table [N].
        grip: of the hand [N].
        touches: 1 where the hand touches the object, as the renderer on the table would be told.
        theta: (10,) of the contact, as told.
        load: (5,) of `mmt_drake.estimation.carried`.
        top: height of the top of the object where it stands [m].
        thing: identity of what the hand touches or holds, from 1 on; 0: it is always the same.
        believed: how far its centre is below the grip until that is told [m].
        rule: of the renderer's policy; its reserve 0: energy is not watched.
        out: what is put out and the new memory.
    """
    now = out[MEMORY:]
    assign(now, memory)
    air, p, felt = now[_AIR : _AIR + carried.CARRIED_SIZE], now[_P : _P + carried.NUMBERS], out[:CARRIES]
    seen = all_finite(motion[:3])
    if not (seen and all_finite(force)):
        left = share_held(t - now[_WHEN])
        for i in range(3):
            felt[i] = left * now[_FELT + i] if now[_BEGUN] != 0.0 else 0.0
        out[CARRIES] = 1.0 if now[MODE] == LIFTED else 0.0
        return
    taken, before = 0.0, now[_TIP : _TIP + 3]
    if now[_BEGUN] != 0.0:
        for i in range(3):
            now[_TANK] -= now[_FELT + i] * (motion[i] - before[i])
    else:
        assign(before, motion[:3])
        now[_BEGUN] = 1.0
    _arrive(now, theta, load, thing, believed)
    flew = now[MODE] == LIFTED
    _change(now, motion, force, grip, touches, load, top)
    assign(felt, force)
    if _carried_elsewhere(now, grip, load):
        felt[0] = felt[1] = felt[2] = 0.0
    if flew and now[MODE] == LIFTED:
        share = 1.0 - math.exp(-h / TAKE_UP_S)
        centre, again = now[_TARGET + carried.CENTRE], False
        if abs(p[carried.CENTRE] / centre - 1.0) > _OTHER and now[_COUNT] > _EVERY:
            p[carried.CENTRE], p[carried.ZETA] = centre, now[_TARGET + carried.ZETA]
            for i in range(2):
                now[_STEP + i] -= air[carried.PULL + i]
                _swing_again(now, i, before[i], h)
            again = True
        for i in range(carried.NUMBERS):
            p[i] += share * (now[_TARGET + i] - p[i])
        _swing_on(now, before, motion, h)
        for i in range(3):
            felt[i] = -air[carried.PULL + i]
        for i in range(2):
            now[_STEP + i] = now[_STEP + i] - felt[i] if again else (1.0 - share) * now[_STEP + i]
            felt[i] += now[_STEP + i]
        if air[carried.HEIGHT] <= 0.0:
            now[MODE] = HELD
        if rule[updates.RESERVE] > 0.0:
            now[_TANK] = min(now[_TANK], carried.stored(air, motion, p) + rule[updates.RESERVE])
    for i in range(3):
        taken += felt[i] * (motion[i] - before[i])
    if rule[updates.RESERVE] > 0.0:
        share = updates.covered(felt, taken, 1.0, now[_TANK], rule)
        for i in range(3):
            felt[i] *= share
    assign(now[_FELT : _FELT + 3], felt)
    assign(before, motion[:3])
    now[_WHEN] = t
    out[CARRIES] = 1.0 if now[MODE] == LIFTED else 0.0


@njit(cache=True)
def _swing_again(now: Array, i: int, here: float, h: float) -> None:
    """Swing one axis anew along the way that is kept, at rest at its start, to where the hand was at the last tick."""
    air, p = now[_AIR : _AIR + carried.CARRIED_SIZE], now[_P : _P + carried.NUMBERS]
    last = (int(now[_COUNT]) - 1) // _EVERY
    first = max(0, last - _ROOM + 1)
    at = carried.LATERAL + carried.AXIS * i
    x = now[_WAY + 2 * (first % _ROOM) + i]
    air[at + carried.RADIUS], air[at + carried.RATE] = x - air[at + carried.ANCHOR], 0.0
    air[at + carried.ANGLE] = air[at + carried.TURNING] = 0.0
    for k in range(first + 1, last + 1):
        after = now[_WAY + 2 * (k % _ROOM) + i]
        if k == first + 1:
            air[at + carried.RATE] = (after - x) / (_EVERY * h)
        carried.swing(air, i, x, after, _EVERY * h, p)
        x = after
    left = int(now[_COUNT]) - 1 - last * _EVERY
    if left > 0:
        carried.swing(air, i, x, here, left * h, p)


@njit(cache=True)
def _swing_on(now: Array, before: Array, motion: Array, h: float) -> None:
    """Carry the object over a tick."""
    count = int(now[_COUNT])
    if count % _EVERY == 0:
        at = _WAY + 2 * (count // _EVERY % _ROOM)
        now[at], now[at + 1] = motion[0], motion[1]
    now[_COUNT] += 1.0
    air, p = now[_AIR : _AIR + carried.CARRIED_SIZE], now[_P : _P + carried.NUMBERS]
    middle = now[_FELT : _FELT + 3]  # room: the force since the last tick has been counted
    for i in range(3):
        middle[i] = 0.5 * (before[i] + motion[i])
    carried.carry(air, before, middle, 0.5 * h, p)
    carried.carry(air, middle, motion, 0.5 * h, p)


@njit(cache=True)
def holds_contact(memory: Array, touches: float) -> float:
    """Whether the renderer on the table is in contact, by the memory of the last tick."""
    if memory[MODE] == HELD:
        return 1.0
    return 0.0 if memory[MODE] == LIFTED else touches
