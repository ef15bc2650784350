"""Pictures in colour of a RealSense camera, beside its depth."""

from typing import Any

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.errors import one_line
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.colour import ColourImage
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.opened import OpenedSensor
from mmt_drake.hw.realsense.sdk import load_sdk


class ColourStream(Closing):
    """The newest picture of one opened colour sensor; a context manager. Distortion, of some pixels, is left in.

    Args:
        sensor: the colour sensor.
        profile: the stream to open.
        depth: the profile of depth beside which it is.

    Raises:
        DeviceError: the sensor does not start, or where it stands is not known.
    """

    def __init__(self, sensor: Any, profile: Any, depth: Any) -> None:
        self._intrinsics = Intrinsics.of_profile(profile.as_video_stream_profile().get_intrinsics(), distorted=True)
        try:
            beside = depth.get_extrinsics_to(profile)
        except RuntimeError as error:
            raise DeviceError(f"realsense: where the colour sensor stands is not known: {one_line(error)}") from None
        self._opened = OpenedSensor(sensor, profile, "colour")
        self._rotation = np.reshape(beside.rotation, (3, 3)).T  # by columns
        self._translation = np.array(beside.translation)

    def newest(self) -> ColourImage | None:
        """The newest picture that has not been given yet; None: there is none."""
        frame = self._opened.queue.poll_for_frame()
        if not frame:
            return None
        pixels = np.array(frame.get_data(), dtype=np.uint8)
        return ColourImage(pixels, self._intrinsics, self._rotation, self._translation)

    def close(self) -> None:
        """Stop the sensor; a second time does nothing."""
        self._opened.close()


def colour_sensor(device: Any, depth: Any) -> tuple[Any, Any]:
    """The sensor of a device that sees colour, and its slowest stream of about the size of depth.

    Args:
        device: whose sensors they are.
        depth: the profile of depth.

    Raises:
        DeviceError: it has none beside that of depth.
    """
    sdk, wide = load_sdk(), depth.as_video_stream_profile().width()
    for sensor in device.query_sensors():
        profiles = sensor.get_stream_profiles()
        kinds = {profile.stream_type() for profile in profiles}
        seen = [p for p in profiles if (p.stream_type(), p.format()) == (sdk.stream.color, sdk.format.rgb8)]
        if seen and sdk.stream.depth not in kinds:
            best = min(seen, key=lambda p: (abs(p.as_video_stream_profile().width() - wide), p.fps()))
            return sensor, best
    raise DeviceError("realsense: the camera has no colour sensor beside that of depth; open it without colour")
