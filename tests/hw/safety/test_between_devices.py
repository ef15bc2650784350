"""What one device tells another: how old its readings are, whether a hand is believed; and presses of a switch."""

import math

import contract
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from mmt_drake.hw.safety.ages import LOST, CameraAge, DeviceAge, HandAge
from mmt_drake.hw.safety.announcer import DeviceAnnouncer, SafetyAnnouncer
from mmt_drake.hw.safety.operator_switch import OperatorSwitch
from mmt_drake.hw.safety.rate_limiter import MotionRateLimiter
from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.hw.safety.supervisor import SafetySupervisor
from mmt_drake.hw.safety.while_well import WhileWell

SYSTEMS = {
    "MotionRateLimiter": lambda: MotionRateLimiter(np.zeros(3)),
    "DeviceAge": DeviceAge,
    "HandAge": HandAge,
    "CameraAge": CameraAge,
    "WhileWell": WhileWell,
    "DeviceAnnouncer": lambda: DeviceAnnouncer(print, "arm", str),
    "SafetyAnnouncer": lambda: SafetyAnnouncer(print),
    "SafetySupervisor": lambda: SafetySupervisor(watched={"peer": 0.1}),
    "OperatorSwitch": OperatorSwitch,
}


def shown(system: LeafSystem, output: str, **inputs: list[float]) -> np.ndarray:
    context = system.CreateDefaultContext()
    for name, value in inputs.items():
        system.GetInputPort(name).FixValue(context, value)
    return system.GetOutputPort(output).Eval(context).copy()


@pytest.mark.parametrize("name", SYSTEMS)
def test_ports_are_those_of_the_docstring(name: str) -> None:
    system = SYSTEMS[name]()
    block = contract.documented_ports(type(system))
    assert block["name"] == name
    assert (block.get("input_ports") or []) == contract.inputs(system)
    assert (block.get("output_ports") or []) == contract.outputs(system)


def test_a_device_is_as_old_as_its_reading_and_infinitely_old_with_a_fault() -> None:
    system = DeviceAge(clock=lambda: 12.5)
    assert shown(system, "age", device=[0.0, 12.48, 1.0]) == pytest.approx(0.02)
    assert shown(system, "age", device=[3.0, 12.48, 0.0]) == math.inf


@pytest.mark.parametrize("fault", [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
def test_a_camera_is_as_old_as_its_frame_and_lost_with_a_fault(fault: float) -> None:
    assert shown(CameraAge(), "age", camera=[fault, 0.04, 0.1]) == (LOST if fault else 0.04)


def test_a_device_grows_old_with_the_clock_although_nothing_changes_in_the_diagram() -> None:
    now = [5.0]
    system = DeviceAge(clock=lambda: now[0])
    simulator = Simulator(system)
    system.GetInputPort("device").FixValue(simulator.get_mutable_context(), [0.0, 5.0, 0.0])
    ages = []
    for tick in range(3):
        simulator.AdvanceTo(tick * 1e-3)
        ages.append(float(system.GetOutputPort("age").Eval(simulator.get_context())[0]))
        now[0] += 0.5
    assert ages == [0.0, 0.5, 1.0]


@pytest.mark.parametrize("armed", [0.0, 1.0])
@pytest.mark.parametrize("present", [*Reason, Reason.STALE + 3])
def test_a_hand_is_believed_unless_the_supervisor_finds_something_wrong_with_it(present: int, armed: float) -> None:
    """Not what is wrong with the force, or with the very arm that asks."""
    of_others = {Reason.NONE, Reason.NOT_ARMED, Reason.COMMAND_NOT_FINITE, Reason.OVERRUN}
    age = shown(HandAge(), "age", status=[armed, float(Reason.SPEED), float(present), 0.0, 0.0, 2.0])
    assert age == (0.0 if present in of_others or present >= Reason.STALE else math.inf)


def test_what_a_stopped_device_says_is_taken_back() -> None:
    system = WhileWell()
    assert shown(system, "signal", signal=[1.0], device=[0.0, 1.0, 1.0]) == 1.0
    for said in (1.0, math.nan):
        assert shown(system, "signal", signal=[said], device=[4.0, 1.0, 1.0]) == 0.0


def test_a_person_is_told_of_a_fault_once_and_when_it_is_gone() -> None:
    told: list[str] = []
    system = DeviceAnnouncer(told.append, "arm", {0.0: "well", 2.0: "lost"}.__getitem__)
    simulator = Simulator(system)
    device = system.GetInputPort("device")
    for tick, fault in enumerate([2.0, 2.0, 2.0, 0.0, 0.0]):
        device.FixValue(simulator.get_mutable_context(), [fault, 0.02 * tick, 0.0])
        simulator.AdvanceTo(0.02 * tick + 0.005)
    assert told == ["0.00 s: arm: lost", "0.06 s: arm: well"]


def test_a_press_during_a_long_press_is_one_of_its_own() -> None:
    now = [0.0]
    switch = OperatorSwitch(period=0.01, press=3.0, clock=lambda: now[0])
    simulator = Simulator(switch)
    seen = []
    for tick in range(6):
        if tick in (1, 3):
            switch.arm()
        simulator.AdvanceTo(0.01 * tick + 0.005)
        seen.append(float(switch.GetOutputPort("switches").Eval(simulator.get_context())[0]))
    assert seen == [0.0, 1.0, 1.0, 0.0, 1.0, 1.0]
    now[0] = 4.0
    simulator.AdvanceTo(0.07)
    assert switch.GetOutputPort("switches").Eval(simulator.get_context())[0] == 0.0


def test_a_press_before_the_run_has_begun_arms_nothing_and_a_stop_counts() -> None:
    switch = OperatorSwitch(period=0.01, press=3.0, clock=lambda: 0.0)
    simulator = Simulator(switch)

    def seen() -> list[float]:
        simulator.AdvanceTo(simulator.get_context().get_time() + 0.05)
        return list(switch.GetOutputPort("switches").Eval(simulator.get_context()))

    switch.arm()
    assert seen() == [0.0, 0.0]
    switch.arm()
    assert seen() == [1.0, 0.0]
    switch, enabled = OperatorSwitch(on_arm=lambda: enabled.append(True)), list[bool]()
    simulator = Simulator(switch)
    switch.stop()
    assert seen() == [0.0, 1.0]
    switch.arm()
    assert seen() == [0.0, 1.0] and not enabled, "nor are motors turned on while the stop is pressed"
