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
MU = carried.NUMBERS
"""Where friction of the grip stands behind the numbers of an object off the table."""
HUNG = carried.NUMBERS + 1
SUBSTEPS = 4  # of a step in the air

# The state of the grasp, beside that of the object on the table: the object off it, what the grip has, whether it is
# off the table, how far the grip has slipped since it closed [m], scratch (motion, then a force), the tip at the latest
# sample and its time.
_next = Layout()
AIR, GRIP, LIFTED, SLIPPED, _SCRATCH, _FORCE, TIP, TIME = map(_next, (carried.CARRIED_SIZE, 1, 1, 1, 6, 3, 6, 1))
GRASP_SIZE = _next.size


@njit(cache=True)
def advance_grasped(
    on: Array, grasp: Array, t: float, motion: Array, grip: float, touches: bool, push: Array, box_p: Array, p: Array
) -> None:
    """Bring the object to time t, in place.

    Args:
        on: (flexible_box.STATE_SIZE,) it on the table, as `flexible_box.begin` left it or the previous call.
        grasp: (GRASP_SIZE,) zeros at first, and where the tip has come to another object.
        t: [s], not before the latest sample; at its time the sample is replaced.
        motion: (6,) of the tip above the top of the object that stands [m], [m/s].
        grip: its force [N].
        touches: whether the tip is in the object's top: an open grip presses on it, one that closes takes it.
        push: (2,) force on the body along x and y by others on the table [N].
        box_p: kernel vector of the object on the table, without effects if it is ever gripped.
        p: (HUNG,) of the object off it, and friction of the grip.
    """
    h, air = t - grasp[TIME], grasp[AIR : AIR + carried.CARRIED_SIZE]
    if grip < LEAST_GRIP:
        grasp[GRIP] = grasp[SLIPPED] = air[carried.ANCHOR_Z] = 0.0
    elif grasp[GRIP] == NOTHING and grasp[LIFTED] == 0.0 and touches:
        grasp[GRIP] = HOLDS
    flew = grasp[LIFTED] != 0.0
    if flew:
        _in_the_air(on, grasp, h, motion, p)
    else:
        _on_the_table(on, grasp, t, motion, touches, push, box_p, p)
    if grasp[GRIP] == HOLDS and (grasp[LIFTED] != 0.0 or motion[2] > air[carried.ANCHOR_Z]):
        grasp[SLIPPED] += _slip(on, grasp, motion, p[MU] * grip, p, box_p)
        if grasp[SLIPPED] > HOLD_LENGTH:
            grasp[GRIP], air[carried.ANCHOR_Z] = LOST, 0.0
    assign(grasp[TIP : TIP + 6], motion)
    grasp[TIME] = t
    if flew and air[carried.HEIGHT] <= 0.0:
        _put_down(on, grasp, t, motion, p)


@njit(cache=True)
def _in_the_air(on: Array, grasp: Array, h: float, motion: Array, p: Array) -> None:
    air, here, there = grasp[AIR : AIR + carried.CARRIED_SIZE], grasp[_SCRATCH:_FORCE], grasp[_FORCE : _FORCE + 3]
    if h <= 0.0:
        return
    if grasp[GRIP] != HOLDS:
        carried.fall(air, h)
    else:
        for n in range(SUBSTEPS):
            for i in range(3):
                way = motion[i] - grasp[TIP + i]
                here[i] = grasp[TIP + i] + way * n / SUBSTEPS
                there[i] = grasp[TIP + i] + way * (n + 1) / SUBSTEPS
            carried.carry(air, here, there, h / SUBSTEPS, p)
    for i in range(2):
        at, lateral = box.BODY + axis.AXIS_SIZE * i, carried.LATERAL + carried.AXIS * i
        on[at + axis.POSITION], on[at + axis.VELOCITY] = air[lateral], air[lateral + carried.RATE]


@njit(cache=True)
def _on_the_table(
    on: Array, grasp: Array, t: float, motion: Array, touches: bool, push: Array, box_p: Array, p: Array
) -> None:
    air, lower, force = grasp[AIR : AIR + carried.CARRIED_SIZE], grasp[_SCRATCH:_FORCE], grasp[_FORCE : _FORCE + 3]
    assign(lower, motion)
    lower[2] -= air[carried.ANCHOR_Z]
    holds = grasp[GRIP] == HOLDS
    box.advance(on, t, lower, 1.0 if holds or touches else 0.0, box_p, push[0], push[1])
    box.force_on_probe(on, box_p, force)
    if holds and force[2] < -p[carried.MASS] * carried.GRAVITY:
        x, y = box.BODY, box.BODY + axis.AXIS_SIZE
        place, rate = (on[x + axis.POSITION], on[y + axis.POSITION]), (on[x + axis.VELOCITY], on[y + axis.VELOCITY])
        carried.lift(air, place, rate, (on[x + axis.ANCHOR], on[y + axis.ANCHOR]))
        grasp[LIFTED] = 1.0


@njit(cache=True)
def _slip(on: Array, grasp: Array, motion: Array, most: float, p: Array, box_p: Array) -> float:
    """Let a grip slip that pulls more than it can hold, on the table or off it; by how far [m]."""
    air = grasp[AIR : AIR + carried.CARRIED_SIZE]
    if grasp[LIFTED] != 0.0:
        return carried.slip(air, motion, most, p)
    force = grasp[_FORCE : _FORCE + 3]
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
def _put_down(on: Array, grasp: Array, t: float, motion: Array, p: Array) -> None:
    air = grasp[AIR : AIR + carried.CARRIED_SIZE]
    grasp[LIFTED] = air[carried.HEIGHT] = air[carried.CLIMB] = 0.0
    for i in range(2):
        at, lateral = box.BODY + axis.AXIS_SIZE * i, carried.LATERAL + carried.AXIS * i
        rate = air[lateral + carried.RATE]
        on[at + axis.POSITION], on[at + axis.VELOCITY] = air[lateral], rate
        on[at + axis.MODE] = 0.0 if rate == 0.0 else math.copysign(1.0, rate)
        on[at + axis.ANCHOR] = air[lateral + carried.ANCHOR] - p[carried.CENTRE] * air[lateral + carried.ANGLE]
    on[box.TIME] = t
    assign(on[box.PROBE : box.PROBE + 6], motion)
    on[box.PROBE + 2] -= air[carried.ANCHOR_Z]
    on[box.CONTACT] = 1.0 if grasp[GRIP] == HOLDS else 0.0


@njit(cache=True)
def place_of(on: Array, body: Array) -> None:
    """Write (4,) x_m, y_m and their rates [m], [m/s] of an object, on the table or off it."""
    for i in range(2):
        at = box.BODY + axis.AXIS_SIZE * i
        body[i], body[2 + i] = on[at + axis.POSITION], on[at + axis.VELOCITY]


@njit(cache=True)
def read_grasped(on: Array, grasp: Array, box_p: Array, p: Array, force: Array, body: Array, held: Array) -> float:
    """Write what is to be seen of the object; 1 where the tip holds or touches it, else 0.

    Args:
        on, grasp, box_p, p: as of `advance_grasped`.
        force: (3,) on the probe [N].
        body: (4,) x_m, y_m, their rates [m], [m/s].
        held: (4,) what the grip has, how far it has slipped up the object and in all [m], how high the object is [m].
    """
    air = grasp[AIR : AIR + carried.CARRIED_SIZE]
    holds = grasp[GRIP] == HOLDS
    if grasp[LIFTED] == 0.0:
        box.force_on_probe(on, box_p, force)
    else:
        for i in range(3):
            force[i] = -carried.pull_of(air, i, grasp[TIP : TIP + 6], p) if holds else 0.0
    place_of(on, body)
    held[0], held[1], held[2], held[3] = grasp[GRIP], air[carried.ANCHOR_Z], grasp[SLIPPED], air[carried.HEIGHT]
    return 1.0 if holds or (grasp[LIFTED] == 0.0 and on[box.CONTACT] != 0.0) else 0.0
