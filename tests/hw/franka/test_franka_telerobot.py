"""The driver as a system: the ports of its simulated twin, and nothing waits."""

import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.diagrams.proof.faults.franka import SETTINGS
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.franka.telerobot import FrankaTelerobot
from mmt_drake.hw.safety.operator_switch import OperatorSwitch

sys.path.append(str(Path(__file__).resolve().parents[2] / "systems"))
import contract

PERIOD = 2e-3


@pytest.fixture
def telerobot(franka: EmulatedFranka) -> Iterator[FrankaTelerobot]:
    with FrankaTelerobot(replace(SETTINGS, address=franka.address), period=PERIOD) as telerobot:
        yield telerobot


def test_it_has_the_documented_ports(telerobot: FrankaTelerobot) -> None:
    block = contract.documented_ports(FrankaTelerobot)
    assert block["name"] == "FrankaTelerobot"
    assert block["input_ports"] == contract.inputs(telerobot)
    assert block["output_ports"] == contract.outputs(telerobot)


def paced(simulator: Simulator, seconds: float) -> None:
    began, now = time.monotonic(), simulator.get_context().get_time()
    for i in range(1, round(seconds / PERIOD) + 1):
        simulator.AdvanceTo(now + i * PERIOD)
        time.sleep(max(0.0, began + i * PERIOD - time.monotonic()))


def wired(builder: DiagramBuilder, telerobot: FrankaTelerobot, commanded: np.ndarray) -> OperatorSwitch:
    """The arm with a constant set-point that is from now, and a switch, which is given back."""
    switch = OperatorSwitch(period=PERIOD)
    for system in (telerobot, switch):
        builder.AddSystem(system)
    for name, value in (("commanded", commanded), ("age", [0.0])):
        source = builder.AddNamedSystem(name, ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), telerobot.GetInputPort(name))
    builder.Connect(switch.GetOutputPort("switches"), telerobot.GetInputPort("switches"))
    return switch


def test_ticks_carry_setpoints_out_and_readings_in_and_an_old_setpoint_or_a_switch_stops_it(
    franka: EmulatedFranka, telerobot: FrankaTelerobot
) -> None:
    here = telerobot.GetOutputPort("motion").Eval(telerobot.CreateDefaultContext())[:3]
    builder = DiagramBuilder()
    switch = wired(builder, telerobot, np.concatenate([here + np.array([0.0, 0.02, 0.0]), np.zeros(3)]))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = telerobot.GetMyContextFromRoot(simulator.get_context())

    def out(name: str) -> np.ndarray:
        return telerobot.GetOutputPort(name).Eval(context).copy()

    paced(simulator, 0.1)
    assert out("device")[0] == ArmFault.NOT_IN_CONTROL

    def armed() -> bool:
        switch.arm()
        for _ in range(50):
            paced(simulator, 0.1)
            if out("device")[2] == 0.0:
                return True
        return False

    assert armed()
    assert out("device")[0] == ArmFault.NONE and out("device")[2] == 0.0
    paced(simulator, 0.5)
    assert out("motion")[1] - here[1] == pytest.approx(0.02, abs=6e-3)
    franka.set(bias=(0.5, 0.0, 2.0))
    paced(simulator, 0.1)
    np.testing.assert_allclose(out("raw_measurement")[6:], [0.5, 0.0, 2.0], atol=1e-5)
    np.testing.assert_array_equal(out("raw_measurement")[:6], out("motion"))

    switch.stop()
    paced(simulator, 0.3)
    assert out("device")[0] == ArmFault.EMERGENCY_STOP and not franka.get()["moving"]
    switch.release()
    paced(simulator, 0.1)
    assert armed()

    source = diagram.GetSubsystemByName("age")
    age = source.get_mutable_source_value(source.GetMyMutableContextFromRoot(simulator.get_mutable_context()))
    age.SetFromVector([SETTINGS.stop_after + 0.1])
    paced(simulator, SETTINGS.stop_after + 0.2)
    assert out("device")[0] == ArmFault.SETPOINTS_LOST


def test_probe_compensation_takes_the_offset_off_what_it_reads(
    franka: EmulatedFranka, telerobot: FrankaTelerobot
) -> None:
    probe = pytest.importorskip("mmt_drake.systems.probe_compensation", reason="no probe compensation here")
    franka.set(bias=(0.4, -0.7, 1.1))
    builder = DiagramBuilder()
    clear = builder.AddSystem(probe.ProbeCompensation(probe.ProbeOptions(step=PERIOD)))
    wired(builder, telerobot, np.zeros(6))
    free = builder.AddSystem(ConstantVectorSource([0.0]))
    high = builder.AddSystem(ConstantVectorSource([0.1]))
    builder.Connect(high.get_output_port(), clear.GetInputPort("clearance"))
    builder.Connect(free.get_output_port(), clear.GetInputPort("in_contact"))
    builder.Connect(telerobot.GetOutputPort("raw_measurement"), clear.GetInputPort("raw_measurement"))
    simulator = Simulator(builder.Build())
    paced(simulator, 0.5)
    context = clear.GetMyContextFromRoot(simulator.get_context())
    np.testing.assert_allclose(clear.GetOutputPort("offset").Eval(context), [0.4, -0.7, 1.1], atol=1e-3)
    np.testing.assert_allclose(clear.GetOutputPort("measurement").Eval(context)[6:], 0.0, atol=1e-3)
