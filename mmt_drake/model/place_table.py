"""A quantity h(x, y) as values over an even grid of places, such as the height of a surface.

Bicubic between the places, beyond the grid level, as at its rim.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.bicubic import cell, interpolated, node, slopes, weights

X0, Y0, DX, DY, COLUMNS, ROWS, FIRST = range(7)
"""Of a packed table: first x and y [m], distances of the columns and rows [m], how many there are; its values."""

_EVEN = 1e-6  # of a distance: what rounding may make of it


class Above(NamedTuple):
    """A table at a place: value and slopes along x and y [1/m]."""

    h: float
    hx: float
    hy: float


@dataclass(frozen=True)
class PlaceTable:
    """A table over places.

    Attributes:
        x, y: columns and rows of the grid [m], increasing and even.
        value: row by row, from the least y on.

    Raises:
        BadInput: a grid of fewer than two columns or rows, one that is not even, or another number of values.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    value: tuple[float, ...]

    def __post_init__(self) -> None:
        for name, at in (("x", self.x), ("y", self.y)):
            apart = np.diff(at)
            even = len(at) >= 2 and apart[0] > 0.0 and np.abs(apart - apart[0]).max() <= _EVEN * len(at) * apart[0]
            if not even:
                expected = "two places or more, increasing by even steps"
                raise BadInput("table", at=name, found=f"{len(at)} places", expected=expected)
        if len(self.value) != len(self.x) * len(self.y):
            expected = f"{len(self.x) * len(self.y)}, a row of {len(self.x)} for each y"
            raise BadInput("table", found=f"{len(self.value)} values", expected=expected)

    def packed(self) -> Array:
        """What `under` reads."""
        apart = [(at[-1] - at[0]) / (len(at) - 1) for at in (self.x, self.y)]
        return np.array([self.x[0], self.y[0], *apart, len(self.x), len(self.y), *self.value])


@njit(cache=True, error_model="numpy")
def under(table: Array, x: float, y: float) -> Above:
    """A packed table at the place (x, y) [m]."""
    columns, rows = int(table[COLUMNS]), int(table[ROWS])
    u, v = (x - table[X0]) / table[DX], (y - table[Y0]) / table[DY]
    s, t = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
    h, hx, hy, _, _, _ = interpolated(table, FIRST, columns, rows, s, t)
    return Above(h, hx / table[DX] if s == u else 0.0, hy / table[DY] if t == v else 0.0)


@njit(cache=True, error_model="numpy")
def nodes_under(table: Array, x: Array, y: Array, nodes: Array, value: Array, slope_x: Array, slope_y: Array) -> None:
    """By which values of a packed table, and how much of each, it is made at places: derivatives of `under`.

    Args:
        table: packed; its values are not read.
        x, y: (n,) places [m].
        nodes: (n, 16) to be filled with the numbers of the values, one perhaps several times.
        value, slope_x, slope_y: (n, 16) to be filled with what each adds to value and slopes.
    """
    columns, rows = int(table[COLUMNS]), int(table[ROWS])
    for k in range(len(x)):
        u, v = (x[k] - table[X0]) / table[DX], (y[k] - table[Y0]) / table[DY]
        s, t = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
        (i, s_in), (j, t_in) = cell(s, columns), cell(t, rows)
        wx, wy, sx, sy = weights(s_in), weights(t_in), slopes(s_in), slopes(t_in)
        for b in range(4):
            for a in range(4):
                at = 4 * b + a
                nodes[k, at] = node(columns, rows, i + a - 1, j + b - 1)
                value[k, at] = wx[a] * wy[b]
                slope_x[k, at] = sx[a] * wy[b] / table[DX] if s == u else 0.0
                slope_y[k, at] = wx[a] * sy[b] / table[DY] if t == v else 0.0
