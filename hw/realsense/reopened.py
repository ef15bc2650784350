"""A camera that is opened anew when it has gone."""

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Protocol

from mmt_drake.closing import Closing
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.stream import DepthFrame

_SILENT = 2.0  # [s] without a frame after which a camera is taken for gone: unplugged, it says nothing more


class CameraStream(Protocol):
    """What a camera and whatever stands for one have in common; see `DepthStream`."""

    intrinsics: Intrinsics

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        """The newest frame, or None after `timeout` [s]."""
        ...

    def close(self) -> None:
        """End it."""
        ...


class ReopenedStream(Closing):
    """Reads a camera, and opens it again after an error or a long silence; a context manager.

    A camera that is unplugged and plugged in again is another device to its library. Every attempt that fails is an
    error of `read`: whoever reads tells of it, and asks again after a while.

    Args:
        open_stream: opens the camera.
        clock: for the silence [s].

    Attributes:
        intrinsics: of the images.

    Raises:
        MissingDependency, DeviceError: as `open_stream`, the first time.
    """

    def __init__(self, open_stream: Callable[[], CameraStream], clock: Callable[[], float] = time.monotonic) -> None:
        self._open, self._clock = open_stream, clock
        self._stream: CameraStream | None = open_stream()
        self._heard = clock()
        self.intrinsics = self._stream.intrinsics

    def read(self, timeout: float = 0.1) -> DepthFrame | None:
        """The newest frame not yet read, or None after `timeout` [s] without one.

        Raises:
            DeviceError: the camera failed, is silent, cannot be opened again, or is another one now.
            RuntimeError: of its library, when the camera fails.
        """
        stream = self._stream or self._opened_again()
        try:
            frame = stream.read(timeout)
        except (DeviceError, RuntimeError):
            self.close()
            raise
        if frame is not None:
            self._heard = self._clock()
        elif self._clock() - self._heard > _SILENT:
            self.close()
            raise DeviceError(f"realsense: no depth frame within {_SILENT:g} s; the camera is opened again")
        return frame

    def close(self) -> None:
        """Close what is open."""
        if self._stream is not None:
            with suppress(RuntimeError):  # of a camera that is not there any more
                self._stream.close()
            self._stream = None

    def _opened_again(self) -> CameraStream:
        stream = self._open()
        if stream.intrinsics != self.intrinsics:
            stream.close()
            raise DeviceError("realsense: another camera, or other images, than those of before")
        self._stream, self._heard = stream, self._clock()
        return stream
