"""A recording's probe motion through a model, in Drake, at the recording's own times."""

from dataclasses import replace

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, Multiplexer, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import PositionOut
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model, check_model
from mmt_drake.motion.delay import delayed_flag
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.numeric.arrays import Array
from mmt_drake.over import in_recording
from mmt_drake.recording import Recording
from mmt_drake.recording.recording import check_recordings
from mmt_drake.replay import TANGENTIAL, body_input, check_fit, first_state, probe_motion, steps_to
from mmt_drake.systems.driven_body import DrivenBody
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.kelvin_voigt import KelvinVoigtContact
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.surface_contact import SurfaceContactSystem


def simulate(model: Model, recording: Recording) -> Recording:
    """The model's answer to a recording's motion, free-running and at rest at the first sample.

    The force is what the model's sensor reads, later than the motion by the model's delay.

    Args:
        model: a flexible box (three axes; or one tangential axis, in contact throughout unless `in_contact` says
            otherwise), a Kelvin-Voigt contact (one axis), a tip on a surface (three axes), a driven body or a
            transmission (input and output).
        recording: with a probe's position, or a driven body's input. Contact is its `in_contact` where it has one,
            else z < 0. An output starts where the recorded one does, or from a state fitted to that
            (`Structure.initial`).

    Returns:
        The recording's times and own columns (none that its reader derived) with the force, or the output (and its
        rate if the recording has it), simulated.

    Raises:
        BadInput: model and recording do not fit, or the model cannot be integrated, or runs away.
    """
    check_recordings("simulate", [recording])
    check_model("simulate", model)
    check_fit(model, recording)
    return answered(recording, replay(model, recording))


def answered(recording: Recording, simulated: dict[str, Array]) -> Recording:
    """The recording with columns that were simulated in the place of its own.

    Raises:
        BadInput: a simulation that runs away.
    """
    for name, values in simulated.items():
        if not np.isfinite(values).all():
            at = f"{recording.time[~np.isfinite(values)][0]:g} s"
            raise BadInput("model", at=at, found=f"{name} without bounds", expected="a motion that can be integrated")
    own = {name: values for name, values in recording.columns.items() if name not in recording.derived}
    if "output_rate" not in own:
        simulated.pop("output_rate", None)
    return replace(recording, columns={**own, **simulated}, derived=frozenset(), clouds=())


def replay(model: Model, recording: Recording) -> dict[str, Array]:
    """The simulated columns (n,) by name at the recording's times; arguments and errors as `simulate`."""
    model = in_recording(model, recording)
    steps_to(recording.time, model.kernel_vector(), recording.source)
    diagram = replay_diagram(model, recording)
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    port = diagram.GetOutputPort("simulated")
    values = np.empty((len(recording), port.size()))
    try:
        for k, t in enumerate(recording.time - recording.time[0]):
            simulator.AdvanceTo(t)
            values[k] = port.Eval(context)
    except RuntimeError as error:  # of the kernels, about effects whose numbers are absurd
        expected = "samples and effects that can be integrated"
        raise BadInput("model", found=str(error).splitlines()[0], expected=expected) from error
    if recording.kind == "single_axis":
        return {"force": values[:, TANGENTIAL]}
    names = ("output", "output_rate") if recording.kind == "driven_body" else ("force_x", "force_y", "force_z")
    return dict(zip(names, values.T, strict=True))


def replay_diagram(model: Model, recording: Recording) -> Diagram:
    """The diagram that `replay` runs: what the recording drives the model with, and the model.

    Time 0 is the first sample. The model is updated at every step of the Simulator: advance it from sample to sample.
    Its output is `simulated`: the force (3) that the sensor reads, or a driven body's position and rate (2). What
    drives the model is late by the model's delay.
    """
    model = in_recording(model, recording)
    if isinstance(model, PositionOut):
        return _driven_diagram(model, recording)
    time, position, velocity = probe_motion(model, recording)
    builder = DiagramBuilder()
    hand = builder.AddNamedSystem("operator", ScriptedOperator(SampledMotion(time, position, velocity)))
    environment: FlexibleBox | KelvinVoigtContact | SurfaceContactSystem
    if isinstance(model, FlexibleBoxModel):
        recorded = "in_contact" in recording
        environment = builder.AddNamedSystem("environment", FlexibleBox(model, period=0.0, told_contact=recorded))
        if recorded:
            contact = delayed_flag(time, recording["in_contact"], model.additions.delay)
            flag = PiecewisePolynomial.ZeroOrderHold(time, contact[np.newaxis])
            source = builder.AddNamedSystem("recorded_contact", TrajectorySource(flag))
            builder.Connect(source.get_output_port(), environment.GetInputPort("contact"))
    elif isinstance(model, SurfaceContact):
        environment = builder.AddNamedSystem("environment", SurfaceContactSystem(model, period=0.0))
    else:
        environment = builder.AddNamedSystem("environment", KelvinVoigtContact(model, period=0.0))
    builder.Connect(hand.GetOutputPort("motion"), environment.GetInputPort("motion"))
    sensor = builder.AddNamedSystem("sensor", Demultiplexer([3, 3, 3]))
    builder.Connect(environment.GetOutputPort("measurement"), sensor.get_input_port())
    builder.ExportOutput(sensor.get_output_port(2), "simulated")
    return builder.Build()


def _driven_diagram(model: PositionOut, recording: Recording) -> Diagram:
    builder = DiagramBuilder()
    start, start_rate = first_state(model, recording)
    driven = builder.AddNamedSystem("body", DrivenBody(model, start=start, start_rate=start_rate, period=0.0))
    time, *driving = body_input(model, recording)
    for name, late in zip(("input", "load"), driving, strict=True):
        if name in recording:
            line = PiecewisePolynomial.FirstOrderHold(time, late[np.newaxis])
            source = builder.AddNamedSystem(name, TrajectorySource(line))
            builder.Connect(source.get_output_port(), driven.GetInputPort(name))
    both = builder.AddSystem(Multiplexer(2))
    for i, name in enumerate(("output", "output_rate")):
        builder.Connect(driven.GetOutputPort(name), both.get_input_port(i))
    builder.ExportOutput(both.get_output_port(), "simulated")
    return builder.Build()
