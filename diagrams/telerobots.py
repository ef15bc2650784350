"""Between what is commanded and what is measured: nothing, a simulated arm, or a device; all are wired alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ConstantValueSource, MatrixGain

from diagrams.arm import Arm, simulated_arm
from diagrams.ports import join, split
from diagrams.station_live import Columns
from hw.safety import WhileWell
from mmt_drake.cloud import Cloud
from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.network.config import ChannelConfig
from mmt_drake.systems import compliant_tip
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.systems.compliant_tip import TipSettings
from mmt_drake.systems.network_channel import network_channel

Array = NDArray[np.float64]

_PROBE = ProbeOptions(mass=0.15, weight=(0.0, 0.0, -0.15 * 9.81))
# What a telerobot measures comes late through its compensation, and with it whatever is made of it.
_OF_THE_MEASUREMENT = ("position", "detected_contact", "theta", "estimat", "filtered_force", "held_body")


@dataclass(frozen=True)
class CompliantTip(TipSettings):
    """The tip of an arm under impedance control, without the arm: `TipSettings`, and what is known of its probe.

    Attributes:
        compensation: what the force is cleared of; its `step` is the scenario's.
    """

    compensation: ProbeOptions = _PROBE


@dataclass(frozen=True)
class Panda(Arm):
    """A whole simulated arm: `Arm`, and what is known of its probe.

    Attributes:
        compensation: as that of a `CompliantTip`.
    """

    compensation: ProbeOptions = _PROBE


def simulated_telerobot(chosen: CompliantTip | Panda, start: Array, step: float, seed: int) -> System:
    """A telerobot at rest with its tip at `start` (3) [m]; ports as of `diagrams.arm.simulated_arm`.

    Args:
        chosen: which one.
        start: in the table frame.
        step: of the simulation [s].
        seed: added to that of its sensors.

    Raises:
        MissingDependency: the model of a whole arm is not installed.
    """
    noise = chosen.sensor.noise
    chosen = replace(chosen, sensor=replace(chosen.sensor, noise=replace(noise, seed=noise.seed + seed)))
    if isinstance(chosen, CompliantTip):
        return compliant_tip.CompliantTip(chosen, start, period=step)
    return simulated_arm(chosen, start, step)


def shown_first(system: System, port: str) -> Array:
    """What a system shows on a port before anything happens."""
    value: Array = system.GetOutputPort(port).Eval(system.CreateDefaultContext())
    return value


def rests_at(telerobot: System) -> Array:
    """(3) where a telerobot's tip is before anything moves [m]."""
    return shown_first(telerobot, "motion")[:3]


def still_surface(surface: Cloud) -> Diagram:
    """What stands for the environment where the object is a real one: its top as it was measured, `point_cloud`."""
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantValueSource(AbstractValue.Make(surface)))
    builder.ExportOutput(source.get_output_port(), "point_cloud")
    diagram = builder.Build()
    diagram.set_name("still_surface")
    return diagram


class Remote(NamedTuple):
    """What the telerobot's side shows.

    Attributes:
        measurement: (9) position [m], velocity [m/s] and force [N], as measured.
        in_contact: (1) what the detector says, of the instant of the measurement,
        detected: (1) and of now; never while an arm has stopped.
        reading: (3) of the force sensor itself, of that instant, too; None where the force is what it reads.
        truth: what only a simulation knows, for the recording.
        proxy: (3) of the detector [m].
        zeroing: what becomes of the force sensor's offset, for the recording; of a telerobot alone.
    """

    measurement: OutputPort
    in_contact: OutputPort
    detected: OutputPort
    reading: OutputPort | None
    truth: Columns
    proxy: OutputPort
    zeroing: Columns = ()


def wire_remote(
    builder: DiagramBuilder,
    parts: Mapping[str, System],
    commanded: OutputPort,
    surface: OutputPort,
    impedance: Impedance | None = None,
) -> Remote:
    """Connect telerobot, environment and detector.

    Args:
        builder: with all parts in it.
        parts: the station's, by name: `environment`, `detector`, and for a telerobot `arm` and `compensation`.
        commanded: (6) where the tip should be; without a telerobot it is there.
        surface: its cloud.
        impedance: of a simulated telerobot, whose force on the tip is then among what is known.
    """
    box, detector, arm = parts["environment"], parts["detector"], parts.get("arm")
    tip = commanded
    if arm is not None:
        builder.Connect(commanded, arm.GetInputPort("commanded"))
        tip = arm.GetOutputPort("motion")
    builder.Connect(split(builder, tip, (3,))[0], detector.GetInputPort("position"))
    builder.Connect(surface, detector.GetInputPort("point_cloud"))
    detected, proxy, _, clearance = split(builder, detector.GetOutputPort("readout"), (1, 3, 1, 1))
    measurement: OutputPort | None = None
    truth: Columns = ()
    if box.HasInputPort("motion"):
        builder.Connect(tip, box.GetInputPort("motion"))
        # Of the body only the displacement, which comes before its rate.
        measurement, force, touches, body = split(builder, box.GetOutputPort("readout"), (9, 3, 1, 2))
        truth = ((force, ("true_force",)), (touches, ("in_contact",)), (body, ("body_position",)))
        if arm is not None:
            builder.Connect(force, arm.GetInputPort("force"))
    if arm is not None and impedance is not None:
        truth += ((_pull(builder, commanded, tip, impedance), ("command_force",)),)
    if arm is None:
        return Remote(measurement, detected, detected, None, truth, proxy)
    compensation = parts["compensation"]
    builder.Connect(arm.GetOutputPort("raw_measurement"), compensation.GetInputPort("raw_measurement"))
    builder.Connect(detected, compensation.GetInputPort("in_contact"))
    builder.Connect(clearance, compensation.GetInputPort("clearance"))
    if arm.HasOutputPort("device"):
        well = builder.AddNamedSystem("while_well", WhileWell(1))
        builder.Connect(detected, well.GetInputPort("signal"))
        builder.Connect(arm.GetOutputPort("device"), well.GetInputPort("device"))
        detected = well.GetOutputPort("signal")
    measurement, in_contact, _, reading, zero = split(builder, compensation.GetOutputPort("readout"), (9, 1, 3, 3, 1))
    return Remote(measurement, in_contact, detected, reading, truth, proxy, ((zero, ("probe_zero",)),))


def wire_estimator(builder: DiagramBuilder, remote: Remote, estimator: System) -> None:
    """Show an estimator what the telerobot's side measures, and what the sensor itself reads where it asks for that."""
    builder.Connect(remote.measurement, estimator.GetInputPort("measurement"))
    builder.Connect(remote.in_contact, estimator.GetInputPort("in_contact"))
    if remote.reading is not None and estimator.HasInputPort("reading"):
        builder.Connect(remote.reading, estimator.GetInputPort("reading"))


def _pull(builder: DiagramBuilder, commanded: OutputPort, tip: OutputPort, impedance: Impedance) -> OutputPort:
    """(3) F_com = K (x_d - x) + D (v_d - v), by which the controller pulls the tip [N]."""
    towards = np.hstack([impedance.stiffness * np.eye(3), impedance.damping * np.eye(3)])
    gain = builder.AddNamedSystem("pull", MatrixGain(np.hstack([towards, -towards])))
    builder.Connect(join(builder, (commanded, tip)), gain.get_input_port())
    return gain.get_output_port()


def of_one_instant(
    builder: DiagramBuilder, signals: Columns, ticks: int, step: float, initial: Mapping[str, Array]
) -> Columns:
    """Signals for a recording of which the measurement is so many ticks late: the others wait for it.

    Args:
        builder: of the station.
        signals: all of them.
        ticks: by how much the measurement is late.
        step: length of one [s].
        initial: by the first name of a port: what it has shown before the run; zeros unless given.
    """
    waiting = tuple((port, names) for port, names in signals if not names[0].startswith(_OF_THE_MEASUREMENT))
    before = [initial.get(names[0], np.zeros(port.size())) for port, names in waiting]
    late = ChannelConfig(delay=ticks * step)
    size = sum(port.size() for port, _ in waiting)
    beside = builder.AddNamedSystem("beside", network_channel(late, size, step, initial=np.concatenate(before)))
    builder.Connect(join(builder, tuple(port for port, _ in waiting)), beside.GetInputPort("sent"))
    shown = split(builder, beside.GetOutputPort("received"), tuple(port.size() for port, _ in waiting))
    left = iter(shown)
    return tuple((port if names[0].startswith(_OF_THE_MEASUREMENT) else next(left), names) for port, names in signals)
