"""A point cloud of a surface, ready for the proxy."""

import itertools
import math
from typing import Any, Self

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from mmt_drake.cloud.grid import EDGE, Grid, build_grid, count_within, grid_order
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

# Layout of a cloud's header: translation x, y, z [m], then these.
SERIAL = 3
SPACING = 4

_FARTHEST = 100.0  # [m] a coordinate from the table, in reach of no depth camera
_serial_numbers = itertools.count(1)
_SPACING_SAMPLES = 64
_SPACING_NEIGHBOURS = 50.0


class Cloud:
    """Points of a surface at one time, in the table frame; immutable.

    A cloud is a set of base points, where a rigid translation has taken them, and when. The neighbour structure is
    built once from the base points, here in the constructor; `moved` shares it, whatever the number of points. Of a
    cloud that another process has told it is built when it, or a moved one, is first asked for.

    Args:
        points: (n, 3) base positions [m]; n may be 0. Copied.
        stamp: when the surface was there [s].
        normals: (n, 3) outward unit normals at the points; None: nobody has said, and up is taken for out.
        colours: (n, 3) sRGB at the points, 0 to 1, NaN where it is not seen; None: nobody has said.

    Raises:
        BadInput: points are not (n, 3), or a number is not finite, or a point further than 100 m along an axis; normals
            that are none, or most of which point down into the surface; colours that are none.
    """

    def __init__(
        self,
        points: ArrayLike,
        *,
        stamp: float = 0.0,
        normals: ArrayLike | None = None,
        colours: ArrayLike | None = None,
    ) -> None:
        base = np.array(points, dtype=np.float64, order="C")
        if base.ndim != 2 or base.shape[1] != 3:
            raise BadInput("cloud", at="points", found=f"an array of shape {base.shape}", expected="shape (n, 3)")
        # Not so of NaN; and it costs no second array.
        if len(base) and not (base.max() <= _FARTHEST and base.min() >= -_FARTHEST):
            bad = np.flatnonzero(~(np.abs(base) <= _FARTHEST).all(axis=1))[0]
            expected = f"coordinates within {_FARTHEST:g} m"
            raise BadInput("cloud", at=f"point {bad}", found=base[bad], expected=expected)
        base.flags.writeable = False
        grid = build_grid(base)
        serial = float(next(_serial_numbers))
        self._normals = None if normals is None else _checked_normals(normals, len(base))
        self._colours = None if colours is None else _checked_colours(colours, len(base))
        self._lowered: dict[float, tuple[Grid, Array]] = {}
        self._fill(base, grid, (0.0, 0.0, 0.0, serial, _spacing(base, grid)), stamp)

    def _fill(self, base: Array, grid: Grid | None, header: tuple[float, ...], stamp: float) -> None:
        if not math.isfinite(stamp):
            raise BadInput("cloud", at="stamp", found=stamp, expected="a time [s]")
        self._base, self._built, self._stamp = base, grid, float(stamp)
        self._header = np.array(header)
        self._header.flags.writeable = False

    @property
    def _grid(self) -> Grid:
        if self._built is None:
            self._built = build_grid(self._base)
        return self._built

    def __reduce__(self) -> tuple[Any, ...]:
        """As another process is told it, where it is another cloud, with a number of its own."""
        header = self._header.tolist()
        told = self._base, self._normals, self._colours
        return _restored, (type(self), told, header[:SERIAL], header[SERIAL + 1 :], self._stamp)

    @classmethod
    def empty(cls, stamp: float = 0.0) -> Self:
        """A cloud without points: nothing has been seen."""
        return cls(np.empty((0, 3)), stamp=stamp)

    def moved(self, translation: ArrayLike, stamp: float) -> Self:
        """The same base points at another translation (from the base, not from here) and time; nothing is copied."""
        other = object.__new__(type(self))
        other._normals, other._colours, other._lowered = self._normals, self._colours, self._lowered
        other._fill(self._base, self._grid, (*_vector(translation), *self._header[SERIAL:]), stamp)
        return other

    @property
    def base(self) -> Array:
        """(n, 3) base points [m], read-only."""
        return self._base

    @property
    def normals(self) -> Array | None:
        """(n, 3) outward unit normals at the base points, read-only; None where nobody has said."""
        return self._normals

    @property
    def colours(self) -> Array | None:
        """(n, 3) sRGB at the base points, 0 to 1, NaN where it is not seen, read-only; None where nobody has said."""
        return self._colours

    def with_normals(self) -> Self:
        """The same points with normals by Open3D, which all point up: what a camera above has seen is outward.

        Each is fitted to a neighbourhood of three spacings, and 3 mm at least.
        """
        if len(self) < 3:
            return self
        cloud = self.to_open3d()
        import open3d

        reach = max(3.0 * self.spacing, 3e-3)
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(radius=reach, max_nn=50))
        found = np.asarray(cloud.normals)
        outward = np.where(found[:, 2:] < 0.0, -found, found)
        return type(self)(self.points(), stamp=self.stamp, normals=outward, colours=self._colours)

    def lowered(self, offset: float) -> tuple[Grid, Array]:
        """Grid of the base points moved against their normals by an offset [m], and (3, n) the normals in its order.

        It is built once for an offset, and shared with whoever is `moved`. Only of a cloud with normals.
        """
        if offset not in self._lowered:
            normals = self._normals
            if normals is None:
                raise BadInput("cloud", at="normals", found="none", expected="a cloud with normals")
            points = np.ascontiguousarray(self._base - offset * normals)
            grid = build_grid(points, float(self._grid.frame[EDGE]))
            self._lowered[offset] = grid, np.ascontiguousarray(normals[grid_order(points, grid)].T)
        return self._lowered[offset]

    @property
    def translation(self) -> Array:
        """(3,) how far the base points have moved [m], read-only."""
        return self._header[:3]

    @property
    def stamp(self) -> float:
        """Time at which the surface was here [s]."""
        return self._stamp

    @property
    def spacing(self) -> float:
        """1/√(points per area) where the cloud is as dense as at half its points [m]; 0 for fewer than two points."""
        return float(self._header[SPACING])

    @property
    def kernel_arrays(self) -> tuple[Array, NDArray[np.int32], Array, Array]:
        """The grid's points, starts and frame, and (5,) translation, serial number of the base points, spacing."""
        return *self._grid, self._header

    def points(self) -> Array:
        """(n, 3) the points where they are now [m], table frame; a new array."""
        return self._base + self._header[:3]

    def __len__(self) -> int:
        return len(self._base)

    def __repr__(self) -> str:
        x, y, z = self.translation
        return f"<Cloud of {len(self)} points at ({x:g}, {y:g}, {z:g}) m, {self.stamp:g} s>"

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        # Drake copies the values in its contexts; what never changes need not be copied.
        return self

    def to_open3d(self) -> Any:
        """An `open3d.geometry.PointCloud` of the points where they are now."""
        import open3d

        return open3d.geometry.PointCloud(open3d.utility.Vector3dVector(self.points()))


def _checked_normals(normals: ArrayLike, n: int) -> Array:
    given = np.array(normals, dtype=np.float64)
    if given.shape != (n, 3):
        raise BadInput("cloud", at="normals", found=f"shape {given.shape}", expected=f"shape ({n}, 3)")
    length = np.linalg.norm(given, axis=1)
    if not np.all(np.abs(length - 1.0) < 1e-3):
        bad = int(np.flatnonzero(~(np.abs(length - 1.0) < 1e-3))[0])
        raise BadInput("cloud", at=f"normal {bad}", found=given[bad], expected="a unit vector")
    if n and np.mean(given[:, 2] < 0.0) > 0.9:
        raise BadInput("cloud", at="normals", found="normals that point down", expected="outward ones, up")
    given.flags.writeable = False
    return given


def _checked_colours(colours: ArrayLike, n: int) -> Array:
    given = np.array(colours, dtype=np.float64)
    if given.shape != (n, 3):
        raise BadInput("cloud", at="colours", found=f"shape {given.shape}", expected=f"shape ({n}, 3)")
    wrong = ((given < 0.0) | (given > 1.0)).any(axis=1)
    if wrong.any():
        bad = int(np.flatnonzero(wrong)[0])
        raise BadInput("cloud", at=f"colour {bad}", found=given[bad], expected="sRGB from 0 to 1")
    given.flags.writeable = False
    return given


def _restored(
    kind: type[Cloud],
    told: tuple[Array, Array | None, Array | None],
    translation: list[float],
    spacing: list[float],
    stamp: float,
) -> Cloud:
    cloud = object.__new__(kind)
    for kept in told:
        if kept is not None:
            kept.flags.writeable = False
    base, cloud._normals, cloud._colours = told
    cloud._lowered = {}
    cloud._fill(base, None, (*translation, float(next(_serial_numbers)), *spacing), stamp)
    return cloud


def _vector(translation: ArrayLike) -> tuple[float, float, float]:
    vector = np.asarray(translation, dtype=np.float64)
    if vector.shape != (3,) or not np.isfinite(vector).all():
        raise BadInput("cloud", at="translation", found=translation, expected="three finite numbers [m]")
    return float(vector[0]), float(vector[1]), float(vector[2])


def _spacing(points: Array, grid: Grid) -> float:
    """1/√density, from the median number of neighbours in a ball, at points taken evenly from the list."""
    n = len(points)
    if n < 2:
        return 0.0
    extent = np.sort(np.ptp(grid.points, axis=1))
    # Guess the area as if the cloud were a rectangle, or a line if it has no second extent, to size the ball.
    guess = max(math.sqrt(extent[2]) * math.sqrt(extent[1] / n), extent[2] / n)
    if guess == 0.0:
        return 0.0
    radius = guess * math.sqrt(_SPACING_NEIGHBOURS / math.pi)
    sample = points[:: max(1, n // _SPACING_SAMPLES)].copy()  # contiguous and writable whatever n: one kernel for all
    counts = _counts_around(grid, sample, radius)
    return radius * math.sqrt(math.pi / max(float(np.median(counts)), 1.0))


@njit(cache=True)
def _counts_around(grid: Grid, sample: Array, radius: float) -> Array:
    counts = np.empty(len(sample))
    for k in range(len(sample)):
        at = (sample[k, 0], sample[k, 1], sample[k, 2])
        counts[k] = count_within(grid, at, radius, grid.points.shape[1] + 1)
    return counts
