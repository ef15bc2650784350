"""The fast path in one system does what its parts do wired together, to the bit, and stops as they do."""

from __future__ import annotations

from dataclasses import replace

import contract
import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, System
from pydrake.systems.primitives import ConstantVectorSource

from mmt_drake.hw.haptic_path import HapticPath
from mmt_drake.hw.omega import OmegaDriver, OmegaOperator, OmegaSettings
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import OperatorSwitch, SafetyLimits, supervised
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.systems.impedance_reflection import ImpedanceReflection

PERIOD = 1e-3
SETTINGS = OmegaSettings(device=0, origin=(0.0, 0.0, 0.01))
LIMITS = SafetyLimits(rise=0.05)


class InContact(LeafSystem):
    """1 in turns of 70 ms, so that the object is touched and left."""

    def __init__(self) -> None:
        super().__init__()
        self.DeclareVectorOutputPort(
            "in_contact", 1, lambda context, out: out.SetFromVector([float(context.get_time() % 0.14 < 0.07)])
        )


def model_sources(builder: DiagramBuilder, user: System) -> None:
    theta = builder.AddSystem(ConstantVectorSource(FlexibleBoxModel().theta()))
    stable, contact = builder.AddSystem(ConstantVectorSource([1.0])), builder.AddSystem(InContact())
    for source, name in ((theta, "theta"), (stable, "stable"), (contact, "in_contact")):
        builder.Connect(source.get_output_port(), user.GetInputPort(name))


def run(omega: EmulatedOmega, diagram: Diagram, switch: OperatorSwitch, ticks: int) -> np.ndarray:
    """What the motors do, and where the handle is, at every tick (ticks, 6)."""
    simulator = Simulator(diagram)
    simulator.Initialize()
    seen = []
    for i in range(ticks):
        if i == 20:
            switch.arm()
        if i == ticks - 60:
            omega.set(nan_position=1.0)
        simulator.AdvanceTo(i * PERIOD)
        omega.advance(PERIOD)
        seen.append(np.concatenate([omega.vector("applied"), omega.vector("")]))
    return np.array(seen)


def moved_hand(omega: EmulatedOmega) -> None:
    omega.reset()
    omega.set(target_z=-0.02, swing_x=0.02, swing_y=0.015, swing_z=0.012, swing_hz=2.3)


def grouped(omega: EmulatedOmega) -> tuple[Diagram, OperatorSwitch, HapticPath]:
    builder = DiagramBuilder()
    path = builder.AddSystem(HapticPath(OmegaDriver(SETTINGS, clock=lambda: omega.get("clock")), LIMITS))
    switch = builder.AddSystem(OperatorSwitch(clock=lambda: omega.get("clock")))
    model_sources(builder, path)
    builder.Connect(switch.get_output_port(), path.GetInputPort("switches"))
    return builder.Build(), switch, path


def modular(omega: EmulatedOmega) -> tuple[Diagram, OperatorSwitch, OmegaOperator]:
    builder = DiagramBuilder()
    hand = OmegaOperator(SETTINGS, clock=lambda: omega.get("clock"))
    switch = OperatorSwitch(clock=lambda: omega.get("clock"))
    safe = builder.AddSystem(supervised(hand, LIMITS, switch=switch))
    renderer = builder.AddSystem(ImpedanceReflection())
    model_sources(builder, renderer)
    builder.Connect(safe.GetOutputPort("motion"), renderer.GetInputPort("motion"))
    builder.Connect(renderer.GetOutputPort("force"), safe.GetInputPort("force"))
    return builder.Build(), switch, hand


def test_it_does_what_its_parts_do_to_the_bit(omega: EmulatedOmega) -> None:
    moved_hand(omega)
    diagram, switch, hand = modular(omega)
    expected = run(omega, diagram, switch, 700)
    hand.close()
    moved_hand(omega)
    diagram, switch, path = grouped(omega)
    with path:
        np.testing.assert_array_equal(run(omega, diagram, switch, 700), expected)
    assert np.abs(expected[:, :3]).max() > 1.0, "nothing was felt"
    assert expected[630, :3].any() and not expected[660:, :3].any(), "the fault at tick 640 stops it"


def test_its_ports_are_those_of_the_docstring_and_show_the_latest_tick(omega: EmulatedOmega) -> None:
    moved_hand(omega)
    diagram, switch, path = grouped(omega)
    with path:
        block = contract.documented_ports(HapticPath)
        assert [name for name in block["input_ports"] if name != "ages"] == contract.inputs(path)
        assert block["output_ports"] == contract.outputs(path)
        simulator = Simulator(diagram)
        for i in range(300):
            if i == 20:
                switch.arm()
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
        context = path.GetMyContextFromRoot(simulator.get_context())
        shown = {name: path.GetOutputPort(name).Eval(context) for name in contract.outputs(path)}
        np.testing.assert_allclose(shown["motion"][:3], omega.vector("read") + SETTINGS.origin, atol=1e-15)
        np.testing.assert_array_equal(shown["force"], omega.vector("applied"))
        assert shown["status"][0] == 1.0 and shown["device"][0] == 0.0
        parts = [shown[name] for name in ("motion", "force", "rendered_force", "status", "device")]
        np.testing.assert_array_equal(np.concatenate(parts), shown["readout"])


def test_a_lost_peer_stops_it(omega: EmulatedOmega) -> None:
    moved_hand(omega)
    driver = OmegaDriver(SETTINGS, clock=lambda: omega.get("clock"))
    builder = DiagramBuilder()
    path = builder.AddSystem(HapticPath(driver, LIMITS, watched={"peer": 0.05}))
    switch = builder.AddSystem(OperatorSwitch(clock=lambda: omega.get("clock")))
    age = builder.AddSystem(ConstantVectorSource([0.01]))
    model_sources(builder, path)
    builder.Connect(switch.get_output_port(), path.GetInputPort("switches"))
    builder.Connect(age.get_output_port(), path.GetInputPort("ages"))
    simulator = Simulator(builder.Build())
    applied = []
    with path:
        for i in range(400):
            if i == 20:
                switch.arm()
            if i == 350:
                values = age.get_mutable_source_value(age.GetMyMutableContextFromRoot(simulator.get_mutable_context()))
                values.SetFromVector([0.06])
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
            applied.append(omega.vector("applied"))
    assert np.any(applied[349]) and not np.any(applied[370:])


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e12])
def test_a_renderer_that_runs_away_is_stopped_or_limited(omega: EmulatedOmega, bad: float) -> None:
    moved_hand(omega)
    wild = False

    def renderer(t, motion, theta, stable, in_contact, force) -> None:
        force[:] = bad if wild else 0.5

    driver = OmegaDriver(SETTINGS, clock=lambda: omega.get("clock"))
    builder = DiagramBuilder()
    path = builder.AddSystem(HapticPath(driver, LIMITS, renderer=renderer))
    switch = builder.AddSystem(OperatorSwitch(clock=lambda: omega.get("clock")))
    model_sources(builder, path)
    builder.Connect(switch.get_output_port(), path.GetInputPort("switches"))
    simulator = Simulator(builder.Build())
    with path:
        for i in range(400):
            if i == 20:
                switch.arm()
            wild = i >= 300
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
            if i == 299:
                assert omega.get("applied_x") == 0.5
        assert omega.get("greatest_force") <= LIMITS.force * (1 + 1e-9) and omega.get("not_finite") == 0.0
        assert np.isfinite(bad) or not omega.vector("applied").any()


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
def test_a_renderer_that_raises_leaves_no_force_on(omega: EmulatedOmega, error: type[BaseException]) -> None:
    """Also where the device has no watchdog of its own."""
    moved_hand(omega)
    fails = False

    def renderer(t, motion, theta, stable, in_contact, force) -> None:
        force[:] = 0.5
        if fails:
            raise error

    driver = OmegaDriver(replace(SETTINGS, watchdog=None), clock=lambda: omega.get("clock"))
    builder = DiagramBuilder()
    path = builder.AddSystem(HapticPath(driver, LIMITS, renderer=renderer))
    switch = builder.AddSystem(OperatorSwitch(clock=lambda: omega.get("clock")))
    model_sources(builder, path)
    builder.Connect(switch.get_output_port(), path.GetInputPort("switches"))
    simulator = Simulator(builder.Build())
    with path:
        for i in range(300):
            if i == 20:
                switch.arm()
            simulator.AdvanceTo(i * PERIOD)
            omega.advance(PERIOD)
        assert omega.get("applied_x") == 0.5
        fails = True
        with pytest.raises(error):
            simulator.AdvanceTo(0.302)
        omega.advance(PERIOD)
        assert not omega.vector("applied").any()
