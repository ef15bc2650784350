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

from mmt_drake.cloud import Cloud
from mmt_drake.diagrams.arm import Arm, simulated_arm
from mmt_drake.diagrams.ports import join, shown_first, split
from mmt_drake.diagrams.station_live import Columns
from mmt_drake.estimation import thesis as rls
from mmt_drake.estimation.output_error import places as output_error
from mmt_drake.estimation.probe import ProbeOptions
from mmt_drake.hw.safety import WhileWell
from mmt_drake.systems import compliant_tip
from mmt_drake.systems.cartesian_impedance import Impedance
from mmt_drake.systems.compliant_tip import TipSettings

Array = NDArray[np.float64]

_PROBE = ProbeOptions(mass=0.15, weight=(0.0, 0.0, -0.15 * 9.81))


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
    """A telerobot at rest with its tip at `start` (3) [m]; ports as of `mmt_drake.diagrams.arm.simulated_arm`.

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


def wire_estimator(builder: DiagramBuilder, remote: Remote, estimator: System) -> dict[str, OutputPort]:
    """Show an estimator what the telerobot's side measures, and what the sensor itself reads where it asks for that.

    Gives its outputs by their names, all of them of one evaluation.
    """
    builder.Connect(remote.measurement, estimator.GetInputPort("measurement"))
    builder.Connect(remote.in_contact, estimator.GetInputPort("in_contact"))
    if remote.reading is not None and estimator.HasInputPort("reading"):
        builder.Connect(remote.reading, estimator.GetInputPort("reading"))
    sizes = output_error.PORT_SIZES if estimator.HasOutputPort("deviation") else rls.PORT_SIZES
    return dict(zip(sizes, split(builder, estimator.GetOutputPort("readout"), tuple(sizes.values())), strict=True))


def _pull(builder: DiagramBuilder, commanded: OutputPort, tip: OutputPort, impedance: Impedance) -> OutputPort:
    """(3) F_com = K (x_d - x) + D (v_d - v), by which the controller pulls the tip [N]."""
    towards = np.hstack([impedance.stiffness * np.eye(3), impedance.damping * np.eye(3)])
    gain = builder.AddNamedSystem("pull", MatrixGain(np.hstack([towards, -towards])))
    builder.Connect(join(builder, (commanded, tip)), gain.get_input_port())
    return gain.get_output_port()
