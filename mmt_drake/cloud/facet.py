"""The plane that touches a surface which only points and their normals tell of.

About a point x of the surface, with weights of the points about it, n is their mean normal and

    delta = sum w (n + n_i).(p_i - x) / (2 sum w)

how far x is below the surface. The mean of the points lies below a dome and the mean of their planes above it, by as
much: what is left is of fourth order in the radius. Points whose normals are another face's, beyond an edge, count
less. From the proxy's foot x is led onto the surface in two steps, so the plane turns as evenly as the weights change,
whichever points come and go.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.grid import Grid, cells_across, row
from mmt_drake.cloud.proxy import NORMAL, SURFACE, TOUCHING, new_memory, pressed, step_proxy
from mmt_drake.cloud.spheres import wendland
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import Vector, dot, get, length, minus, plus, put, times

FACET_SIZE = 4
_STEPS = 2
_SPACINGS = 6.0


def touching_plane(memory: Array, hand: Array, cloud: Cloud | None, settings: Array, facet: Array) -> None:
    """Write the plane that touches the surface under the hand: n, and n . x of its points x [m], table frame.

    Zeros where the proxy touches nothing. Of a cloud without normals it is the plane of the proxy.

    Args:
        memory: of a proxy after its step.
        hand: (3,) or longer; the first three are its position [m], table frame.
        cloud: that the proxy has seen.
        settings: `ProxySettings.packed`; points count within six spacings of the foot, r2 at least and r3 at most.
        facet: (FACET_SIZE,) to be filled.
    """
    facet[:] = 0.0
    if memory[TOUCHING] == 0.0:
        return
    if cloud is None or cloud.normals is None:
        _plane_of_proxy(memory, facet)
        return
    grid, normals = cloud.lowered(0.0)
    radius = min(float(settings[2]), max(float(settings[1]), _SPACINGS * cloud.spacing))
    _touching_plane(memory, hand, *grid, normals, cloud.translation, radius, facet)


def is_below(memory: Array, hand: Array, cloud: Cloud | None, facet: Array) -> bool:
    """Whether the hand is below the surface by the plane there, arguments as of `touching_plane` after it."""
    if cloud is None or cloud.normals is None:
        return pressed(memory, hand)
    return bool(facet[:3] @ hand[:3] < facet[3])


@njit(cache=True)
def _plane_of_proxy(memory: Array, facet: Array) -> None:
    put(facet, 0, get(memory, NORMAL))
    facet[3] = dot(get(memory, NORMAL), get(memory, SURFACE))


@njit(cache=True)
def _touching_plane(
    memory: Array,
    hand: Array,
    points: Array,
    starts: NDArray[np.int32],
    frame: Array,
    normals: Array,
    translation: Array,
    radius: float,
    facet: Array,
) -> None:
    grid, moved = Grid(points, starts, frame), get(translation, 0)
    goal, x = minus(get(hand, 0), moved), minus(get(memory, SURFACE), moved)
    n = get(memory, NORMAL)
    for step in range(_STEPS):
        total, normal, along = _about(grid, normals, x, radius, n)
        if total == 0.0 or length(normal) < 1e-3 * total:
            break
        n = times(1.0 / length(normal), normal)
        depth = along / total
        x = plus(x, times(depth, n))
        if step < _STEPS - 1:  # on to where the hand is nearest
            way = minus(goal, x)
            x = plus(x, minus(way, times(dot(way, n), n)))
    put(facet, 0, n)
    facet[3] = dot(n, plus(x, moved))


@njit(cache=True)
def _about(grid: Grid, normals: Array, x: Vector, radius: float, face: Vector) -> tuple[float, Vector, float]:
    """Sums over the points within a radius of x, grid coordinates, on a face: w, w n_i, and w (n + n_i).(p_i - x)/2."""
    limit = radius * radius
    total = nx = ny = nz = px = py = pz = own = 0.0
    z0, z1 = cells_across(grid, 2, x, radius)
    y0, y1 = cells_across(grid, 1, x, radius)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(grid, iy, iz, x, radius)
            for i in range(first, end):
                dx, dy, dz = grid.points[0, i] - x[0], grid.points[1, i] - x[1], grid.points[2, i] - x[2]
                squared = dx * dx + dy * dy + dz * dz
                if squared >= limit:
                    continue
                a, b, c = normals[0, i], normals[1, i], normals[2, i]
                alike = max(a * face[0] + b * face[1] + c * face[2], 0.0) ** 2
                w = wendland(math.sqrt(squared), 0.0, radius) * alike * alike
                total += w
                nx += w * a
                ny += w * b
                nz += w * c
                px += w * dx
                py += w * dy
                pz += w * dz
                own += w * (a * dx + b * dy + c * dz)
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    mean = (nx * px + ny * py + nz * pz) / size if size > 0.0 else 0.0
    return total, (nx, ny, nz), 0.5 * (mean + own)


def surface_near(cloud: Cloud, points: Array, faces: Array, radius: float) -> tuple[Array, Array]:
    """How far points stand below a surface, and its normal there, by the formula above.

    Args:
        cloud: with normals.
        points: (n, 3) [m], table frame; within the radius of the surface.
        faces: (n, 3) a unit normal of the face that each is held against.
        radius: within which points of the cloud count [m].

    Returns:
        (n,) depths [m], negative above the surface, NaN where no point counts; (n, 3) unit normals.

    Raises:
        BadInput: the cloud has no normals.
    """
    grid, normals = cloud.lowered(0.0)
    depths, means = np.full(len(points), math.nan), np.array(faces, dtype=np.float64)
    for i, (point, face) in enumerate(zip((points - cloud.translation).tolist(), faces.tolist(), strict=True)):
        total, mean, along = _about(grid, normals, tuple(point), radius, tuple(face))
        if total > 0.0 and length(mean) > 1e-3 * total:
            depths[i] = along / total
            means[i] = times(1.0 / length(mean), mean)
    return depths, means


def compile_touching_plane(settings: Array) -> None:
    """Compile what a detector with these settings (`ProxySettings.packed`) needs for clouds with normals."""
    cloud, memory, facet = Cloud(np.zeros((1, 3)), normals=[[0.0, 0.0, 1.0]]), new_memory(), np.zeros(FACET_SIZE)
    for _ in range(2):  # first it comes down from above
        step_proxy(memory, np.zeros(3), cloud, settings)
    touching_plane(memory, np.zeros(3), cloud, settings, facet)
    _plane_of_proxy(memory, facet)
