"""Depth frames from a RealSense camera, from a recording of one, or from librealsense's software device."""

import queue
import time
from collections.abc import Callable, Generator
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.errors import BadInput, one_line
from mmt_drake.hw.realsense.depth import DepthImage, Intrinsics
from mmt_drake.hw.realsense.sdk import CameraError, load_sdk

_QUEUED = 4  # frames of a recording read ahead
_END_OF_RECORDING = 2.0  # [s] without a frame


class DepthFrame(NamedTuple):
    """One depth image.

    Attributes:
        depth: (height, width) in units, 0 without depth; its own memory.
        unit: of depth [m].
        number: as the camera counts; gaps are frames lost.
        device_time: of the frame [s], by the camera's or the recording's clock.
        arrival: when it came in [s], by the stream's clock.
    """

    depth: DepthImage
    unit: float
    number: int
    device_time: float
    arrival: float


Frames = Generator[DepthFrame, None, None]


class DepthStream(Closing):
    """The depth frames of one opened sensor, the newest first; a context manager.

    Args:
        sdk: the module `pyrealsense2`.
        sensor: the depth sensor.
        profile: the stream to open.
        keeps: what the sensor belongs to and must live as long.
        clock: that arrivals are told by [s].

    Attributes:
        intrinsics: of the images.

    Raises:
        CameraError: the sensor does not start.
        BadInput: images with distortion.
    """

    def __init__(
        self, sdk: ModuleType, sensor: Any, profile: Any, keeps: Any = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.intrinsics = Intrinsics.of_profile(profile.as_video_stream_profile().get_intrinsics())
        self._sensor, self._keeps, self._clock = sensor, keeps, clock
        self._queue = sdk.frame_queue(1)  # newest wins
        self._open = False
        try:
            sensor.open(profile)
            try:
                sensor.start(self._queue)
            except RuntimeError:
                sensor.close()
                raise
        except RuntimeError as error:
            raise CameraError(f"realsense: the depth stream does not start: {one_line(error)}") from None
        self._open = True

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        """The newest frame not yet read, or None after `timeout` [s] without one.

        Raises:
            CameraError: the stream is closed.
        """
        if not self._open:
            raise CameraError("realsense: the depth stream is closed")
        came, frame = self._queue.try_wait_for_frame(max(1, round(timeout * 1e3)))
        return _copied(frame, self._clock()) if came else None

    def close(self) -> None:
        """Stop the sensor; a second time does nothing."""
        if self._open:
            self._open = False
            self._sensor.stop()
            self._sensor.close()


def open_camera(
    serial: str | None = None, *, width: int = 640, height: int = 480, rate: int = 30, sdk: ModuleType | None = None
) -> DepthStream:
    """Open the depth stream of a camera that is plugged in.

    Args:
        serial: number of the camera; null takes the first one.
        width: of the images [px].
        height: of the images [px].
        rate: images per second [Hz].
        sdk: the module `pyrealsense2`; found by itself by default.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        CameraError: no such camera, or no such stream of it.
    """
    sdk = sdk or load_sdk()
    devices = {device.get_info(sdk.camera_info.serial_number): device for device in sdk.context().query_devices()}
    if not devices:
        raise CameraError("realsense: no camera found; plug one in (USB 3), and see `rs-enumerate-devices`")
    if serial is not None and serial not in devices:
        raise CameraError(f"realsense: no camera with serial number {serial}; found {', '.join(devices)}")
    device = devices[serial] if serial else next(iter(devices.values()))
    sensor = device.first_depth_sensor()
    profiles = _depth_profiles(sdk, sensor)
    for profile in profiles:
        video = profile.as_video_stream_profile()
        if (video.width(), video.height(), video.fps()) == (width, height, rate):
            return DepthStream(sdk, sensor, profile, device)
    offered = sorted({(p.as_video_stream_profile().width(), p.as_video_stream_profile().height()) for p in profiles})
    sizes = ", ".join(f"{w} x {h}" for w, h in offered)
    raise CameraError(f"realsense: no depth stream of {width} x {height} at {rate} Hz; the camera offers {sizes}")


def open_sensor(
    sensor: Any, keeps: Any = None, *, sdk: ModuleType | None = None, clock: Callable[[], float] = time.monotonic
) -> DepthStream:
    """Open the first depth stream of a sensor that is at hand already, of a `software_device` for one.

    Args:
        sensor, keeps, sdk, clock: as for `DepthStream`.

    Raises:
        CameraError: it has none, or it does not start.
    """
    sdk = sdk or load_sdk()
    profiles = _depth_profiles(sdk, sensor)
    if not profiles:
        raise CameraError("realsense: the sensor has no depth stream")
    return DepthStream(sdk, sensor, profiles[0], keeps, clock)


def recorded_frames(
    path: str | Path, *, sdk: ModuleType | None = None
) -> tuple[Intrinsics, Generator[DepthFrame, None, None]]:
    """The camera of a recording, and every frame in turn, as fast as they are taken; none is left out.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        BadInput: no such file, or no recording with a depth stream.
    """
    sdk = sdk or load_sdk()
    device, sensor, profile = _recorded(sdk, path)
    intrinsics = Intrinsics.of_profile(profile.as_video_stream_profile().get_intrinsics())
    device.as_playback().set_real_time(False)  # the reader waits for each frame to be taken
    return intrinsics, _every_frame(sdk, device, sensor, profile)


def _every_frame(sdk: ModuleType, device: Any, sensor: Any, profile: Any) -> Frames:
    waiting: queue.Queue[DepthFrame] = queue.Queue(_QUEUED)
    ended = False

    def take(frame: Any) -> None:
        copied = _copied(frame, time.monotonic())
        while not ended:
            try:
                return waiting.put(copied, timeout=0.05)
            except queue.Full:
                continue

    player = device.as_playback()
    sensor.open(profile)
    sensor.start(take)
    try:
        quiet_since = time.monotonic()
        while True:
            try:
                yield waiting.get(timeout=0.05)
                quiet_since = time.monotonic()
            except queue.Empty:
                quiet = time.monotonic() - quiet_since
                stopped = player.current_status() == sdk.playback_status.stopped
                if quiet > (0.1 if stopped else _END_OF_RECORDING):
                    return
    finally:
        ended = True
        sensor.stop()
        sensor.close()


def _recorded(sdk: ModuleType, path: str | Path) -> tuple[Any, Any, Any]:
    if not Path(path).is_file():
        raise BadInput(path, found="no such file", expected="a recording of a RealSense camera")
    try:
        device = sdk.context().load_device(str(path))
        sensors = device.query_sensors()
    except RuntimeError as error:
        raise BadInput(path, found=one_line(error), expected="a recording of a RealSense camera (.db3)") from None
    for sensor in sensors:
        if profiles := _depth_profiles(sdk, sensor):
            return device, sensor, profiles[0]
    raise BadInput(path, found="no depth stream", expected="a recording of a camera's depth")


def _depth_profiles(sdk: ModuleType, sensor: Any) -> list[Any]:
    wanted = sdk.stream.depth, sdk.format.z16
    return [p for p in sensor.get_stream_profiles() if (p.stream_type(), p.format()) == wanted]


def _copied(frame: Any, arrival: float) -> DepthFrame:
    depth = frame.as_depth_frame()
    image = np.array(frame.get_data(), dtype=np.uint16)
    return DepthFrame(image, depth.get_units(), frame.get_frame_number(), frame.get_timestamp() * 1e-3, arrival)


Source = Callable[[float], DepthFrame | None]
"""Called with a timeout [s], gives the newest frame or None."""
