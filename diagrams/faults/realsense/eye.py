"""An emulated camera above a flat top; time is that of whoever calls `tick`, however long the camera's thread takes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mmt_drake.hw.realsense.depth import DepthImage
from mmt_drake.hw.realsense.emulator import RATE, EmulatedUsb, noisy_plane, software_camera
from mmt_drake.hw.realsense.view import View
from mmt_drake.hw.realsense.worker import CloudWorker

_VIEW = View(focal=240.0, width=160)
_PATIENCE = 20.0  # [s] with the camera's thread on a machine that is busy


class Eye:
    """Shows a frame of its own noise whenever one is due, or what a trial has it show instead.

    Attributes:
        camera: the software device.
        usb: through which it is opened.
        place: file with the camera's place.
        instead: called in the place of showing a frame, while there is a fault.

    Args:
        folder: for the file.
        clock: that arrivals are told by [s].
        period: of the ticks [s].
        seed: of the noise.

    Raises:
        MissingDependency: the camera's library is not installed.
    """

    def __init__(self, folder: Path, clock: Callable[[], float], period: float, seed: int = 0) -> None:
        self.place = folder / "camera.yaml"
        self._where, self._rng = _VIEW.extrinsics(), np.random.default_rng(seed)
        self._where.write(self.place)
        self.camera = software_camera(_VIEW.intrinsics())
        self.usb = EmulatedUsb(self.camera, clock)
        self.instead: Callable[[Eye], object] | None = None
        self.image: DepthImage = self.new_image()
        self._ticks, self._every = 0, round(1.0 / RATE / period)

    def new_image(self) -> DepthImage:
        """(height, width) of the flat top, with noise of its own, in units."""
        return noisy_plane(_VIEW.intrinsics(), self._where, self._rng)

    def show(self) -> None:
        """Have the next frame come in."""
        self.image = self.new_image()
        self.camera.show(self.image)

    def tick(self, worker: CloudWorker) -> None:
        """Have a frame come in if one is due, and wait until the camera's thread has dealt with it."""
        self._ticks += 1
        if self._ticks % self._every == 0 and self.usb.works:
            shown, dealt_with = self.camera.shown, worker.frames
            if self.instead is None:
                self.show()
            else:
                self.instead(self)
            wanted = dealt_with + min(self.camera.shown - shown, 1)
            wait_until(lambda: worker.frames >= wanted)

    def fail(self, worker: CloudWorker, *, error: str | None = None) -> None:
        """Have the camera's driver raise an error from now on, or, by default, unplug it."""
        self.usb.error, self.usb.plugged = error, error is not None
        wait_until(lambda: worker.failure is not None)

    def mend(self) -> None:
        """Plug it in again, without any fault, and wait until it is open again if it was not."""
        self.instead = None
        broken, opened = not self.usb.works, self.usb.opened
        self.usb.error, self.usb.plugged = None, True
        if broken:
            wait_until(lambda: self.usb.opened > opened)


def wait_until(true: Callable[[], object]) -> None:
    """Wait for the camera's thread.

    Raises:
        TimeoutError: it does not do it.
    """
    ends = time.monotonic() + _PATIENCE
    while not true():
        if time.monotonic() > ends:
            raise TimeoutError("the camera's thread is stuck")
        time.sleep(1e-4)
