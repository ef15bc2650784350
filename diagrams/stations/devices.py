"""The devices of a run, connected: each takes the place of what simulates it."""

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from types import MappingProxyType

from mmt_drake.closing import Closing
from mmt_drake.diagrams.stations.device_options import Franka, Omega
from mmt_drake.diagrams.stations.surfaces import DepthCamera
from mmt_drake.hw.franka.telerobot import FrankaTelerobot
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.realsense.camera import DepthCameraSystem
from mmt_drake.hw.realsense.depth import DepthToCloud
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.reopened import CameraStream, ReopenedStream
from mmt_drake.hw.realsense.stream import RecordedStream, open_camera
from mmt_drake.hw.realsense.worker import CloudWorker
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.supervised import supervised

#: For so long an arm may take to be in control after a person has pressed the switch [s].
ARMING = 3.0
_NOTHING: Mapping[str, float] = MappingProxyType({})


class RemoteArm(Closing):
    """An arm at the table, as a station takes it in place of a simulated telerobot and its object.

    It is connected from here on and has to be closed. It does not move before a person has armed it.

    Attributes:
        system: with the ports of `FrankaTelerobot`, `age` and `switches` among them.
        switch: arms and stops, from any thread, where no hand beside it has one.
        address: where it is.
        compensation: of its force.
        oldest: age of its readings at which the other side has to let go [s].

    Args:
        device: which one, and how it is set up.
        period: of the ticks [s].

    Raises:
        MissingDependency, DeviceError: as `FrankaArm`.
    """

    def __init__(self, device: Franka, period: float) -> None:
        self.address, self.oldest = device.address, device.gap
        self.compensation = replace(device.compensation, step=period)
        #: As people call it.
        self.name = f"arm at {device.address}"
        self.switch = OperatorSwitch(period=period)
        self.system = FrankaTelerobot(device, period=period)

    def close(self) -> None:
        """Bring the arm to rest; may be called again."""
        self.system.close()


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
        clock: of the frames' arrivals [s].

    Raises:
        BadInput: its place or its recording cannot be read.
        MissingDependency, DeviceError: as `open_camera`.
    """

    def __init__(
        self, chosen: DepthCamera, stream: CameraStream | None = None, clock: Callable[[], float] = time.monotonic
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


def _stream(chosen: DepthCamera) -> CameraStream:
    if chosen.recording is not None:
        return RecordedStream(chosen.recording)
    return ReopenedStream(
        lambda: open_camera(chosen.serial, width=chosen.width, height=chosen.height, rate=chosen.rate)
    )


class Hand(Closing):
    """A person's hand on a device, behind a supervisor, as a station takes it in place of a simulated one.

    The device is open from here on and has to be closed. It makes no force before a person has armed it.

    Attributes:
        system: with the ports of `supervised`.
        switch: arms and stops, from any thread.
        watched: name -> greatest age [s] of what must stay fresh.
        force_scale: newtons on the device per newton that the supervisor lets through.

    Args:
        device: which one, and what it may do.
        period: of the ticks [s].
        watched: as `SafetySupervisor` takes it.
        press: how long a press of the arm switch lasts [s]; `ARMING` where it brings an arm into control as well.
        clock: of readings and switches [s], never set.
        supervisor_clock: of what the supervisor looks at; `clock` if None.

    Raises:
        BadInput: limits that cannot be kept at this period.
        MissingDependency, DeviceError: as `OmegaDevice`.
    """

    def __init__(
        self,
        device: Omega,
        period: float,
        watched: Mapping[str, float] = _NOTHING,
        *,
        press: float = 0.1,
        clock: Callable[[], float] = time.monotonic,
        supervisor_clock: Callable[[], float] | None = None,
    ) -> None:
        watch = clock if supervisor_clock is None else supervisor_clock
        self._operator = OmegaOperator(device, period=period, clock=clock, supervisor_clock=watch)
        try:
            self.switch = OperatorSwitch(period=period, press=press, clock=watch, on_arm=self._operator.request_forces)
            limits = device.table_limits()
            self.system = supervised(self._operator, limits, period=period, watched=watched, switch=self.switch)
        except BaseException:
            self.close()
            raise
        #: As the device calls itself.
        self.name = self._operator.device.name
        self.watched, self.force_scale = watched, device.force_scale

    def close(self) -> None:
        """Bring the device to rest; may be called again."""
        self._operator.close()
