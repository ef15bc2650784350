"""A scene as a vector: what is seen of objects on a table, a row each, as it is recorded and crosses the network."""

from enum import IntEnum
from typing import Any

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array

COLOUR = ("lightness", "green_red", "blue_yellow")
"""Of the top: L*, a*, b* of CIELAB [1]; NaN where nobody has told it."""
ENTRY = ("thing", "state", "x", "y", "top", "height", "along", "across", *COLOUR, "age")
"""Of a row: identity, from 1 on, 0 where the row is empty; a `SeenState`; middle of the top and its height in the table
frame [m]; its height above the table [m]; its extents along x and y [m]; its `COLOUR`; since when it has been known
[s]."""
THING, STATE, X, Y, TOP, HEIGHT, ALONG, ACROSS, LIGHTNESS, _, _, AGE = range(len(ENTRY))
LOOKS = AGE - HEIGHT
"""How many numbers from `HEIGHT` on tell what an object looks like: its extents and its colour."""
ROW = len(ENTRY)
MOST = 6
"""Objects that a scene holds."""
MARGIN = 0.008
"""By which a top may reach beyond what is seen of it [m]."""
SCENE_SIZE = MOST * ROW
SCENE = tuple(f"{i + 1}_{name}" for i in range(MOST) for name in ENTRY)
"""Names of the numbers."""
PLAIN_SCENE = tuple(name for name in SCENE if not name.endswith(COLOUR))
"""The same in recordings that were made before colours were told."""
PLACES = tuple(f"{i + 1}_{axis}" for i in range(MOST) for axis in "xy")
"""Names of the numbers that tell where so many objects truly are."""
SCENE_UNITS = dict(zip(ENTRY, ("", "", *"mmmmmm", "", "", "", "s"), strict=True))
"""Units of a row."""


class SeenState(IntEnum):
    """What is seen of an object. All but the first two are told for half a second at least."""

    NONE = 0
    SEEN = 1
    OCCLUDED = 2  # the probe or what holds it may hide it: it is taken to be where it was
    LOST = 3  # it should be seen and is not
    FOUND = 4  # it was lost or taken away, and one just like it has appeared: taken to be the same
    MERGED = 5  # it is one cluster with others: told apart by their outlines
    SPLIT = 6  # it is several clusters; or it was taken for one with another, which has left it
    TAKEN_AWAY = 7  # lost for a second: it is no longer there to be touched
    NEW = 8  # it has not been seen before
    CARRIED = 9  # a grip holds it off the table: it is where the tip is


@njit(cache=True)
def is_there(state: Any) -> Any:
    """Whether an object in this state may be touched: of one state, or of each of an array."""
    return (state != SeenState.NONE.value) & (state != SeenState.TAKEN_AWAY.value)


@njit(cache=True)
def row_of(scene: Array, thing: float) -> int:
    """Where in a scene the row of an object begins; -1: it is not in it."""
    for i in range(MOST):
        if scene[i * ROW] == thing and thing > 0.0:
            return i * ROW
    return -1


@njit(cache=True)
def under(scene: Array, x: float, y: float, margin: float) -> int:
    """Where in a scene the row begins of the object under x, y [m]; -1: none is.

    Of several it is that which they are the farthest within; they may be beyond its outline by the margin [m].
    """
    best, least = -1, margin
    for i in range(MOST):
        row = i * ROW
        if scene[row] > 0.0 and is_there(scene[row + STATE]):
            dx, dy = abs(x - scene[row + X]), abs(y - scene[row + Y])
            beyond = max(dx - 0.5 * scene[row + ALONG], dy - 0.5 * scene[row + ACROSS])
            if beyond < least or (beyond == least and best < 0):
                best, least = row, beyond
    return best


def rows(scene: Array) -> Array:
    """(k, ROW) of the objects of a scene."""
    table = np.asarray(scene).reshape(MOST, ROW)
    return table[table[:, THING] > 0.0]
