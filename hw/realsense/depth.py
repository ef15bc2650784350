"""From a depth image to the cloud of a surface, in the table frame.

Compiled, without Python's lock: in a camera's thread it does not hold up the tick of the diagram.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Length, Quantity

if TYPE_CHECKING:
    from mmt_drake.hw.realsense.colour import ColourImage

DepthImage = NDArray[np.uint16]
Image = NDArray[np.float32]


_PIXELS, _FOCAL, _CENTRE = Quantity("px", 3, whole=True), Quantity("px", positive=True), Quantity("px", -math.inf)


@dataclass(frozen=True)
class Intrinsics(Checked):
    """A pinhole camera without distortion; depth images of stereo cameras are rectified.

    Attributes:
        width: of the image [px].
        height: of the image [px].
        fx: focal length along x [px].
        fy: focal length along y [px].
        cx: principal point, x [px], counted from the middle of the first pixel.
        cy: principal point, y [px].

    Raises:
        BadInput: no such camera.
    """

    width: Annotated[int, _PIXELS]
    height: Annotated[int, _PIXELS]
    fx: Annotated[float, _FOCAL]
    fy: Annotated[float, _FOCAL]
    cx: Annotated[float, _CENTRE]
    cy: Annotated[float, _CENTRE]

    CALLED: ClassVar = "intrinsics"

    @classmethod
    def of_profile(cls, intrinsics: Any, *, distorted: bool = False) -> Intrinsics:
        """From a `pyrealsense2.intrinsics`.

        Args:
            intrinsics: they.
            distorted: take one with distortion for one without, where a few pixels do not count.

        Raises:
            BadInput: it has distortion, which a depth image should not have.
        """
        if not distorted and any(abs(c) > 1e-9 for c in intrinsics.coeffs):
            raise BadInput("intrinsics", at="coeffs", found=intrinsics.coeffs, expected="a rectified depth image")
        return cls(intrinsics.width, intrinsics.height, intrinsics.fx, intrinsics.fy, intrinsics.ppx, intrinsics.ppy)

    def rays(self) -> Array:
        """(height, width, 3) the points of the optical frame at depth 1."""
        v, u = np.mgrid[: self.height, : self.width].astype(np.float64)
        return np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones_like(u)], axis=-1)

    def pixels(self, points: Array) -> Array:
        """(n, 2) u, v [px] at which points (n, 3) of the optical frame are seen, all ahead of the camera."""
        across = points[:, :2] / points[:, 2:]
        return np.asarray(across * (self.fx, self.fy) + (self.cx, self.cy))

    def points(self, depth: DepthImage, unit: float) -> Array:
        """(n, 3) points [m], optical frame, of the pixels that have a depth."""
        z = depth.astype(np.float64)[..., None] * unit
        return (self.rays() * z)[depth > 0]


@dataclass(frozen=True)
class TemporalFilter(Checked):
    """A first-order low-pass in every pixel, as depth cameras offer it, here with its memory outside.

    White noise comes out √(`alpha`/(2 - `alpha`)) times as large; a surface that rises is seen (1 - alpha)/alpha frames
    late. A surface that slides along itself looks the same all the time, and is not late.

    Attributes:
        alpha: weight of the new frame, above 0, 1 at most.
        step: a pixel that changes by more than this starts anew [m].

    Raises:
        BadInput: a number out of its range.
    """

    alpha: Annotated[float, Quantity("", 0.0, 1.0, positive=True)] = 0.2
    step: Length = 0.01

    CALLED: ClassVar = "temporal filter"

    def __call__(self, before: Image | None, depth: DepthImage, unit: float) -> Image:
        """The next image of the filter; nothing is changed in place.

        Args:
            before: (height, width) its last image [m], 0 without depth; None for the first frame, or another size.
            depth: (height, width) the new frame, in units.
            unit: of it [m].

        Returns:
            (height, width) [m]; a pixel without depth now has none, whatever it had before.
        """
        if before is None or before.shape != depth.shape:
            before = np.zeros(depth.shape, np.float32)
        return _filtered(before, np.ascontiguousarray(depth), unit, self.alpha, self.step)


class Converted(NamedTuple):
    """What became of a depth image.

    Attributes:
        cloud: of the surface.
        lost: share of the image's pixels (0 to 1) that had no depth.
        image: (height, width) of the temporal filter [m], for the next one; None without one.
    """

    cloud: Cloud
    lost: float
    image: Image | None


class DepthToCloud:
    """Deprojects, crops and filters the depth images of one camera; see `CloudSettings` for the filters.

    Args:
        intrinsics: of the depth images.
        extrinsics: where the camera is.
        settings: what is kept.
        smooth: over frames; by default each stands alone.
    """

    def __init__(
        self,
        intrinsics: Intrinsics,
        extrinsics: Extrinsics,
        settings: CloudSettings | None = None,
        smooth: TemporalFilter | None = None,
    ) -> None:
        self.intrinsics, self.settings, self.smooth = intrinsics, settings or CloudSettings(), smooth
        self._rotation = extrinsics.rotation()
        self._rays = np.ascontiguousarray(intrinsics.rays() @ self._rotation.T)
        self._origin = np.array(extrinsics.position)
        s = self.settings
        self._box = np.array([*s.low, *s.high])
        self._limits = np.array([s.near, s.far, math.inf if s.edge is None else s.edge])
        shape = intrinsics.height, intrinsics.width  # compiles before the clock starts
        self(np.zeros(shape, np.uint16), 0.001)

    def __call__(
        self,
        depth: DepthImage,
        unit: float,
        stamp: float = 0.0,
        before: Image | None = None,
        colour: ColourImage | None = None,
    ) -> Converted:
        """The cloud of a depth image.

        Args:
            depth: (height, width) along the optical axis, in units; 0 is no depth.
            unit: of depth [m].
            stamp: when it was taken [s].
            before: `Converted.image` of the frame before, if frames are smoothed.
            colour: taken beside it; the cloud then has colours.

        Raises:
            BadInput: another size or kind of image.
        """
        shape = self._rays.shape[:2]
        if depth.shape != shape or depth.dtype != np.uint16:
            raise BadInput("depth image", found=f"{depth.shape} of {depth.dtype}", expected=f"{shape} of uint16")
        depth = np.ascontiguousarray(depth)
        if self.smooth is None:
            image = None
            points, lost = _deproject(depth, unit, self._rays, self._origin, self._box, self._limits)
        else:
            image = self.smooth(before, depth, unit)
            points, lost = _deproject(image, 1.0, self._rays, self._origin, self._box, self._limits)
        if self.settings.voxel is not None:
            first, cells = (np.array(numbers) for numbers in self.settings.cells())
            points = _voxel_means(points, first, cells, self.settings.voxel, self.settings.support)
        colours = None if colour is None else colour.at((points - self._origin) @ self._rotation)
        return Converted(Cloud(points, stamp=stamp, colours=colours), lost / depth.size, image)


@njit(cache=True, nogil=True)
def _deproject(
    depth: DepthImage | Image, unit: float, rays: Array, origin: Array, box: Array, limits: Array
) -> tuple[Array, int]:
    """(n, 3) points of the table frame in the box, and how many pixels had no depth."""
    height, width = depth.shape
    points = np.empty((height * width, 3))
    kept = lost = 0
    near, far, edge = limits
    for v in range(height):
        for u in range(width):
            if depth[v, u] == 0:
                lost += 1
                continue
            z = depth[v, u] * unit
            if z < near or z > far:
                continue
            if edge < math.inf and _at_edge(depth, v, u, edge / unit):
                continue
            inside = True
            for axis in range(3):
                value = origin[axis] + z * rays[v, u, axis]
                points[kept, axis] = value
                inside = inside and box[axis] <= value < box[3 + axis]
            kept += inside
    return points[:kept].copy(), lost


@njit(cache=True, nogil=True)
def _at_edge(depth: DepthImage | Image, v: int, u: int, edge: float) -> bool:
    """Whether a pixel differs from one of its neighbours, of those that have a depth, by more than `edge` [units]."""
    here = float(depth[v, u])
    for dv, du in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        y, x = v + dv, u + du
        if 0 <= y < depth.shape[0] and 0 <= x < depth.shape[1]:
            there = float(depth[y, x])
            if there > 0.0 and abs(there - here) > edge:
                return True
    return False


@njit(cache=True, nogil=True)
def _voxel_means(
    points: Array, first: NDArray[np.int64], cells: NDArray[np.int64], voxel: float, support: int
) -> Array:
    """(m, 3) mean of the points in each cube that holds `support` of them, in the order of the cubes."""
    counts = np.zeros(cells[0] * cells[1] * cells[2], np.int32)
    index = np.empty(len(points), np.int64)
    for i in range(len(points)):
        at = 0
        for axis in range(3):
            k = math.floor(points[i, axis] / voxel + 0.5) - first[axis]
            at = at * cells[axis] + k
        index[i] = at
        counts[at] += 1
    row = np.full(len(counts), -1, np.int32)
    rows = 0
    for at in range(len(counts)):
        if counts[at] >= support:
            row[at] = rows
            rows += 1
    means = np.zeros((rows, 3))
    for i in range(len(points)):
        r = row[index[i]]
        if r >= 0:
            for axis in range(3):
                means[r, axis] += points[i, axis] / counts[index[i]]
    return means


@njit(cache=True, nogil=True)
def _filtered(before: Image, depth: DepthImage, unit: float, alpha: float, step: float) -> Image:
    out = np.zeros(depth.shape, np.float32)
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            if depth[v, u] == 0:
                continue
            new, old = depth[v, u] * unit, before[v, u]
            known = old > 0.0 and abs(new - old) <= step
            out[v, u] = old + alpha * (new - old) if known else new
    return out
