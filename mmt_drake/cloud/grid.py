"""The uniform grid that finds a cloud's points near a position: built by counting sort, queried without allocating.

Cells are cubes, numbered with x running fastest, and the points are stored cell by cell. All cells of one row along x
that touch a ball are therefore one unbroken stretch of the sorted points, and a ball query is a short list of such
stretches. Kernels walk them as::

    z0, z1 = cells_across(grid, 2, at, radius)
    y0, y1 = cells_across(grid, 1, at, radius)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(grid, iy, iz, at, radius)
            for i in range(first, end):
                ...  # grid.points[:, i] may lie in the ball; test it
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout
from mmt_drake.numeric.vectors import Vector

# Layout of `frame`: corner of cell 0 [m], the cells' edge [m] and its inverse, the number of cells along x, y and z.
_, EDGE, PER_METRE, COUNT, FRAME_SIZE = map(Layout(), (3, 1, 1, 3, 0))

DEFAULT_EDGE = 2.5e-3
_CELLS_ALWAYS_ALLOWED = 1 << 16
_CELLS_PER_POINT = 4
# Rows are trimmed to the ball with this much to spare [m], so that rounding never loses a point on a cell's border.
_SLACK = 1e-8


class Grid(NamedTuple):
    """The arrays of one built grid; treat them as read-only.

    Attributes:
        points: (3, n) the cloud's points [m], sorted by cell.
        starts: (cells + 1,) where each cell's points begin in `points`.
        frame: (8,) corner x, y, z [m], edge [m], 1/edge, cells along x, y, z.
    """

    points: Array
    starts: NDArray[np.int32]
    frame: Array


def build_grid(points: Array, edge: float = DEFAULT_EDGE) -> Grid:
    """Sort points into cubic cells.

    Args:
        points: (n, 3) finite positions [m], C-contiguous; n may be 0.
        edge: wanted edge of a cell [m]. A cloud so wide that it would need many more cells than it has points gets
            larger cells: queries stay exact and become slower.
    """
    frame = np.zeros(FRAME_SIZE)
    frame[EDGE] = edge
    _fit_frame(points, frame)
    return Grid(*_sorted(points, frame), frame)


def grid_order(points: Array, grid: Grid) -> NDArray[np.intp]:
    """(n,) which of the points, (n, 3), stands where in the grid that was built from them."""
    frame = grid.frame
    # As `_sorted` has it: the same product, cut off the same way.
    at = ((points - frame[:3]) * frame[PER_METRE]).astype(np.int32).T.astype(np.int64)
    return np.argsort(at[0] + int(frame[COUNT]) * (at[1] + int(frame[COUNT + 1]) * at[2]), kind="stable")


@njit(cache=True)
def cells_across(grid: Grid, axis: int, at: Vector, radius: float) -> tuple[int, int]:
    """The cells (first, end) along one axis (0, 1, 2) that a ball touches; `at` in grid coordinates [m]."""
    return _cells_between(grid.frame, axis, at[axis] - radius, at[axis] + radius)


@njit(cache=True)
def row(grid: Grid, iy: int, iz: int, at: Vector, radius: float) -> tuple[int, int]:
    """The stretch (first, end) of sorted points in the row of cells (iy, iz) that a ball can reach."""
    frame = grid.frame
    edge = frame[EDGE]
    to_y = at[1] - frame[1] - iy * edge
    to_z = at[2] - frame[2] - iz * edge
    gap_y = max(-to_y, to_y - edge, 0.0)
    gap_z = max(-to_z, to_z - edge, 0.0)
    reach = radius + _SLACK
    left = reach * reach - gap_y * gap_y - gap_z * gap_z
    if left < 0.0:
        return 0, 0
    half = math.sqrt(left)
    x0, x1 = _cells_between(frame, 0, at[0] - half, at[0] + half)
    if x0 >= x1:
        return 0, 0
    first_cell = int(frame[COUNT]) * (iy + int(frame[COUNT + 1]) * iz)
    return grid.starts[first_cell + x0], grid.starts[first_cell + x1]


@njit(cache=True)
def count_within(grid: Grid, at: Vector, radius: float, enough: int) -> int:
    """Number of points strictly within `radius` of `at` [m], grid coordinates; stops counting at `enough`."""
    found = 0
    limit = radius * radius
    z0, z1 = cells_across(grid, 2, at, radius)
    y0, y1 = cells_across(grid, 1, at, radius)
    for iz in range(z0, z1):
        for iy in range(y0, y1):
            first, end = row(grid, iy, iz, at, radius)
            for i in range(first, end):
                dx = grid.points[0, i] - at[0]
                dy = grid.points[1, i] - at[1]
                dz = grid.points[2, i] - at[2]
                if dx * dx + dy * dy + dz * dz < limit:
                    found += 1
                    if found >= enough:
                        return found
    return found


@njit(cache=True)
def _cells_between(frame: Array, axis: int, low: float, high: float) -> tuple[int, int]:
    """The cells (first, end) along one axis that hold coordinates from low to high [m]."""
    count = frame[COUNT + axis]
    first = math.floor((low - frame[axis]) * frame[PER_METRE])
    end = math.floor((high - frame[axis]) * frame[PER_METRE]) + 1.0
    return int(min(max(first, 0.0), count)), int(min(max(end, 0.0), count))


@njit(cache=True)
def _fit_frame(points: Array, frame: Array) -> None:
    """Put the frame around the points and choose the cells' edge, starting from the wanted one in `frame`."""
    n = points.shape[0]
    if n == 0:
        return
    extent, cells = np.empty(3), frame[COUNT:]
    for axis in range(3):
        low = high = points[0, axis]
        # Comparisons rather than min and max, whose care for NaN costs four times as much.
        for i in range(1, n):
            x = points[i, axis]
            if x < low:
                low = x
            if x > high:
                high = x
        frame[axis], extent[axis] = low, high - low
    most = max(_CELLS_ALWAYS_ALLOWED, _CELLS_PER_POINT * n)
    while True:
        frame[PER_METRE] = 1.0 / frame[EDGE]
        for axis in range(3):
            cells[axis] = math.floor(extent[axis] * frame[PER_METRE]) + 1.0
        if cells[0] * cells[1] * cells[2] <= most:
            break
        frame[EDGE] *= 1.25


@njit(cache=True)
def _sorted(points: Array, frame: Array) -> tuple[Array, NDArray[np.int32]]:
    """`Grid.points` and `Grid.starts`: the points of a cell stay in the order they came in."""
    n, nx, ny = points.shape[0], np.int32(frame[COUNT]), np.int32(frame[COUNT + 1])
    cells = int(frame[COUNT] * frame[COUNT + 1] * frame[COUNT + 2])
    starts, cell_of_point, ordered = np.zeros(cells + 1, np.int32), np.empty(n, np.int32), np.empty((3, n))
    ox, oy, oz = frame[0], frame[1], frame[2]
    per_metre = frame[PER_METRE]
    flat = points.reshape(-1)
    # Two loops, because the first one vectorises only if it does not also count.
    for i in range(n):
        ix = np.int32((flat[3 * i] - ox) * per_metre)
        iy = np.int32((flat[3 * i + 1] - oy) * per_metre)
        iz = np.int32((flat[3 * i + 2] - oz) * per_metre)
        cell_of_point[i] = ix + nx * (iy + ny * iz)
    for i in range(n):
        starts[cell_of_point[i] + 1] += 1
    for cell in range(cells):
        starts[cell + 1] += starts[cell]
    # Cells are filled from their ends, so starts[cell + 1] runs down from the cell's end to its start.
    for i in range(n - 1, -1, -1):
        cell = cell_of_point[i]
        slot = starts[cell + 1] - 1
        starts[cell + 1] = slot
        ordered[0, slot] = points[i, 0]
        ordered[1, slot] = points[i, 1]
        ordered[2, slot] = points[i, 2]
    for cell in range(cells):
        starts[cell] = starts[cell + 1]
    starts[cells] = n
    return ordered, starts
