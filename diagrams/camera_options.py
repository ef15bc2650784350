"""Depth cameras as a scenario names them: simulated, and real."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from mmt_drake.ceilings import Bound, refuse_beyond
from mmt_drake.errors import BadInput, check_number
from mmt_drake.hw.realsense.noise import DepthNoise
from mmt_drake.hw.realsense.settings import CloudSettings
from mmt_drake.hw.realsense.temporal import TemporalFilter
from mmt_drake.hw.realsense.view import TableScene, View
from mmt_drake.hw.safety.limits import OURS

_RATES = (1e-3, 1e3)  # [Hz]


@dataclass(frozen=True)
class SimulatedDepthCamera:
    """The object's top as a simulated depth camera sees it: rendered, with a camera's errors.

    The object is a box about the middle of what a recorded hand covers, else about the origin. It moves with the body;
    beyond its rim, and where no camera looks, there is no surface. Where the detector's `surface_offset` is not said,
    it is measured on the untouched object.

    Attributes:
        size: of the box along x, y, z [m].
        view: the camera, and where it stands.
        noise: axial and lateral noise, in parts of what the errors say.
        errors: noise, holes, flying pixels; null: those of a stereo camera (`DepthNoise.stereo`).
        settings: what of a depth image becomes the cloud.
        smooth: over frames; null: each stands alone.
        rate: frames per second [Hz].
        latency: from the moment a frame shows to its cloud [s], less than the time between frames.
    """

    size: tuple[float, float, float] = (0.2, 0.2, 0.08)
    view: View = field(default_factory=View)
    noise: float = 1.0
    errors: DepthNoise | None = None
    settings: CloudSettings = field(default_factory=CloudSettings)
    smooth: TemporalFilter | None = None
    rate: float = 30.0
    latency: float = 0.03

    def __post_init__(self) -> None:
        TableScene(self.size)  # refuses a box without meaning
        check_number("cloud", "noise", self.noise, least=0.0)
        _check_rate(self.rate)
        if not 0.0 <= self.latency < 1.0 / self.rate:
            raise BadInput("cloud", at="latency", found=self.latency, expected=f"0 to below {1.0 / self.rate:g} s")

    def camera_errors(self) -> DepthNoise:
        """The camera's errors."""
        return (self.errors or DepthNoise.stereo(self.view.focal)).scaled(self.noise)


@dataclass(frozen=True)
class DepthCamera:
    """The surface as a RealSense camera sees it, in a run with hardware.

    How much lower the detector is to take the cloud, `surface_offset`, is said by
    `python -m mmt_drake.hw.realsense cloud`.

    Attributes:
        extrinsics: YAML file with the camera's place, from `python -m mmt_drake.hw.realsense calibrate`.
        serial: number of the camera; null takes the first one.
        recording: `.db3` file that is played over and over in place of a camera.
        width: of the camera's images [px].
        height: of the camera's images [px].
        rate: images per second [Hz].
        stale: age from which on a frame no longer counts [s].
        settings: what of a depth image becomes the cloud.
        smooth: over frames; null: each stands alone.
    """

    extrinsics: str | None = None
    serial: str | None = None
    recording: str | None = None
    width: int = 640
    height: int = 480
    rate: int = 30
    stale: Annotated[float, Bound(1.0, "s", OURS)] = 0.25
    settings: CloudSettings = field(default_factory=CloudSettings)
    smooth: TemporalFilter | None = None

    def __post_init__(self) -> None:
        if self.extrinsics is None:
            expected = "the file that `python -m mmt_drake.hw.realsense calibrate` wrote"
            raise BadInput("cloud", at="extrinsics", found="nothing", expected=expected)
        if self.serial is not None and self.recording is not None:
            raise BadInput("cloud", at="recording", found=self.recording, expected="nothing beside a serial number")
        _check_rate(self.rate)
        check_number("cloud", "stale", self.stale, least=0.0, open_interval=True)
        refuse_beyond(self, "cloud")


def _check_rate(rate: float) -> None:
    if not _RATES[0] <= rate <= _RATES[1]:
        raise BadInput("cloud", at="rate", found=rate, expected=f"{_RATES[0]:g} to {_RATES[1]:g} Hz")
