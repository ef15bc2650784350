"""The far side of an emulated depth camera: librealsense's software device, and what may become of its frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import DepthImage, Intrinsics
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.sdk import load_sdk
from mmt_drake.hw.realsense.stream import DepthFrame, DepthStream, open_sensor

UNIT = 1e-4  # of depth [m]
RATE = 30  # frames per second that it claims [Hz]


@dataclass
class SoftwareCamera:
    """librealsense's software device with one depth stream, and perhaps one of colour.

    Attributes:
        sdk: the module `pyrealsense2`.
        device, sensor, profile: of the software device.
        colour: sensor and profile of colour; None: it has none.
        unit: of depth [m].
        number: of the latest frame; a frame's time follows from its number.
        shown: frames that came in.
    """

    sdk: ModuleType
    device: Any
    sensor: Any
    profile: Any
    colour: tuple[Any, Any] | None = None
    unit: float = UNIT
    number: int = 0
    shown: int = 0

    def show(self, depth: DepthImage) -> None:
        """Have a frame come in, of (height, width) in units."""
        self.number += 1
        self.show_again(depth, self.number)

    def show_again(self, depth: DepthImage, number: int) -> None:
        """Have a frame come in with a number, and the time that belongs to it, which may have been before."""
        self.shown += 1
        self.sensor.on_video_frame(self._frame(self.profile, depth, number, 2))

    def show_colour(self, pixels: NDArray[np.uint8]) -> None:
        """Have a picture (height, width, 3) come in; only of one that sees colour."""
        if self.colour is None:
            raise DeviceError("realsense: an emulated camera without colour")
        sensor, profile = self.colour
        sensor.on_video_frame(self._frame(profile, pixels, self.number, 3))

    def _frame(self, profile: Any, pixels: NDArray[Any], number: int, bytes_each: int) -> Any:
        frame = self.sdk.software_video_frame()
        frame.stride, frame.bpp = pixels.shape[1] * bytes_each, bytes_each
        frame.timestamp = 1000.0 + (number - 1) * 1e3 / RATE
        frame.domain = self.sdk.timestamp_domain.hardware_clock
        frame.frame_number, frame.depth_units = number, self.unit
        frame.profile, frame.pixels = profile.as_video_stream_profile(), np.ascontiguousarray(pixels)
        return frame


def software_camera(seen: Intrinsics, coloured: ColourImage | None = None) -> SoftwareCamera:
    """One that sees as these intrinsics say.

    Args:
        seen: of its images.
        coloured: a picture of a sensor of colour beside it, which stands there; by default there is none.

    Raises:
        MissingDependency: pyrealsense2 is not here.
    """
    sdk = load_sdk()
    device = sdk.software_device()
    sensor = device.add_sensor("Depth")
    profile = sensor.add_video_stream(_stream(sdk, seen, 1, sdk.stream.depth, sdk.format.z16, 2))
    sensor.add_read_only_option(sdk.option.depth_units, UNIT)
    if coloured is None:
        return SoftwareCamera(sdk, device, sensor, profile)
    pictures = device.add_sensor("RGB")
    colour = pictures.add_video_stream(_stream(sdk, coloured.intrinsics, 2, sdk.stream.color, sdk.format.rgb8, 3))
    beside = sdk.extrinsics()
    beside.rotation, beside.translation = coloured.rotation.T.ravel().tolist(), coloured.translation.tolist()
    profile.register_extrinsics_to(colour, beside)
    return SoftwareCamera(sdk, device, sensor, profile, (pictures, colour))


def _stream(sdk: ModuleType, seen: Intrinsics, uid: int, kind: Any, form: Any, bytes_each: int) -> Any:
    i = sdk.intrinsics()
    i.width, i.height, i.model = seen.width, seen.height, sdk.distortion.none
    i.fx, i.fy, i.ppx, i.ppy = seen.fx, seen.fy, seen.cx, seen.cy
    i.coeffs = [0.0] * 5
    stream = sdk.video_stream()
    stream.type, stream.index, stream.uid, stream.fmt = kind, 0, uid, form
    stream.width, stream.height, stream.fps, stream.bpp, stream.intrinsics = i.width, i.height, RATE, bytes_each, i
    return stream


def noisy_plane(seen: Intrinsics, where: Extrinsics, rng: np.random.Generator) -> DepthImage:
    """(height, width) depth of the plane z = 0, in units; each pixel is off by one unit at most.

    A camera without noise would show the same image for ever, as no camera does.
    """
    ahead = seen.rays() @ where.rotation().T
    depth: NDArray[np.float64] = -where.position[2] / ahead[..., 2] / UNIT
    return np.round(depth + rng.uniform(-0.5, 0.5, depth.shape)).astype(np.uint16)


class EmulatedUsb:
    """The cable of an emulated camera: what is opened through it fails when it says so.

    Attributes:
        error: raised by every read, as librealsense raises; None: there is none.
        plugged: whether there is a camera at all.
        opened: how often it was.

    Args:
        camera: at its other end.
        clock: of arrivals [s].
    """

    def __init__(self, camera: SoftwareCamera, clock: Callable[[], float]) -> None:
        self._camera, self._clock = camera, clock
        self.error: str | None = None
        self.plugged, self.opened = True, 0

    @property
    def works(self) -> bool:
        """Whether frames can come."""
        return self.plugged and self.error is None

    def open(self) -> _Plugged:
        """Open the camera.

        Raises:
            DeviceError: it is not there.
        """
        if not self.plugged:
            raise DeviceError("realsense: no camera found; plug one in (USB 3)")
        stream = open_sensor(self._camera.sensor, self._camera.device, clock=self._clock)
        self.opened += 1
        return _Plugged(self, stream)


class _Plugged:
    """An opened camera at a cable."""

    def __init__(self, usb: EmulatedUsb, stream: DepthStream) -> None:
        self._usb, self._stream = usb, stream
        self.intrinsics = stream.intrinsics

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        frame = self._stream.read(min(timeout, 0.01))  # an error is seen soon
        error = self._usb.error if self._usb.plugged else "device disconnected"
        if error is not None:
            raise RuntimeError(error)
        return frame

    def close(self) -> None:
        self._stream.close()
