"""A depth camera at work, as a station takes it in place of a simulated surface."""

import time
from collections.abc import Callable
from contextlib import ExitStack

from mmt_drake.closing import Closing
from mmt_drake.diagrams.stations import surfaces as options
from mmt_drake.hw.realsense.camera import DepthCameraSystem
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.reopened import CameraStream, ReopenedStream
from mmt_drake.hw.realsense.stream import RecordedStream, open_camera
from mmt_drake.hw.realsense.worker import CloudWorker


class Camera(Closing):
    """A camera, or a recording of one, and the thread that makes clouds of its frames.

    Open from here on; has to be closed.

    Attributes:
        system: `mmt_drake.hw.realsense.camera.DepthCameraSystem`.
        worker: of the clouds.
        oldest: age of its latest frame from which on that no longer counts [s].
        name: in a word or two.

    Args:
        chosen: which one, where it is, and what of its images becomes the cloud.
        stream: an open one, in place of what is chosen; closed with the rest.
        clock: that the frames' arrivals are told by [s].

    Raises:
        BadInput: its place or its recording cannot be read.
        MissingDependency, DeviceError: as `open_camera`.
    """

    def __init__(
        self,
        chosen: options.DepthCamera,
        stream: CameraStream | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        with ExitStack() as opened:
            source = stream or _stream(chosen)
            opened.callback(source.close)
            where = Extrinsics.read(str(chosen.extrinsics))
            convert = DepthToCloud(source.intrinsics, where, chosen.settings, chosen.smooth)
            # Closed first: the thread reads from the stream.
            self.worker = opened.enter_context(CloudWorker(source.read, convert))
            self.system = DepthCameraSystem(self.worker, stale=chosen.stale, clock=clock)
            self._opened = opened.pop_all()
        self.oldest = chosen.stale
        self.name = f"depth camera {chosen.recording or chosen.serial or ''}".rstrip()

    def close(self) -> None:
        """End the thread and the camera's stream; may be called again."""
        self._opened.close()


def _stream(chosen: options.DepthCamera) -> CameraStream:
    if chosen.recording is not None:
        return RecordedStream(chosen.recording)
    return ReopenedStream(
        lambda: open_camera(chosen.serial, width=chosen.width, height=chosen.height, rate=chosen.rate)
    )
