"""What `simulate` computes, in one compiled loop without a Diagram: the same numbers, some hundred times faster."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.model import driven_body, flexible_box, kelvin_voigt
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import DrivenBodyModel, FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.motion.delay import delayed_flag, delayed_input, delayed_motion
from mmt_drake.recording import AXES, Recording

Array = NDArray[np.float64]


def replayed(model: Structure, recording: Recording) -> dict[str, Array]:
    """What the model answers to a recording's motion or input, free-running and at rest at the first sample.

    Args:
        model: of a structure that fits the recording.
        recording: as for `mmt_drake.simulate.simulate`.

    Returns:
        Column -> (n,): force_x, force_y, force_z; or force; or output, output_rate.

    Raises:
        BadInput: model and recording do not fit.
    """
    delay = model.additions.delay
    if isinstance(model, DrivenBodyModel):
        return _driven(model, recording, delay)
    if isinstance(model, FlexibleBoxModel):
        return _box(model, recording, delay)
    if isinstance(model, KelvinVoigt) and recording.kind == "single_axis":
        time, position, velocity = _along(recording, delay)
        force = np.empty(len(recording))
        load = np.zeros(len(recording))
        kelvin_voigt.replay(time, position[:, 1].copy(), velocity[:, 1].copy(), load, model.kernel_vector(), force)
        return {"force": force}
    raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=f"one for a {model.NAME} model")


def _box(model: FlexibleBoxModel, recording: Recording, delay: float) -> dict[str, Array]:
    if recording.kind == "driven_body":
        raise BadInput(recording.source, found="a driven_body recording", expected="columns of a contact")
    time, position, velocity = _along(recording, delay)
    n = len(time)
    contact = np.full(n, flexible_box.CONTACT_BY_GEOMETRY)
    if "in_contact" in recording:
        contact = delayed_flag(time, recording["in_contact"], delay)
    force, body = np.empty((n, 3)), np.empty((n, 4))
    flexible_box.replay(time, position, velocity, contact, model.kernel_vector(), force, body)
    if recording.kind == "single_axis":
        return {"force": force[:, 1].copy()}
    return {f"force_{axis}": force[:, i].copy() for i, axis in enumerate(AXES)}


def _driven(model: DrivenBodyModel, recording: Recording, delay: float) -> dict[str, Array]:
    if recording.kind != "driven_body":
        found = f"a {recording.kind} recording"
        raise BadInput(recording.source, found=found, expected="the columns time, input, output")
    time = recording.time - recording.time[0]
    u = delayed_input(time, recording["input"], delay)
    load = delayed_input(time, recording["load"], delay) if "load" in recording else np.zeros(len(time))
    output, rate, state = np.empty(len(time)), np.empty(len(time)), np.empty(driven_body.STATE_SIZE)
    driven_body.replay(time, u, load, float(recording["output"][0]), model.kernel_vector(), state, output, rate)
    return {"output": output, "output_rate": rate}


def _along(recording: Recording, delay: float) -> tuple[Array, Array, Array]:
    """Times from 0 [s], positions and velocities (n, 3) of the probe; one axis is y, pressed just below the surface."""
    time = recording.time - recording.time[0]
    if recording.kind == "single_axis":
        position, velocity = np.zeros((len(time), 3)), np.zeros((len(time), 3))
        position[:, 1], velocity[:, 1] = recording["position"], recording["velocity"]
        position[:, 2] = -1e-9
    else:
        position, velocity = recording.vector("position"), recording.vector("velocity")
    return time, *delayed_motion(time, position, velocity, delay)
