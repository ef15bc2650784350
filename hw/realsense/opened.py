"""A stream of a sensor that is open and whose frames come in."""

from typing import Any

from mmt_drake.closing import Closing
from mmt_drake.errors import one_line
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.sdk import load_sdk


class OpenedSensor(Closing):
    """One stream of a sensor, opened and started; a context manager.

    Args:
        sensor: of librealsense.
        profile: the stream to open.
        what: it tells, for messages.

    Attributes:
        queue: of its frames, which holds the newest.
        is_open: until it is closed.

    Raises:
        DeviceError: the sensor does not start.
    """

    def __init__(self, sensor: Any, profile: Any, what: str) -> None:
        self.queue, self._sensor, self.is_open = load_sdk().frame_queue(1), sensor, False
        try:
            sensor.open(profile)
            try:
                sensor.start(self.queue)
            except RuntimeError:
                sensor.close()
                raise
        except RuntimeError as error:
            raise DeviceError(f"realsense: the {what} stream does not start: {one_line(error)}") from None
        self.is_open = True

    def close(self) -> None:
        """Stop the sensor; a second time does nothing."""
        if self.is_open:
            self.is_open = False
            self._sensor.stop()
            self._sensor.close()
