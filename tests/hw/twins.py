"""Every device and what simulates it, put through one and the same session; each session leaves a `Log`."""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import contract
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import PortDataType, System

from mmt_drake.diagrams.proof.faults.franka import SETTINGS as FRANKA
from mmt_drake.diagrams.stations.arm import Arm, missing_arm, simulated_arm
from mmt_drake.hw.franka.telerobot import FrankaTelerobot
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.realsense.camera import DepthCameraSystem
from mmt_drake.hw.realsense.depth import DepthToCloud, Intrinsics
from mmt_drake.hw.realsense.emulator import software_camera
from mmt_drake.hw.realsense.extrinsics import Extrinsics
from mmt_drake.hw.realsense.simulated import simulated_camera
from mmt_drake.hw.realsense.stream import open_sensor
from mmt_drake.hw.realsense.worker import CloudWorker
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.compliant_tip import CompliantTipSystem, TipSettings
from mmt_drake.systems.scripted_operator import ScriptedOperator

sys.path.append(str(Path(__file__).parent / "realsense"))
from realsense_samples import plane_depth, told

Array = np.ndarray

PUSH = np.array([0.0, 12.0, 0.0])  # [N]
AWAY = np.array([0.0, 0.02, 0.0])  # [m]
STEP = 1e-3  # of what is simulated, and of a device whose clock the test moves [s]
PACED = 2e-3  # of a device that goes by the wall's [s]
MOVED, PUSHED, END = 0.8, 1.6, 2.4  # [s] of a telerobot's session


@dataclass
class Log:
    """What a session showed.

    Attributes:
        ports: `in NAME` or `out NAME` -> size.
        own: those that this version alone has.
        through: pairs (input, output) of which the second follows the first at once.
        time: of each tick [s],
        clock: and by the device's own clock, which readings follow.
        shown: output -> its value at each tick.
    """

    ports: dict[str, int]
    own: frozenset[str]
    through: set[tuple[str, str]]
    time: list[float] = field(default_factory=list)
    clock: list[float] = field(default_factory=list)
    shown: dict[str, list[Any]] = field(default_factory=dict)

    def array(self, name: str) -> Array:
        """(ticks, size) of an output."""
        return np.array(self.shown[name])


class Session:
    """A system on its own, with fixed inputs, tick by tick."""

    def __init__(self, system: System, period: float, own: str = "", clock: Callable[[], float] | None = None) -> None:
        self.system, self.period, self.clock = system, period, clock
        self.simulator = Simulator(system)
        self.context = self.simulator.get_mutable_context()
        inputs, outputs = contract.inputs(system), contract.outputs(system)
        sizes = {f"in {name}": system.GetInputPort(name).size() for name in inputs}
        sizes |= {f"out {name}": system.GetOutputPort(name).size() for name in outputs}
        through = {
            (i, o)
            for i in inputs
            for o in outputs
            if system.HasDirectFeedthrough(system.GetInputPort(i).get_index(), system.GetOutputPort(o).get_index())
        }
        self.log = Log(sizes, frozenset(own.split(", ")) if own else frozenset(), through)
        for name in inputs:
            if system.GetInputPort(name).get_data_type() == PortDataType.kVectorValued:
                self.set(name, np.zeros(system.GetInputPort(name).size()))

    def set(self, name: str, value: Array) -> None:
        self.system.GetInputPort(name).FixValue(self.context, value)

    def read(self, name: str) -> Any:
        value = self.system.GetOutputPort(name).Eval(self.context)
        return value.copy() if isinstance(value, np.ndarray) else value

    def note(self) -> None:
        self.log.time.append(self.context.get_time())
        self.log.clock.append(self.context.get_time() if self.clock is None else self.clock())
        for name in contract.outputs(self.system):
            self.log.shown.setdefault(name, []).append(self.read(name))

    def tick(self) -> None:
        self.simulator.AdvanceTo(self.context.get_time() + self.period)
        self.note()


# ------------------------------------------------------------------------------------------------------------ operators
def _hold(session: Session, before: Callable[[], object]) -> Log:
    """A hand that feels nothing for 0.3 s, and then something."""
    session.note()
    for k in range(800):
        if "in force" in session.log.ports:
            session.set("force", np.array([0.0, 0.0, 1.5 if k > 300 else 0.0]))
        before()
        session.tick()
    return session.log


def simulated_hand(request: pytest.FixtureRequest) -> Log:
    return _hold(Session(ScriptedOperator(scripted_motion("strokes")), STEP), lambda: None)


def omega(request: pytest.FixtureRequest) -> Log:
    device = request.getfixturevalue("omega")
    device.set(target_z=-0.01, swing_y=0.02, swing_hz=1.0)
    settings = OmegaSettings(device=0, velocity_window=0.002)
    with OmegaOperator(settings, clock=lambda: float(device.get("clock"))) as hand:
        return _hold(Session(hand, STEP, own="in force, out device, out reported_motion"), lambda: device.advance(STEP))


# ----------------------------------------------------------------------------------------------------------- telerobots
def _probe(session: Session, push: Callable[[Array], object], paced: bool = False) -> Log:
    """An arm that is moved aside, holds its place, and is pushed."""
    home = session.read("motion")[:3]
    began, start, pushed = time.monotonic(), session.context.get_time(), False
    session.note()
    for k in range(round(END / session.period)):
        t = k * session.period
        s = min(t / MOVED, 1.0)
        along, rate = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2 / MOVED
        session.set("commanded", np.concatenate([home + along * AWAY, rate * AWAY]))
        if t >= PUSHED and not pushed:
            pushed = True
            push(PUSH)
        session.tick()
        if paced:
            time.sleep(max(0.0, began + session.context.get_time() - start - time.monotonic()))
    session.log.time = [t - start for t in session.log.time]
    return session.log


def _simulated(system: System) -> Log:
    session = Session(system, STEP, own="in force")
    return _probe(session, lambda force: session.set("force", force))


def compliant_tip(request: pytest.FixtureRequest) -> Log:
    return _simulated(CompliantTipSystem(TipSettings(), np.array([0.0, 0.0, 0.05])))


def simulated_panda(request: pytest.FixtureRequest) -> Log:
    if (missing := missing_arm()) is not None:
        pytest.skip(missing)
    return _simulated(simulated_arm(Arm(), np.array([0.0, 0.0, 0.05]), STEP))


def franka(request: pytest.FixtureRequest) -> Log:
    device = request.getfixturevalue("franka")
    with FrankaTelerobot(replace(FRANKA, address=device.address), period=PACED) as arm:
        # The emulated arm is late on a busy machine, and its time with it.
        session = Session(arm, PACED, own="in age, in switches, out device", clock=lambda: float(arm._driver._arm.time))
        here = session.read("motion")
        session.set("commanded", here)
        arm.request_control()
        for _ in range(2500):
            session.simulator.AdvanceTo(session.context.get_time() + PACED)
            if session.read("device")[2] == 0.0:
                break
            time.sleep(PACED)
        return _probe(session, lambda force: device.set(push=tuple(force)), paced=True)


# -------------------------------------------------------------------------------------------------------------- cameras
SEEN = Intrinsics(160, 120, 150.0, 150.0, 79.5, 59.5)
ABOVE = Extrinsics.from_matrix(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 0.4))  # it looks straight down


def _look(session: Session) -> Log:
    for _ in range(30):
        session.tick()
    return session.log


def rendered_camera(request: pytest.FixtureRequest) -> Log:
    camera = simulated_camera(ABOVE, DepthToCloud(SEEN, ABOVE), latency=0.01)
    session = Session(camera, 5e-3, own="in body")
    session.note()
    return _look(session)


def depth_camera(request: pytest.FixtureRequest) -> Log:
    pytest.importorskip("pyrealsense2", reason="the extra `realsense` is not installed")
    device = software_camera(SEEN)
    with (
        open_sensor(device.sensor, device.device) as stream,
        CloudWorker(stream.read, DepthToCloud(SEEN, ABOVE)) as worker,
    ):
        session = Session(DepthCameraSystem(worker, stale=60.0), 5e-3)
        session.note()
        device.show(told(plane_depth(SEEN, ABOVE)))
        ends = time.monotonic() + 20.0
        while not worker.latest and time.monotonic() < ends:
            time.sleep(2e-3)
        return _look(session)
