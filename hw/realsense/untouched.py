"""The untouched object as a camera shows it, from a few of its frames."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mmt_drake.cloud import Cloud
from mmt_drake.errors import BadInput
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.offset import measured_offset
from mmt_drake.hw.realsense.temporal import TemporalFilter
from mmt_drake.hw.realsense.view import TableScene

Array = NDArray[np.float64]

_FRAMES = 8
_FIRST_FRAME = 500_000  # a number that no run reaches: the noise of these frames is their own
_MARGIN = 0.01  # of the object's rim, where a surface is hard to tell from its edge [m]
_FEWEST = 10


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


def untouched(
    convert: DepthToCloud,
    noise: DepthNoise,
    depth: NDArray[np.float32],
    scene: TableScene,
    r2: float,
    smooth: TemporalFilter | None = None,
) -> Untouched:
    """Look at the object with a simulated camera, before a run.

    Args:
        convert: the camera, where it is taken to be, and the filters.
        noise: its errors.
        depth: (height, width) what a perfect one sees of the untouched object [m].
        scene: where the object is.
        r2: contact radius of the detector [m].
        smooth: over frames; by default each stands alone.

    Raises:
        BadInput: it does not see the object's top.
    """
    middle, rim = np.array(scene.at), 0.5 * np.array(scene.size[:2]) - _MARGIN
    tops, smoothed = list[Array](), None
    settling = 0 if smooth is None else math.ceil(3.0 / smooth.alpha)
    for k in range(-settling, _FRAMES):
        told = noise.apply(depth, convert.intrinsics, _FIRST_FRAME + k)
        if smooth is not None:
            smoothed = smooth(smoothed, told, noise.unit)
        if k < 0:
            continue
        points = (convert(told, noise.unit) if smoothed is None else convert(smoothed, 1.0)).cloud.points()
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
