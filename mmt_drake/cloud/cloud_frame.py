"""What is seen of objects in one cloud: clusters of points, what they cover, and what may be hidden."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import numpy as np
from scipy.spatial import ConvexHull, QhullError, cKDTree

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.colour import cielab
from mmt_drake.cloud.seen import UNCOLOURED, SeenThing
from mmt_drake.cloud.segment import ABOVE
from mmt_drake.cloud.tracking_options import Tracking
from mmt_drake.numeric.arrays import Array

SAME_TOP: Final = 0.008
"""[m]: tops of one height."""
WHOLE: Final = 0.002
"""[m], and a spacing: of the extents that may be missing where all of it is seen."""
_RIM, _STEEP = 0.008, 4  # [m] from the rim of a top, within which points count less, by this power of the distance


@dataclass(frozen=True, eq=False)
class Cluster:
    """Points that are the top of an object, or a part of one, or of several.

    Attributes:
        points: (n, 3) in the table frame [m].
    """

    points: Array

    @property
    def across(self) -> Array:
        """(n, 2) x and y of them [m]."""
        return self.points[:, :2]

    @property
    def extents(self) -> Array:
        """(2,) how far they reach along x and y [m]."""
        return np.asarray(np.ptp(self.across, axis=0))

    @property
    def middle(self) -> tuple[float, float]:
        """x, y between its ends [m]."""
        x, y = (0.5 * (self.across.min(axis=0) + self.across.max(axis=0))).tolist()
        return x, y

    @cached_property
    def tree(self) -> Any:
        """The same two, to find the nearest one."""
        return cKDTree(self.across)

    @cached_property
    def top(self) -> float:
        """A mean in which points count less the nearer they are to the rim, where a camera mixes heights."""
        try:
            rim = ConvexHull(self.across).equations
        except QhullError:  # they stand in a line
            return float(self.points[:, 2].mean())
        inside = -(self.across @ rim[:, :2].T + rim[:, 2]).max(axis=1)
        return float(np.average(self.points[:, 2], weights=np.clip(inside / _RIM, 1e-3, 1.0) ** _STEEP))


@dataclass(frozen=True, eq=False)
class CloudFrame:
    """What is seen in one cloud.

    Attributes:
        t: when it is looked at [s].
        probe: (3,) where the tip is [m].
        table: height of the table [m].
        spacing: between points [m].
        points: (n, 3) without those of the probe and of what is carried [m].
        options: how objects are told apart.
        seen: the cloud.
        carried: what is off the table.
    """

    t: float
    probe: Array
    table: float
    spacing: float
    points: Array
    options: Tracking
    seen: Cloud
    carried: SeenThing | None = None

    @cached_property
    def _colours(self) -> tuple[Any, Array]:
        """Where colours are seen, and CIELAB there."""
        told = self.seen.colours
        coloured = np.flatnonzero([] if told is None else np.isfinite(told).all(axis=1))
        return cKDTree(self.seen.points()[coloured]), np.zeros((0, 3)) if told is None else cielab(told[coloured])

    def coloured(self, cluster: Cluster, before: tuple[float, ...] = UNCOLOURED) -> tuple[float, ...]:
        """Colour of a cluster, in the middle of its points; as before where less than half of it is seen in colour."""
        tree, colours = self._colours
        if len(colours) == 0:
            return before
        away, which = tree.query(cluster.points)
        here = which[away < 1e-6]
        return before if 2 * len(here) < len(away) else tuple(np.median(colours[here], axis=0).tolist())

    def beneath(self, thing: SeenThing, cluster: Cluster | None = None) -> bool:
        """Whether what is carried may hide an object, or the rest of it."""
        if self.carried is None:
            return False
        reach = self.options.hides + 0.5 * (max(thing.size) + max(self.carried.size))
        part = cluster is None or bool((cluster.extents < np.subtract(thing.size, WHOLE + self.spacing)).any())
        return part and math.dist(thing.place, self.carried.place) < reach

    def covered(self, thing: SeenThing, cluster: Cluster) -> float:
        """Share of a top that a cluster covers."""
        if abs(cluster.top - thing.top) > SAME_TOP:
            return 0.0
        return float(np.mean(cluster.tree.query(thing.placed)[0] < 2.0 * self.spacing))

    def cuts(self, cluster: Cluster) -> bool:
        """Whether a cluster is so near to where the table is no longer seen that the view may end on it.

        A camera sees less of what is higher: of a top by its height at most, within 45 degrees of straight down.
        """
        table = self.below(self.table + ABOVE)
        if table is None:
            return False
        room = max(cluster.top - self.table, 0.0) + 2.0 * self.spacing
        inside = (cluster.across > table.min(axis=0) + room) & (cluster.across < table.max(axis=0) - room)
        return not inside.all()

    def below(self, height: float) -> Array | None:
        """(n, 2) where something lower than a height is seen [m]; None: tops alone are."""
        low = self.points[self.points[:, 2] < height, :2]
        return low if len(low) >= self.options.fewest else None

    def bare(self, thing: SeenThing) -> bool:
        """Whether the table is seen where an object was."""
        low = self.below(self.table + 0.5 * thing.height)
        if low is None:
            return False
        return float(np.mean(cKDTree(low).query(thing.placed)[0] < 3.0 * self.spacing)) > 0.5
