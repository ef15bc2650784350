"""A surface z = h(x, y) as heights over an even grid: bicubic between them, beyond the grid level, as at its rim."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.bicubic import cell, interpolated, node, slopes, weights

X0, Y0, DX, DY, COLUMNS, ROWS, FIRST = range(7)
"""Of a packed map: the first x and y [m], the distances of the columns and rows [m], how many there are; heights."""

_EVEN = 1e-6  # of a distance: what rounding may make of it


class Above(NamedTuple):
    """A surface under a place: height [m] and slopes along x and y."""

    h: float
    hx: float
    hy: float


@dataclass(frozen=True)
class HeightMap:
    """A table of heights.

    Attributes:
        x, y: columns and rows of the grid [m], increasing and even.
        height: row by row, from the least y on [m].

    Raises:
        BadInput: a grid of fewer than two columns or rows, one that is not even, or another number of heights.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    height: tuple[float, ...]

    def __post_init__(self) -> None:
        for name, at in (("x", self.x), ("y", self.y)):
            apart = np.diff(at)
            even = len(at) >= 2 and apart[0] > 0.0 and np.abs(apart - apart[0]).max() <= _EVEN * len(at) * apart[0]
            if not even:
                expected = "two places or more, increasing by even steps"
                raise BadInput("surface", at=name, found=f"{len(at)} places", expected=expected)
        if len(self.height) != len(self.x) * len(self.y):
            expected = f"{len(self.x) * len(self.y)}, a row of {len(self.x)} for each y"
            raise BadInput("surface", at="height", found=f"{len(self.height)} heights", expected=expected)

    def packed(self) -> Array:
        """What `under` reads."""
        apart = [(at[-1] - at[0]) / (len(at) - 1) for at in (self.x, self.y)]
        return np.array([self.x[0], self.y[0], *apart, len(self.x), len(self.y), *self.height])


@njit(cache=True, error_model="numpy")
def under(surface: Array, x: float, y: float) -> Above:
    """A packed map under the place (x, y) [m]."""
    columns, rows = int(surface[COLUMNS]), int(surface[ROWS])
    u, v = (x - surface[X0]) / surface[DX], (y - surface[Y0]) / surface[DY]
    s, t = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
    h, hx, hy, _, _, _ = interpolated(surface, FIRST, columns, rows, s, t)
    return Above(h, hx / surface[DX] if s == u else 0.0, hy / surface[DY] if t == v else 0.0)


@njit(cache=True, error_model="numpy")
def nodes_under(surface: Array, x: Array, y: Array, nodes: Array, value: Array, slope_x: Array, slope_y: Array) -> None:
    """By which heights of a packed map, and how much of each, the surface is made under places: derivatives of `under`.

    Args:
        surface: packed; its heights are not read.
        x, y: (n,) places [m].
        nodes: (n, 16) to be filled with the numbers of the heights, one perhaps several times.
        value, slope_x, slope_y: (n, 16) to be filled with what each adds to height and slopes, per metre.
    """
    columns, rows = int(surface[COLUMNS]), int(surface[ROWS])
    for k in range(len(x)):
        u, v = (x[k] - surface[X0]) / surface[DX], (y[k] - surface[Y0]) / surface[DY]
        s, t = min(max(u, 0.0), columns - 1.0), min(max(v, 0.0), rows - 1.0)
        (i, s_in), (j, t_in) = cell(s, columns), cell(t, rows)
        wx, wy, sx, sy = weights(s_in), weights(t_in), slopes(s_in), slopes(t_in)
        for b in range(4):
            for a in range(4):
                at = 4 * b + a
                nodes[k, at] = node(columns, rows, i + a - 1, j + b - 1)
                value[k, at] = wx[a] * wy[b]
                slope_x[k, at] = sx[a] * wy[b] / surface[DX] if s == u else 0.0
                slope_y[k, at] = wx[a] * sy[b] / surface[DY] if t == v else 0.0
