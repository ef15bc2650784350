"""Bicubic interpolation of a table, smooth through its points: slopes are central differences (Catmull and Rom 1974).

The weights of four neighbours in a row, at -1, 0, 1 and 2, for a place t from 0 to 1; in two dimensions they multiply.
"""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array

Weights = tuple[float, float, float, float]


@njit(cache=True, error_model="numpy")
def weights(t: float) -> Weights:
    """Of the value."""
    return (
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    )


@njit(cache=True, error_model="numpy")
def slopes(t: float) -> Weights:
    """Of the slope, per distance of the neighbours."""
    return (-0.5 + t * (2.0 - 1.5 * t), t * (-5.0 + 4.5 * t), 0.5 + t * (4.0 - 4.5 * t), t * (-1.0 + 1.5 * t))


@njit(cache=True, error_model="numpy")
def bends(t: float) -> Weights:
    """Of the second derivative, per distance squared."""
    return 2.0 - 3.0 * t, -5.0 + 9.0 * t, 4.0 - 9.0 * t, -1.0 + 3.0 * t


@njit(cache=True, error_model="numpy")
def node(columns: int, rows: int, i: int, j: int) -> int:
    """Number of the value in column i of row j, or of the one at the rim next to it, of values row by row."""
    return min(max(j, 0), rows - 1) * columns + min(max(i, 0), columns - 1)


@njit(cache=True, error_model="numpy")
def cell(at: float, count: int) -> tuple[int, float]:
    """Which of the distances between so many neighbours a place is in, and where in it."""
    i = min(math.floor(at), count - 2)
    return i, at - i


@njit(cache=True, error_model="numpy")
def interpolated(
    table: Array, first: int, columns: int, rows: int, x: float, y: float
) -> tuple[float, float, float, float, float, float]:
    """A value, its slopes along both ways and its second derivatives xx, xy, yy, per distance of the neighbours.

    Args:
        table: values row by row, from `first` on.
        first: where they begin.
        columns, rows: how many there are, two at least.
        x, y: a place within them, in distances.
    """
    (i, s), (j, t) = cell(x, columns), cell(y, rows)
    wx, wy, sx, sy, bx, by = weights(s), weights(t), slopes(s), slopes(t), bends(s), bends(t)
    h = hx = hy = hxx = hxy = hyy = 0.0
    for b in range(4):
        level = slope = bend = 0.0
        for a in range(4):
            value = table[first + node(columns, rows, i + a - 1, j + b - 1)]
            level += wx[a] * value
            slope += sx[a] * value
            bend += bx[a] * value
        h += wy[b] * level
        hx += wy[b] * slope
        hy += sy[b] * level
        hxx += wy[b] * bend
        hxy += sy[b] * slope
        hyy += by[b] * level
    return h, hx, hy, hxx, hxy, hyy
