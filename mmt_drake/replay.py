"""The computation of `simulate` in one compiled loop without a Diagram: the same numbers, some hundred times faster."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.model import driven_body, flexible_box, kelvin_voigt, surface_contact
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import MAX_STEP, FlexibleBoxModel
from mmt_drake.model.structure import PositionOut, Structure
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.motion.delay import delayed_flag, delayed_input, delayed_motion, input_behind
from mmt_drake.motion.hand import HandOrientation, orientation_of
from mmt_drake.numeric.arrays import Array
from mmt_drake.over import in_recording
from mmt_drake.recording import AXES, Recording
from mmt_drake.recording.derive import motion_of
from mmt_drake.windows import Windows

TANGENTIAL = 1
"""The axis of a flexible box that a single-axis recording is taken for."""

_MOST_STEPS = 2e8  # of a replay: some twenty seconds, or hours of a recording
_STEPS_AT_ONCE = 1e6  # between two times at which Ctrl-C is heard


def replayed(model: Structure, recording: Recording) -> dict[str, Array]:
    """The model's answer to a recording's motion or input, free-running and at rest at the first sample.

    A body whose output is recorded begins, where its model says so (`Structure.initial`), with a state that is fitted
    to that output.

    Args:
        model: of a structure that fits the recording.
        recording: as for `mmt_drake.simulation.simulate`.

    Returns:
        Column -> (n,): force_x, force_y, force_z; or force; or output, output_rate.

    Raises:
        BadInput: model and recording do not fit, or it would take too long (`steps_to`).
    """
    check_fit(model, recording)
    model = in_recording(model, recording)
    if isinstance(model, PositionOut):
        return _driven(model, recording)
    if isinstance(model, FlexibleBoxModel):
        return _box(model, recording)
    if isinstance(model, SurfaceContact):
        found = np.empty((len(recording), 6))
        surface_contact.replay(*probe_motion(model, recording), model.kernel_vector(), found)
        return {f"force_{axis}": found[:, i].copy() for i, axis in enumerate(AXES)}
    assert isinstance(model, KelvinVoigt)  # no other structure is left
    time, position, velocity = probe_motion(model, recording)
    force = np.empty(len(recording))
    load = np.zeros(len(recording))
    along = position[:, TANGENTIAL].copy(), velocity[:, TANGENTIAL].copy()
    kelvin_voigt.replay(time, *along, load, model.kernel_vector(), force)
    return {"force": force}


def check_fit(model: Structure, recording: Recording) -> None:
    """Refuse a recording of another kind than a model's.

    Raises:
        BadInput: see above.
    """
    if isinstance(model, PositionOut):
        good, wants = recording.kind == "driven_body", "time, input, output"
    elif isinstance(model, KelvinVoigt):
        good, wants = recording.kind == "single_axis", "time, position, force"
    elif isinstance(model, SurfaceContact):
        good, wants = recording.kind in ("contact", "motion"), "time, position_x, position_y, position_z, force_x ..."
    else:
        good, wants = recording.kind != "driven_body", "time, position_x, position_y, position_z, force_x ..."
    if not good:
        raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=f"the columns {wants}")


def steps_to(time: Array, p: Array, source: str) -> Array:
    """(n,) integration steps at most that the samples and all before them take.

    Args:
        time: (n,) [s].
        p: kernel vector of the model.
        source: of the recording.

    Raises:
        BadInput: there are more than 200 million.
    """
    steps: Array = np.cumsum(1.0 + np.diff(time, prepend=time[0]) / p[MAX_STEP])
    if not steps[-1] <= _MOST_STEPS:
        found = f"{time[-1] - time[0]:g} s, in steps of {p[MAX_STEP]:g} s that the model asks for"
        raise BadInput(source, at="time", found=found, expected=f"at most {_MOST_STEPS:g} steps")
    return steps


def _parts(time: Array, p: Array, source: str) -> Iterator[tuple[int, int]]:
    """First and end of stretches of samples that are replayed at once."""
    steps = steps_to(time, p, source)
    cuts = np.searchsorted(steps, np.arange(_STEPS_AT_ONCE, steps[-1], _STEPS_AT_ONCE))
    return pairwise(np.unique([0, *cuts, len(time)]).tolist())


def _box(model: FlexibleBoxModel, recording: Recording) -> dict[str, Array]:
    time, position, velocity = probe_motion(model, recording)
    n = len(time)
    contact = np.full(n, flexible_box.CONTACT_BY_GEOMETRY)
    if "in_contact" in recording:
        contact = delayed_flag(time, recording["in_contact"], model.additions.delay)
    force, body = np.empty((n, 3)), np.empty((n, 4))
    state, p = np.empty(flexible_box.STATE_SIZE), model.kernel_vector()
    for first, end in _parts(time, p, recording.source):
        flexible_box.replay_part(state, first, end, time, position, velocity, contact, p, force, body)
    if recording.kind == "single_axis":
        return {"force": force[:, TANGENTIAL].copy()}
    return {f"force_{axis}": force[:, i].copy() for i, axis in enumerate(AXES)}


def _driven(model: PositionOut, recording: Recording) -> dict[str, Array]:
    time, u, load = body_input(model, recording)
    output, rate, state = np.empty(len(time)), np.empty(len(time)), np.empty(driven_body.STATE_SIZE)
    p = model.kernel_vector()
    driven_body.set_out(state, time[0], time[0], u[0], load[0], *first_state(model, recording))
    for first, end in _parts(time, p, recording.source):
        driven_body.replay_part(first, end, time, u, load, p, state, output, rate)
    return {"output": output, "output_rate": rate}


def check_load(model: Structure, recording: Recording) -> None:
    """Refuse a recording without the load that pushes the model's output.

    Raises:
        BadInput: see above.
    """
    if isinstance(model, PositionOut) and model.needs_load and "load" not in recording:
        columns = ", ".join(name for name in recording.columns if name not in recording.derived)
        expected = "the column load, of which the model's parameter `load` says the force"
        raise BadInput(recording.source, at="columns", found=columns, expected=expected)


def body_input(model: PositionOut, recording: Recording) -> tuple[Array, Array, Array]:
    """Times from 0 [s], and the input and load as they reach the body, each (n,).

    Raises:
        BadInput: the recording has no input and output, or no load for a model that needs one.
    """
    check_fit(model, recording)
    check_load(model, recording)
    recording = towards_goal(model, recording)
    time, delay = recording.time - recording.time[0], model.additions.delay
    u = input_behind(time, recording["input"], delay, model.additions.lag)
    return time, u, delayed_input(time, recording["load"], delay) if "load" in recording else model.carried(u)


def towards_goal(model: Structure, recording: Recording) -> Recording:
    """The recording as a model takes it: of a closed loop the column `goal`, where there is one, is the input."""
    if not isinstance(model, DrivenBodyModel) or model.controller is None or "goal" not in recording:
        return recording
    columns = {name: values for name, values in recording.columns.items() if name != "goal"}
    return replace(recording, columns={**columns, "input": recording["goal"]})


def first_state(model: PositionOut, recording: Recording) -> tuple[float, float]:
    """Position and rate with which the body begins a recording: at rest, or fitted where its model says so.

    Raises:
        BadInput: as `replayed`.
    """
    if model.initial == "rest":
        return float(recording["output"][0]), 0.0
    windows = Windows.whole(recording.time, recording["output"], fitted=True)
    position, rate = in_windows(model, recording, windows)[1][0]
    return float(position), float(rate)


def in_windows(model: PositionOut, recording: Recording, windows: Windows) -> tuple[dict[str, Array], Array]:
    """The columns of `replayed`, window by window, and the state (w, 2) that each begins with.

    Raises:
        BadInput: as `replayed`.
    """
    model = in_recording(model, recording)
    (time, u, load), p = body_input(model, recording), model.kernel_vector()
    steps_to(time, p, recording.source)
    simulated, states = np.full((2, len(time)), np.nan), np.empty((len(windows.rows), 2))
    measured = np.ascontiguousarray(recording["output"], dtype=np.float64)
    windows.replay(measured, time, u, load, p, simulated[0], simulated[1], states)
    return {"output": simulated[0], "output_rate": simulated[1]}, states


def probe_motion(model: Structure, recording: Recording) -> tuple[Array, Array, Array]:
    """Times from 0 [s], positions and velocities (n, 3) of the tip, late by the model's delay.

    One axis is the tangential one, y, pressed just below the surface. Where no velocity was recorded, position is what
    the polynomial of the derived one says (`motion_of`), so that the two belong to each other.

    Raises:
        BadInput: a tip beside what was recorded (`Additions.tool`) of a hand whose orientation was not.
    """
    time = recording.time - recording.time[0]
    if recording.kind == "single_axis":
        position, velocity = np.zeros((len(time), 3)), np.zeros((len(time), 3))
        position[:, TANGENTIAL], velocity[:, TANGENTIAL] = _moved(recording, "position"), recording["velocity"]
        position[:, 2] = -1e-9
    else:
        position = np.column_stack([_moved(recording, f"position_{axis}") for axis in AXES])
        velocity = recording.vector("velocity")
    if any(model.additions.tool):
        hand = HandOrientation.of(time, orientation_of(recording))
        position, velocity = hand.tip(position, velocity, model.additions.tool)
    return time, *delayed_motion(time, position, velocity, model.additions.delay)


def _moved(recording: Recording, position: str) -> Array:
    """(n,) a column of positions, of a motion whose velocity was derived or recorded."""
    if position.replace("position", "velocity") not in recording.derived:
        return recording[position]
    return motion_of(recording.time, recording[position])[0]
