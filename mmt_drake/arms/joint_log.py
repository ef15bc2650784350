"""Logs of an arm's joints: positions and torques over one clock, from the files that robots write."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.errors import BadInput, some
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.column_map import Taken
from mmt_drake.recording.csv_file import read_table
from mmt_drake.recording.npz_file import arrays_of
from mmt_drake.recording.stored import as_array

TIMES: Final = ("time", "t_s", "timestamp", "t")
POSITIONS: Final = ("q_rad", "q", "actual_q", "position")
LINKS: Final = ("q_link_rad", "q_link")
TORQUES: Final = ("tau_Nm", "tau", "tau_J", "i_A", "tau_motor_Nm", "actual_current", "effort")
"""Names that columns have in logs; where a model file names no torque column the first that is there is taken."""

_INDEXED = re.compile(r"^(.*?)[_\[.]?(\d+)\]?$")
_LEAST_SAMPLES = 200


@dataclass(frozen=True)
class JointLog:
    """One log.

    Attributes:
        source: where it was read from.
        time: (n,) [s], strictly increasing.
        q: (n, joints) positions [rad] or [m].
        torque: (n, joints) what the drives give [N m] or [N], along the joints.
        column: of the file that the torque was made from.
        link: (n, joints) positions of the links, behind the gears; None where there is no second encoder.
    """

    source: str
    time: Array
    q: Array
    torque: Array
    column: str
    link: Array | None = None

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.time[-1] - self.time[0])


def load_joint_log(path: str | Path, model: ArmModel, joints: Sequence[str]) -> JointLog:
    """Read a log: NPZ, CSV, MCAP or a ROS bag with `sensor_msgs/JointState`.

    Args:
        path: of the file. Arrays of NPZ have a column for each joint; in CSV their names end with the joint's number,
            as in `q_0`, `q[0]` or `actual_q_0`, or with its name, as in `q_elbow`.
        model: which column is the torque, and what its unit is worth.
        joints: names of those that are to be read, in the order of the log's columns; of a `JointState` by name.

    Raises:
        BadInput: it cannot be read, lacks a column, has another number of joints, times that do not increase or
            numbers that are none.
    """
    path = Path(path)
    if not path.exists():
        raise BadInput(
            path, found="no such file", expected="a log of joints: .npz, .csv, .mcap, .bag, .db3 or a bag folder"
        )
    if path.suffix in (".npz", ".csv") and path.is_dir():
        raise BadInput(path, found="a folder", expected=f"a {path.suffix} file")
    names = (model.column,) if model.column else TORQUES
    if path.suffix == ".npz":
        arrays = {name: array.astype(np.float64, copy=False) for name, array in arrays_of(path, texts=True).items()}
    elif path.suffix == ".csv":
        arrays = _csv(path, (*TIMES, *POSITIONS, *LINKS, *names), joints)
    else:
        arrays = _joint_states(path, joints)
    time = _named(arrays, TIMES, path, "time").reshape(-1)
    q = _wide(_named(arrays, POSITIONS, path, "position"), joints, path, "position")
    column = next((name for name in names if name in arrays), "")
    torque = _wide(_named(arrays, names, path, "torque"), joints, path, "torque")
    for at, factor in (("torque", model.factor), ("position", model.position_factor)):
        if factor and len(factor) not in (1, len(joints)):
            expected = f"1, or {len(joints)}: one for each joint"
            raise BadInput(model.source, at=f"{at}.factor", found=f"{len(factor)} numbers", expected=expected)
    link = next((_wide(arrays[name], joints, path, name) for name in LINKS if name in arrays), None)
    turned, worth = (np.array(factor or (1.0,)) for factor in (model.position_factor, model.factor))
    log = JointLog(str(path), time, q * turned, torque * worth, column, None if link is None else link * turned)
    return _checked(log, path, joints)


def _checked(log: JointLog, path: Path, joints: Sequence[str]) -> JointLog:
    if log.link is not None and len(log.link) != len(log.time):
        raise BadInput(
            path, at="link", found=f"{len(log.link)} positions", expected=f"{len(log.time)}, one for each time"
        )
    if not len(log.time) == len(log.q) == len(log.torque):
        found = f"{len(log.time)} times, {len(log.q)} positions and {len(log.torque)} torques"
        raise BadInput(path, found=found, expected="as many of each")
    if len(log.time) < _LEAST_SAMPLES:
        raise BadInput(path, found=f"{len(log.time)} samples", expected=f"{_LEAST_SAMPLES} at least")
    link = log.time if log.link is None else log.link
    for name, values in (("time", log.time), ("position", log.q), ("torque", log.torque), ("link", link)):
        bad = np.argwhere(~np.isfinite(values.reshape(len(values), -1)))
        if bad.size:
            row, column = bad[0]
            of = "" if values.ndim == 1 else f" of {joints[column]}"
            found = f"{values.reshape(len(values), -1)[row, column]:g}"
            raise BadInput(path, at=f"{name}{of}, row {row + 1}", found=found, expected="finite numbers")
    still = np.flatnonzero(np.diff(log.time) <= 0.0)
    if still.size:
        row = int(still[0]) + 1
        found = f"{log.time[row]:.12g} s after {log.time[row - 1]:.12g} s"
        raise BadInput(path, at=f"time, row {row + 1}", found=found, expected="times that increase")
    return log


def _named(arrays: Mapping[str, Array], names: Sequence[str], path: Path, what: str) -> Array:
    for name in names:
        if name in arrays:
            return arrays[name]
    raise BadInput(path, at=what, found=f"columns {some(arrays)}", expected=" or ".join(names))


def _wide(values: Array, joints: Sequence[str], path: Path, what: str) -> Array:
    """Columns of an array, one for each joint, (n, joints)."""
    columns = values[:, None] if values.ndim == 1 else values
    if columns.ndim != 2 or columns.shape[1] != len(joints):
        found = f"{columns.shape[1] if columns.ndim == 2 else columns.ndim} columns"
        expected = f"{len(joints)}, one for each of {', '.join(joints)} (`joints:` of the model says which)"
        raise BadInput(path, at=what, found=found, expected=expected)
    return np.ascontiguousarray(columns, dtype=np.float64)


def _csv(path: Path, wanted: Sequence[str], joints: Sequence[str]) -> dict[str, Array]:
    """Columns of a file with a header; those that differ in a number or a joint's name at the end are one array."""
    places: dict[str, dict[int, str]] = {}

    def taken(headers: tuple[str, ...]) -> list[Taken]:
        named = {f"{stem}_{joint}": (stem, k) for stem in wanted for k, joint in enumerate(joints)}
        for header in headers:
            match = _INDEXED.match(header)
            stem, number = (match[1], int(match[2])) if match and match[1] else (header, -1)
            stem, number = named.get(header, (stem, number))
            places.setdefault(stem, {})[number] = header
        for stem in wanted:
            _complete(path, stem, places.get(stem, {}), joints)
        if not any(stem in places for stem in wanted):
            expected = f"columns like t, q_0 ... and {wanted[-1]}_0 ..."
            raise BadInput(path, at="header", found=some(headers), expected=expected)
        return [Taken(name, name) for stem in wanted for name in places.get(stem, {}).values()]

    _, columns, _ = read_table(path, taken)
    arrays: dict[str, Array] = {}
    for stem in wanted:
        own = {number: as_array(columns[name]) for number, name in places.get(stem, {}).items()}
        if own:
            arrays[stem] = own[-1] if -1 in own else np.stack([own[k] for k in sorted(own)], 1)
    return arrays


def _complete(path: Path, stem: str, own: Mapping[int, str], joints: Sequence[str]) -> None:
    """Refuse columns of some joints where others have none."""
    numbers = sorted(number for number in own if number >= 0)
    if len(numbers) > 1 or (numbers and len(joints) == 1):
        first = min(numbers[0], 1)  # robots count from 0 or from 1
        lacking = [f"{stem}_{number}" for number in range(first, first + len(joints)) if number not in numbers]
        if lacking and len(numbers) < len(joints):
            expected = f"one for each of {', '.join(joints)} (`joints:` of the model says which)"
            found = f"{', '.join(own[number] for number in numbers)}, no {', '.join(lacking)}"
            raise BadInput(path, at="header", found=found, expected=expected)


def _joint_states(path: Path, joints: Sequence[str]) -> dict[str, Array]:
    """Positions and efforts of the first topic of `sensor_msgs/JointState` that names these joints."""
    from mmt_drake.recording.bags import opened_bag

    rows: list[tuple[float, Any]] = []
    topic = ""
    with opened_bag(path) as reader:
        wanted = [c for c in reader.connections if c.msgtype.endswith("msg/JointState")]
        for connection, _, raw in reader.messages(connections=wanted):
            message: Any = reader.deserialize(raw, connection.msgtype)
            if set(joints) <= set(message.name) and topic in ("", connection.topic):
                topic, stamp = connection.topic, message.header.stamp
                order = [message.name.index(name) for name in joints]
                rows.append((stamp.sec + 1e-9 * stamp.nanosec, (message, order)))
    if not rows:
        raise BadInput(path, found="no JointState with these joints", expected=", ".join(joints))
    for time, (message, _) in rows:
        for name in ("position", "effort"):
            if len(getattr(message, name)) != len(message.name):
                found = f"{len(getattr(message, name))} numbers"
                raise BadInput(path, at=f"{name} at {time:.6f} s", found=found, expected=f"{len(message.name)}")
    rows.sort(key=lambda row: row[0])
    return {
        "time": np.array([time for time, _ in rows]),
        "position": np.array([message.position[order] for _, (message, order) in rows]),
        "effort": np.array([message.effort[order] for _, (message, order) in rows]),
    }
