"""Bags of others: every container, message and clock that the contract promises to read."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_samples import ROS1, ROS2, TOPICS, Messages, make, messages, motion
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from samples import same

from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load, save


def entry(
    topic: str, kind: str, numbers: Any, log: int, stamp: int = 0, frame: str = "table"
) -> tuple[str, str, int, Any]:
    """One message of a ROS 2 bag."""
    msgtype, message = make(ROS2, kind, numbers, stamp, frame)
    return topic, msgtype, log, message


def write_ros1(path: Path, found: Messages) -> Path:
    with Ros1Writer(path) as bag:
        connections: dict[str, Any] = {}
        for topic, kind, log, message in found:
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, kind, typestore=ROS1)
            bag.write(connections[topic], log, ROS1.serialize_ros1(message, kind))
    return path


def write_ros2(path: Path, found: Messages, plugin: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    with Ros2Writer(path, version=9, storage_plugin=plugin) as bag:
        connections: dict[str, Any] = {}
        for topic, kind, log, message in found:
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, kind, typestore=ROS2)
            bag.write(connections[topic], log, ROS2.serialize_cdr(message, kind))
    return path


@pytest.mark.parametrize("form", ["ros1", "db3 folder", "db3", "mcap folder", "mcap"])
def test_every_container_gives_the_same_recording(form: str, tmp_path: Path) -> None:
    if form == "ros1":
        path = write_ros1(tmp_path / "a.bag", messages(ROS1))
    else:
        plugin = StoragePlugin.MCAP if form.startswith("mcap") else StoragePlugin.SQLITE3
        path = write_ros2(tmp_path / "bag", messages(ROS2), plugin)
        path = path if form.endswith("folder") else next(path.glob(f"*.{form}"))
    # The flag has no header: its clock is the log time, which is the others' stamp here.
    same(motion(), load(path), clock=1e-9)


@pytest.mark.parametrize(
    "kinds",
    [
        {"position": "vector3", "force": "vector3"},
        {"position": "array", "velocity": "array", "force": "array"},
        {"position": "vector", "force": "vector"},
        {"position": "labelled_array", "force": "labelled_array"},
    ],
)
def test_the_messages_of_the_thesis_are_read(kinds: dict[str, str], tmp_path: Path) -> None:
    read = load(write_ros2(tmp_path / "bag", messages(ROS2, kinds=kinds)))
    expected = motion()
    rows = slice(0, len(read))
    shifted = read.time[0] - expected.time[0]  # without headers the clock is the log time, 2 ms later
    assert shifted == pytest.approx(0.002 if kinds["force"] != "vector" else 0.0, abs=1e-9)
    for name in ("position_x", "force_z"):
        np.testing.assert_array_equal(read[name], expected[name][rows])


@pytest.mark.parametrize("width", [3, 6, 7])
def test_poses_of_3_6_or_7_numbers_give_their_first_three(width: int, tmp_path: Path) -> None:
    found = [entry for entry in messages(ROS2) if entry[0] != "/telerobot/pose"]
    expected = motion()
    for row, time in enumerate(expected.time):
        numbers = [*expected.vector("position")[row].tolist(), 9.0, 9.0, 9.0, 9.0][:width]
        found.append(entry("/telerobot/pose", "array", numbers, round(time * 1e9)))
    read = load(write_ros2(tmp_path / "bag", found))
    np.testing.assert_array_equal(read["position_y"], expected["position_y"])


def test_theta_is_unknown_before_its_first_message_and_held_after(tmp_path: Path) -> None:
    found = messages(ROS2)
    for at, mass in [(0.155, 1.0), (0.305, 2.0)]:
        found.append(entry("/estimator/theta", "labelled_array", [mass, 0, 500, 60, 60, 0.1, 500, 60], round(at * 1e9)))
    read = load(write_ros2(tmp_path / "bag", found))
    mass = read["theta_m"]
    expected = np.where(read.time < 0.155, np.nan, np.where(read.time < 0.305, 1.0, 2.0))
    np.testing.assert_array_equal(mass, expected)


def test_topics_at_different_rates_meet_on_the_clock_of_the_fastest(tmp_path: Path) -> None:
    found: Messages = []
    slope = np.array([0.1, -0.2, 0.3])
    for k in range(301):  # force at 1 kHz
        stamp = k * 1_000_000
        found.append(entry(TOPICS["force"], "wrench", (slope * k * 1e-3).tolist(), stamp, stamp))
    for k in range(11):  # poses every 33 ms from 5 ms to 335 ms
        stamp = 5_000_000 + k * 33_000_000
        found.append(entry(TOPICS["position"], "pose", (slope * stamp * 1e-9).tolist(), stamp, stamp))
    read = load(write_ros2(tmp_path / "bag", found))
    np.testing.assert_allclose(read.time, np.arange(5, 301) * 1e-3, atol=1e-12)
    np.testing.assert_allclose(read.vector("position"), read.time[:, None] * slope, atol=1e-12)
    np.testing.assert_allclose(read.vector("force"), read.time[:, None] * slope, atol=1e-12)
    assert any("left out 5 of 301" in note for note in read.notes)
    assert any("/telerobot/pose: interpolated" in note for note in read.notes)


def test_a_calendar_s_time_is_counted_from_the_first_sample_without_losing_nanoseconds(tmp_path: Path) -> None:
    start = 1_700_000_000_123_456_789
    read = load(write_ros1(tmp_path / "a.bag", messages(ROS1, start)))
    np.testing.assert_array_equal(read.time, np.round(motion().time * 1e9) / 1e9)
    assert any(str(start) in note for note in read.notes)


def test_header_stamps_of_another_clock_are_not_mixed_with_log_times(tmp_path: Path) -> None:
    found = [(topic, kind, log + 50 * 10**9, message) for topic, kind, log, message in messages(ROS2)]
    read = load(write_ros2(tmp_path / "bag", found))
    assert read.time[0] == pytest.approx(50.002)  # stamps say 0


@pytest.mark.parametrize("name", ["force", "/telerobot/wrench", "telerobot/wrench"])
def test_a_bag_that_calls_its_topics_otherwise_is_mapped(name: str, tmp_path: Path) -> None:
    renamed = [("/ft/data" if topic == TOPICS["force"] else topic, *rest) for topic, *rest in messages(ROS2)]
    path = write_ros2(tmp_path / "bag", renamed)
    with pytest.raises(
        BadInput,
        match=r"found topics /environment/in_contact, /ft/data, .*expected also /telerobot/wrench, or --topic force=",
    ):
        load(path)
    same(motion(), load(path, {name: "/ft/data"}), clock=1e-9)


def test_another_frame_is_told_and_two_frames_are_refused(tmp_path: Path) -> None:
    read = load(write_ros2(tmp_path / "a", messages(ROS2, frame="base_link")))
    assert any("frame 'base_link' taken for the table frame" in note for note in read.notes)
    found = messages(ROS2, frame="base_link")
    for i, (topic, _, log, _) in enumerate(found):
        if topic == TOPICS["force"]:
            found[i] = entry(topic, "wrench", [0.0, 0.0, 0.0], log, log - 2_000_000, "tool0")
    with pytest.raises(BadInput, match=r"frame_id: found 'base_link' on /telerobot/pose.*'tool0' on /telerobot/wrench"):
        load(write_ros2(tmp_path / "b", found))


@pytest.mark.parametrize(
    ("topic", "kind", "numbers", "message"),
    [
        (
            "/telerobot/wrench",
            "pose",
            [0.0, 0.0, 0.0],
            "found geometry_msgs/msg/PoseStamped, expected geometry_msgs/msg/Wrench",
        ),
        ("/telerobot/wrench", "string", None, "found std_msgs/msg/String"),
        ("/telerobot/wrench", "array", [0.0, 0.0], r"messages of 2 numbers, expected 3 \(or 6 and more\)"),
        ("/estimator/theta", "array", [0.0] * 5, "messages of 5 numbers, expected 6, 8 or 10"),
        ("/telerobot/twist", "bool", 1, "found std_msgs/msg/Bool"),
    ],
)
def test_wrong_messages_are_refused(topic: str, kind: str, numbers: Any, message: str, tmp_path: Path) -> None:
    found = [entry for entry in messages(ROS2) if entry[0] != topic]
    for k in range(50):
        found.append(entry(topic, kind, numbers, k * 10**7))
    with pytest.raises(BadInput, match=f"{topic}.*{message}"):
        load(write_ros2(tmp_path / "bag", found))


def test_arrays_whose_length_changes_are_refused(tmp_path: Path) -> None:
    found = messages(ROS2)
    for k in range(2):
        found.append(entry("/estimator/theta", "array", [1.0] * (6 + 2 * k), (k + 1) * 10**8))
    with pytest.raises(BadInput, match=r"messages of \[6, 8\] numbers, expected always as many"):
        load(write_ros2(tmp_path / "bag", found))


@pytest.mark.parametrize(
    ("topics", "message"),
    [
        ({"forse": "/telerobot/wrench"}, "did you mean 'force'"),
        ({"force": "/telerobot/wrensh"}, "did you mean '/telerobot/wrench'"),
        ({"cloud": "/telerobot/pose"}, "found geometry_msgs/msg/PoseStamped, expected sensor_msgs/msg/PointCloud2"),
        ({"true_force": "/telerobot/wrench"}, "read as force and as true_force"),
    ],
)
def test_mappings_that_lead_nowhere_are_refused(topics: dict[str, str], message: str, tmp_path: Path) -> None:
    path = write_ros2(tmp_path / "bag", messages(ROS2))
    with pytest.raises(BadInput, match=message):
        load(path, topics)


def test_topics_that_never_overlap_are_refused(tmp_path: Path) -> None:
    found = messages(ROS2)
    found = [entry for entry in found if (entry[0] == TOPICS["force"]) == (entry[2] > 3 * 10**8)]
    with pytest.raises(BadInput, match="topics that do not overlap"):
        load(write_ros2(tmp_path / "bag", found))


def test_a_stamp_twice_is_refused(tmp_path: Path) -> None:
    found = messages(ROS2, kinds={"position": "vector3", "force": "vector3"})
    found.append(next(entry for entry in found if entry[0] == TOPICS["force"]))
    with pytest.raises(BadInput, match="/telerobot/wrench, message 2: found the stamp 2000000 ns twice"):
        load(write_ros2(tmp_path / "bag", found))


def test_a_bag_keeps_its_clouds(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(12, 3)).astype(np.float32)
    whole = motion()
    save(Recording(whole.time, whole.columns, clouds=((0.1, points),)), tmp_path / "own.mcap")
    found = []
    with AnyReader([tmp_path / "own.mcap"]) as reader:
        for connection, log, raw in reader.messages():
            found.append((connection.topic, connection.msgtype, log, reader.deserialize(raw, connection.msgtype)))
    read = load(write_ros2(tmp_path / "bag", found))
    np.testing.assert_array_equal(read.clouds[0][1], points)
    same(whole, read, clock=1e-9)


@pytest.mark.parametrize("ending", [".bag", ".db3"])
def test_bags_that_are_damaged_are_refused_in_one_line(ending: str, tmp_path: Path) -> None:
    if ending == ".bag":
        path = write_ros1(tmp_path / "a.bag", messages(ROS1))
    else:
        path = next(write_ros2(tmp_path / "b", messages(ROS2)).glob("*.db3"))
    data = path.read_bytes()
    for content in (data[: len(data) // 2], b"nonsense" * 100):
        (tmp_path / f"c{ending}").write_bytes(content)
        with pytest.raises(BadInput, match=rf"c{ending}: found") as caught:
            load(tmp_path / f"c{ending}")
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("size", [1, 700, 10**9])
def test_a_bag_reads_alike_in_batches_of_any_size(size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_ros1(tmp_path / "a.bag", messages(ROS1))
    monkeypatch.setattr("mmt_drake.recording.bags._BATCH", size)
    same(motion(), load(path), clock=1e-9)
