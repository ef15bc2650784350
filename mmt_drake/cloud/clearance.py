"""The height of a hand above the surface: what says that it is in free space, where a proxy can be wrong.

A proxy that has come through a cloud sees nothing around it and is free again, deep below the surface. A camera looks
down on the surface, and what is below a point that it has seen is not free space but out of its sight. So the question
is not how near the next point is but whether every point about the hand lies below it.
"""

import math

from numba import njit
from numpy import int32
from numpy.typing import NDArray

from mmt_drake.cloud.cloud import Cloud
from mmt_drake.cloud.grid import COUNT, EDGE, Grid, cells_across
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.vectors import Vector, get, minus

NO_SURFACE = -math.inf


def clearance(cloud: Cloud | None, hand: Array, radius: float) -> float:
    """Height of a hand above the highest point of a cloud that is within `radius` of it across z [m].

    Where none is so near, in a hole or beyond the rim, it is the height above the whole cloud, taken up to one cell of
    its grid too high: over a hole nothing else is certain. Below 0 the hand is under the surface; without points it is
    `NO_SURFACE`.

    Args:
        cloud: the surface now; None if none has come in yet.
        hand: (3,) or longer; the first three are a position [m], table frame.
        radius: of the column about the hand [m].
    """
    if cloud is None or len(cloud) == 0:
        return NO_SURFACE
    height: float = _clearance(hand, *cloud.kernel_arrays, radius)
    return height


@njit(cache=True)
def _clearance(hand: Array, points: Array, starts: NDArray[int32], frame: Array, header: Array, radius: float) -> float:
    """See `clearance`; `points` to `header` are `Cloud.kernel_arrays`."""
    at = minus(get(hand, 0), get(header, 0))
    grid = Grid(points, starts, frame)
    top = _highest_within(grid, at, radius)
    if top == -math.inf:
        top = frame[2] + frame[COUNT + 2] * frame[EDGE]
    return at[2] - top


@njit(cache=True)
def _highest_within(grid: Grid, at: Vector, radius: float) -> float:
    """Greatest z of the points in the column about `at`, grid coordinates [m]; -inf if there are none."""
    x0, x1 = cells_across(grid, 0, at, radius)
    y0, y1 = cells_across(grid, 1, at, radius)
    highest = -math.inf
    if x0 >= x1:
        return highest
    count_x, count_y = int(grid.frame[COUNT]), int(grid.frame[COUNT + 1])
    for iz in range(int(grid.frame[COUNT + 2]) - 1, -1, -1):
        for iy in range(y0, y1):
            row = count_x * (iy + count_y * iz)
            for i in range(grid.starts[row + x0], grid.starts[row + x1]):
                dx, dy = grid.points[0, i] - at[0], grid.points[1, i] - at[1]
                if dx * dx + dy * dy < radius * radius:
                    highest = max(highest, grid.points[2, i])
        if highest > -math.inf:  # the layers below are lower
            return highest
    return highest
