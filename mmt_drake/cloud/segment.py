"""From the cloud of a table to the tops of what stands on it: the table's plane taken out, the rest clustered."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.numeric.arrays import Array

_NEAR_TABLE = 0.02  # [m]: points that may be the table's
_FEWEST_OF_TABLE, _MOST_OF_TABLE = 50, 2000  # points that a plane is sought in
_FLAT = 0.004  # [m] from the fitted plane: still the plane
ABOVE = 0.008  # [m] above the plane: no longer the table
_LEVEL = 0.7  # least z of a normal: else it is a side, or an edge
_ROUNDS = 50  # of the search for the plane
_NEIGHBOURS = 4
_STEPS, _DONE = 20, 2e-4  # of a registration, and what it stops at [m]


def load_open3d() -> None:
    """Load what segments a cloud, which takes a second or two, and compile it: before a clock starts."""
    import open3d  # noqa: F401

    _flattest(np.zeros((3, 3)), np.zeros((1, 3), np.int64))


def above_table(points: Array, table: float) -> tuple[Array, float]:
    """The points above the table, and how high that is [m].

    The plane is sought among the points within 2 cm of where the table should be; of too few nothing is found, and the
    table is where it should be.

    Args:
        points: (n, 3) [m].
        table: height of the table in the table frame, as it is known beforehand [m].
    """
    near = points[np.abs(points[:, 2] - table) < _NEAR_TABLE]
    if len(near) >= _FEWEST_OF_TABLE:
        near = np.ascontiguousarray(near[:: max(1, len(near) // _MOST_OF_TABLE)])
        normal, d = _plane(near)
        if abs(normal[2]) > 0.98:  # level, to 11 deg
            table = float(-(normal[:2] @ near[:, :2].mean(axis=0) + d) / normal[2])
            return points[(points @ normal + d) / normal[2] > ABOVE], table
    return points[points[:, 2] > table + ABOVE], table


def _plane(points: Array) -> tuple[Array, float]:
    """The plane n . x + d = 0 that most points are near to: its unit normal, and d [m].

    Fischler and Bolles' random sample consensus, then a fit to all that are near. It is not Open3D's, which gives
    another answer in every run on more than one core.
    """
    picked = np.random.default_rng(0).integers(len(points), size=(_ROUNDS, 3))  # two runs give the same numbers
    found = _flattest(points, picked)
    flat = points[np.abs(points @ found[:3] + found[3]) < _FLAT]
    if len(flat) < 3:
        return found[:3], float(found[3])
    middle = flat.mean(axis=0)
    normal = np.linalg.eigh((flat - middle).T @ (flat - middle))[1][:, 0]
    return normal, -float(normal @ middle)


@njit(cache=True)
def _flattest(points: Array, picked: NDArray[np.int64]) -> Array:
    """(4,) unit normal and d of the plane through three points, (k, 3) of the (n, 3), that most are near to."""
    best, found = -1, np.zeros(4)
    for k in range(len(picked)):
        p, q, r = points[picked[k, 0]], points[picked[k, 1]], points[picked[k, 2]]
        ux, uy, uz, vx, vy, vz = q[0] - p[0], q[1] - p[1], q[2] - p[2], r[0] - p[0], r[1] - p[1], r[2] - p[2]
        a, b, c = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        size = np.sqrt(a * a + b * b + c * c)
        if size == 0.0:
            continue
        a, b, c = a / size, b / size, c / size
        d, count = -(a * p[0] + b * p[1] + c * p[2]), 0
        for i in range(len(points)):
            count += abs(a * points[i, 0] + b * points[i, 1] + c * points[i, 2] + d) < _FLAT
        if count > best:
            best = count
            found[0], found[1], found[2], found[3] = a, b, c, d
    return found


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


def registered(templates: list[Array], points: Array, spacing: float, below: Array | None = None) -> list[Array]:
    """By how much each of some tops has moved, so that together they cover the points (k, 2) [m].

    Level tops do not tell where they are but by their rims. So of each the part that covers no point is drawn to the
    nearest point, and to each point that none covers the nearest top, until that is nothing: an iterated closest point
    without turning, of several at once.

    Args:
        templates: (n, 2) points of each where it was last [m].
        points: (m, 2) of them all now [m].
        spacing: between points: what is nearer is covered [m].
        below: (k, 2) where something lower is seen [m]. A part that covers no point, nor any of these, may be hidden,
            and is drawn nowhere; None: nothing is hidden.
    """
    lower = None if below is None else cKDTree(below)
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
            if lower is not None:
                beyond &= lower.query(each, distance_upper_bound=spacing)[0] < spacing
            pull[i] = np.concatenate([points[nearest[beyond]] - each[beyond], left[of == i]])
            steps.append(pull[i].mean(axis=0) if len(pull[i]) else np.zeros(2))
        for i, push in enumerate(_apart(placed, 0.5 * spacing)):
            steps[i] = steps[i] + push
            moved[i] = moved[i] + steps[i]
        if max(float(np.hypot(*step)) for step in steps) < _DONE:
            break
    return moved


def _apart(placed: list[Array], close: float) -> list[Array]:
    """By how much each of some tops is to move so that they lie less over each other: a quarter of it in a step [m]."""
    push = [np.zeros(2) for _ in placed]
    for i, one in enumerate(placed):
        for j, other in enumerate(placed[:i]):
            within = cKDTree(other).query(one)[0] < close
            if not within.any():
                continue
            away = one.mean(axis=0) - other.mean(axis=0)
            direction = away / max(float(np.hypot(*away)), 1e-9)
            along = one[within] @ direction
            step = 0.25 * float(np.ptp(along)) * direction
            push[i], push[j] = push[i] + step, push[j] - step
    return push


def spacing_of(cloud: Cloud) -> float:
    """Between the points of a cloud, 2 mm at least [m]."""
    return max(cloud.spacing, 2e-3)


def _as_open3d(points: Array) -> Any:
    import open3d

    return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(np.ascontiguousarray(points)))
