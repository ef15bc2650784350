"""A sphere in a point cloud: the local normal, the way ahead, the way out (thesis appendix C).

Compiled kernels on a `Grid`. Positions are in the grid's own coordinates [m]; nothing is allocated.
"""

import math

from numba import njit

from mmt_drake.cloud.grid import COUNT, EDGE, Grid, cells_across, row
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import Vector, dot, length, minus, plus, times


@njit(cache=True)
def wendland(r: float, r1: float, r3: float) -> float:
    """Weight of a point at distance r [m] in the normal estimate: 1 up to r1, falling to 0 at r3 (thesis eq. 15)."""
    if r <= r1:
        return 1.0
    if r >= r3:
        return 0.0
    t = (r - r1) / (r3 - r1)
    left = 1.0 - t
    left *= left
    return left * left * (4.0 * t + 1.0)


@njit(cache=True)
def distance_roots(a: float, b: Vector, c: Vector) -> tuple[float, float]:
    """The two d at which ‖b - d c‖ = a, smaller one first; NaN, NaN if there is none (thesis eq. 24-29).

    d = (2 b·c ± √(4 (b·c)² - 4 (‖b‖² - a²) ‖c‖²)) / (2 ‖c‖²). The thesis prints eq. 29 without the first 4 under the
    root. b and a in metres; c need not be a unit vector, but not zero.
    """
    bc = dot(b, c)
    cc = dot(c, c)
    under = bc * bc - (dot(b, b) - a * a) * cc
    if under < 0.0:
        return math.nan, math.nan
    root = math.sqrt(under)
    return (bc - root) / cc, (bc + root) / cc


@njit(cache=True)
def neighbourhood(grid: Grid, at: Vector, r1: float, r3: float) -> tuple[float, Vector, float, Vector]:
    """Everything the proxy asks of the points within r3 of it, in one pass.

    Returns:
        Distance to the nearest point, infinite if none is within r3 [m]; the sum of eq. 14, not normalised: directions
        from the points to the centre, weighted by eq. 15 (a point exactly at the centre has no direction and adds
        none); the sum of the weights; the points' weighted mean [m].
    """
    limit = r3 * r3
    nearest = math.inf
    nx = ny = nz = 0.0
    total = mx = my = mz = 0.0
    z0, z1 = cells_across(grid, 2, at, r3)
    y0, y1 = cells_across(grid, 1, at, r3)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(grid, iy, iz, at, r3)
            for i in range(first, end):
                px, py, pz = grid.points[0, i], grid.points[1, i], grid.points[2, i]
                dx, dy, dz = at[0] - px, at[1] - py, at[2] - pz
                squared = dx * dx + dy * dy + dz * dz
                if squared >= limit:
                    continue
                nearest = min(nearest, squared)
                r = math.sqrt(squared)
                weight = wendland(r, r1, r3)
                total += weight
                mx += weight * px
                my += weight * py
                mz += weight * pz
                if r > 0.0:
                    scaled = weight / r
                    nx += scaled * dx
                    ny += scaled * dy
                    nz += scaled * dz
    if total > 0.0:
        mx, my, mz = mx / total, my / total, mz / total
    return math.sqrt(nearest), (nx, ny, nz), total, (mx, my, mz)


@njit(cache=True)
def way_ahead(grid: Grid, at: Vector, way: Vector, a: float) -> float:
    """Part of the way, 0 to 1, that a sphere of radius a can travel from `at` before a point touches it.

    The minimum of all first roots of thesis eq. 16, over every point of the cloud, and of 1. A point that is inside the
    sphere at the start stops it at once if the sphere moves towards the point, else not at all. The path is cut to the
    cloud's bounding box and walked in pieces from the near end, so a long jump costs only what lies in its way.
    """
    whole = length(way)
    if whole == 0.0:
        return 1.0
    along = times(1.0 / whole, way)
    begin, box_end = _path_in_box(grid.frame, at, along, whole, a)
    best = whole
    while begin < best and begin <= box_end:
        piece = min(2.0 * a, best - begin)
        near_end = plus(at, times(begin, along))
        middle = plus(at, times(begin + 0.5 * piece, along))
        ball = a + 0.5 * piece
        z0, z1 = cells_across(grid, 2, middle, ball)
        y0, y1 = cells_across(grid, 1, middle, ball)
        for iz in range(z0, z1):
            for iy in range(y0, y1):
                first, end = row(grid, iy, iz, middle, ball)
                for i in range(first, end):
                    # Solved from the piece's near end: from a far start the roots would cancel.
                    to_point = minus((grid.points[0, i], grid.points[1, i], grid.points[2, i]), near_end)
                    enter, leave = distance_roots(a, to_point, along)
                    enter, leave = begin + enter, begin + leave
                    if enter >= 0.0:
                        best = min(best, enter)
                    elif enter + leave > 0.0:
                        return 0.0
        begin += piece
    return best / whole


@njit(cache=True)
def way_out(grid: Grid, at: Vector, normal: Vector, a: float) -> float:
    """Distance [m] that a sphere of radius a must move along the unit normal until the points inside it are outside.

    The maximum over those points of the roots of thesis eq. 18. Each has exactly one root that is not negative, since
    the centre is less than a away from it. Points outside the sphere are left out, or a wall on the far side of a
    groove would throw the proxy out through it.
    """
    limit = a * a
    best = 0.0
    z0, z1 = cells_across(grid, 2, at, a)
    y0, y1 = cells_across(grid, 1, at, a)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(grid, iy, iz, at, a)
            for i in range(first, end):
                to_point = minus((grid.points[0, i], grid.points[1, i], grid.points[2, i]), at)
                if dot(to_point, to_point) < limit:
                    _, leave = distance_roots(a, to_point, normal)
                    best = max(best, leave)
    return best


@njit(cache=True)
def _path_in_box(frame: Array, at: Vector, along: Vector, whole: float, a: float) -> tuple[float, float]:
    """The part (begin, end) [m] of a path of a sphere of radius a that can meet the grid's box; begin > end if none."""
    begin, end = 0.0, whole
    for axis in range(3):
        low = frame[axis] - a
        high = frame[axis] + frame[COUNT + axis] * frame[EDGE] + a
        if abs(along[axis]) < 1e-12:
            # Parallel to these two faces: over any length that matters the path stays on one side of them.
            if at[axis] < low or at[axis] > high:
                return 1.0, 0.0
            continue
        to_low, to_high = (low - at[axis]) / along[axis], (high - at[axis]) / along[axis]
        begin = max(begin, min(to_low, to_high))
        end = min(end, max(to_low, to_high))
    return begin, end
