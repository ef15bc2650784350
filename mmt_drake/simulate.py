"""A recording's probe motion through a model, in Drake, at the recording's own times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import AffineSystem, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.errors import BadInput
from mmt_drake.model.files import KelvinVoigt, Model
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.recording import Recording
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.recorded_operator import RecordedOperator

Array = NDArray[np.float64]

_TANGENTIAL = 1  # the axis of a flexible box that a single-axis recording is taken for


def simulate(model: Model, recording: Recording) -> Recording:
    """What the model answers to a recording's motion, free-running and at rest at the first sample.

    Args:
        model: a flexible box (three axes; or one tangential axis, in contact throughout unless `in_contact` says
            otherwise) or a Kelvin-Voigt contact (one axis).
        recording: with a probe's position. Contact is its `in_contact` where it has one, else z < 0.

    Returns:
        The recording's times and own columns (none that its reader derived) with the force columns simulated;
        they are added where there were none.

    Raises:
        BadInput: model and recording do not fit.
    """
    single = recording.kind == "single_axis"
    if recording.kind == "driven_body" or (isinstance(model, KelvinVoigt) and not single):
        wants = "time, position, force" if isinstance(model, KelvinVoigt) else "a probe's position and force"
        raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=f"columns {wants}")
    force = replay(model, recording)
    names = ("force",) if single else tuple(f"force_{axis}" for axis in "xyz")
    simulated = dict(zip(names, force.T[_TANGENTIAL : _TANGENTIAL + 1] if single else force.T, strict=True))
    own = {name: values for name, values in recording.columns.items() if name not in recording.derived}
    return replace(recording, columns={**own, **simulated}, derived=frozenset(), clouds=())


def replay(model: Model, recording: Recording) -> Array:
    """Force on the probe (n, 3) [N] at the recording's times; arguments as `simulate`."""
    diagram = replay_diagram(model, recording)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    port = diagram.GetOutputPort("force")
    force = np.empty((len(recording), 3))
    for k, t in enumerate(recording.time - recording.time[0]):
        simulator.AdvanceTo(t)
        force[k] = port.Eval(context)
    return force


def replay_diagram(model: Model, recording: Recording) -> Diagram:
    """The diagram that `replay` runs: a hand that repeats the recording, and the model under its probe.

    Time 0 is the first sample. The model is updated at every step of the Simulator: advance it from sample to sample.
    Outputs: `motion` (6) and `force` (3).
    """
    time = recording.time - recording.time[0]
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
    builder.ExportOutput(motion, "motion")
    builder.ExportOutput(force, "force")
    return builder.Build()


def _kelvin_voigt(model: KelvinVoigt) -> AffineSystem:
    """F = F0 - k (x - x0) - b v along the one axis, as a system from motion (6) to force (3)."""
    none = np.zeros((0, 0))
    D = np.zeros((3, 6))
    D[_TANGENTIAL, _TANGENTIAL] = model.force(1.0, 0.0) - model.force(0.0, 0.0)
    D[_TANGENTIAL, 3 + _TANGENTIAL] = model.force(0.0, 1.0) - model.force(0.0, 0.0)
    y0 = np.zeros(3)
    y0[_TANGENTIAL] = model.force(0.0, 0.0)
    return AffineSystem(none, np.zeros((0, 6)), np.zeros(0), np.zeros((3, 0)), D, y0)


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
