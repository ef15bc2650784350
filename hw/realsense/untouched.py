"""The untouched object as a camera shows it, from a few of its frames."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.view import Solid
from mmt_drake.numeric.arrays import Array

_FRAMES = 8
_FIRST_FRAME = 500_000  # a number that no run reaches: the noise of these frames is their own
_MARGIN = 0.01  # of the object's rim, where a surface is hard to tell from its edge [m]
_FEWEST = 10
_POSITIONS, _LEAST_POSITIONS = 2000, 100  # at which a sphere comes down, and meets a point


class Untouched(NamedTuple):
    """The object's top as one camera shows it.

    Attributes:
        points: how many the cloud of one frame has.
        spacing: between them [m].
        height: of the measured above the true top, mean [m]: the calibration's error.
        roughness: standard deviation of the points' heights [m].
        offset: how much lower a detector is to take the cloud (`measured_offset`) [m].
    """

    points: int
    spacing: float
    height: float
    roughness: float
    offset: float


def untouched(convert: DepthToCloud, noise: DepthNoise, depth: NDArray[np.float32], box: Solid, r2: float) -> Untouched:
    """Look at the object with a simulated camera, before a run.

    Args:
        convert: the camera, where it is taken to be, and the filters.
        noise: its errors.
        depth: (height, width) what a perfect one sees of the untouched object [m].
        box: the object.
        r2: contact radius of the detector [m].

    Raises:
        BadInput: it does not see the object's top.
    """
    middle, rim = np.array(box.at), 0.5 * np.array(box.size[:2]) - _MARGIN
    tops, image = list[Array](), None
    settling = 0 if convert.smooth is None else math.ceil(3.0 / convert.smooth.alpha)
    for k in range(-settling, _FRAMES):
        seen = noise.apply(depth, convert.intrinsics, _FIRST_FRAME + k)
        cloud, _, image = convert(seen, noise.unit, before=image)
        if k >= 0:
            points = cloud.points()
            tops.append(points[(np.abs(points[:, :2] - middle) < rim).all(axis=1)])
    top = tops[0]
    if len(top) < _FEWEST:
        raise BadInput("camera", found=f"{len(top)} points of the object's top", expected=f"{_FEWEST} or more")
    low, high = (middle - rim + r2).tolist(), (middle + rim - r2).tolist()
    offsets = [measured_offset(each, r2, tuple(low), tuple(high), seed=k) for k, each in enumerate(tops)]
    return Untouched(
        points=len(top),
        spacing=Cloud(top).spacing,
        height=float(top[:, 2].mean()),
        roughness=float(top[:, 2].std()),
        offset=float(np.mean(offsets)),
    )


def measured_offset(
    points: ArrayLike, r2: float, low: tuple[float, float], high: tuple[float, float], *, seed: int = 0
) -> float:
    """Mean height above z = 0 at which a sphere that comes down meets the first point of an untouched surface [m].

    What `ProxySettings.surface_offset` should be for this camera: sampling, noise, its correlation, the voxel filter
    and what is left of the calibration's error are all in it. `mmt_drake.cloud.contact_offset` is the closed form for
    points strewn at random with independent noise, and a voxel filter leaves neither. A sphere of radius r2 whose
    centre is at a horizontal distance rho from a point of height z touches it at z + √(r2² - rho²); the highest counts.

    Args:
        points: (n, 3) of the object's flat top, untouched, from one or, better, several frames one by one: average.
        r2: contact radius of the detector [m].
        low: least x, y where the sphere comes down [m]; r2 or more from the object's rim.
        high: greatest x, y.
        seed: of the positions.

    Raises:
        BadInput: no surface there.
    """
    from scipy.spatial import cKDTree

    check_number("measured offset", "r2", r2, least=0.0, open_interval=True)
    cloud: Array = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    positions = np.random.default_rng(seed).uniform(low, high, (_POSITIONS, 2))
    heights = []
    for position, near in zip(positions, cKDTree(cloud[:, :2]).query_ball_point(positions, r2), strict=True):
        if near:
            apart = ((cloud[near, :2] - position) ** 2).sum(axis=1)
            heights.append(float((cloud[near, 2] + np.sqrt(np.maximum(r2 * r2 - apart, 0.0))).max()))
    if len(heights) < _LEAST_POSITIONS:
        found = f"points below {len(heights)} of {_POSITIONS} places"
        raise BadInput("measured offset", found=found, expected="an untouched surface")
    return float(np.mean(heights))
