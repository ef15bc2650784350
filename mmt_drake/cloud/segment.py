"""From the cloud of a table to the tops of what stands on it: the table's plane taken out, the rest clustered."""

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.numeric.arrays import Array

_NEAR_TABLE = 0.02  # [m]: points that may be the table's
_FEWEST_OF_TABLE, _MOST_OF_TABLE = 50, 2000  # points that a plane is sought in
_FLAT = 0.004  # [m] from the fitted plane: still the plane
_ABOVE = 0.008  # [m] above the plane: no longer the table
_LEVEL = 0.7  # least z of a normal: else it is a side, or an edge
_ROUNDS = 50  # of the search for the plane
_NEIGHBOURS = 4
_STEPS, _DONE = 20, 2e-4  # of a registration, and what it stops at [m]


def load_open3d() -> None:
    """Load what segments a cloud, which takes a second or two: before a clock starts."""
    import open3d  # noqa: F401


def above_table(points: Array, table: float) -> tuple[Array, float]:
    """The points above the table, and how high that is [m].

    Open3D finds the plane among the points within 2 cm of where the table should be; of too few nothing is found, and
    the table is where it should be.

    Args:
        points: (n, 3) [m].
        table: height of the table in the table frame, as it is known beforehand [m].
    """
    near = points[np.abs(points[:, 2] - table) < _NEAR_TABLE]
    if len(near) >= _FEWEST_OF_TABLE:
        import open3d

        open3d.utility.random.seed(0)  # two runs give the same numbers
        near = near[:: max(1, len(near) // _MOST_OF_TABLE)]
        (a, b, c, d), _ = _as_open3d(near).segment_plane(_FLAT, 3, _ROUNDS)
        if abs(c) > 0.98:  # level, to 11 deg
            table = float(-(a * np.mean(near[:, 0]) + b * np.mean(near[:, 1]) + d) / c)
            return points[(points @ [a, b, c] + d) / c > _ABOVE], table
    return points[points[:, 2] > table + _ABOVE], table


def tops(points: Array, spacing: float, fewest: int) -> list[Array]:
    """Clusters of the points whose surface is level, (n, 3) each, the largest first.

    Args:
        points: (n, 3) above the table [m].
        spacing: between the points [m].
        fewest: so many points make a cluster.
    """
    if len(points) < fewest:
        return []
    import open3d

    cloud, reach = _as_open3d(points), max(2.2 * spacing, 0.005)
    if np.ptp(points[:, 2]) > 2.0 * _FLAT:
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(radius=reach, max_nn=20))
        level = np.abs(np.asarray(cloud.normals)[:, 2]) > _LEVEL
        points = points[level]
        cloud = _as_open3d(points)
    labels = np.asarray(cloud.cluster_dbscan(reach, _NEIGHBOURS))
    found = [points[labels == label] for label in range(labels.max() + 1)] if len(labels) else []
    return sorted((each for each in found if len(each) >= fewest), key=len, reverse=True)


def registered(templates: list[Array], points: Array, spacing: float) -> list[Array]:
    """By how much each of some tops has moved, so that together they cover the points (k, 2) [m].

    Level tops do not tell where they are but by their rims. So of each the part that covers no point is drawn to the
    nearest point, and to each point that none covers the nearest top, until that is nothing: an iterated closest point
    without turning, of several at once.

    Args:
        templates: (n, 2) points of each where it was last [m].
        points: (m, 2) of them all now [m].
        spacing: between points: what is nearer is covered [m].
    """
    moved = [np.zeros(2) for _ in templates]
    near = cKDTree(points)
    owner = np.concatenate([np.full(len(template), i) for i, template in enumerate(templates)])
    for _ in range(_STEPS):
        placed = [template + by for template, by in zip(templates, moved, strict=True)]
        everything = np.concatenate(placed)
        pull = [np.zeros((0, 2)) for _ in templates]
        distance, which = cKDTree(everything).query(points)
        uncovered = distance > spacing
        left, of = points[uncovered] - everything[which[uncovered]], owner[which[uncovered]]
        steps = []
        for i, each in enumerate(placed):
            away, nearest = near.query(each)
            beyond = away > spacing
            pull[i] = np.concatenate([points[nearest[beyond]] - each[beyond], left[of == i]])
            steps.append(pull[i].mean(axis=0) if len(pull[i]) else np.zeros(2))
            moved[i] = moved[i] + steps[i]
        if max(float(np.hypot(*step)) for step in steps) < _DONE:
            break
    return moved


def spacing_of(cloud: Cloud) -> float:
    """Between the points of a cloud, 2 mm at least [m]."""
    return max(cloud.spacing, 2e-3)


def _as_open3d(points: Array) -> Any:
    import open3d

    return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(np.ascontiguousarray(points)))
