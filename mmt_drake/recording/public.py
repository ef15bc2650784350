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
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.check import completed
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import AXES

FOLDER: Final = "MMT_RECORDINGS"
"""The environment's variable that names the folder of public recordings."""

Arrays = Mapping[str, np.ndarray[Any, Any]]
Column = str | Callable[[Arrays], np.ndarray[Any, Any]]
Labels = np.ndarray[Any, Any]


@dataclass(frozen=True)
class DataSet:
    """One data set, and how its files are read.

    Attributes:
        name: its folder.
        arrays: names that a file must have to be one of it, each with the shape of one sample.
        columns: `time` and the contract's columns (of a vector the name without its axis), each with the array that it
            is, or what computes it from all of them.
        notes: what was decided in doing so.
        split_by: name of each sample's recording, where a file has several.
    """

    name: str
    arrays: Mapping[str, tuple[int, ...]]
    columns: Mapping[str, Column]
    notes: tuple[str, ...] = ()
    split_by: Callable[[Arrays], Labels] | None = None

    def read(self, data: Arrays) -> dict[str, Array]:
        """The columns (n,) of the arrays of one recording."""
        read: dict[str, Array] = {}
        for name, column in self.columns.items():
            values = (data[column] if isinstance(column, str) else column(data)).astype(np.float64)
            names = [name] if values.ndim == 1 else [f"{name}_{part}" for part in (*AXES, "w")[: values.shape[1]]]
            read |= zip(names, np.ascontiguousarray(np.atleast_2d(values.T)), strict=True)
        return read


def public_recordings() -> Path:
    """The folder that has one for each data set: what `FOLDER` names, else `shared/recordings` beside the checkout."""
    return Path(os.environ.get(FOLDER) or Path(__file__).resolve().parents[3] / "shared" / "recordings")


def _reaction(data: Arrays) -> np.ndarray[Any, Any]:
    return -data["F_N"]


def _zeros(data: Arrays) -> Array:
    return np.zeros(len(data["t_s"]))


def _motor_voltage(data: Arrays) -> Array:
    duty: np.ndarray[Any, Any] = data["load_raw"].astype(np.uint16).astype(np.int16) * 1e-3
    return duty * data["vin_V"]


def _below_the_highest(data: Arrays) -> Array:
    position = data["pos_m"].astype(np.float64)
    position[:, 2] -= position[:, 2].max()
    return position


def _of_moving_joint(name: str) -> Callable[[Arrays], Array]:
    def column(data: Arrays) -> Array:
        reach = np.ptp(data["q_rad"], axis=0)
        joint = int(np.argmax(reach))
        moving = np.count_nonzero(reach > 0.01 * reach[joint])
        if moving > 1:
            found = f"{moving} joints that move"
            raise BadInput("ur10e", at="q_rad", found=found, expected="one, as in ur10e_jointwise")
        values: Array = data[name][:, joint]
        return values

    return column


def _even_times(data: Arrays) -> Array:
    position = data["pos_m"]
    return np.arange(len(position), dtype=np.float64) * np.float64(sample_period(position, data["vel_mps"]))


def _reaches(data: Arrays) -> Labels:
    kinds = np.where(data["kind"] == 0.0, "device", "person")
    return np.array([f"trial {trial:g} {kind}" for trial, kind in zip(data["trial"], kinds, strict=True)])


def _parts_in_time(data: Arrays) -> Labels:
    restarts = np.diff(data["t_s"], prepend=data["t_s"][0]) < 0.0
    return np.array([f"part {number}" for number in np.cumsum(restarts) + 1])


def _drops(data: Arrays) -> Labels:
    return np.array([f"drop {number}" for number in data["drop"]])


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


DATA_SETS = (
    DataSet(
        "emps",
        {"t_s": (), "u_V": (), "force_N": (), "q_m": (), "qref_m": ()},
        {"time": "t_s", "input": "force_N", "output": "q_m", "goal": "qref_m"},
        (
            "input: drive force [N], the amplifier's command times its gain; output: carriage position [m]",
            "goal: of the position controller [m]",
        ),
    ),
    DataSet(
        "bam_servo",
        {"t_s": (), "load_raw": (), "vin_V": (), "temp_C": (), "q_rad": (), "dq_radps": (), "qgoal_rad": ()},
        {
            "time": "t_s",
            "input": _motor_voltage,
            "output": "q_rad",
            "output_rate": "dq_radps",
            "goal": "qgoal_rad",
            "voltage": "vin_V",
            "temperature": "temp_C",
        },
        (
            "input: motor voltage [V], the duty cycle (load_raw, two's complement, 0.001 each) times the supply vin_V",
            "output: servo angle [rad], 0 hanging down; output_rate: as the servo reports it; goal: of its controller",
            "while the torque is disabled the input is 0, but the motor is let go rather than held at 0 V",
        ),
    ),
    DataSet(
        "silverbox",
        {"t_s": (), "u_V": (), "y_V": ()},
        {"time": "t_s", "input": "u_V", "output": "y_V"},
        ("input and output in volts",),
    ),
    DataSet(
        "falling_balls",
        {"drop": (), "t_s": (), "h_m": (), "v_mps": ()},
        {"time": "t_s", "input": _zeros, "output": "h_m", "output_rate": "v_mps"},
        ("input: 0, nothing but gravity and air acts; output: height [m], up",),
        split_by=_drops,
    ),
    DataSet(
        "mr_damper",
        {"t_s": (), "x_m": (), "v_mps": (), "F_N": ()},
        {"time": "t_s", "position": "x_m", "velocity": "v_mps", "force": _reaction},
        ("force: -F_N; the file has the actuator's force on the damper (it has the sign of the velocity)",),
    ),
    DataSet(
        "dvrk_palpation",
        {"t_s": (), "pos_m": (3,), "force_N": (3,), "quat": (4,)},
        {
            "time": "t_s",
            "position": _below_the_highest,
            "force": "force_N",
            "orientation": lambda data: np.roll(data["quat"], -1, axis=1),
            "in_contact": lambda data: np.ones(len(data["t_s"])),
        },
        (
            "axes of the robot's base, z up; the surface's height is not known: z = 0 is the highest point reached",
            "orientation: of quat, taken for w, x, y, z: the tool then points down",
            "in_contact: 1, the probe does not leave the surface (force_z stays positive throughout)",
        ),
    ),
    DataSet(
        "brfd_friction_damper",
        {"t_s": (), "x_m": (), "F_N": (), "v_mps": (), "act1_N": (), "act2_N": ()},
        {"time": "t_s", "position": "x_m", "force": _reaction, "velocity": "v_mps"},
        ("force: -F_N; the file has the force of the machine on the damper",),
    ),
    DataSet(
        "pork_indentation",
        {"t_s": (), "F_N": (), "x_m": (), "toolgap_m": ()},
        {"time": "t_s", "position": "x_m", "force": _reaction},
        ("force: -F_N, on the indenter; position: into the tissue",),
    ),
    DataSet(
        "silicone_tensile",
        {"t_s": (), "strain_eng": (), "stress_eng_Pa": (), "x_m": (), "F_N": ()},
        {"time": "t_s", "position": "x_m", "force": _reaction},
        ("force: -F_N, on the grip; position: elongation; a part ends where the time steps back",),
        split_by=_parts_in_time,
    ),
    DataSet(
        "davinci_tool",
        {"t_raw": (), "q_back_rad": (), "tau_back_Nm": (), "q_front_rad": (), "tau_front_Nm": ()},
        {"time": "t_raw", "position": "q_back_rad", "force": "tau_back_Nm"},
        ("position: angle of the spindle [rad]; force: the torque on it [N m]",),
    ),
    DataSet(
        "haptic_force_field",
        {"trial": (), "kind": (), "t_s": (), "y_m": (), "vy_mps": (), "force_N": ()},
        {"time": "t_s", "position": "y_m", "velocity": "vy_mps", "force": lambda data: -data["force_N"]},
        ("force: -force_N, that of the field on the hand, or of the hand on the device (kind person)",),
        split_by=_reaches,
    ),
    DataSet(
        "carter_pendulum",
        {"t_s": (), "phi_rad": ()},
        {"time": "t_s", "input": _zeros, "output": "phi_rad"},
        ("input: 0, it swings freely; output: angle [rad], 0 hanging down",),
    ),
    DataSet(
        "hsm150_motor",
        {"t_s": (), "q_rad": (), "dq_radps": (), "tau_in_Nm": (), "tau_meas_Nm": ()},
        {"time": "t_s", "input": "tau_in_Nm", "output": "q_rad"},
        ("input: torque that is asked for [N m]; output: angle [rad]",),
    ),
    DataSet(
        "kinova_gen3_joint7",
        {"t_s": (), "q_rad": (), "dq_radps": (), "tau_cmd_Nm": (), "tau_Nm": (), "i_A": ()},
        {"time": "t_s", "input": "i_A", "output": lambda data: np.unwrap(data["q_rad"].astype(np.float64))},
        ("input: motor current [A]; output: joint angle [rad], its turns counted",),
    ),
    DataSet(
        "ur10e_jointwise",
        {"t_s": (), "q_rad": (6,), "dq_radps": (6,), "i_A": (6,), "i_des_A": (6,), "tau_des_Nm": (6,)},
        {"time": "t_s", "input": _of_moving_joint("i_A"), "output": _of_moving_joint("q_rad")},
        ("input: current of the joint that moves [A]; output: its angle [rad]",),
    ),
    DataSet(
        "panda_comanipulation",
        {"pos_m": (3,), "vel_mps": (3,), "force_N": (3,)},
        {"time": _even_times, "position": "pos_m", "velocity": "vel_mps", "force": "force_N"},
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
        found = f"probing of {len(arrays['normal'])} sites by depth steps, without times"
        raise BadInput(source, found=found, expected="a recording over time")
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
        columns = data_set.read(part)
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
    labels = data_set.split_by(series)
    for label in dict.fromkeys(labels.tolist()):
        mine = labels == label
        yield f" {label}", {name: array[mine] for name, array in series.items()}
