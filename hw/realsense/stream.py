"""Depth frames from a RealSense camera, from a recording of one, or from librealsense's software device."""

import queue
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.errors import BadInput, one_line
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.colour_stream import ColourStream, colour_sensor
from mmt_drake.hw.realsense.depth import DepthImage, Intrinsics
from mmt_drake.hw.realsense.opened import OpenedSensor
from mmt_drake.hw.realsense.sdk import load_sdk, new_context

_QUEUED = 4  # frames of a recording read ahead
_END_OF_RECORDING = 2.0  # [s] without a frame
_CLOSED_WITHIN = 1.0  # [s]


class DepthFrame(NamedTuple):
    """One depth image.

    Attributes:
        depth: (height, width) in units, 0 without depth; its own memory.
        unit: of depth [m].
        number: as the camera counts; gaps are frames lost.
        device_time: of the frame [s], by the camera's or the recording's clock.
        arrival: when it came in [s], by the stream's clock.
        colour: the newest picture in colour since the frame before; None: there is none.
    """

    depth: DepthImage
    unit: float
    number: int
    device_time: float
    arrival: float
    colour: ColourImage | None = None


Frames = Generator[DepthFrame, None, None]


class DepthStream(Closing):
    """The depth frames of one opened sensor, the newest first; a context manager.

    Args:
        sensor: the depth sensor.
        profile: the stream to open.
        keeps: what the sensor belongs to and must live as long.
        clock: of arrivals [s].
        colour: sensor and profile of colour, if that is to be told, too.

    Attributes:
        intrinsics: of the images.

    Raises:
        DeviceError: the sensor does not start, or that of colour.
        BadInput: images with distortion.
    """

    def __init__(
        self,
        sensor: Any,
        profile: Any,
        keeps: Any = None,
        clock: Callable[[], float] = time.monotonic,
        colour: tuple[Any, Any] | None = None,
    ) -> None:
        self.intrinsics = Intrinsics.of_profile(profile.as_video_stream_profile().get_intrinsics())
        self._keeps, self._clock = keeps, clock
        self._colour: ColourStream | None = None
        self._opened = OpenedSensor(sensor, profile, "depth")
        try:
            self._colour = None if colour is None else ColourStream(*colour, profile)
        except DeviceError:
            self.close()
            raise

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        """The newest frame not yet read, or None after `timeout` [s] without one.

        Raises:
            DeviceError: the stream is closed.
        """
        if not self._opened.is_open:
            raise DeviceError("realsense: the depth stream is closed")
        came, frame = self._opened.queue.try_wait_for_frame(max(1, round(timeout * 1e3)))
        if not came:
            return None
        colour = None if self._colour is None else self._colour.newest()
        return _copied(frame, self._clock())._replace(colour=colour)

    def close(self) -> None:
        """Stop the sensor; a second time does nothing."""
        if self._colour is not None:
            self._colour.close()
        self._opened.close()


def open_camera(
    serial: str | None = None, *, width: int = 640, height: int = 480, rate: int = 30, colour: bool = False
) -> DepthStream:
    """Open the depth stream of a camera that is plugged in.

    Args:
        serial: number of the camera; null takes the first one.
        width: of the images [px].
        height: of the images [px].
        rate: images per second [Hz].
        colour: have its sensor of colour see, too, at its slowest.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        DeviceError: no such camera, or no such stream of it.
    """
    sdk = load_sdk()
    devices = {device.get_info(sdk.camera_info.serial_number): device for device in new_context().query_devices()}
    if not devices:
        raise DeviceError("realsense: no camera found; plug one in (USB 3), and see `rs-enumerate-devices`")
    if serial is not None and serial not in devices:
        raise DeviceError(f"realsense: no camera with serial number {serial}; found {', '.join(devices)}")
    device = devices[serial] if serial else next(iter(devices.values()))
    sensor = device.first_depth_sensor()
    profiles = _depth_profiles(sensor)
    for profile in profiles:
        video = profile.as_video_stream_profile()
        if (video.width(), video.height(), video.fps()) == (width, height, rate):
            return DepthStream(sensor, profile, device, colour=colour_sensor(device, profile) if colour else None)
    offered = sorted({(p.as_video_stream_profile().width(), p.as_video_stream_profile().height()) for p in profiles})
    sizes = ", ".join(f"{w} x {h}" for w, h in offered)
    raise DeviceError(f"realsense: no depth stream of {width} x {height} at {rate} Hz; the camera offers {sizes}")


def open_sensor(
    sensor: Any, keeps: Any = None, *, clock: Callable[[], float] = time.monotonic, colour: bool = False
) -> DepthStream:
    """Open the first depth stream of a sensor that is at hand already, of a `software_device` for one.

    Args:
        sensor, keeps, clock: as for `DepthStream`.
        colour: have the sensor of colour of what it belongs to, `keeps`, see, too.

    Raises:
        DeviceError: it has none, or it does not start.
    """
    profiles = _depth_profiles(sensor)
    if not profiles:
        raise DeviceError("realsense: the sensor has no depth stream")
    return DepthStream(sensor, profiles[0], keeps, clock, colour_sensor(keeps, profiles[0]) if colour else None)


def recorded_frames(path: str | Path) -> tuple[Intrinsics, Frames]:
    """The camera of a recording, and every frame in turn, as fast as they are taken; none is left out.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        BadInput: no such file, or no recording with a depth stream.
    """
    device, sensor, profile = _recorded(path)
    intrinsics = Intrinsics.of_profile(profile.as_video_stream_profile().get_intrinsics())
    device.as_playback().set_real_time(False)  # the reader waits for each frame to be taken
    return intrinsics, _every_frame(device, sensor, profile)


class RecordedStream(Closing):
    """Plays a recording (`.db3`, or `.bag` of older versions) at its own pace, over and over; a context manager.

    It is read as `DepthStream` is, but no frame is passed over: a reader that is too slow sees a slow camera. Between
    the last frame and the first one of the next round is a tenth of a second, which the player takes to end.

    Args:
        path: of the recording.

    Attributes:
        intrinsics: of the images.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        BadInput: no such file, or no recording with a depth stream.
    """

    def __init__(self, path: str | Path) -> None:
        self._path = path
        self.intrinsics, self._frames = recorded_frames(path)
        self._waiting: DepthFrame | None = None
        self._began: float | None = None  # clock at the first frame of this round less that frame's own time

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        """The next frame when it is due, or None if that is not within `timeout` [s].

        Raises:
            BadInput: the recording is gone.
        """
        if self._waiting is None:
            self._waiting = self._next()
            if self._waiting is None:
                return None
        if self._began is None:
            self._began = time.monotonic() - self._waiting.device_time
        early = self._began + self._waiting.device_time - time.monotonic()
        time.sleep(min(max(early, 0.0), timeout))
        if early > timeout:
            return None
        frame, self._waiting = self._waiting._replace(arrival=time.monotonic()), None
        return frame

    def _next(self) -> DepthFrame | None:
        """The next frame; None at the end, from where it begins anew."""
        for frame in self._frames:
            return frame
        _, self._frames = recorded_frames(self._path)
        self._began = None
        return None

    def close(self) -> None:
        """Stop playing; a second time does nothing."""
        self._frames.close()


def _every_frame(device: Any, sensor: Any, profile: Any) -> Frames:
    waiting: queue.Queue[DepthFrame] = queue.Queue(_QUEUED)
    ended = False

    def take(frame: Any) -> None:
        copied = _copied(frame, time.monotonic())
        while not ended:
            try:
                return waiting.put(copied, timeout=0.05)
            except queue.Full:
                continue

    player, stopped = device.as_playback(), load_sdk().playback_status.stopped
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
                if quiet > (0.1 if player.current_status() == stopped else _END_OF_RECORDING):
                    return
    finally:
        ended = True
        player.pause()
        sensor.stop()
        sensor.close()
        # librealsense crashes where a player goes whose thread still reads
        _wait_until(lambda: player.current_status() == stopped, _CLOSED_WITHIN)


def _wait_until(happened: Callable[[], bool], timeout: float) -> None:
    ends = time.monotonic() + timeout
    while not happened() and time.monotonic() < ends:
        time.sleep(1e-3)


def _recorded(path: str | Path) -> tuple[Any, Any, Any]:
    if not Path(path).is_file():
        raise BadInput(path, found="no such file", expected="a recording of a RealSense camera")
    try:
        device = new_context().load_device(str(path))
        sensors = device.query_sensors()
    except RuntimeError as error:
        raise BadInput(path, found=one_line(error), expected="a recording of a RealSense camera (.db3)") from None
    for sensor in sensors:
        if profiles := _depth_profiles(sensor):
            return device, sensor, profiles[0]
    raise BadInput(path, found="no depth stream", expected="a recording of a camera's depth")


def _depth_profiles(sensor: Any) -> list[Any]:
    sdk = load_sdk()
    wanted = sdk.stream.depth, sdk.format.z16
    return [p for p in sensor.get_stream_profiles() if (p.stream_type(), p.format()) == wanted]


def _copied(frame: Any, arrival: float) -> DepthFrame:
    depth = frame.as_depth_frame()
    image = np.array(frame.get_data(), dtype=np.uint16)
    return DepthFrame(image, depth.get_units(), frame.get_frame_number(), frame.get_timestamp() * 1e-3, arrival)


Source = Callable[[float], DepthFrame | None]
"""Called with a timeout [s], gives the newest frame or None."""
