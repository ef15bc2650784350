"""A surface over a grid of heights: an organ, say."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
from numba import njit

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.bicubic import interpolated
from mmt_drake.quantities import Length
from mmt_drake.surfaces import layout
from mmt_drake.surfaces.layout import OWN
from mmt_drake.surfaces.shapes import Shape

BUILTIN = "builtin:organ"
_MOST = 1000  # heights along a side
_STEEPEST = 10.0  # from one height to the next: steeper than any organ, and what millimetres look like

# Behind `layout.OWN`: heights along x and y, their distance [m], half the lengths they cover [m], then row by row.
_COLUMNS, _ROWS, _SPACING, _HALF_X, _HALF_Y, _FIRST = range(OWN, OWN + 6)


@dataclass(frozen=True, kw_only=True)
class HeightField(Shape):
    """A smooth surface z = h(x, y) through heights on a grid, about its origin; level beyond, as at its rim.

    Between them it is bicubic with slopes of central differences (Catmull-Rom): its normal turns without a jump.

    Attributes:
        file: CSV of heights [m], a row for each y, from the least; or `builtin:organ`, a smooth hill beside a hollow.
        spacing: of the grid [m].
    """

    file: str = BUILTIN
    spacing: Length = 0.005
    KIND: ClassVar = layout.HEIGHTS

    def __post_init__(self) -> None:
        super().__post_init__()
        self.heights()

    def heights(self) -> Array:
        """(rows, columns) of y and x [m].

        Raises:
            BadInput: no such file, no table of finite numbers, or what cannot be metres.
        """
        if self.file == BUILTIN:
            return _organ(self.spacing)
        path = Path(self.file)
        if not path.is_file():
            raise BadInput(path, found="no such file", expected="a CSV of heights [m]")
        try:
            heights = np.loadtxt(path, delimiter=",", ndmin=2)
        except ValueError as error:
            raise BadInput(path, found=str(error).splitlines()[0], expected="rows of as many heights [m]") from None
        return checked_heights(heights, self.spacing, path)

    def own_numbers(self) -> Array:
        """What `height_of` reads."""
        heights = self.heights()
        rows, columns = heights.shape
        half = 0.5 * self.spacing * (columns - 1), 0.5 * self.spacing * (rows - 1)
        return np.concatenate([[columns, rows, self.spacing, *half], heights.ravel()])

    def patch(self, uv: Array) -> Array:
        """See `Shape.patch`; lengths are those across z."""
        packed = np.concatenate([np.zeros(OWN), self.own_numbers()])
        return np.column_stack([uv, [height_of(packed, u, v)[0] for u, v in uv]])


def checked_heights(heights: Array, spacing: float, source: object) -> Array:
    """Heights that may be a surface.

    Args:
        heights: (rows, columns) [m].
        spacing: of their grid [m].
        source: for messages.

    Raises:
        BadInput: fewer than 2 or more than 1000 along a side, one that is not finite, or a slope of more than 10.
    """
    if not all(2 <= side <= _MOST for side in heights.shape):
        found = " x ".join(map(str, heights.shape)) + " heights"
        raise BadInput(source, found=found, expected=f"2 to {_MOST} along each side")
    if not np.isfinite(heights).all():
        row, column = np.argwhere(~np.isfinite(heights))[0]
        raise BadInput(
            source, at=f"row {row + 1}, column {column + 1}", found=heights[row, column], expected="a height"
        )
    steepest = max(float(np.abs(np.diff(heights, axis=axis)).max()) for axis in (0, 1)) / spacing
    if steepest > _STEEPEST:
        expected = f"slopes of at most {_STEEPEST:g}: heights and spacing in metres"
        raise BadInput(source, found=f"a slope of {steepest:.3g}", expected=expected)
    return heights


def _organ(spacing: float) -> Array:
    """A hill 15 mm high and 60 mm wide beside a hollow of 6 mm."""
    x = y = np.arange(-round(0.15 / spacing), round(0.15 / spacing) + 1) * spacing
    x, y = np.meshgrid(x, y)
    hill = 0.015 * np.exp(-((x - 0.02) ** 2 + (y + 0.01) ** 2) / (2.0 * 0.03**2))
    hollow = 0.006 * np.exp(-((x + 0.045) ** 2 + (y - 0.03) ** 2) / (2.0 * 0.02**2))
    return np.asarray(hill - hollow)


@njit(cache=True, error_model="numpy")
def height_of(surface: Array, u: float, v: float) -> tuple[float, float, float, float, float, float]:
    """Of a height field at (u, v) from its origin [m]: height, slopes along both, second derivatives uu, uv, vv."""
    columns, rows, spacing = int(surface[_COLUMNS]), int(surface[_ROWS]), surface[_SPACING]
    x = min(max((u + surface[_HALF_X]) / spacing, 0.0), columns - 1.0)
    y = min(max((v + surface[_HALF_Y]) / spacing, 0.0), rows - 1.0)
    h, hx, hy, hxx, hxy, hyy = interpolated(surface, _FIRST, columns, rows, x, y)
    beyond_x, beyond_y = abs(u) > surface[_HALF_X], abs(v) > surface[_HALF_Y]
    if beyond_x:
        hx = hxx = hxy = 0.0
    if beyond_y:
        hy = hyy = hxy = 0.0
    per = 1.0 / spacing
    return h, hx * per, hy * per, hxx * per * per, hxy * per * per, hyy * per * per
