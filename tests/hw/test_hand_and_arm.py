"""A station on both devices, by their own clocks: what is wrong with one stops the other."""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.faults.franka import SETTINGS
from mmt_drake.diagrams.proof.faults.patient_clock import PatientClock
from mmt_drake.diagrams.stations.devices import ARMING, Hand, RemoteArm
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.errors import BadInput
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety.reasons import Reason

STEP = 2e-3
REST = round(1e3 * SETTINGS.stop_within) + 150  # [ms] of the robot, and what a busy machine needs to see a fault


class Bench:
    """A station that is stepped by the wall's clock."""

    def __init__(self, omega: EmulatedOmega, franka: EmulatedFranka) -> None:
        self.omega, self.franka = omega, franka
        omega.set(real_time=1.0, target_y=0.01, swing_y=0.01, swing_hz=0.5)
        scenario = load_scenario("setup3", [f"step={STEP}", "clouds=none"])
        device = replace(scenario.operator_device, device=0, watchdog=None)
        settings = {name: getattr(SETTINGS, name) for name in ("realtime", "table", "low", "high", "gap", "hold_after")}
        self.arm = RemoteArm(replace(scenario.telerobot_device, address=franka.address, **settings), STEP)
        origin = tuple(self.arm.system.GetOutputPort("motion").Eval(self.arm.system.CreateDefaultContext())[:3])
        watched = {"arm": self.arm.oldest}
        self.hand = Hand(replace(device, origin=origin), STEP, watched, press=ARMING, supervisor_clock=PatientClock())
        self.station = build_station(scenario, devices=Devices(self.hand, self.arm))
        self.simulator = Simulator(self.station.diagram)

    def until(self, done: Callable[[], bool], within: float = 5.0) -> bool:
        start, began = self.simulator.get_context().get_time(), time.monotonic()
        tick = 0
        while time.monotonic() - began < within:
            tick += 1
            self.simulator.AdvanceTo(start + tick * STEP)
            if done():
                return True
            time.sleep(max(0.0, began + tick * STEP - time.monotonic()))
        return False

    def status(self) -> np.ndarray:
        """(6) of the hand's supervisor."""
        context = self.hand.system.GetMyContextFromRoot(self.simulator.get_context())
        return self.hand.system.GetOutputPort("status").Eval(context)

    def fault(self) -> float:
        """Of the arm."""
        return float(self.arm.system._driver.latest.device[0])

    def both(self) -> bool:
        """Both run after one press, or after another: an arm may refuse once, as a real one does."""
        self.until(lambda: True)  # a press before the first tick would be none
        return any(self._pressed() for _ in range(3))

    def _pressed(self) -> bool:
        self.hand.switch.arm()
        return self.until(lambda: self.status()[0] == 1.0 and self.fault() == 0.0, ARMING)


@pytest.fixture
def bench(omega: EmulatedOmega, franka: EmulatedFranka) -> Iterator[Bench]:
    made = Bench(omega, franka)
    with made.station:
        yield made


def test_one_press_arms_both_and_a_lost_hand_stops_the_arm(bench: Bench) -> None:
    assert bench.both()
    assert bench.until(lambda: bench.franka.get()["moving"])
    bench.omega.set(failing=1e9, error=1.0)
    since = bench.franka.get()["ticks"]
    assert bench.until(lambda: bench.fault() == ArmFault.SETPOINTS_LOST)
    assert bench.until(lambda: not bench.franka.get()["moving"])
    assert bench.franka.get()["ticks"] - since <= REST
    assert bench.status()[0] == 0.0 and bench.status()[1] == Reason.DEVICE_FAULT
    bench.omega.set(failing=0.0)
    assert bench.until(lambda: bench.status()[2] == Reason.STALE)
    assert bench.both(), "a person starts both again"


def test_an_arm_that_stops_is_no_longer_felt_and_a_stop_of_the_hand_s_switch_stops_both(bench: Bench) -> None:
    assert bench.both()
    bench.franka.set(reflex=6)
    assert bench.until(lambda: bench.fault() == ArmFault.REFLEX)
    assert bench.until(lambda: bench.status()[0] == 0.0, 0.1) and bench.status()[1] == Reason.STALE
    assert bench.both(), "the reflex is recovered from"
    bench.hand.switch.stop()
    assert bench.until(lambda: bench.fault() == ArmFault.EMERGENCY_STOP and bench.status()[0] == 0.0)
    assert bench.until(lambda: not bench.franka.get()["moving"])


def test_the_end_of_a_station_brings_both_to_rest(bench: Bench) -> None:
    assert bench.both() and bench.until(lambda: bench.franka.get()["moving"])
    bench.station.__exit__(None, None, None)
    told = bench.franka.get()
    assert not told["moving"] and np.abs(told["dq"]).max() < 0.02
    bench.omega.update()
    assert not bench.omega.vector("applied").any()


def test_an_arm_without_a_hand_on_a_device_is_refused(franka: EmulatedFranka) -> None:
    scenario = load_scenario("setup3", ["telerobot_device.realtime=ignore"])
    device = replace(scenario.telerobot_device, address=franka.address)
    told = pytest.raises(BadInput, match="found an arm, expected a hand on a device")
    with RemoteArm(device, 1e-3) as arm, told:
        build_station(scenario, devices=Devices(arm=arm))
