"""The MCAP files written here are read by others, survive a crash, and cost little."""

import os
import resource
import signal
import subprocess
import sys
import time
import tracemalloc
from io import BytesIO
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader, breakup_chunk
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from samples import contact, same

from mmt_drake.errors import BadInput
from mmt_drake.recording import McapWriter, Recording, load, save
from mmt_drake.recording.mcap_layout import MAGIC
from mmt_drake.recording.signals import SIGNALS, signals_in

WHOLE = contact()


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("mcap") / "a.mcap"
    clouds = ((0.5, np.arange(30, dtype=np.float32).reshape(10, 3)),)
    save(Recording(WHOLE.time, WHOLE.columns, clouds=clouds), target)
    return target


def test_rosbags_reads_every_message_with_its_values_stamp_and_frame(path: Path) -> None:
    signals = {signal.topic: signal for signal in signals_in(WHOLE.columns)}
    seen = dict.fromkeys(signals, 0)
    with AnyReader([path]) as reader:
        assert {c.topic: c.msgtype for c in reader.connections} == {
            **{topic: signal.msgtype for topic, signal in signals.items()},
            "/cloud": "sensor_msgs/msg/PointCloud2",
        }
        for connection, log, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            if connection.topic == "/cloud":
                assert message.width == 10 and [field.name for field in message.fields] == ["x", "y", "z"]
                assert message.data.view("<f4").tolist() == list(range(30))
                continue
            row = seen[connection.topic]
            seen[connection.topic] += 1
            assert log == round(WHOLE.time[row] * 1e9)
            if hasattr(message, "header"):
                assert message.header.frame_id == "table"
                assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == log
            expected = [WHOLE.columns[name][row] for name in signals[connection.topic].columns]
            np.testing.assert_array_equal(fields(message)[: len(expected)], expected)
    assert set(seen.values()) == {len(WHOLE)}


def fields(message: object) -> list[float]:
    """The numbers of a message, picked by the names of its fields."""
    for part, names in [("pose", ("position",)), ("twist", ("linear",)), ("wrench", ("force",)), ("point", ())]:
        if hasattr(message, part):
            vector = getattr(message, part)
            for name in names:
                vector = getattr(vector, name)
            if part == "pose":
                turn = message.pose.orientation  # type: ignore[attr-defined]
                assert (turn.x, turn.y, turn.z, turn.w) == (0.0, 0.0, 0.0, 1.0)
            return [vector.x, vector.y, vector.z]
    if hasattr(message, "quaternion"):
        turn = message.quaternion
        return [turn.x, turn.y, turn.z, turn.w]
    return list(np.atleast_1d(message.data))  # type: ignore[attr-defined]


def test_the_mcap_package_reads_it_with_all_checksums(path: Path) -> None:
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None and summary.statistics is not None
        count = len(WHOLE) * len(signals_in(WHOLE.columns)) + 1
        assert summary.statistics.message_count == count
        times = [message.log_time for _, _, message in reader.iter_messages()]
        assert len(times) == count and times == sorted(times)
        forces = list(reader.iter_messages(topics=["/telerobot/wrench"]))
        assert len(forces) == len(WHOLE) and forces[0][0].encoding == "ros2msg"
        assert b"MSG: geometry_msgs/Vector3" in forces[0][0].data  # dependencies are in the file
        file.seek(0)
        records = list(StreamReader(file, validate_crcs=True).records)
    assert [message.sequence for _, _, message in forces] == list(range(len(WHOLE)))
    assert type(records[0]).__name__ == "Header" and type(records[-1]).__name__ == "Footer"


def test_message_indexes_point_at_the_messages(path: Path) -> None:
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None
        for index in summary.chunk_indexes:
            file.seek(index.chunk_start_offset)
            inside = file.read(index.chunk_length + index.message_index_length)
            records = list(
                islice(
                    StreamReader(BytesIO(inside), skip_magic=True, emit_chunks=True).records,
                    1 + len(index.message_index_offsets),
                )
            )
            chunk, tables = records[0], records[1:]
            assert {table.channel_id for table in tables} == set(index.message_index_offsets)
            by_place = {}
            position = 0
            for message in breakup_chunk(chunk):
                by_place[position] = message
                position += 9 + 22 + len(message.data)
            for table in tables:
                for log_time, offset in table.records:
                    assert by_place[offset].channel_id == table.channel_id
                    assert by_place[offset].log_time == log_time


@pytest.mark.parametrize("kept", [0.2, 0.41, 0.5, 0.77, 0.95, 0.999])
def test_a_file_cut_anywhere_is_read_up_to_its_last_complete_chunk(kept: float, path: Path, tmp_path: Path) -> None:
    data = path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: int(kept * len(data))])
    complete = [
        index.message_end_time
        for index in summary_of(path).chunk_indexes
        if index.chunk_start_offset + index.chunk_length <= kept * len(data) and len(index.message_index_offsets) > 1
    ]
    if not complete:
        with pytest.raises(BadInput, match="no message"):
            load(cut)
        return
    read = load(cut)
    rows = int(np.searchsorted(WHOLE.time, max(complete) * 1e-9 + 1e-6))
    assert len(read) == rows
    np.testing.assert_array_equal(read["force_y"], WHOLE["force_y"][:rows])
    assert any("cut off" in note for note in read.notes)


def summary_of(path: Path):
    with path.open("rb") as file:
        return make_reader(file).get_summary()


def test_zeros_and_garbage_after_a_power_cut_do_not_hide_what_is_complete(path: Path, tmp_path: Path) -> None:
    index = summary_of(path).chunk_indexes
    first_two = [entry for entry in index if len(entry.message_index_offsets) > 1][1]
    end = first_two.chunk_start_offset + first_two.chunk_length
    data = path.read_bytes()
    damaged = bytearray(data[:end])
    damaged[-500:-400] = bytes(100)
    for content, rows in [(data[:end] + bytes(4096), 2000), (bytes(damaged), 1000)]:
        (tmp_path / "cut.mcap").write_bytes(content)
        read = load(tmp_path / "cut.mcap")
        assert len(read) == rows and any("cut off" in note or "damaged" in note for note in read.notes)


def test_a_completed_file_with_a_damaged_chunk_is_refused(path: Path, tmp_path: Path) -> None:
    data = bytearray(path.read_bytes())
    entry = summary_of(path).chunk_indexes[1]
    data[entry.chunk_start_offset + entry.chunk_length - 200] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(bytes(data))
    with pytest.raises(BadInput, match="damaged data"):
        load(tmp_path / "a.mcap")


CRASHING = """
import os, sys, time
import numpy as np
from mmt_drake.recording import McapWriter
writer = McapWriter(sys.argv[1], [("position", 3), ("force", 3)])
for second in range(3):
    seconds = second + np.arange(1000) * 1e-3
    writer.write_block(seconds, {"position": np.zeros((1000, 3)), "force": np.full((1000, 3), second)})
time.sleep(0.3)  # the last block is on its way in the writer's thread
os.kill(os.getpid(), 9)
"""


def test_a_killed_process_leaves_every_block_it_wrote(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", CRASHING, str(tmp_path / "a.mcap")], check=False)
    assert done.returncode == -signal.SIGKILL
    assert os.listdir(tmp_path) == ["a.part.mcap"]
    read = load(tmp_path / "a.part.mcap")
    assert len(read) == 3000 and read["force_x"][-1] == 2.0 and "cut off" in " ".join(read.notes)


@pytest.fixture
def small_disk():
    """Files of this process cannot grow beyond 300 kB: writing more fails like on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)
    signal.signal(signal.SIGXFSZ, previous)


def test_a_full_disk_ends_a_live_recording_with_what_was_complete(small_disk: None, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    writer = McapWriter(tmp_path / "a.mcap", [("position", 3), ("force", 3)])
    with pytest.raises(
        BadInput, match=r"a\.mcap: found File too large, .*recorded until (\d\.\d+) s is kept in .*a\.part\.mcap"
    ):
        for second in range(20):
            noise = 0.01 * rng.standard_normal((1000, 3))
            writer.write_block(second + np.arange(1000) * 1e-3, {"position": noise, "force": noise})
    writer.close()  # has nothing left to do
    read = load(tmp_path / "a.part.mcap")
    assert len(read) % 1000 == 0 and len(read) > 0


@pytest.mark.parametrize("ending", [".mcap", ".csv", ".npz"])
def test_a_full_disk_leaves_nothing_half_written(ending: str, small_disk: None, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=rf"a{ending}: found File too large, expected (a place to write to|room .*)$"):
        save(WHOLE, tmp_path / f"a{ending}")
    assert os.listdir(tmp_path) == []


def test_an_older_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    target, part = tmp_path / "a.mcap", tmp_path / "a.part.mcap"
    target.write_text("older")
    with pytest.raises(BadInput):
        McapWriter(target, [("position", 4)])
    assert os.listdir(tmp_path) == ["a.mcap"]
    with pytest.raises(ZeroDivisionError), McapWriter(target, [("position", 3)]):
        raise ZeroDivisionError
    assert target.read_text() == "older" and summary_of(part) is not None  # completed, under its own name
    with McapWriter(target, [("position", 3)]):
        assert target.read_text() == "older" and part.read_bytes().startswith(MAGIC)
    assert target.read_bytes().startswith(MAGIC)
    assert sorted(os.listdir(tmp_path)) == ["a.mcap", "a.part1.mcap"], "what an error has left is kept"


def test_a_second_writer_of_a_file_is_refused_and_spoils_nothing(tmp_path: Path) -> None:
    target = tmp_path / "a.mcap"
    with McapWriter(target, [("position", 3)]) as first:
        first.write_block([0.0], {"position": np.ones((1, 3))})
        for refused in (lambda: McapWriter(target, [("position", 3)]), lambda: save(WHOLE, target)):
            with pytest.raises(BadInput, match=r"a\.mcap: found another run that is recording to it"):
                refused()
    assert first.stands and os.listdir(tmp_path) == ["a.mcap"] and first.path == target
    save(WHOLE, target)
    assert not first.stands, "another recording has its name now"


@pytest.mark.parametrize(
    ("signals", "seconds", "columns", "message"),
    [
        ([("force", 3)], [0.0, 0.0], {"force": np.zeros((2, 3))}, "row 2"),
        ([("force", 3)], [0.0, np.nan], {"force": np.zeros((2, 3))}, "row 2"),
        ([("force", 3)], [-1.0], {"force": np.zeros((1, 3))}, "0 s or later"),
        ([("force", 3)], [0.0], {"force": np.zeros((1, 2))}, r"shape \(1, 2\)"),
        ([("force", 3)], [0.0], {}, "also 'force'"),
        ([("forse", 3)], [0.0], {}, "did you mean 'force'"),
        ([("force", 2)], [0.0], {}, "size 3 or 1"),
        ([("force", 3), ("force", 3)], [0.0], {}, "same signal twice"),
    ],
)
def test_blocks_that_do_not_fit_are_refused(signals, seconds, columns, message, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=message), McapWriter(tmp_path / "a.mcap", signals) as writer:
        writer.write_block(seconds, columns)


def every_signal() -> list[tuple[str, int]]:
    written = [signal for signal in SIGNALS if signal.quantity != "number"]
    widest = {signal.name: max(other.size for other in written if other.name == signal.name) for signal in written}
    return list(widest.items())


def block(second: int, rng: np.random.Generator) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    columns = {name: rng.random((1000, size)).round() for name, size in every_signal()}
    columns["orientation"] = np.tile([0.0, 0.0, 0.0, 1.0], (1000, 1))
    return second + np.arange(1000) * 1e-3, columns


@pytest.fixture(scope="module")
def peer(tmp_path_factory: pytest.TempPathFactory) -> tuple[float, float]:
    """What rosbags takes per message to encode and to decode every signal [s]."""
    path = tmp_path_factory.mktemp("peer") / "a.mcap"
    with McapWriter(path, every_signal()) as writer:
        writer.write_block(*block(0, np.random.default_rng(0)))
    types = get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([path]) as reader:
        raw = list(islice(reader.messages(), 3000))
        begin = time.perf_counter()
        messages = [(reader.deserialize(data, c.msgtype), c.msgtype) for c, _, data in raw]
        decoding = time.perf_counter() - begin
    begin = time.perf_counter()
    for message, msgtype in messages:
        types.serialize_cdr(message, msgtype)
    return (time.perf_counter() - begin) / len(raw), decoding / len(raw)


def test_writing_and_reading_are_several_times_faster_than_message_by_message(
    peer: tuple[float, float], tmp_path: Path
) -> None:
    rng = np.random.default_rng(0)
    blocks = [block(second, rng) for second in range(20)]
    with McapWriter(tmp_path / "a.mcap", every_signal()) as writer:
        begin = time.perf_counter()
        for seconds, columns in blocks:
            writer.write_block(seconds, columns)
    writing = time.perf_counter() - begin
    begin = time.perf_counter()
    assert len(load(tmp_path / "a.mcap")) == 20_000
    reading = time.perf_counter() - begin
    messages = 1000 * len(every_signal()) * len(blocks)
    assert writing < 0.2 * messages * peer[0] and reading < 0.2 * messages * peer[1]


def test_memory_does_not_grow_with_the_recording(tmp_path: Path) -> None:
    def held() -> int:
        """Bytes of the writers, ours and mcap's; other threads of the tests have memory of their own."""
        kept = tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, "*mcap*")])
        return sum(trace.size for trace in kept.traces)

    rng = np.random.default_rng(0)
    tracemalloc.start()
    with McapWriter(tmp_path / "a.mcap", every_signal()) as writer:
        for second in range(10):
            writer.write_block(*block(second, rng))
        before = held()
        for second in range(10, 60):
            writer.write_block(*block(second, rng))
        grown = held() - before
    tracemalloc.stop()
    assert 0 < grown < 50 * 10_000  # bytes; what stays of a second is its entry in the index


def test_an_uneven_clock_and_a_late_start_come_back(tmp_path: Path) -> None:
    late = contact(0.5, start=1000.25)
    save(late, tmp_path / "a.mcap")
    same(late, load(tmp_path / "a.mcap"), clock=0.6e-9)
