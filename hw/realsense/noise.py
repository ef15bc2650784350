"""The errors of a depth camera, put on a rendered depth image.

Axial and lateral noise after Nguyen, Izadi and Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
tracking", 3DIMPVT 2012, pp. 524-530 (doi:10.1109/3DIMPVT.2012.84). A stereo camera's axial noise is the noise of its
disparity d = f B / z, which is about the same at every distance, so sigma_z = z² sigma_d / (f B): eq. 1 and 2 of
Keselman, Woodfill, Grunnet-Jepsen and Bhowmik, "Intel RealSense stereoscopic depth cameras", CVPR workshops 2017
(arXiv:1705.05548), and the maker's own "depth RMS error = distance² subpixel / (focal length baseline)" in
Grunnet-Jepsen, Sweetser and Woodfill, "Best-known-methods for tuning Intel RealSense D400 depth cameras for best
performance" (Intel, revision 2.0). What these leave out and users of such cameras know: neighbouring pixels share a
matching window, so their errors are correlated and a voxel filter does not average them away; pixels at the edge of an
object fly between the two surfaces; the strip that only one of the two imagers sees has no depth; and blobs of pixels
fail where there is no texture.
"""

import math
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import DepthImage, Image, Intrinsics
from mmt_drake.quantities import Checked, Quantity

_JUMP = 0.01  # second difference of the depths of neighbours from which on they are two surfaces [m]
_STEEPEST = math.radians(85.0)  # beyond, both formulas of the paper grow without bound


_Length = Annotated[float, Quantity("m")]
_Pixels = Annotated[float, Quantity("px")]


@dataclass(frozen=True)
class DepthNoise(Checked):
    """Standard deviations and shares; all zero is a perfect camera but for its unit of depth.

    With z the depth [m] and theta the angle between ray and surface normal, the axial standard deviation is
    `axial` + `axial_z2` (z - `axial_from`)² + `grazing` theta² / (√z (pi/2 - theta)²), the last term from 60 deg on,
    and the lateral one is `lateral` + `lateral_angle` theta / (pi/2 - theta) pixels.

    Attributes:
        axial: [m].
        axial_z2: [1/m].
        axial_from: [m].
        grazing: [m^1.5].
        lateral: [px].
        lateral_angle: [px].
        correlation: standard deviation of the Gaussian window that neighbouring pixels share [px]; 0 is white noise.
        flying: share of the pixels at a jump of depth that take a value between the two surfaces.
        holes: share of all pixels that have no depth,
        hole_size: in blobs of about this size [px].
        baseline: between the two imagers [m]; what the second does not see has no depth. 0: one imager.
        unit: of the depth [m].
        seed: of everything random; each number of a frame gives another image.

    Raises:
        BadInput: a number out of its range.
    """

    axial: _Length = 0.0
    axial_z2: Annotated[float, Quantity("1/m")] = 0.0
    axial_from: _Length = 0.0
    grazing: Annotated[float, Quantity("m^1.5")] = 0.0
    lateral: _Pixels = 0.0
    lateral_angle: _Pixels = 0.0
    correlation: _Pixels = 0.0
    flying: float = 0.0
    holes: float = 0.0
    hole_size: Annotated[float, Quantity("px", positive=True)] = 3.0
    baseline: _Length = 0.0
    unit: Annotated[float, Quantity("m", positive=True)] = 1e-4
    seed: Annotated[int, Quantity("", whole=True)] = 0

    CALLED: ClassVar = "depth noise"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("flying", "holes"):
            if not 0.0 <= getattr(self, name) < 1.0:
                raise BadInput("depth noise", at=name, found=getattr(self, name), expected="a share, 0 to below 1")

    @classmethod
    def stereo(cls, focal: float, baseline: float = 0.055, subpixel: float = 0.08, **changes: Any) -> Self:
        """An active stereo camera such as a RealSense D415.

        0.08 px is the maker's figure: of that noise's curves in the tuning guide above (a D435: 848 px over 90 deg,
        50 mm), and what its engineer says to count with for a calibrated camera, 0.032 px being the best case
        (librealsense, issue 3904). The guide, read in quotations only, expects below 0.1 px on a well-textured target,
        down to 0.05, and a calibration from 0.2 on. A D435 that was measured with Nguyen's method bears it out: sigma_z
        = 0.000611 + 0.003587 (z - 0.3515)² m (L. Kotsonis, bachelor thesis, ETH Zurich 2018; `realsense_d435.yaml` of
        ANYbotics elevation_mapping, pull request 75), which is 0.04 to 0.08 px from 0.4 to 3 m. The baselines, 55 mm of
        a D415, are as others quote the data sheet.

        Lateral noise, correlation, flying pixels and holes are assumptions, set so that a good scene looks like one.
        The lateral noise of that D435 was measured as 0.01576 z, 7 of its pixels: by so much the edge of an object is
        wrong. Here `flying` and the hidden strip stand for that; as a shuffle of the pixels of a smooth surface it
        would add to an axial noise that was measured with it.

        Args:
            focal: length [px].
            baseline: between the two imagers [m].
            subpixel: standard deviation of the disparity [px].
            changes: any attribute.
        """
        usual = cls(
            axial_z2=subpixel / (focal * baseline),
            lateral=0.5,
            lateral_angle=0.035,
            correlation=1.5,
            flying=0.5,
            holes=0.02,
            baseline=baseline,
        )
        return replace(usual, **changes)

    def scaled(self, factor: float) -> Self:
        """The same camera with so many times the axial and lateral noise; flying pixels and holes stay."""
        names = ("axial", "axial_z2", "grazing", "lateral", "lateral_angle")
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    def apply(self, depth: Image, intrinsics: Intrinsics, frame: int) -> DepthImage:
        """What the camera tells where a perfect one sees `depth`.

        Args:
            depth: (height, width) [m]; 0 or not finite where nothing is seen.
            intrinsics: of the image.
            frame: number of the image; the same number gives the same errors.

        Returns:
            (height, width) depth in units, 0 where there is none.
        """
        random = np.random.default_rng((self.seed, frame))
        shape = depth.shape
        axial = _window(random.standard_normal(shape, np.float32), self.correlation)
        shift = random.standard_normal((2, *shape), np.float32)
        chance = random.random((2, *shape), np.float32)
        lost = np.zeros(shape, np.bool_)
        if self.holes > 0.0:
            blobs = _window(random.standard_normal(shape, np.float32), self.hole_size / 2.0)
            lost = blobs > NormalDist().inv_cdf(1.0 - self.holes)
        i = intrinsics
        camera = np.array([i.fx, i.fy, i.cx, i.cy, self.baseline, self.flying, self.unit])
        sigma = np.array([self.axial, self.axial_z2, self.axial_from, self.grazing, self.lateral, self.lateral_angle])
        clean = np.where(np.isfinite(depth), depth, np.float32(0.0))
        return _measured(clean, camera, sigma, axial, shift, chance, lost)


def _window(white: Image, width: float) -> Image:
    """White noise through a Gaussian window [px], again with standard deviation 1."""
    if width <= 0.0:
        return white
    from scipy.ndimage import gaussian_filter, gaussian_filter1d

    size = 2 * math.ceil(4.0 * width) + 1
    line = gaussian_filter1d(np.eye(1, size, size // 2)[0], width, mode="constant")
    smooth: Image = gaussian_filter(white, width, mode="wrap") / np.float32((line**2).sum())
    return smooth


@njit(cache=True, nogil=True, error_model="numpy")
def _measured(
    clean: Image,
    camera: NDArray[np.float64],
    sigma: NDArray[np.float64],
    axial: Image,
    shift: Image,
    chance: Image,
    lost: NDArray[np.bool_],
) -> DepthImage:
    height, width = clean.shape
    fx, baseline, flying, unit = camera[0], camera[4], camera[5], camera[6]
    depth = np.zeros((height, width), np.uint16)
    for v in range(height):
        leftmost = math.inf  # of all pixels further right, where the second imager sees them
        for u in range(width - 1, -1, -1):
            z = clean[v, u]
            if z <= 0.0:
                continue
            hidden = False
            if baseline > 0.0:
                there = u - fx * baseline / z
                hidden = there > leftmost
                leftmost = min(leftmost, there)
            if hidden or lost[v, u]:
                continue
            at_edge = _at_edge(clean, v, u)
            # Across an edge the difference of two pixels is no slope.
            angle = 0.0 if at_edge else _angle(clean, camera, v, u)
            ratio = angle / (0.5 * math.pi - angle)
            spread = sigma[4] + sigma[5] * ratio
            y = min(max(math.floor(v + spread * shift[0, v, u] + 0.5), 0), height - 1)
            x = min(max(math.floor(u + spread * shift[1, v, u] + 0.5), 0), width - 1)
            z = clean[y, x]
            if z <= 0.0:
                continue
            if at_edge and chance[0, v, u] < flying:
                low, high = _range_around(clean, v, u)
                z = low + chance[1, v, u] * (high - low)
            away = z - sigma[2]
            deviation = sigma[0] + sigma[1] * away * away
            if angle > math.pi / 3.0:
                deviation += sigma[3] * ratio * ratio / math.sqrt(z)
            steps = int(np.rint((z + deviation * axial[v, u]) / unit))
            if 0 < steps < 65536:
                depth[v, u] = steps
    return depth


@njit(cache=True, nogil=True, error_model="numpy")
def _at_edge(clean: Image, v: int, u: int) -> bool:
    """Whether the depth bends by more than `_JUMP` here, along a row or a column; a slope, however steep, does not."""
    height, width = clean.shape
    twice = 2.0 * clean[v, u]
    bend = 0.0
    if 0 < u < width - 1 and min(clean[v, u - 1], clean[v, u + 1]) > 0.0:
        bend = abs(clean[v, u - 1] + clean[v, u + 1] - twice)
    if 0 < v < height - 1 and min(clean[v - 1, u], clean[v + 1, u]) > 0.0:
        bend = max(bend, abs(clean[v - 1, u] + clean[v + 1, u] - twice))
    return bend > _JUMP


@njit(cache=True, nogil=True, error_model="numpy")
def _angle(clean: Image, camera: NDArray[np.float64], v: int, u: int) -> float:
    """Between the ray and the surface's normal [rad], from the differences to the pixels before and after."""
    height, width = clean.shape
    u0, u1, v0, v1 = max(u - 1, 0), min(u + 1, width - 1), max(v - 1, 0), min(v + 1, height - 1)
    z = clean[v, u]
    left, right, above, below = clean[v, u0], clean[v, u1], clean[v0, u], clean[v1, u]
    if min(left, right, above, below) <= 0.0:
        return 0.0
    rx, ry = (u - camera[2]) / camera[0], (v - camera[3]) / camera[1]
    slope_x = (right - left) / (u1 - u0) * camera[0] / z
    slope_y = (below - above) / (v1 - v0) * camera[1] / z
    # The plane's normal (a, b, c) has depth 1/z = a' rx + b' ry + c', so slope_x = -a/n.ray and so on.
    a, b = -slope_x, -slope_y
    c = 1.0 - a * rx - b * ry
    ray = math.sqrt(rx * rx + ry * ry + 1.0)
    return min(math.acos(min(1.0, 1.0 / (ray * math.sqrt(a * a + b * b + c * c)))), _STEEPEST)


@njit(cache=True, nogil=True, error_model="numpy")
def _range_around(clean: Image, v: int, u: int) -> tuple[float, float]:
    """Least and greatest depth of the pixel and its eight neighbours [m]."""
    low, high = clean[v, u], clean[v, u]
    for y in range(max(v - 1, 0), min(v + 2, clean.shape[0])):
        for x in range(max(u - 1, 0), min(u + 2, clean.shape[1])):
            if clean[y, x] > 0.0:
                low, high = min(low, clean[y, x]), max(high, clean[y, x])
    return low, high
