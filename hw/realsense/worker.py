"""Turns depth frames into clouds in a thread of its own, and shows the latest."""

from __future__ import annotations

import threading
import time
from typing import NamedTuple

from hw.realsense.depth import DepthToCloud
from hw.realsense.stream import DepthStream, Source
from hw.realsense.temporal import TemporalFilter
from mmt_drake.closing import Closing
from mmt_drake.cloud import Cloud
from mmt_drake.errors import one_line

_TIMEOUT = 0.1  # of one wait for a frame [s]; closing takes as long


class Latest(NamedTuple):
    """What a camera last showed.

    Attributes:
        cloud: table frame; its stamp is the camera's own time.
        arrival: of its frame [s], by `time.monotonic`.
        ready: when the cloud was ready [s], by the same clock.
        number: of the frame, as the camera counts.
        lost: share of pixels without depth.
    """

    cloud: Cloud
    arrival: float
    ready: float
    number: int
    lost: float


class CloudWorker(Closing):
    """The thread between a camera and whoever wants its newest cloud; a context manager.

    Filtering and the cloud's neighbour structure run here and, but for moments, without Python's lock. Frames that come
    in the meantime are skipped: newest wins. The exchange is one reference, replaced whole: a reader never waits and
    never sees half of a cloud.

    Args:
        source: called with a timeout [s], gives the newest frame or None; `DepthStream.read`.
        convert: from depth to cloud.
        smooth: over frames; by default each stands alone.

    Attributes:
        latest: the newest cloud; None before the first.
        failure: why the thread ended by itself, one line; None while it runs.
    """

    def __init__(self, source: Source, convert: DepthToCloud, smooth: TemporalFilter | None = None) -> None:
        self.latest: Latest | None = None
        self.failure: str | None = None
        self._source, self._convert, self._smooth = source, convert, smooth
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="depth camera", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread; the latest cloud stays."""
        self._closing.set()
        self._thread.join(10 * _TIMEOUT)

    def _run(self) -> None:
        smoothed = None
        try:
            while not self._closing.is_set():
                frame = self._source(_TIMEOUT)
                if frame is None:
                    continue
                if self._smooth is None:
                    cloud, lost = self._convert(frame.depth, frame.unit, frame.device_time)
                else:
                    smoothed = self._smooth(smoothed, frame.depth, frame.unit)
                    cloud, lost = self._convert(smoothed, 1.0, frame.device_time)
                self.latest = Latest(cloud, frame.arrival, time.monotonic(), frame.number, lost)
        except Exception as error:  # whatever it is: a diagram waits for frames that do not come
            self.failure = one_line(error)


def watch(stream: DepthStream, convert: DepthToCloud, smooth: TemporalFilter | None = None) -> CloudWorker:
    """A worker on a stream that is open already; close the worker first, then the stream."""
    return CloudWorker(stream.read, convert, smooth)
