"""Public data sets, read in the form in which they are published.

Each is recognised by the names of its arrays and turned into the contract's columns by one
declaration in ``DATA_SETS``.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording.check import completed
from mmt_drake.recording.recording import Array, Recording
from mmt_drake.recording.signals import AXES

FOLDER: Final = "MMT_RECORDINGS"
"""The environment's variable that names the folder of public recordings."""

Arrays = Mapping[str, np.ndarray[Any, Any]]
Columns = dict[str, Array]


@dataclass(frozen=True)
class DataSet:
    """How the files of one data set are read.

    Attributes:
        name: its folder.
        arrays: names that a file must have to be one of it, each with the shape of one sample.
        columns: from the arrays to ``time`` and the contract's columns.
        notes: what was decided in doing so.
        split_by: array that numbers the recordings of one file.
    """

    name: str
    arrays: Mapping[str, tuple[int, ...]]
    columns: Callable[[Arrays], Columns]
    notes: tuple[str, ...] = ()
    split_by: str | None = None


def public_recordings() -> Path:
    """Where each data set has a folder: what `FOLDER` names, else `shared/recordings` beside the checkout."""
    return Path(os.environ.get(FOLDER) or Path(__file__).resolve().parents[3] / "shared" / "recordings")


def _emps(data: Arrays) -> Columns:
    return {"time": data["t_s"], "input": data["force_N"], "output": data["q_m"]}


def _bam_servo(data: Arrays) -> Columns:
    duty = data["load_raw"].astype(np.uint16).astype(np.int16) * 1e-3
    return {
        "time": data["t_s"],
        "input": duty * data["vin_V"],
        "output": data["q_rad"],
        "output_rate": data["dq_radps"],
    }


def _silverbox(data: Arrays) -> Columns:
    return {"time": data["t_s"], "input": data["u_V"], "output": data["y_V"]}


def _falling_balls(data: Arrays) -> Columns:
    height = data["h_m"]
    return {"time": data["t_s"], "input": np.zeros(len(height)), "output": height, "output_rate": data["v_mps"]}


def _mr_damper(data: Arrays) -> Columns:
    return {"time": data["t_s"], "position": data["x_m"], "velocity": data["v_mps"], "force": -data["F_N"]}


def _dvrk_palpation(data: Arrays) -> Columns:
    position = data["pos_m"].astype(np.float64)
    position[:, 2] -= position[:, 2].max()
    contact = np.ones(len(position))
    return {
        "time": data["t_s"],
        **_axes("position", position),
        **_axes("force", data["force_N"]),
        "in_contact": contact,
    }


def _pressed(data: Arrays) -> Columns:
    return {"time": data["t_s"], "position": data["x_m"], "force": -data["F_N"]}


def _brfd(data: Arrays) -> Columns:
    return {**_pressed(data), "velocity": data["v_mps"]}


def _pendulum(data: Arrays) -> Columns:
    return {"time": data["t_s"], "input": np.zeros(len(data["phi_rad"])), "output": data["phi_rad"]}


def _hsm150(data: Arrays) -> Columns:
    return {"time": data["t_s"], "input": data["tau_in_Nm"], "output": data["q_rad"]}


def _kinova(data: Arrays) -> Columns:
    return {"time": data["t_s"], "input": data["i_A"], "output": np.unwrap(data["q_rad"].astype(np.float64))}


def _ur10e_jointwise(data: Arrays) -> Columns:
    reach = np.ptp(data["q_rad"], axis=0)
    joint = int(np.argmax(reach))
    if np.count_nonzero(reach > 0.01 * reach[joint]) > 1:
        found = f"{np.count_nonzero(reach > 0.01 * reach[joint])} joints that move"
        raise BadInput("ur10e", at="q_rad", found=found, expected="one, as in ur10e_jointwise")
    return {"time": data["t_s"], "input": data["i_A"][:, joint], "output": data["q_rad"][:, joint]}


def _panda_comanipulation(data: Arrays) -> Columns:
    position, velocity = data["pos_m"], data["vel_mps"]
    time = np.arange(len(position), dtype=np.float64) * np.float64(sample_period(position, velocity))
    return {
        "time": time,
        **_axes("position", position),
        **_axes("velocity", velocity),
        **_axes("force", data["force_N"]),
    }


def sample_period(position: Array, velocity: Array) -> float:
    """Sampling period of a motion recorded without a clock [s].

    The median over all samples of the step between neighbours, divided by the speed there:
    1.46 to 1.50 ms for the files of this set. They come from a 1 kHz loop that lost samples: the
    single ratios gather around 1 and 2 ms, and displacement over the integral of velocity, their
    mean, is 1.44 ms. So speeds by this clock are right to about 4 %.

    Args:
        position: (n, 3) [m].
        velocity: (n, 3) [m/s].
    """
    speed = np.linalg.norm(velocity, axis=1)
    moving = speed > 0.0
    step = np.linalg.norm(np.gradient(position, axis=0), axis=1)
    return float(np.median(step[moving] / speed[moving]))


def _axes(name: str, vectors: np.ndarray[Any, Any]) -> Columns:
    return {f"{name}_{axis}": vectors[:, i] for i, axis in enumerate(AXES)}


DATA_SETS = (
    DataSet(
        "emps",
        {"t_s": (), "u_V": (), "force_N": (), "q_m": ()},
        _emps,
        ("input: drive force [N], the amplifier's command times its gain; output: carriage position [m]",),
    ),
    DataSet(
        "bam_servo",
        {"t_s": (), "load_raw": (), "vin_V": (), "q_rad": (), "dq_radps": ()},
        _bam_servo,
        (
            "input: motor voltage [V], the duty cycle (load_raw, two's complement, 0.001 each) times the supply vin_V",
            "output: servo angle [rad], 0 hanging down; output_rate: as the servo reports it",
            "while the torque is disabled the input is 0, but the motor is let go rather than held at 0 V",
        ),
    ),
    DataSet("silverbox", {"t_s": (), "u_V": (), "y_V": ()}, _silverbox, ("input and output in volts",)),
    DataSet(
        "falling_balls",
        {"drop": (), "t_s": (), "h_m": (), "v_mps": ()},
        _falling_balls,
        ("input: 0, nothing but gravity and air acts; output: height [m], up",),
        split_by="drop",
    ),
    DataSet(
        "mr_damper",
        {"t_s": (), "x_m": (), "v_mps": (), "F_N": ()},
        _mr_damper,
        ("force: -F_N; the file has the actuator's force on the damper (it has the sign of the velocity)",),
    ),
    DataSet(
        "dvrk_palpation",
        {"t_s": (), "pos_m": (3,), "force_N": (3,), "quat": (4,)},
        _dvrk_palpation,
        (
            "axes of the robot's base, z up; the surface's height is not known: z = 0 is the highest point reached",
            "in_contact: 1, the probe does not leave the surface (force_z stays positive throughout)",
        ),
    ),
    DataSet(
        "brfd_friction_damper",
        {"t_s": (), "x_m": (), "F_N": (), "v_mps": (), "act1_N": (), "act2_N": ()},
        _brfd,
        ("force: -F_N; the file has the force of the machine on the damper",),
    ),
    DataSet(
        "pork_indentation",
        {"t_s": (), "F_N": (), "x_m": (), "toolgap_m": ()},
        _pressed,
        ("force: -F_N, on the indenter; position: into the tissue",),
    ),
    DataSet(
        "carter_pendulum",
        {"t_s": (), "phi_rad": ()},
        _pendulum,
        ("input: 0, it swings freely; output: angle [rad], 0 hanging down",),
    ),
    DataSet(
        "hsm150_motor",
        {"t_s": (), "q_rad": (), "dq_radps": (), "tau_in_Nm": (), "tau_meas_Nm": ()},
        _hsm150,
        ("input: torque that is asked for [N m]; output: angle [rad]",),
    ),
    DataSet(
        "kinova_gen3_joint7",
        {"t_s": (), "q_rad": (), "dq_radps": (), "tau_cmd_Nm": (), "tau_Nm": (), "i_A": ()},
        _kinova,
        ("input: motor current [A]; output: joint angle [rad], its turns counted",),
    ),
    DataSet(
        "ur10e_jointwise",
        {"t_s": (), "q_rad": (6,), "dq_radps": (6,), "i_A": (6,), "i_des_A": (6,), "tau_des_Nm": (6,)},
        _ur10e_jointwise,
        ("input: current of the joint that moves [A]; output: its angle [rad]",),
    ),
    DataSet(
        "panda_comanipulation",
        {"pos_m": (3,), "vel_mps": (3,), "force_N": (3,)},
        _panda_comanipulation,
        (
            "time: a constant period, the median of |gradient of position| / |velocity|",
            "motion of a hand guiding the robot in free space; axes of the robot's base, not a table's; "
            "force: the wrist's, as published, not a contact force",
        ),
    ),
)


def find(arrays: Arrays, source: str) -> DataSet:
    """The data set that these arrays belong to; the one with the most array names if several fit.

    Raises:
        BadInput: none, or one that is no recording over time.
    """
    fitting = [known for known in DATA_SETS if set(known.arrays) <= set(arrays)]
    if {"despos_m", "normal", "contact"} <= set(arrays):
        raise BadInput(
            source,
            found=f"probing of {len(arrays['normal'])} sites by depth steps, without times",
            expected="a recording over time",
        )
    if not fitting:
        known = "; ".join(f"{data_set.name}: {', '.join(sorted(data_set.arrays))}" for data_set in DATA_SETS)
        expected = f"'time' and the columns of a recording, or a known data set ({known})"
        raise BadInput(source, found=f"arrays {', '.join(arrays) or 'none'}", expected=expected)
    return max(fitting, key=lambda data_set: len(data_set.arrays))


def read_public(data_set: DataSet, arrays: Arrays, source: str) -> list[Recording]:
    """The recordings of one file, checked; numbers without a dimension become ``constants``.

    Raises:
        BadInput: arrays of different lengths or shapes, or what ``check.completed`` finds.
    """
    constants = {name: float(array) for name, array in arrays.items() if array.ndim == 0}
    series = {name: array for name, array in arrays.items() if array.ndim > 0}
    _check_shapes(data_set, series, source)
    recordings = []
    for label, part in _parts(data_set, series):
        columns = {name: values.astype(np.float64) for name, values in data_set.columns(part).items()}
        time = columns.pop("time")
        recordings.append(completed(time, columns, source + label, notes=data_set.notes, constants=constants))
    return recordings


def _check_shapes(data_set: DataSet, series: Arrays, source: str) -> None:
    length = max(len(array) for array in series.values()) if series else 0
    for name, sample in data_set.arrays.items():
        shape = series[name].shape if name in series else ()
        if shape != (length, *sample):
            expected = f"{(length, *sample)}, as in {data_set.name}"
            raise BadInput(source, at=name, found=f"shape {shape}", expected=expected)
        bad = ~np.isfinite(series[name].reshape(length, -1)).all(axis=1)
        if bad.any():
            row = f"row {int(np.argmax(bad)) + 1}, array {name!r}"
            raise BadInput(source, at=row, found=series[name][np.argmax(bad)], expected="finite numbers")


def _parts(data_set: DataSet, series: Arrays) -> Iterator[tuple[str, Arrays]]:
    if data_set.split_by is None:
        yield "", series
        return
    numbers = series[data_set.split_by]
    for number in np.unique(numbers):
        mine = numbers == number
        yield f" {data_set.split_by} {number}", {name: array[mine] for name, array in series.items()}
