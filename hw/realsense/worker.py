"""Turns depth frames into clouds in a thread of its own, and shows the latest."""

import threading
from typing import NamedTuple

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.cloud import Cloud
from mmt_drake.errors import one_line
from mmt_drake.hw.realsense.depth import DepthToCloud, Image
from mmt_drake.hw.realsense.faults import BLIND, FROZEN, STALE
from mmt_drake.hw.realsense.stream import DepthFrame, Source

_TIMEOUT = 0.1  # of one wait for a frame [s]; closing takes as long
_AGAIN = 0.5  # [s] after an error until the next frame is asked for


class LatestFrame(NamedTuple):
    """What a camera last showed.

    Attributes:
        cloud: table frame; its stamp is the camera's own time.
        arrival: of its frame [s], by the stream's clock.
        number: of the frame, as the camera counts.
        lost: share of pixels without depth.
    """

    cloud: Cloud
    arrival: float
    number: int
    lost: float


class CloudWorker(Closing):
    """The thread between a camera and whoever wants its newest cloud; a context manager.

    Filtering and the cloud's neighbour structure run here and, but for moments, without Python's lock. Frames that come
    in the meantime are skipped: newest wins. The exchange is one reference, replaced whole: a reader never waits and
    never sees half of a cloud.

    A frame from which nothing new is known of the surface is passed over, and the latest cloud grows old: one without a
    single point of the surface (a covered lens), one that is no newer than the frame before it, and one whose image is
    that of the frame before it to the last bit, which the noise of a depth camera makes as good as impossible. An error
    of the camera is reported, and the next frame asked for all the same: the source may get the camera back.

    Args:
        source: called with a timeout [s], gives the newest frame or None; `DepthStream.read`.
        convert: from depth to cloud.

    Attributes:
        latest: the newest cloud; None before the first.
        failure: the error that is in the way of frames, one line; None while they can come.
        passed_over: why the newest frame was, `BLIND`, `FROZEN`, or `STALE` where it came late; None if it was not.
        frames: how many were read, and dealt with.
    """

    def __init__(self, source: Source, convert: DepthToCloud) -> None:
        self.latest: LatestFrame | None = None
        self.failure: str | None = None
        self.passed_over: float | None = None
        self.frames = 0
        self._source, self._convert = source, convert
        self._before: DepthFrame | None = None
        self._smoothed: Image | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="depth camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread; the latest cloud stays."""
        self._closing.set()
        self._thread.join(10 * _TIMEOUT)

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                frame = self._source(_TIMEOUT)
                if frame is not None:
                    self._take(frame)
            except Exception as error:  # whatever it is: a diagram waits for frames that do not come
                self.failure = one_line(error)
                self._closing.wait(_AGAIN)

    def _take(self, frame: DepthFrame) -> None:
        before, self._before = self._before, frame
        passed_over = None if before is None else _repeats(frame, before)
        if passed_over is None:
            cloud, lost, self._smoothed = self._convert(
                frame.depth, frame.unit, frame.device_time, self._smoothed, frame.colour
            )
            if len(cloud):
                self.latest = LatestFrame(cloud, frame.arrival, frame.number, lost)
            else:
                passed_over = BLIND
        self.passed_over, self.failure = passed_over, None
        self.frames += 1


def _repeats(frame: DepthFrame, before: DepthFrame) -> float | None:
    """Why a frame tells nothing that the one before it did not; a clock that was set costs one frame."""
    if (frame.number, frame.device_time) == (before.number, before.device_time):
        return FROZEN
    if frame.device_time < before.device_time:
        return STALE
    if np.array_equal(frame.depth, before.depth):
        return FROZEN if frame.depth.any() else BLIND
    return None
