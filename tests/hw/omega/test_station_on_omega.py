"""Set-up 1 with the emulated device in the operator's hand, tick by tick on the device's own clock."""

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.diagrams.stations.device_options import Omega
from mmt_drake.diagrams.stations.devices import Hand
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.errors import BadInput
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety.limits import SafetyLimits
from mmt_drake.recording import load

PERIOD = 1e-3
TICKS = 900


class Session:
    """A station, whose hand a person arms at tick 20."""

    def __init__(self, omega: EmulatedOmega, scenario: Scenario, record: Path) -> None:
        self.omega, self.told = omega, list[str]()
        device = scenario.operator_device
        self.hand = Hand(device, scenario.step, clock=lambda: omega.get("clock"))
        self.station: Station = build_station(
            scenario, record=record, devices=Devices(self.hand), tell=self.told.append
        )
        self.simulator = Simulator(self.station.diagram)
        self.simulator.Initialize()
        self.tick = 0

    def go(self, ticks: int) -> np.ndarray:
        """(ticks, 6) at each tick where the library was read, and what the motors were told."""
        seen = []
        for _ in range(ticks):
            if self.tick == 20:
                self.hand.switch.arm()
            # Up to the next tick and not into it.
            self.simulator.AdvanceTo((self.tick + 0.5) * PERIOD)
            self.omega.advance(PERIOD)
            seen.append(np.concatenate([self.omega.vector("read"), self.omega.vector("applied")]))
            self.tick += 1
        return np.array(seen)


@pytest.fixture
def session(omega: EmulatedOmega, tmp_path: Path) -> Iterator[Session]:
    omega.set(target_z=-0.02, swing_x=0.02, swing_y=0.015, swing_z=0.012, swing_hz=2.3)
    changes = ["estimator=!OutputErrorOptions {}", "operator_device.device=0", "environment.cloud.points=2000"]
    session = Session(omega, load_scenario("setup1", changes), tmp_path / "out.mcap")
    with session.station:
        yield session


def test_each_row_is_what_was_read_and_sent_in_its_tick(session: Session, tmp_path: Path) -> None:
    """And so the force that a reading is answered with is sent in the very same tick."""
    seen = session.go(TICKS)
    session.station.__exit__(None, None, None)
    columns = load(tmp_path / "out.mcap").columns
    at = np.column_stack([columns[f"master_position_{axis}"] for axis in "xyz"])
    sent = np.column_stack([columns[f"applied_force_{axis}"] for axis in "xyz"])
    rendered = np.column_stack([columns[f"rendered_force_{axis}"] for axis in "xyz"])
    origin = session.station.scenario.operator_device.origin
    assert len(at) == TICKS
    np.testing.assert_allclose(at, seen[:, :3] + origin, atol=1e-12)
    np.testing.assert_allclose(sent, seen[:, 3:], atol=1e-12)
    limits = session.station.scenario.operator_device.limits
    free = (columns["safety_armed"] == 1.0) & (np.linalg.norm(rendered, axis=1) < 0.5 * limits.force)
    risen = np.arange(TICKS) > 20 + 1e3 * limits.rise + 100
    assert (free & risen).sum() > 200 and np.abs(sent[free & risen]).max() > 0.5
    np.testing.assert_allclose(sent[free & risen], rendered[free & risen], atol=1e-12)


def test_a_device_that_reads_nonsense_is_stopped_in_20_ms_and_says_so(session: Session) -> None:
    assert np.abs(session.go(TICKS)[-1, 3:]).max() > 0.1
    session.omega.set(nan_position=1.0)
    assert not session.go(60)[20:, 3:].any()
    assert [line.partition(": ")[2] for line in session.told] == [
        "stopped: not armed yet; ready to arm",
        "armed",
        "stopped: the device reports a fault",
    ]


def test_the_device_is_at_rest_before_the_recording_is_completed(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert np.abs(session.go(TICKS)[-1, 3:]).max() > 0.1
    left: list[np.ndarray] = []
    recorder = session.station.recorder
    assert recorder is not None
    close = recorder.close

    def look_and_close(**how: bool) -> None:
        session.omega.advance(PERIOD)
        left.append(session.omega.vector("applied"))
        close(**how)

    monkeypatch.setattr(recorder, "close", look_and_close)
    session.station.__exit__(None, None, None)
    assert not np.any(left[0]) and len(left) == 1


def test_a_hand_whose_limits_cannot_be_kept_leaves_the_device_closed(omega: EmulatedOmega) -> None:
    scenario = load_scenario("setup1", ["step=0.008", "operator_device.device=0"])
    with pytest.raises(BadInput, match="ramp"):
        Hand(scenario.operator_device, scenario.step)
    with Hand(scenario.operator_device, 1e-3) as hand:
        assert hand.name == "emulated omega.7"


class _Socket:
    """A network in memory, which a test may cut."""

    def __init__(self, out: list[bytes], back: list[bytes], cut: threading.Event) -> None:
        self._out, self._back, self._cut = out, back, cut

    def send(self, datagram: bytes) -> bool:
        if not self._cut.is_set():
            self._out.append(datagram)
        return True

    def receive(self) -> bytes | None:
        return self._back.pop(0) if self._back else None

    def close(self) -> None:
        """Nothing is open."""


def test_a_hand_whose_telerobot_is_lost_feels_nothing_20_ms_after_the_timeout_until_a_person_arms_again(
    omega: EmulatedOmega,
) -> None:
    pytest.importorskip("cryptography", reason="the extra `link` is not installed")
    from mmt_drake.diagrams.stations.two_sides import build_side
    from mmt_drake.hw.link.link import Link
    from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions

    omega.set(target_z=-0.02, swing_y=0.015, swing_z=0.012, swing_hz=2.3)
    changes = ["estimator=!OutputErrorOptions {}", "operator_device.device=0", "environment.cloud.points=2000"]
    scenario, cut, key = load_scenario("setup1", changes), threading.Event(), bytes(range(32))
    there: list[bytes] = []
    back: list[bytes] = []
    sockets = {OPERATOR: _Socket(there, back, cut), TELEROBOT: _Socket(back, there, cut)}
    options = LinkOptions(timeout=0.05)
    clock = lambda: 10**9 + round(1e9 * omega.get("clock"))  # noqa: E731

    def open_link(role, signals, agreed):
        return Link(role, signals, key, sockets[role], options, scenario=agreed, clock=clock)

    watched = {"peer": options.timeout}
    with Hand(scenario.operator_device, 1e-3, watched, clock=lambda: omega.get("clock")) as hand:
        sides = [
            build_side(scenario, OPERATOR, open_link, devices=Devices(hand)),
            build_side(scenario, TELEROBOT, open_link),
        ]
        simulators = [Simulator(side.diagram) for side in sides]
        force = []
        for tick in range(1600):
            if tick in (100, 1200):
                hand.switch.arm()
            if tick == 1500:
                assert sides[1].link.age < 5e-3
                hand.switch.stop()
            if tick == 800:
                cut.set()
            if tick == 1000:
                cut.clear()
            for simulator in simulators:
                simulator.AdvanceTo((tick + 0.5) * PERIOD)
            omega.advance(PERIOD)
            force.append(np.linalg.norm(omega.vector("applied")))
        for side in sides:
            side.__exit__(None, None, None)
    felt = np.array(force)
    assert felt[500:800].max() > 1.0, "the object is felt"
    assert not felt[800 + 50 + 20 : 1200].any(), "silent, and not armed by itself when the peer is back"
    assert felt[1250:1500].max() > 1.0
    assert not felt[1500 + 20 :].any() and sides[0].link.alive
    assert sides[1].link.age > 0.09, "what an arm there would follow is told to be old from the stop on"


def test_the_limits_are_those_of_the_device_whatever_it_is_scaled_by(omega: EmulatedOmega) -> None:
    """10 N of the table would be 30 N at the handle, which moves at twice the table's speed."""
    omega.set(swing_y=-0.05, swing_hz=0.6, hand_stiffness=3000.0, hand_damping=60.0)
    limits = SafetyLimits(force=2.0, power=0.1)
    device = Omega(device=0, force=8.0, scale=0.5, force_scale=3.0, clutch_button=None, limits=limits)
    builder, told, power = DiagramBuilder(), [], []
    with Hand(device, PERIOD, clock=lambda: omega.get("clock")) as hand:
        builder.AddSystem(hand.system)
        source = builder.AddSystem(ConstantVectorSource([0.0, 10.0, 0.0]))
        builder.Connect(source.get_output_port(), hand.system.GetInputPort("force"))
        simulator = Simulator(builder.Build())
        for tick in range(1000):
            if tick == 20:
                hand.switch.arm()
            simulator.AdvanceTo((tick + 0.5) * PERIOD)
            omega.advance(PERIOD)
            told.append(omega.vector("applied"))
            power.append(told[-1] @ np.array([omega.get(f"v{axis}") for axis in "xyz"]))
    force = np.linalg.norm(told, axis=1)
    assert 1.9 < force.max() <= 2.0 * (1 + 1e-9)
    assert 0.095 < max(power) < 0.11, "but for the window of the velocity, which is 5 ms late"
