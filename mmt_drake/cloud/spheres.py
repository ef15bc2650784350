"""What a sphere meets in a point cloud: the local normal, the way ahead, the way out (thesis appendix C).

Compiled kernels on the arrays of a `Grid`. Positions are in the grid's own coordinates [m]; unit vectors are three
numbers; nothing is allocated.
"""

from __future__ import annotations

import math

from numba import njit

from mmt_drake.cloud.grid import COUNT, EDGE, cells_across, row


@njit(cache=True)
def wendland(r, r1, r3):
    """Weight of a point at distance r [m] in the normal estimate: 1 up to r1, smoothly down to 0 at r3 (thesis eq. 15)."""
    if r <= r1:
        return 1.0
    if r >= r3:
        return 0.0
    t = (r - r1) / (r3 - r1)
    left = 1.0 - t
    left *= left
    return left * left * (4.0 * t + 1.0)


@njit(cache=True)
def distance_roots(a, bx, by, bz, cx, cy, cz):
    """The two d at which ‖b - d c‖ = a, smaller one first; NaN, NaN if there is none (thesis eq. 24-29).

    d = (2 b·c ± √(4 (b·c)² - 4 (‖b‖² - a²) ‖c‖²)) / (2 ‖c‖²). The thesis prints eq. 29 without the first 4 under the
    root. b and a in metres; c need not be a unit vector, but not zero.
    """
    bc = bx * cx + by * cy + bz * cz
    cc = cx * cx + cy * cy + cz * cz
    under = bc * bc - (bx * bx + by * by + bz * bz - a * a) * cc
    if under < 0.0:
        return math.nan, math.nan
    root = math.sqrt(under)
    return (bc - root) / cc, (bc + root) / cc


@njit(cache=True)
def neighbourhood(points, starts, frame, x, y, z, r1, r3):
    """Everything the proxy asks of the points within r3 of (x, y, z), in one pass.

    Returns:
        Distance to the nearest point (infinite if none is within r3); the sum of eq. 14, not normalised: directions
        from the points to the centre, weighted by eq. 15 (a point exactly at the centre has no direction and adds
        none); the sum of the weights; the weighted sum of the points' coordinates. Eight numbers in all.
    """
    limit = r3 * r3
    nearest = math.inf
    nx = ny = nz = 0.0
    total = mx = my = mz = 0.0
    z0, z1 = cells_across(frame, 2, z, r3)
    y0, y1 = cells_across(frame, 1, y, r3)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(starts, frame, iy, iz, x, y, z, r3)
            for i in range(first, end):
                px, py, pz = points[0, i], points[1, i], points[2, i]
                dx, dy, dz = x - px, y - py, z - pz
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
    return math.sqrt(nearest), nx, ny, nz, total, mx, my, mz


@njit(cache=True)
def way_ahead(points, starts, frame, x, y, z, cx, cy, cz, length, a):
    """How far a sphere of radius a can travel from (x, y, z) along the unit vector c before a point touches it.

    The minimum of `length` and of all first roots of thesis eq. 16, over every point of the cloud. A point that is
    inside the sphere at the start stops it at once if the sphere moves towards the point, else not at all. The path is
    cut to the cloud's bounding box and walked in pieces from the near end, so a long jump costs only what lies in its
    way.
    """
    begin, end_of_box = _path_in_box(frame, x, y, z, cx, cy, cz, length, a)
    best = length
    while begin < best and begin <= end_of_box:
        piece = min(2.0 * a, best - begin)
        middle = begin + 0.5 * piece
        ball = a + 0.5 * piece
        bx, by, bz = x + middle * cx, y + middle * cy, z + middle * cz
        z0, z1 = cells_across(frame, 2, bz, ball)
        y0, y1 = cells_across(frame, 1, by, ball)
        for iz in range(z0, z1):
            for iy in range(y0, y1):
                first, end = row(starts, frame, iy, iz, bx, by, bz, ball)
                for i in range(first, end):
                    dx, dy, dz = points[0, i] - x, points[1, i] - y, points[2, i] - z
                    entry, leave = distance_roots(a, dx, dy, dz, cx, cy, cz)
                    if entry >= 0.0:
                        best = min(best, entry)
                    elif entry + leave > 0.0 and leave > 0.0:
                        return 0.0
        begin += piece
    return best


@njit(cache=True)
def way_out(points, starts, frame, x, y, z, nx, ny, nz, a):
    """How far a sphere of radius a must move along the unit vector n until the points now inside it are outside.

    The maximum over those points of the roots of thesis eq. 18. Each has exactly one root that is not negative, since
    the centre is less than a away from it. Points outside the sphere are left out, or a wall on the far side of a
    groove would throw the proxy out through it.
    """
    limit = a * a
    best = 0.0
    z0, z1 = cells_across(frame, 2, z, a)
    y0, y1 = cells_across(frame, 1, y, a)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(starts, frame, iy, iz, x, y, z, a)
            for i in range(first, end):
                dx, dy, dz = points[0, i] - x, points[1, i] - y, points[2, i] - z
                if dx * dx + dy * dy + dz * dz < limit:
                    _, leave = distance_roots(a, dx, dy, dz, nx, ny, nz)
                    best = max(best, leave)
    return best


@njit(cache=True)
def _path_in_box(frame, x, y, z, cx, cy, cz, length, a):
    """The part (begin, end) of a path of a sphere of radius a that can meet the grid's box; begin > end if none."""
    begin, end = 0.0, length
    for axis in range(3):
        at = x if axis == 0 else (y if axis == 1 else z)
        along = cx if axis == 0 else (cy if axis == 1 else cz)
        low = frame[axis] - a
        high = frame[axis] + frame[COUNT + axis] * frame[EDGE] + a
        if abs(along) < 1e-12:
            # Parallel to these two faces: over any length that matters the path stays on one side of them.
            if at < low or at > high:
                return 1.0, 0.0
            continue
        to_low, to_high = (low - at) / along, (high - at) / along
        begin = max(begin, min(to_low, to_high))
        end = min(end, max(to_low, to_high))
    return begin, end
