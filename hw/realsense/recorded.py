"""A recording of a camera in the place of a camera."""

import time
from pathlib import Path
from types import ModuleType

from mmt_drake.closing import Closing
from mmt_drake.hw.realsense.stream import DepthFrame, recorded_frames


class RecordedStream(Closing):
    """Plays a recording (`.db3`, or `.bag` of older versions) at its own pace, over and over; a context manager.

    It is read as `DepthStream` is, but no frame is passed over: a reader that is too slow sees a slow camera. Between
    the last frame and the first one of the next round is a tenth of a second, which the player takes to end.

    Args:
        path: of the recording.
        sdk: the module `pyrealsense2`; found by itself by default.

    Attributes:
        intrinsics: of the images.

    Raises:
        MissingDependency: pyrealsense2 is not here.
        BadInput: no such file, or no recording with a depth stream.
    """

    def __init__(self, path: str | Path, *, sdk: ModuleType | None = None) -> None:
        self._path, self._sdk = path, sdk
        self.intrinsics, self._frames = recorded_frames(path, sdk=sdk)
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
        _, self._frames = recorded_frames(self._path, sdk=self._sdk)
        self._began = None
        return None

    def close(self) -> None:
        """Stop playing; a second time does nothing."""
        self._frames.close()
