"""The driver as a system: read, felt, limited, watched, and at rest whatever happens."""

import gc
from collections.abc import Iterator
from dataclasses import replace

import contract
import numpy as np
import pytest
from pydrake.systems.framework import System

from mmt_drake.diagrams.proof.faults.injection import PERIOD
from mmt_drake.diagrams.proof.faults.omega import SETTINGS, OmegaRig
from mmt_drake.hw.errors import DeviceError
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.omega.faults import HandFault, describe_fault
from mmt_drake.hw.omega.operator import OmegaOperator
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.hw.safety.supervised import supervised
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.systems.scripted_operator import ScriptedOperator


@pytest.fixture
def rig(omega: EmulatedOmega) -> Iterator[OmegaRig]:
    rig = OmegaRig(omega)
    yield rig
    rig.close()


def ports(system: System) -> dict[str, int]:
    given = {f"in {name}": system.GetInputPort(name).size() for name in contract.inputs(system)}
    return given | {f"out {name}": system.GetOutputPort(name).size() for name in contract.outputs(system)}


def test_it_has_the_ports_of_a_simulated_hand_and_one_about_itself(omega: EmulatedOmega) -> None:
    with OmegaOperator(OmegaSettings(device=0)) as real:
        simulated = ScriptedOperator(scripted_motion("strokes"))
        assert ports(real) == ports(simulated) | {"in force": 3, "out reported_motion": 6, "out device": 3}
        block = contract.documented_ports(OmegaOperator)
        assert block["name"] == "OmegaOperator"
        assert block["input_ports"] == contract.inputs(real) and block["output_ports"] == contract.outputs(real)


def test_behind_a_supervisor_it_has_the_ports_of_a_hand_and_what_becomes_of_its_force(omega: EmulatedOmega) -> None:
    with OmegaOperator(OmegaSettings(device=0)) as real:
        told = {"out motion": 6, "out status": 6, "out applied_force": 3, "out switches": 2}
        assert ports(supervised(real, watched={"peer": 0.1})) == {"in force": 3, "in ages": 1} | told


def test_the_force_sent_at_a_tick_answers_the_position_read_at_that_tick(rig: OmegaRig) -> None:
    """No tick lies between: what the motors do is the wall's force at the position that was read last."""
    assert rig.arm()
    errors = []
    for _ in range(100):
        before = rig.omega.vector("read")
        rig.go(1)
        read = rig.omega.vector("read")
        z, vz = rig.motion[2], rig.motion[5]
        assert z == pytest.approx(read[2] + 0.01, abs=1e-12) and not np.array_equal(before, read)
        expected = -400.0 * z - 2.0 * vz if z < 0 else 0.0
        errors.append(abs(rig.omega.get("applied_z") - expected))
    assert rig.status[3] == 0.0 and max(errors) < 1e-9


def test_the_hand_s_velocity_is_in_time_where_the_device_s_own_is_late(rig: OmegaRig) -> None:
    rig.omega.set(swing_y=0.02, swing_hz=3.0)
    rig.go(500)
    told: dict[str, list] = {"motion": [], "reported_motion": []}
    for _ in range(700):
        rig.go(1)
        context = rig.operator.GetMyContextFromRoot(rig.simulator.get_context())
        for port, rows in told.items():
            rows.append(rig.operator.GetOutputPort(port).Eval(context)[[1, 4]])
    motion, reported = (np.array(rows) for rows in told.values())
    true = (motion[2:, 0] - motion[:-2, 0]) / (2.0 * PERIOD)
    late, in_time = (np.std(found[1:-1, 1] - true) / np.std(true) for found in (reported, motion))
    assert in_time < 0.05 and late > 0.08


def test_a_jump_of_the_position_is_no_velocity_that_anyone_feels(rig: OmegaRig) -> None:
    rig.go(50)
    rig.omega.set(jump=0.009)
    for _ in range(12):
        rig.go(1)
        context = rig.operator.GetMyContextFromRoot(rig.simulator.get_context())
        felt, seen = (rig.operator.GetOutputPort(port).Eval(context)[3:] for port in ("motion", "reported_motion"))
        assert np.abs(felt - seen).max() <= 0.3


def test_without_a_person_there_is_no_force_and_with_one_the_wall_holds_the_hand(rig: OmegaRig) -> None:
    assert not rig.go(500).any()
    free = rig.motion[2]
    assert rig.arm()
    applied = rig.go(588)  # a period of the hand later
    assert rig.motion[2] > free + 0.002
    assert applied[:, 2].max() > 1.0


def test_a_force_that_is_not_supervised_is_still_limited_by_the_driver(omega: EmulatedOmega) -> None:
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder
    from pydrake.systems.primitives import ConstantVectorSource

    with OmegaOperator(replace(SETTINGS, force=3.0), clock=lambda: omega.get("clock")) as hand:
        builder = DiagramBuilder()
        builder.AddSystem(hand)
        source = builder.AddSystem(ConstantVectorSource([100.0, 0.0, 0.0]))
        builder.Connect(source.get_output_port(), hand.GetInputPort("force"))
        simulator = Simulator(builder.Build())
        for i in range(200):
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
        assert omega.get("applied_x") == pytest.approx(3.0) and omega.get("greatest_force") <= 3.0 + 1e-12
        source.get_mutable_source_value(
            source.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        ).SetFromVector([np.nan, 0.0, 0.0])
        for i in range(200, 203):
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
        assert not omega.vector("applied").any() and omega.get("not_finite") == 0.0
        context = hand.GetMyContextFromRoot(simulator.get_context())
        assert hand.GetOutputPort("device").Eval(context)[0] == HandFault.BAD_FORCE


def test_a_diagram_that_stops_ticking_is_cut_off_by_the_devices_watchdog(rig: OmegaRig) -> None:
    assert rig.arm()
    while not rig.omega.vector("applied").any():
        rig.go(1)
    rig.omega.advance(0.020)
    assert not rig.omega.vector("applied").any()
    assert not rig.go(30).any() and rig.status[0] == 0.0
    assert describe_fault(rig.device[0]) == "forces are off: watchdog"
    assert rig.arm(), "a person turns the motors on again"


def test_the_force_button_of_the_device_disarms(rig: OmegaRig) -> None:
    assert rig.arm()
    rig.omega.set(force_button=1.0)
    assert not rig.go(30).any() and rig.status[1] == Reason.DEVICE_FAULT
    assert describe_fault(rig.device[0]) == "forces are off: force button"
    rig.omega.set(force_button=0.0)
    assert not rig.go(50).any(), "pressed again it turns the motors on, not the force"
    assert rig.arm()


def test_the_clutch_moves_the_workspace(rig: OmegaRig) -> None:
    assert rig.arm()
    rig.omega.set(button=1.0)
    rig.go(12)  # the button is looked at every ten ticks
    before = rig.motion
    applied = rig.go(300)
    np.testing.assert_array_equal(rig.motion, [*before[:3], 0.0, 0.0, 0.0])
    assert not applied.any()
    rig.omega.set(button=0.0)
    moved = [rig.motion[:3]]
    rig.go(12, lambda i: moved.append(rig.motion[:3]))
    assert np.abs(np.diff(moved, axis=0)).max() < 3e-4, "it goes on where it was, without a jump"
    assert rig.status[0] == 1.0, rig.describe()


def test_a_closed_or_forgotten_device_is_at_rest(omega: EmulatedOmega) -> None:
    rig = OmegaRig(omega)
    assert rig.arm()
    rig.go(300)
    rig.close()
    omega.advance(PERIOD)
    assert not omega.vector("applied").any()
    del rig
    gc.collect()
    other = OmegaDevice(SETTINGS)  # it was given back
    other.start()
    other.set_force(np.array([2.0, 0.0, 0.0]))
    omega.advance(PERIOD)
    assert omega.get("applied_x") == 2.0
    del other
    gc.collect()
    omega.advance(PERIOD)
    assert not omega.vector("applied").any()


def test_a_hand_whose_run_was_forgotten_in_the_middle_is_at_rest(omega: EmulatedOmega) -> None:
    rig = OmegaRig(omega, settings=replace(SETTINGS, watchdog=None))
    assert rig.arm()
    rig.go(300)
    assert omega.vector("applied").any()
    del rig
    gc.collect()
    omega.advance(PERIOD)
    assert not omega.vector("applied").any()


def test_pose_and_force_can_be_asked_for(omega: EmulatedOmega) -> None:
    omega.set(target_x=0.02, hand_stiffness=500.0)
    with OmegaDevice(replace(SETTINGS, watchdog=None)) as device:
        device.start()
        device.set_force(np.array([0.0, 1.5, 0.0]))
        for _ in range(3):
            omega.advance(1.0)
        position, orientation = device.pose()
        np.testing.assert_allclose(position, [0.02, 0.003, 0.0], atol=1e-5)
        np.testing.assert_array_equal(orientation, np.eye(3))
        np.testing.assert_allclose(device.force(), [0.0, 1.5, 0.0])
        assert device.name == "emulated omega.7"


@pytest.mark.parametrize(
    "members, settings, told",
    [
        ({"connected": 0.0}, {}, "cannot open the device: no device found; is it plugged in"),
        ({"calibrated": 0.0}, {}, "not calibrated; put its pole into the calibration pit"),
        ({"no_watchdog": 1.0}, {}, r"watchdog \(set it to null for a device that has none\): not implemented"),
    ],
)
def test_a_device_that_cannot_be_set_up_says_what_to_do_and_is_given_back(
    omega: EmulatedOmega, members: dict[str, float], settings: dict[str, object], told: str
) -> None:
    omega.set(**members)
    with pytest.raises(DeviceError, match=told):
        OmegaDevice(replace(SETTINGS, **settings))  # type: ignore[arg-type]
    omega.set(connected=1.0, calibrated=1.0, no_watchdog=0.0)
    with OmegaDevice(SETTINGS), pytest.raises(DeviceError, match="in use by another program"):
        OmegaDevice(SETTINGS)


def test_calibration_is_automatic_only_where_that_is_asked_for(omega: EmulatedOmega) -> None:
    omega.set(calibrated=0.0)
    OmegaDevice(replace(SETTINGS, calibration="none")).close()
    assert omega.get("calibrated") == 0.0
    OmegaDevice(replace(SETTINGS, calibration="automatic")).close()
    assert omega.get("calibrated") == 1.0


def test_two_devices_run_side_by_side(omega: EmulatedOmega, second_omega: EmulatedOmega) -> None:
    with OmegaDevice(SETTINGS) as first, OmegaDevice(replace(SETTINGS, device=1)) as second:
        for device, force in ((first, 1.0), (second, 2.0)):
            device.start()
            device.set_force(np.array([force, 0.0, 0.0]))
        omega.advance(PERIOD)
        second_omega.advance(PERIOD)
        assert (omega.get("applied_x"), second_omega.get("applied_x")) == (1.0, 2.0)


def test_a_diagram_starts_where_the_hand_is(omega: EmulatedOmega) -> None:
    omega.set(x=0.03, y=-0.02, z=0.01)
    with OmegaOperator(SETTINGS, clock=lambda: omega.get("clock")) as hand:
        motion = hand.GetOutputPort("motion").Eval(hand.CreateDefaultContext())
        np.testing.assert_allclose(motion, [0.03, -0.02, 0.02, 0.0, 0.0, 0.0], atol=1e-12)
        assert not omega.vector("applied").any() and omega.get("sets") == 0.0, "the motors are still off"


def test_a_diagram_that_raises_leaves_no_force_on(omega: EmulatedOmega, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = OmegaRig(omega, replace(SETTINGS, watchdog=None))
    assert rig.arm()
    while not omega.vector("applied").any():
        rig.go(1)
    monkeypatch.setattr(rig.wall, "added", "no vector")
    with pytest.raises(Exception):  # noqa: B017 - Drake hands on whatever it was
        rig.go(1)
    omega.advance(PERIOD)
    assert not omega.vector("applied").any()
    rig.close()
