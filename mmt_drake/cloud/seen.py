"""Objects on a table as they are seen, and all of them together."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from mmt_drake.model.scene_layout import COLOUR, MOST, ROW, SCENE_SIZE, SeenState
from mmt_drake.numeric.arrays import Array

UNCOLOURED = (math.nan,) * len(COLOUR)
"""The colour of what nobody has seen in colour."""
_SHOWN_S = 0.5  # that something is told


@dataclass(frozen=True, eq=False)
class SeenThing:
    """An object as it is seen; never changed.

    Attributes:
        thing: its identity, from 1 on.
        state: what is seen of it.
        place: x, y of the middle of its top [m].
        top: height of that in the table frame [m].
        height: of it above the table [m].
        outline: (n, 2) points of its top, from the middle [m].
        cloud: (n, 3) its points of the latest frame in which it was seen [m].
        known: when it was first seen [s].
        since: when its state began [s].
        seen: when it was seen last [s].
        frames: for how many frames something has been odd.
        looks: how often it was seen apart from others.
        cut: it may go on beyond the edge of what is seen: what more comes into view is of it.
        colour: of its top, as `mmt_drake.model.scene_layout.COLOUR`.
    """

    thing: int
    state: SeenState
    place: tuple[float, float]
    top: float
    height: float
    outline: Array
    cloud: Array
    known: float
    since: float
    seen: float
    frames: int = 0
    looks: int = 1
    cut: bool = False
    colour: tuple[float, ...] = UNCOLOURED

    @property
    def size(self) -> tuple[float, float]:
        """Extents of its top along x and y [m]."""
        along, across = np.ptp(self.outline, axis=0).tolist()
        return along, across

    @property
    def placed(self) -> Array:
        """(n, 2) its outline where it was last [m]."""
        return self.outline + self.place

    def now(self, state: SeenState, t: float, **changes: Any) -> Self:
        """It in a state; what is told is told for a while."""
        if SeenState.FOUND <= self.state <= SeenState.NEW and state == SeenState.SEEN and t - self.since < _SHOWN_S:
            state = self.state
        return replace(self, state=state, since=self.since if state == self.state else t, **changes)

    def row(self, t: float) -> tuple[float, ...]:
        """As it stands in a scene."""
        seen = *self.place, self.top, self.height, *self.size, *self.colour
        return (self.thing, self.state, *seen, t - self.known)


@dataclass(frozen=True)
class SeenScene:
    """All that is seen, and who comes next; never changed.

    Attributes:
        things: all that are or were there, by identity.
        newcomers: middles of clusters that belong to nobody, and for how many frames.
        following: identity of the next new object.
        grip: identity of what a grip holds and, from when it closed, the middle of its top from the tip and height of
            the tip [m].
        probe: (3,) where the tip was [m]; None: nobody has looked yet.
    """

    things: tuple[SeenThing, ...] = ()
    newcomers: tuple[tuple[float, float, int], ...] = ()
    following: int = 1
    grip: tuple[int, float, float, float] | None = None
    probe: tuple[float, float, float] | None = None

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def vector(self, t: float) -> Array:
        """(SCENE_SIZE,) it at a time; of too many those that have been there longest: a newcomer has to wait."""
        here = sorted(self.things, key=lambda each: (each.state == SeenState.TAKEN_AWAY, each.thing))[:MOST]
        scene = np.zeros(SCENE_SIZE)
        for i, thing in enumerate(sorted(here, key=lambda each: each.thing)):
            scene[i * ROW : (i + 1) * ROW] = thing.row(t)
        return scene
