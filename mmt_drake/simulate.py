"""A recording's probe motion through a model, in Drake, at the recording's own times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import AffineSystem, Multiplexer, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.errors import BadInput
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import DrivenBodyModel, FlexibleBoxModel
from mmt_drake.model_files import Model
from mmt_drake.recording import Recording
from mmt_drake.systems.driven_body import DrivenBody
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.recorded_operator import RecordedOperator

Array = NDArray[np.float64]

_TANGENTIAL = 1  # the axis of a flexible box that a single-axis recording is taken for


def simulate(model: Model, recording: Recording) -> Recording:
    """What the model answers to a recording's motion, free-running and at rest at the first sample.

    Args:
        model: a flexible box (three axes; or one tangential axis, in contact throughout unless `in_contact` says
            otherwise), a Kelvin-Voigt contact (one axis) or a driven body (input and output).
        recording: with a probe's position, or a driven body's input. Contact is its `in_contact` where it has one,
            else z < 0. A driven body starts where the recording's output does.

    Returns:
        The recording's times and own columns (none that its reader derived) with the force, or the output (and its
        rate if the recording has it), simulated.

    Raises:
        BadInput: model and recording do not fit.
    """
    _check_fit(model, recording)
    simulated = replay(model, recording)
    own = {name: values for name, values in recording.columns.items() if name not in recording.derived}
    if "output_rate" not in own:
        simulated.pop("output_rate", None)
    return replace(recording, columns={**own, **simulated}, derived=frozenset(), clouds=())


def replay(model: Model, recording: Recording) -> dict[str, Array]:
    """The simulated columns (n,) by name at the recording's times; arguments and errors as `simulate`."""
    diagram = replay_diagram(model, recording)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    port = diagram.GetOutputPort("simulated")
    values = np.empty((len(recording), port.size()))
    for k, t in enumerate(recording.time - recording.time[0]):
        simulator.AdvanceTo(t)
        values[k] = port.Eval(context)
    if recording.kind == "single_axis":
        return {"force": values[:, _TANGENTIAL]}
    names = ("output", "output_rate") if recording.kind == "driven_body" else ("force_x", "force_y", "force_z")
    return dict(zip(names, values.T, strict=True))


def replay_diagram(model: Model, recording: Recording) -> Diagram:
    """The diagram that `replay` runs: what the recording drives the model with, and the model.

    Time 0 is the first sample. The model is updated at every step of the Simulator: advance it from sample to sample.
    Its output is `simulated`: the force (3) on the probe, or a driven body's position and rate (2).
    """
    time = recording.time - recording.time[0]
    if isinstance(model, DrivenBodyModel):
        return _driven_diagram(model, time, recording)
    position, velocity = _motion(recording)
    builder = DiagramBuilder()
    hand = builder.AddNamedSystem("operator", RecordedOperator(time, position, velocity))
    motion = hand.GetOutputPort("motion")
    if isinstance(model, FlexibleBoxModel):
        contact = _contact(recording)
        box = builder.AddNamedSystem("environment", FlexibleBox(model, period=0.0, told_contact=contact is not None))
        builder.Connect(motion, box.GetInputPort("motion"))
        if contact is not None:
            flag = PiecewisePolynomial.ZeroOrderHold(time, contact[np.newaxis])
            told = builder.AddNamedSystem("recorded_contact", TrajectorySource(flag))
            builder.Connect(told.get_output_port(), box.GetInputPort("contact"))
        force = box.GetOutputPort("force")
    else:
        spring = builder.AddNamedSystem("environment", _kelvin_voigt(model))
        builder.Connect(motion, spring.get_input_port())
        force = spring.get_output_port()
    builder.ExportOutput(force, "simulated")
    return builder.Build()


def _driven_diagram(model: DrivenBodyModel, time: Array, recording: Recording) -> Diagram:
    builder = DiagramBuilder()
    u = PiecewisePolynomial.FirstOrderHold(time, recording["input"][np.newaxis])
    source = builder.AddNamedSystem("input", TrajectorySource(u))
    driven = builder.AddNamedSystem("body", DrivenBody(model, start=recording["output"][0], period=0.0))
    builder.Connect(source.get_output_port(), driven.GetInputPort("input"))
    both = builder.AddSystem(Multiplexer(2))
    for i, name in enumerate(("output", "output_rate")):
        builder.Connect(driven.GetOutputPort(name), both.get_input_port(i))
    builder.ExportOutput(both.get_output_port(), "simulated")
    return builder.Build()


def _check_fit(model: Model, recording: Recording) -> None:
    if isinstance(model, DrivenBodyModel):
        good, wants = recording.kind == "driven_body", "time, input, output"
    elif isinstance(model, KelvinVoigt):
        good, wants = recording.kind == "single_axis", "time, position, force"
    else:
        good, wants = recording.kind != "driven_body", "time, position_x, position_y, position_z, force_x ..."
    if not good:
        raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=f"the columns {wants}")


def _kelvin_voigt(model: KelvinVoigt) -> AffineSystem:
    """F = F0 - k (x - x0) - b v along the one axis, as a system from motion (6) to force (3)."""
    per_position, per_velocity, constant = model.affine()
    D, y0 = np.zeros((3, 6)), np.zeros(3)
    D[_TANGENTIAL, _TANGENTIAL], D[_TANGENTIAL, 3 + _TANGENTIAL], y0[_TANGENTIAL] = per_position, per_velocity, constant
    return AffineSystem(np.zeros((0, 0)), np.zeros((0, 6)), np.zeros(0), np.zeros((3, 0)), D, y0)


def _motion(recording: Recording) -> tuple[Array, Array]:
    """Position and velocity (n, 3) of the probe; one axis is the tangential one, pressed just below the surface."""
    if recording.kind != "single_axis":
        return recording.vector("position"), recording.vector("velocity")
    position, velocity = np.zeros((len(recording), 3)), np.zeros((len(recording), 3))
    position[:, _TANGENTIAL], velocity[:, _TANGENTIAL] = recording["position"], recording["velocity"]
    position[:, 2] = -1e-9
    return position, velocity


def _contact(recording: Recording) -> Array | None:
    return recording.columns.get("in_contact")
