"""The flexible object that may be gripped, lifted, carried and put down: on the table `flexible_box`, off it `carried`.

A closed grip that touches holds the object: the contact then acts either way, above the surface too. What presses it on
the table is its weight less what the grasp pulls; where nothing is left of that, it leaves the table upright, its
place, velocity and contact as they are. Friction of the table is that of the whole weight until then. It is back where
its foot reaches the table: what it had of vertical motion and of swing is lost there, its centre's place and velocity
along the table and the stretch of the grasp carry over. A grip that slips further than `HOLD_LENGTH` has lost it, and
it falls.
"""

import math

from numba import njit

from mmt_drake.model import body as axis
from mmt_drake.model import carried
from mmt_drake.model import flexible_box as box
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

LEAST_GRIP = 0.5
"""Force of a grip from which on it is closed [N]."""
HOLD_LENGTH = 0.015
"""By how far a grip may slip before the object is out of it [m]."""
NOTHING, HOLDS, LOST = 0.0, 1.0, 2.0
"""What a grip has."""
SUBSTEPS = 4  # of a step in the air

# The state: the object on the table, off it, what the grip has, whether it is off the table, how far the grip has
# slipped since it closed [m], scratch (motion, then a force), the tip at the latest sample and its time.
_next = Layout()
BOX, AIR, GRIP, LIFTED, SLIPPED, _SCRATCH, _FORCE, TIP, TIME = map(
    _next, (box.STATE_SIZE, carried.CARRIED_SIZE, 1, 1, 1, 6, 3, 6, 1)
)
GRASPED_SIZE = _next.size


@njit(cache=True)
def begin_grasped(state: Array, t: float, motion: Array, box_p: Array) -> None:
    """The object at rest on the table at time t [s], the grip open and the tip at `motion` (6) [m], [m/s]."""
    for i in range(GRASPED_SIZE):
        state[i] = 0.0
    box.begin(state[: box.STATE_SIZE], t, motion, box.CONTACT_BY_GEOMETRY, box_p)
    assign(state[TIP : TIP + 6], motion)
    state[TIME] = t


@njit(cache=True)
def advance_grasped(state: Array, t: float, motion: Array, grip: float, box_p: Array, p: Array, mu: float) -> None:
    """Bring the object to time t, in place.

    Args:
        state: (GRASPED_SIZE,).
        t: [s], not before the latest sample; at its time the sample is replaced.
        motion: (6,) of the tip, [m], [m/s].
        grip: its force [N].
        box_p: kernel vector of the object on the table, without effects.
        p: (`carried.NUMBERS`,) of the object off it.
        mu: friction of the grip.
    """
    h, air = t - state[TIME], state[AIR : AIR + carried.CARRIED_SIZE]
    if grip < LEAST_GRIP:
        state[GRIP] = state[SLIPPED] = air[carried.ANCHOR_Z] = 0.0
    elif state[GRIP] == NOTHING and state[LIFTED] == 0.0 and motion[2] < 0.0:
        state[GRIP] = HOLDS
    flew = state[LIFTED] != 0.0
    if flew:
        _in_the_air(state, h, motion, p)
    else:
        _on_the_table(state, t, motion, box_p, p)
    if state[GRIP] == HOLDS and (state[LIFTED] != 0.0 or motion[2] > air[carried.ANCHOR_Z]):
        state[SLIPPED] += _slip(state, motion, mu * grip, p, box_p)
        if state[SLIPPED] > HOLD_LENGTH:
            state[GRIP], air[carried.ANCHOR_Z] = LOST, 0.0
    assign(state[TIP : TIP + 6], motion)
    state[TIME] = t
    if flew and air[carried.HEIGHT] <= 0.0:
        _put_down(state, t, motion, p)


@njit(cache=True)
def _in_the_air(state: Array, h: float, motion: Array, p: Array) -> None:
    air, here, there = state[AIR : AIR + carried.CARRIED_SIZE], state[_SCRATCH:_FORCE], state[_FORCE : _FORCE + 3]
    if h <= 0.0:
        return
    if state[GRIP] != HOLDS:
        carried.fall(air, h)
    else:
        for n in range(SUBSTEPS):
            for i in range(3):
                way = motion[i] - state[TIP + i]
                here[i] = state[TIP + i] + way * n / SUBSTEPS
                there[i] = state[TIP + i] + way * (n + 1) / SUBSTEPS
            carried.carry(air, here, there, h / SUBSTEPS, p)
    for i in range(2):
        at, lateral = BOX + box.BODY + axis.AXIS_SIZE * i, carried.LATERAL + carried.AXIS * i
        state[at + axis.POSITION], state[at + axis.VELOCITY] = air[lateral], air[lateral + carried.RATE]


@njit(cache=True)
def _on_the_table(state: Array, t: float, motion: Array, box_p: Array, p: Array) -> None:
    air, lower, force = state[AIR : AIR + carried.CARRIED_SIZE], state[_SCRATCH:_FORCE], state[_FORCE : _FORCE + 3]
    assign(lower, motion)
    lower[2] -= air[carried.ANCHOR_Z]
    touches = state[GRIP] == HOLDS or lower[2] < 0.0
    on = state[BOX : BOX + box.STATE_SIZE]
    box.advance(on, t, lower, 1.0 if touches else 0.0, box_p)
    box.force_on_probe(on, box_p, force)
    if state[GRIP] == HOLDS and force[2] < -p[carried.MASS] * carried.GRAVITY:
        x, y = box.BODY, box.BODY + axis.AXIS_SIZE
        place, rate = (on[x + axis.POSITION], on[y + axis.POSITION]), (on[x + axis.VELOCITY], on[y + axis.VELOCITY])
        carried.lift(air, place, rate, (on[x + axis.ANCHOR], on[y + axis.ANCHOR]))
        state[LIFTED] = 1.0


@njit(cache=True)
def _slip(state: Array, motion: Array, most: float, p: Array, box_p: Array) -> float:
    """Let a grip slip that pulls more than it can hold, on the table or off it; by how far [m]."""
    air = state[AIR : AIR + carried.CARRIED_SIZE]
    if state[LIFTED] != 0.0:
        return carried.slip(air, motion, most, p)
    on, force = state[BOX : BOX + box.STATE_SIZE], state[_FORCE : _FORCE + 3]
    size = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    if size <= most:
        return 0.0
    gone, way = 0.0, 0.0
    for i in range(3):
        way = carried.slip_of(-force[i], size, most, p[carried.NORMAL_K] if i == 2 else p[carried.K])
        gone += way * way
        if i == 2:
            air[carried.ANCHOR_Z] += way
        else:
            on[box.BODY + axis.AXIS_SIZE * i + axis.ANCHOR] += way
    on[box.PROBE + 2] = motion[2] - air[carried.ANCHOR_Z]
    return math.sqrt(gone)


@njit(cache=True)
def _put_down(state: Array, t: float, motion: Array, p: Array) -> None:
    air, on = state[AIR : AIR + carried.CARRIED_SIZE], state[BOX : BOX + box.STATE_SIZE]
    state[LIFTED] = air[carried.HEIGHT] = air[carried.CLIMB] = 0.0
    for i in range(2):
        at, lateral = box.BODY + axis.AXIS_SIZE * i, carried.LATERAL + carried.AXIS * i
        rate = air[lateral + carried.RATE]
        on[at + axis.POSITION], on[at + axis.VELOCITY] = air[lateral], rate
        on[at + axis.MODE] = 0.0 if rate == 0.0 else math.copysign(1.0, rate)
        on[at + axis.ANCHOR] = air[lateral + carried.ANCHOR] - p[carried.CENTRE] * air[lateral + carried.ANGLE]
    on[box.TIME] = t
    assign(on[box.PROBE : box.PROBE + 6], motion)
    on[box.PROBE + 2] -= air[carried.ANCHOR_Z]
    on[box.CONTACT] = 1.0 if state[GRIP] == HOLDS else 0.0


@njit(cache=True)
def read_grasped(state: Array, box_p: Array, p: Array, force: Array, body: Array, held: Array) -> float:
    """Write what is to be seen of the object; 1 where the tip holds or touches it, else 0.

    Args:
        state: of `advance_grasped`.
        box_p, p: as there.
        force: (3,) on the probe [N].
        body: (4,) x_m, y_m, their rates [m], [m/s].
        held: (4,) what the grip has, how far it has slipped up the object and in all [m], how high the object is [m].
    """
    on, air = state[BOX : BOX + box.STATE_SIZE], state[AIR : AIR + carried.CARRIED_SIZE]
    holds = state[GRIP] == HOLDS
    if state[LIFTED] == 0.0:
        box.force_on_probe(on, box_p, force)
    else:
        for i in range(3):
            force[i] = -carried.pull_of(air, i, state[TIP : TIP + 6], p) if holds else 0.0
    for i in range(2):
        at = box.BODY + axis.AXIS_SIZE * i
        body[i], body[2 + i] = on[at + axis.POSITION], on[at + axis.VELOCITY]
    held[0], held[1], held[2], held[3] = state[GRIP], air[carried.ANCHOR_Z], state[SLIPPED], air[carried.HEIGHT]
    return 1.0 if holds or (state[LIFTED] == 0.0 and on[box.CONTACT] != 0.0) else 0.0
