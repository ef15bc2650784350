"""Faults of the depth camera that sees the surface: an emulated one, the kinds, and what comes of each."""

import json
import math
import random
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.faults.injection import PERIOD, Injection, Tally, emulated_omega, inject
from mmt_drake.diagrams.proof.faults.session import CHANGES, FORCE, Session, telerobot_record
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.diagrams.stations.devices import Camera
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.surfaces import DepthCamera
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.realsense.camera import LOOK
from mmt_drake.hw.realsense.depth import DepthImage
from mmt_drake.hw.realsense.emulator import RATE, EmulatedUsb, noisy_plane, software_camera
from mmt_drake.hw.realsense.faults import BLIND, FAILED, FROZEN, STALE, WELL
from mmt_drake.hw.realsense.reopened import ReopenedStream
from mmt_drake.hw.realsense.view import View
from mmt_drake.hw.realsense.worker import CloudWorker
from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.recording import load

_VIEW = View(focal=240.0, width=160)
_PATIENCE = 20.0  # [s] with the camera's thread on a machine that is busy


class Eye:
    """Shows a frame of its own noise whenever one is due, or what a fault has it show instead.

    Attributes:
        camera: the software device.
        usb: through which it is opened.
        extrinsics: file that says where the camera is.
        instead: called in place of showing a frame, while there is a fault.

    Args:
        folder: for the file.
        clock: of arrivals [s].
        period: of the ticks [s].

    Raises:
        MissingDependency: the camera's library is not installed.
    """

    def __init__(self, folder: Path, clock: Callable[[], float], period: float) -> None:
        self.extrinsics = folder / "camera.yaml"
        self._where, self._rng = _VIEW.extrinsics(), np.random.default_rng(0)
        self._where.write(self.extrinsics)
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


#: Age from which on the camera no longer counts [s].
OLDEST = 0.25


@dataclass(frozen=True)
class CameraFault:
    """One kind of fault, and what must come of it.

    Attributes:
        start: brings it about.
        fault: on the camera's port; `WELL` where the run must go on.
        seen_after: how long it takes until it can be seen [s], beside the time between two looks at the camera.
    """

    start: Callable[[Eye, CloudWorker], object]
    fault: float
    seen_after: float = OLDEST


Show = Callable[[Eye], object]
"""What the camera does when a frame is due."""


def _instead(show: Show) -> Callable[[Eye, CloudWorker], object]:
    def start(eye: Eye, worker: CloudWorker) -> None:
        eye.instead = show

    return start


def _once(show: Show) -> Callable[[Eye, CloudWorker], object]:
    def once(eye: Eye) -> None:
        eye.instead = None
        show(eye)

    return _instead(once)


def _dark(eye: Eye) -> None:
    eye.camera.show(np.zeros_like(eye.image))


def _not_a_number(eye: Eye) -> None:
    unit, eye.camera.unit = eye.camera.unit, math.nan
    eye.show()
    eye.camera.unit = unit


def _late(eye: Eye) -> None:
    """This frame does not come until the next one has."""
    eye.camera.number += 1
    image, number = eye.new_image(), eye.camera.number

    def both(eye: Eye) -> None:
        eye.instead = None
        eye.show()
        eye.camera.show_again(image, number)

    eye.instead = both


KINDS: dict[str, CameraFault] = {
    # Where the surface is not known any more nobody knows of contact: no force, and a person arms again, for the hand
    # may be deep in the object by the time it is seen again. It counts from the last frame that showed something new.
    "no frames any more": CameraFault(_instead(lambda eye: None), STALE),
    "one frame over and over": CameraFault(
        _instead(lambda eye: eye.camera.show_again(eye.image, eye.camera.number)), FROZEN
    ),
    "image frozen, its number goes on": CameraFault(_instead(lambda eye: eye.camera.show(eye.image)), FROZEN),
    "no pixel with depth any more": CameraFault(_instead(_dark), BLIND),
    "unit of depth is not a number": CameraFault(_instead(_not_a_number), BLIND),
    # What the driver reports is known at once.
    "driver's error": CameraFault(
        lambda eye, worker: eye.fail(worker, error="uvc streamer: input/output error"), FAILED, 0.0
    ),
    "unplugged and back": CameraFault(lambda eye, worker: eye.fail(worker), FAILED, 0.0),
    # One bad frame of thirty a second hides nothing: the one before it still counts.
    "one frame without depth": CameraFault(_once(_dark), WELL),
    "one frame late": CameraFault(_instead(_late), WELL),
}


_LONGER = 100  # ticks that are watched once it can be seen
_AFTER = 150  # ticks with a camera that is well again
_STROKE = 500  # ticks of one stroke of the hand
APART = ("no frames any more", "unplugged and back")
"""Kinds that are tried with the camera at the other side of a link too."""


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """Every kind of fault that an emulated camera can have."""
    omega = emulated_omega(folder)
    for name, kind in KINDS.items():
        yield try_kind(name, kind, omega, moments, folder / "camera.mcap")
    for name in APART:
        yield try_kind(f"{name}, apart", KINDS[name], omega, moments, folder / "camera.mcap", apart=True)


def try_kind(
    name: str, kind: CameraFault, omega: EmulatedOmega, moments: int, record: Path, *, apart: bool = False
) -> Row:
    """One kind, in one session, with a person who arms again where the force went to zero.

    Args:
        name: of it, and seed of the moments.
        kind: what happens.
        omega: the operator's device.
        moments: how many.
        record: file for the (operator's) recording.
        apart: the camera is at the telerobot's side of two.
    """
    draw, must, tally = random.Random(name), kind.fault != WELL, Tally(FORCE)
    omega.reset()
    clock = partial(omega.get, "clock")
    eye = Eye(record.parent, clock, PERIOD)
    keys = {"extrinsics": str(eye.extrinsics), "stale": OLDEST, "settings": {"voxel": None}}
    scenario = load_scenario("setup1", [*CHANGES, f"environment.cloud=!DepthCamera {json.dumps(keys)}"])
    chosen = scenario.environment.cloud
    assert isinstance(chosen, DepthCamera)
    camera = Camera(chosen, ReopenedStream(eye.usb.open, clock), clock)
    fault = Injection[Session](
        lambda _: kind.start(eye, camera.worker),
        lambda _: eye.mend(),
        (Reason.STALE + apart,) if must else (),  # the peer's age comes first
        kind.seen_after + LOOK + (PERIOD if apart else 0.0),  # by the next packet
        watched=_LONGER,
        after=_AFTER,
    )

    def approach() -> None:
        """Go on to a moment at which there is a force."""
        session.go(draw.randrange(60))
        for _ in range(_STROKE):
            if omega.vector("applied").any():
                break
            session.go(1)

    each = partial(eye.tick, camera.worker)
    with Session(omega, record, scenario=scenario, camera=camera, each=each, apart=apart) as session:
        omega.set(swing_z=0.004)  # it hardly leaves the object: a force that came back by itself would be felt
        inject(session, fault, moments, approach, tally)
        tally.armed(session, "at the end")
    tally.must_have_felt(moments, moments)
    tally.recorded(session, record)
    faults = load(telerobot_record(record) if apart else record, forces=False)["camera_fault"]
    if must and kind.fault not in faults:
        tally.wrong.append(f"the recording tells of the faults {np.unique(faults)}")
    return tally.row(name, "camera", moments, fault.allowed)
