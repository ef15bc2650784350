"""The place where friction holds the body: what one copy of an object can tell another.

Copies with the same numbers under the same probe come together while they slide. Friction that holds them keeps each
where its past has put it, with other numbers perhaps, and the contact spring turns the distance into a force that
stays (the memory of a play: Krasnosel'skii, Pokrovskii, "Systems with Hysteresis", Springer 1989). Who knows where the
body is held may tell it, and when that was seen. A copy whose body has not moved nor lost its contact since before then
still has all of that distance, and can take the place over, however late it is told; one that has moved meanwhile has
to wait for later news.

A told place, (HELD_SIZE,), is for x and then for y the body's position, the anchor of its contact spring, probe less
body where that is unstretched [m], and a stamp [s]: at that time it was held there in contact; 0 until that is known.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.flexible_box import BODY, CONTACT, TIME
from mmt_drake.numeric.layout import Layout

Array = NDArray[np.float64]

PLACE, SPRING, STAMP, ENTRY = map(Layout(), (1, 1, 1, 0))
HELD_SIZE = 2 * ENTRY

NEAR = 1e-4
"""A body this near to its told place [m] stays where it is: places are known no better with a hand's motion."""

NOT_TOLD = np.zeros(HELD_SIZE)
"""In the place of a told one; writable as the arrays of ports are, and never written to."""

HELD_BODY = ("x", "anchor_x", "stamp_x", "y", "anchor_y", "stamp_y")
"""The numbers of a told place, by name."""


def tell(held: Array, bodies: Array, stamp: float) -> Array:
    """A told place (HELD_SIZE,), made new along the axes on which the body is held.

    Args:
        held: what was told before.
        bodies: (2, AXIS_SIZE) states along x and y, in contact.
        stamp: of these [s].
    """
    told = held.copy()
    for i, body in enumerate(bodies):
        if body[MODE] == 0.0 and body[VELOCITY] == 0.0:  # without friction the mode says nothing
            told[ENTRY * i : ENTRY * (i + 1)] = body[POSITION], body[ANCHOR], stamp
    return told


@njit(cache=True)
def watch(before: Array, after: Array, since: Array) -> None:
    """Keep track of since when each body has been where it is.

    Args:
        before, after: states of `flexible_box` at two ticks.
        since: (2,) [s], changed in place.
    """
    for i in range(2):
        at = BODY + AXIS_SIZE * i
        moves = after[at + MODE] != 0.0 or after[at + POSITION] != before[at + POSITION]
        if moves or after[CONTACT] != before[CONTACT]:
            since[i] = after[TIME]


@njit(cache=True)
def astray(state: Array, i: int, held: Array, since: Array) -> bool:
    """Whether along x (0) or y (1) the body of a copy is known to be held at another place, farther than `NEAR`.

    Args:
        state: of `flexible_box`.
        i: the axis.
        held: (HELD_SIZE,) the told place; one that is not finite is no news.
        since: of `watch`.
    """
    at, told = BODY + AXIS_SIZE * i, ENTRY * i
    if state[CONTACT] == 0.0 or state[at + MODE] != 0.0 or not since[i] < held[told + STAMP]:
        return False
    if not (math.isfinite(held[told + PLACE]) and math.isfinite(held[told + SPRING])):
        return False
    # The spring is stretched by what is neither in the body's place nor in its anchor: only their sum is felt there.
    return abs(held[told + PLACE] + held[told + SPRING] - state[at + POSITION] - state[at + ANCHOR]) > NEAR


@njit(cache=True)
def lead(state: Array, i: int, held: Array, share: float) -> None:
    """Move a body a share of the way to its told place along axis i, in place; a share of 1 is exactly there."""
    at, told = BODY + AXIS_SIZE * i, ENTRY * i
    if share == 1.0:
        state[at + POSITION], state[at + ANCHOR] = held[told + PLACE], held[told + SPRING]
    else:
        state[at + POSITION] += share * (held[told + PLACE] - state[at + POSITION])
        state[at + ANCHOR] += share * (held[told + SPRING] - state[at + ANCHOR])
