"""Logs of joints: CSV as robots write it, NPZ, JointState in MCAP and ROS bags; and what is none, in one line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_arm
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from mmt_drake.arms.arm_file import ArmModel
from mmt_drake.arms.joint_log import load_joint_log
from mmt_drake.errors import BadInput
from mmt_drake.recording import bounds

N = 300
TIME = np.arange(N) / 100.0
Q = np.stack([np.sin((1 + j) * TIME) for j in range(3)], 1)
TAU = np.stack([np.cos((1 + j) * TIME) for j in range(3)], 1)
WRITERS = ["ros1.bag", "ros2 folder, sqlite3", "ros2 folder, mcap", "ros2 file, mcap", "ros2 file, sqlite3"]


def table(path: Path, names: tuple[str, str, str], separator: str = ",", columns: Any = None) -> Path:
    """A CSV; a name has `{}` where the joint's number goes, or `{joint}` where its name does."""
    time, q, tau = names
    header = [time, *(name.format(j, joint=joint) for name in (q, tau) for j, joint in enumerate(small_arm.JOINTS))]
    rows = np.column_stack([TIME, Q, TAU]) if columns is None else columns
    lines = [separator.join(header), *(separator.join(f"{value:.9g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def npz(path: Path, **changed: Any) -> Path:
    """An archive; None leaves an array out."""
    arrays = {"t_s": TIME, "q_rad": Q, "tau_Nm": TAU, **changed}
    np.savez(path, **{name: values for name, values in arrays.items() if values is not None})
    return path


def bag(folder: Path, kind: str, order: tuple[str, ...] = small_arm.JOINTS, efforts: bool = True) -> Path:
    """A bag of JointState, joints in some order: other joints on a topic before it, the same ones on one behind."""
    ros1 = kind.startswith("ros1")
    types = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    state, header, stamp = (
        types.types[name]
        for name in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    plugin = StoragePlugin.MCAP if "mcap" in kind else StoragePlugin.SQLITE3
    path = folder / ("log.bag" if ros1 else "log")
    pick = [small_arm.JOINTS.index(name) for name in order]
    with Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=plugin) as writer:
        topics = [
            writer.add_connection(t, state.__msgtype__, typestore=types)
            for t in ("/gripper", "/joint_states", "/again")
        ]
        for i, t in enumerate(TIME):
            when = stamp(sec=int(t), nanosec=round(1e9 * (t % 1.0)))
            told = header(seq=i, stamp=when, frame_id="") if ros1 else header(stamp=when, frame_id="")
            zero = np.zeros(1)
            messages = (
                state(told, ["finger"], zero, zero, zero),
                state(told, list(order), Q[i, pick], np.zeros(3), TAU[i, pick] if efforts else np.zeros(0)),
                state(told, list(order), Q[i, pick], np.zeros(3), np.zeros(3)),
            )
            for topic, message in zip(topics, messages, strict=True):
                raw = types.serialize_ros1 if ros1 else types.serialize_cdr
                writer.write(topic, int(1e9 * (5.0 + t)), raw(message, state.__msgtype__))
    if "file" in kind:
        (path,) = [file for file in path.iterdir() if file.suffix in (".mcap", ".db3")]
    return path


def load(path: Path, folder: Path, **keys: Any) -> Any:
    return load_joint_log(path, small_arm.model(folder, **keys), small_arm.JOINTS)


def refused(path: Path, folder: Path, **keys: Any) -> str:
    with pytest.raises(BadInput) as error:
        load(path, folder, **keys)
    line = str(error.value)
    assert "\n" not in line and ", expected " in line
    return line


def check(log: Any) -> None:
    np.testing.assert_allclose(log.time - log.time[0], TIME, atol=1e-6)
    np.testing.assert_allclose(log.q, Q, atol=1e-8)
    np.testing.assert_allclose(log.torque, TAU, atol=1e-8)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize(
    "names",
    [
        ("time", "q_{}", "tau_{}"),
        ("t", "q[{}]", "tau[{}]"),
        ("t_s", "q.{}", "tau.{}"),
        ("timestamp", "actual_q_{}", "actual_current_{}"),
        ("time", "q{}", "tau_J{}"),
        ("time", "q_{joint}", "tau_{joint}"),
    ],
    ids=lambda names: names[1],
)
def test_csv_is_read_by_the_names_of_its_columns(names: tuple[str, str, str], separator: str, tmp_path: Path) -> None:
    check(load(table(tmp_path / "log.csv", names, separator), tmp_path))


def test_columns_of_some_joints_alone_are_told_with_those_that_lack(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = np.column_stack([TIME, Q[:, [0, 2]], TAU])
    np.savetxt(path, rows, delimiter=",", header="time,q_0,q_2,tau_0,tau_1,tau_2", comments="")
    assert "header: found q_0, q_2, no q_1, expected one for each of turn, lift, bend" in refused(path, tmp_path)


def test_columns_stand_by_their_numbers_and_not_by_their_order(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    header = "tau_2,q_1,time,q_0,tau_0,q_2,tau_1,note"
    rows = np.column_stack([TAU[:, 2], Q[:, 1], TIME, Q[:, 0], TAU[:, 0], Q[:, 2], TAU[:, 1]])
    path.write_text("\n".join([header, *(",".join(f"{v:.9g}" for v in row) + ",ok" for row in rows)]))
    check(load(path, tmp_path))


def test_npz_is_read_and_units_and_signs_are_the_model_s(tmp_path: Path) -> None:
    path = npz(tmp_path / "log.npz", i_A=2.0 * TAU)
    check(load(path, tmp_path))
    log = load(path, tmp_path, column="i_A", factor=(0.5, -0.5, 1.0))
    np.testing.assert_allclose(log.torque, TAU * [1.0, -1.0, 2.0])
    assert log.column == "i_A" and log.duration == pytest.approx(TIME[-1])


def test_a_log_of_one_joint_needs_no_number(tmp_path: Path) -> None:
    path = tmp_path / "one.csv"
    path.write_text(
        "time,q,tau\n" + "".join(f"{t},{q},{f}\n" for t, q, f in zip(TIME, Q[:, 0], TAU[:, 0], strict=True))
    )
    model = small_arm.model(tmp_path, joints=("lift",))
    log = load_joint_log(path, model, model.joints)
    np.testing.assert_allclose(log.q, Q[:, :1])
    one = load_joint_log(npz(tmp_path / "one.npz", q_rad=Q[:, 0], tau_Nm=TAU[:, 0]), model, model.joints)
    np.testing.assert_allclose(one.torque, TAU[:, :1])


@pytest.mark.parametrize("kind", WRITERS)
def test_joint_states_are_read_by_the_names_of_joints(kind: str, tmp_path: Path) -> None:
    path = bag(tmp_path, kind, ("bend", "turn", "lift"))
    check(load(path, tmp_path))


def test_the_bags_of_these_tests_are_bags(tmp_path: Path) -> None:
    with AnyReader([bag(tmp_path, "ros1.bag")]) as reader:
        assert {c.msgtype for c in reader.connections} == {"sensor_msgs/msg/JointState"}


def test_joint_states_without_efforts_are_refused(tmp_path: Path) -> None:
    assert "effort" in refused(bag(tmp_path, "ros2 folder, mcap", efforts=False), tmp_path)


def test_joint_states_of_another_robot_are_refused(tmp_path: Path) -> None:
    path = bag(tmp_path, "ros1.bag")
    model = ArmModel(small_arm.written(tmp_path))
    with pytest.raises(BadInput, match="no JointState with these joints, expected shoulder"):
        load_joint_log(path, model, ("shoulder",))


def worse(values: np.ndarray, row: int, value: float) -> np.ndarray:
    changed = values.copy()
    changed[row] = value
    return changed


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "time that stands still": ({"t_s": worse(TIME, 50, TIME[49])}, "time, row 51: found 0.49 s after 0.49 s"),
    "time that steps back": ({"t_s": worse(TIME, 50, 0.0)}, "time, row 51"),
    "NaN in a position": ({"q_rad": worse(Q, 7, np.nan)}, "position of turn, row 8: found nan"),
    "an infinite torque": ({"tau_Nm": worse(TAU, 9, np.inf)}, "torque of turn, row 10: found inf"),
    "another number of joints": ({"q_rad": Q[:, :2]}, "found 2 columns, expected 3, one for each of turn, lift, bend"),
    "fewer torques than times": ({"tau_Nm": TAU[:-1]}, "299 torques"),
    "no time": ({"t_s": None}, "time: found columns q_rad, tau_Nm, expected time or t_s"),
    "no torque": ({"tau_Nm": None}, "torque: found columns"),
    "too few samples": ({"t_s": TIME[:50], "q_rad": Q[:50], "tau_Nm": TAU[:50]}, "found 50 samples, expected 200"),
}


@pytest.mark.parametrize("what", BAD)
def test_a_log_that_is_none_is_told_in_one_line(what: str, tmp_path: Path) -> None:
    changed, told = BAD[what]
    assert told in refused(npz(tmp_path / "log.npz", **changed), tmp_path)


def test_files_that_cannot_be_read_are_told_in_one_line(tmp_path: Path) -> None:
    assert "no such file" in refused(tmp_path / "none.npz", tmp_path)
    for ending in (".npz", ".bag", ".mcap", ".db3", ".csv"):
        path = tmp_path / f"broken{ending}"
        path.write_bytes(b"\x00\x01 this is none")
        assert str(path) in refused(path, tmp_path), ending
    empty = tmp_path / "empty.csv"
    empty.write_text("")
    assert str(empty) in refused(empty, tmp_path)
    (tmp_path / "folder").mkdir()
    assert "folder" in refused(tmp_path / "folder", tmp_path)
    (tmp_path / "folder.csv").mkdir()
    assert "folder.csv" in refused(tmp_path / "folder.csv", tmp_path)


def test_a_row_of_csv_that_ends_early_is_told(tmp_path: Path) -> None:
    path = table(tmp_path / "log.csv", ("time", "q_{}", "tau_{}"))
    lines = path.read_text().splitlines()
    lines[20] = lines[20].rpartition(",")[0]
    path.write_text("\n".join(lines))
    assert "row 20 (line 21): found 6 cells, expected 7" in refused(path, tmp_path)


def test_a_cell_of_csv_that_is_no_number_is_told(tmp_path: Path) -> None:
    path = table(tmp_path / "log.csv", ("time", "q_{}", "tau_{}"))
    lines = path.read_text().splitlines()
    cells = lines[20].split(",")
    lines[20] = ",".join([*cells[:2], "", *cells[3:]])
    path.write_text("\n".join(lines))
    assert "row 20 (line 21), column 'q_1': found ''" in refused(path, tmp_path)


def test_decimal_commas_and_blanks_between_cells_are_read(tmp_path: Path) -> None:
    path = table(tmp_path / "log.csv", ("time", "q_{}", "tau_{}"), ";")
    path.write_text(path.read_text().replace(".", ","))
    check(load(path, tmp_path))
    path.write_text(path.read_text().replace(",", ".").replace(";", " "))
    check(load(path, tmp_path))


def test_a_log_of_more_than_a_recording_may_hold_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "MOST", 1000)
    for path in (npz(tmp_path / "log.npz"), table(tmp_path / "log.csv", ("time", "q_{}", "tau_{}"))):
        assert "at most 0.0009537 MiB" in refused(path, tmp_path)


def test_factors_that_are_not_one_a_joint_are_refused(tmp_path: Path) -> None:
    line = refused(npz(tmp_path / "log.npz"), tmp_path, factor=(1.0, 2.0))
    assert "torque.factor: found 2 numbers, expected 1, or 3" in line


def test_a_column_of_the_model_that_is_missing_is_told(tmp_path: Path) -> None:
    assert "expected current" in refused(npz(tmp_path / "log.npz"), tmp_path, column="current")


def test_a_bag_with_a_record_of_more_than_it_may_hold_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = bag(tmp_path, "ros1")
    load(path, tmp_path)
    monkeypatch.setattr(bounds, "MOST_AT_ONCE", 1000)
    assert "expected at most 0.0009537 MiB" in refused(path, tmp_path)
