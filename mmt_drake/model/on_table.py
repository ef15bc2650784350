"""Several flexible objects on one table, under one probe's tip: touch, and collisions.

Each is a `flexible_box` whose top has a footprint, a box's or a cylinder's, and a height of its own; its body slides on
the table without turning. The tip touches the one through whose top it comes from above, and holds it until it is above
that height again or beyond the footprint; it touches no other meanwhile, nor a side.

Bodies that overlap by delta, or would within a step h, push each other along the axis of least overlap. With v the
speed at which they approach, m the reduced mass and b = 2 sqrt(k m)::

    F = max(0, (k (delta + h v/2) + b v) / (1 + (h b/2 + h^2 k/4)/m))

That is k delta + b v in the middle of the step, by the implicit midpoint rule: what two free bodies lose is what the
spring takes, and h b v^2 beside it. It acts on both alike and never pulls: momentum is kept, and no energy is made.

A grip that closes while the tip touches an object has that one until it opens, may lift it and put it down elsewhere
(`grasped_box`). What is off the table meets no other: it goes through what it is not lifted over.
"""

import math

from numba import njit

from mmt_drake.model import flexible_box as box
from mmt_drake.model import grasped_box
from mmt_drake.model.body import AXIS_SIZE, POSITION, VELOCITY
from mmt_drake.model.parameters import M
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

# A row of what is told of the objects: middle of the top at first, its height [m]; half sides, or the radius twice [m];
# 1 for a cylinder.
MIDDLE, TOP, HALF, ROUND, ROW = map(Layout(), (2, 1, 2, 1, 0))

_VX, _VY = box.BODY + VELOCITY, box.BODY + AXIS_SIZE + VELOCITY
_X, _Y = box.BODY + POSITION, box.BODY + AXIS_SIZE + POSITION
NONE = -1
"""Stands for no object."""

Place = tuple[float, float]
Overlap = tuple[float, float, float]
"""How far two bodies overlap [m], and the direction from the first to the second; 0 or less: they do not."""


@njit(cache=True, error_model="numpy")
def place_of(states: Array, rows: Array, i: int) -> Place:
    """Where the middle of the top of object i is [m]."""
    return rows[i, MIDDLE] + states[i, _X], rows[i, MIDDLE + 1] + states[i, _Y]


@njit(cache=True, error_model="numpy")
def within(states: Array, rows: Array, i: int, x: float, y: float) -> bool:
    """Whether x, y [m] is over the top of object i."""
    at = place_of(states, rows, i)
    return is_over(rows[i], x - at[0], y - at[1])


@njit(cache=True, error_model="numpy")
def is_over(row: Array, x: float, y: float) -> bool:
    """Whether x, y from the middle of a top [m] is within its rim."""
    if row[ROUND] != 0.0:
        return x * x + y * y <= row[HALF] ** 2
    return abs(x) <= row[HALF] and abs(y) <= row[HALF + 1]


@njit(cache=True, error_model="numpy")
def overlap(states: Array, rows: Array, i: int, j: int) -> Overlap:
    """Of objects i and j."""
    a, b = place_of(states, rows, i), place_of(states, rows, j)
    x, y = b[0] - a[0], b[1] - a[1]
    if rows[i, ROUND] == 0.0 and rows[j, ROUND] == 0.0:
        deep_x = rows[i, HALF] + rows[j, HALF] - abs(x)
        deep_y = rows[i, HALF + 1] + rows[j, HALF + 1] - abs(y)
        if deep_x < deep_y:
            return deep_x, math.copysign(1.0, x), 0.0
        return deep_y, 0.0, math.copysign(1.0, y)
    reach = rows[i, HALF] + rows[j, HALF]
    if rows[i, ROUND] == 0.0 or rows[j, ROUND] == 0.0:
        square, disk = (i, j) if rows[i, ROUND] == 0.0 else (j, i)
        # From the box's point that is nearest to the cylinder's axis; a cylinder whose axis is inside goes out by the
        # nearest side.
        near_x = min(max(x, -rows[square, HALF]), rows[square, HALF])
        near_y = min(max(y, -rows[square, HALF + 1]), rows[square, HALF + 1])
        x, y, reach = x - near_x, y - near_y, rows[disk, HALF]
        if x == 0.0 and y == 0.0:
            left_x, left_y = rows[square, HALF] - abs(near_x), rows[square, HALF + 1] - abs(near_y)
            if left_x < left_y:
                return reach + left_x, math.copysign(1.0, near_x), 0.0
            return reach + left_y, 0.0, math.copysign(1.0, near_y)
    apart = math.sqrt(x * x + y * y)
    if apart == 0.0:
        return reach, 1.0, 0.0
    return reach - apart, x / apart, y / apart


@njit(cache=True, error_model="numpy")
def begin(states: Array, t: float, motion: Array, rows: Array, p: Array, moved: Array) -> None:
    """All objects at rest at time t [s] under the probe's first sample, which touches none.

    Args:
        states: (n, flexible_box.STATE_SIZE), to be filled.
        t: [s].
        motion: (6,) position [m] and velocity [m/s] of the probe.
        rows: (n, ROW) where and what they are.
        p: (n, ...) their kernel vectors.
        moved: (6,) scratch.
    """
    for i in range(len(states)):
        for k in range(6):
            moved[k] = motion[k]
        moved[2] -= rows[i, TOP]
        box.begin(states[i], t, moved, 0.0, p[i])


@njit(cache=True, error_model="numpy")
def advance(
    states: Array,
    grasp: Array,
    touched: int,
    t: float,
    motion: Array,
    grip: float,
    rows: Array,
    p: Array,
    hung: Array,
    k: float,
    moved: Array,
    push: Array,
) -> int:
    """Bring all objects to the probe's next sample, in place.

    Args:
        states: of `begin`.
        grasp: (grasped_box.GRASP_SIZE,), zeros at first.
        touched: the object that the tip holds, or NONE.
        t: of the sample [s].
        motion: (6,) position [m] and velocity [m/s] of the probe there.
        grip: its force [N]; 0: there is none.
        rows, p: as of `begin`.
        hung: (n, grasped_box.HUNG) them off the table; the first number 0: no grip takes it.
        k: stiffness of a collision [N/m].
        moved: (6,) scratch.
        push: (n, 2) scratch.

    Returns:
        The object that the tip holds now, or NONE.
    """
    n, flies = len(states), touched if grasp[grasped_box.LIFTED] != 0.0 else NONE
    last = states[0, box.TIME]
    for i in range(n):
        push[i, 0] = push[i, 1] = 0.0
        last = max(last, states[i, box.TIME])  # that of an object off the table has stopped
    if t > last:
        for i in range(n):
            for j in range(i):
                if flies not in (i, j):
                    _collide(states, rows, p, i, j, t - last, k, push)
    if touched != NONE:
        free = flies == NONE and grasp[grasped_box.GRIP] != grasped_box.HOLDS
        if free and (motion[2] >= rows[touched, TOP] or not within(states, rows, touched, motion[0], motion[1])):
            touched = NONE
    else:
        for i in range(n):
            before = states[i, box.PROBE + 2]  # above its top
            if before >= 0.0 and motion[2] < rows[i, TOP] and within(states, rows, i, motion[0], motion[1]):
                touched = i
                break
    if grip < grasped_box.LEAST_GRIP and (touched == NONE or hung[touched, 0] == 0.0):
        grasp[grasped_box.GRIP] = grasp[grasped_box.SLIPPED] = 0.0
    for i in range(n):
        for m in range(6):
            moved[m] = motion[m]
        moved[2] -= rows[i, TOP]
        if i == touched and hung[i, 0] > 0.0:
            inside = moved[2] < 0.0
            grasped_box.advance_grasped(states[i], grasp, t, moved, grip, inside, push[i], p[i], hung[i])
        else:
            box.advance(states[i], t, moved, 1.0 if i == touched else 0.0, p[i], push[i, 0], push[i, 1])
    return touched


@njit(cache=True, error_model="numpy")
def _collide(states: Array, rows: Array, p: Array, i: int, j: int, h: float, k: float, push: Array) -> None:
    deep, x, y = overlap(states, rows, i, j)
    v = x * (states[i, _VX] - states[j, _VX]) + y * (states[i, _VY] - states[j, _VY])
    if not max(deep, deep + h * v) > 0.0:
        return
    mass = p[i, M] * p[j, M] / (p[i, M] + p[j, M])
    b = 2.0 * math.sqrt(k * mass)
    force = max(0.0, (k * (deep + 0.5 * h * v) + b * v) / (1.0 + (0.5 * h * b + 0.25 * h * h * k) / mass))
    push[i, 0] -= force * x
    push[i, 1] -= force * y
    push[j, 0] += force * x
    push[j, 1] += force * y
