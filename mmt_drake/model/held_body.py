"""Reports of where friction holds the body, from one copy of an object to another.

Copies with the same numbers under the same probe come together while they slide. Friction that holds them keeps each
where its past has put it, with other numbers perhaps, and the contact spring turns the distance into a force that
stays (the memory of a play: Krasnosel'skii, Pokrovskii, "Systems with Hysteresis", Springer 1989). Who knows where the
body is held may report it, and when that was seen. A copy whose body has not moved nor lost its contact since before
then still has all of that distance, and can take the report over, however late it comes; one that has moved meanwhile
has to wait for a later one.

A report, (HELD_SIZE,), is for x and then for y the body's position, the anchor of its contact spring, probe less
body where that is unstretched [m], and a stamp [s]: at that time it was held there in contact; 0 until that is known.
Behind them stands when the latest sample of the contact was that it rests on [s].

The anchor stays as it is for as long as the contact lasts. Where those of two copies differ they count the body's
position from different places. No force tells that, unless laws ask where the body is: two copies then meet a wall in
different places. So the report has the latest anchor, of a body that slides too.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.flexible_box import BODY, CONTACT, TIME
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

HELD_POSITION, HELD_ANCHOR, HELD_STAMP, HELD_ENTRY = map(Layout(), (1, 1, 1, 0))
HELD_SEEN = 2 * HELD_ENTRY
HELD_SIZE = HELD_SEEN + 1

NEAR = 1e-4
"""A body this near to its reported position [m] stays where it is: it is known no better with a hand's motion."""

NO_REPORT = np.zeros(HELD_SIZE)
"""Stands for a report where there is none; writable as the arrays of ports are, and never written to."""

HELD_BODY = ("x", "anchor_x", "stamp_x", "y", "anchor_y", "stamp_y", "seen")
"""The numbers of a report, by name."""


def report(held: Array, bodies: Array, stamp: float) -> Array:
    """The report (HELD_SIZE,), made new along the axes on which the body is held, and counted as it is counted now.

    Args:
        held: the report before.
        bodies: (2, AXIS_SIZE) states along x and y, in contact.
        stamp: of these [s].
    """
    renewed = held.copy()
    renewed[HELD_SEEN] = stamp
    for i, body in enumerate(bodies):
        entry = HELD_ENTRY * i
        if body[MODE] == 0.0 and body[VELOCITY] == 0.0:  # without friction the mode says nothing
            renewed[entry : entry + HELD_ENTRY] = body[POSITION], body[ANCHOR], stamp
        else:
            renewed[entry + HELD_POSITION] += renewed[entry + HELD_ANCHOR] - body[ANCHOR]
            renewed[entry + HELD_ANCHOR] = body[ANCHOR]
    return renewed


@njit(cache=True)
def watch(before: Array, after: Array, since: Array) -> None:
    """Keep track of since when each body has been where it is, and of when the contact began or ended.

    Args:
        before, after: states of `flexible_box` at two ticks.
        since: (3,) [s], changed in place.
    """
    touched = after[CONTACT] != before[CONTACT]
    if touched:
        since[2] = after[TIME]
    for i in range(2):
        at = BODY + AXIS_SIZE * i
        moves = after[at + MODE] != 0.0 or after[at + POSITION] != before[at + POSITION]
        if moves or touched:
            since[i] = after[TIME]


@njit(cache=True)
def astray(state: Array, i: int, held: Array, since: Array) -> bool:
    """True where along x (0) or y (1) the body of a copy is known to be held elsewhere, farther than `NEAR`.

    Args:
        state: of `flexible_box`.
        i: the axis.
        held: (HELD_SIZE,) the report; one that is not finite says nothing.
        since: of `watch`.
    """
    at, entry = BODY + AXIS_SIZE * i, HELD_ENTRY * i
    if state[CONTACT] == 0.0 or state[at + MODE] != 0.0 or not since[i] < held[entry + HELD_STAMP]:
        return False
    if not (math.isfinite(held[entry + HELD_POSITION]) and math.isfinite(held[entry + HELD_ANCHOR])):
        return False
    # The spring is stretched by what is neither in the body's position nor in its anchor: only their sum is felt.
    reported = held[entry + HELD_POSITION] + held[entry + HELD_ANCHOR]
    return abs(reported - state[at + POSITION] - state[at + ANCHOR]) > NEAR


@njit(cache=True)
def lead(state: Array, i: int, held: Array, share: float) -> None:
    """Move a body a share of the way to its reported position along axis i, in place; a share of 1 is exactly there."""
    at, entry = BODY + AXIS_SIZE * i, HELD_ENTRY * i
    if share == 1.0:
        state[at + POSITION], state[at + ANCHOR] = held[entry + HELD_POSITION], held[entry + HELD_ANCHOR]
    else:
        state[at + POSITION] += share * (held[entry + HELD_POSITION] - state[at + POSITION])
        state[at + ANCHOR] += share * (held[entry + HELD_ANCHOR] - state[at + ANCHOR])


@njit(cache=True)
def counted_elsewhere(state: Array, i: int, held: Array, since: Array) -> float:
    """How far from where the report does it the copy counts the body's position along axis i [m]; 0 if not known.

    Args:
        state, i, held, since: as of `astray`.
    """
    anchor = held[HELD_ENTRY * i + HELD_ANCHOR]
    if state[CONTACT] == 0.0 or not since[2] < held[HELD_SEEN] or not math.isfinite(anchor):
        return 0.0
    return state[BODY + AXIS_SIZE * i + ANCHOR] - anchor


@njit(cache=True)
def count_from(state: Array, i: int, distance: float) -> None:
    """Have a body's position along axis i counted from elsewhere [m], in place; the contact spring does not notice."""
    at = BODY + AXIS_SIZE * i
    state[at + POSITION] += distance
    state[at + ANCHOR] -= distance
