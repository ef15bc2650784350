"""Files that ask for more than any measurement needs, or hold something else: one line, at once."""

import os
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import numpy as np
import pytest
import zstandard
from bag_samples import ROS1, messages
from mcap.records import Channel, Chunk, Header, Schema
from memory import peak_of
from rosbags.rosbag1 import Writer as Ros1Writer
from samples import contact, same
from table_samples import csv_text, good

from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.mcap_layout import MAGIC, as_bytes

GOOD = csv_text(good())
MEMORY, SECONDS = 100e6, 5.0
CLOUD = {"cloud_time": np.array([0.0, 0.1]), "cloud_size": np.array([1, 2]), "cloud_points": np.zeros((3, 3))}


def sparse(path: Path, beginning: bytes) -> None:
    """12 GB of nothing after a few bytes."""
    path.write_bytes(beginning)
    os.truncate(path, 12 * 10**9)


def bomb(path: Path) -> None:
    """A member that says it unpacks to 3.75 GiB."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("time.npy", bytes(1000))
    data = bytearray(path.read_bytes())
    central = data.rindex(b"PK\x01\x02")
    data[central + 24 : central + 28] = (0xF0000000).to_bytes(4, "little")
    path.write_bytes(bytes(data))


def lying_header(path: Path) -> None:
    """Members whose headers announce more numbers than there are."""
    np.savez(path.with_suffix(".true.npz"), **good())
    with zipfile.ZipFile(path.with_suffix(".true.npz")) as archive, zipfile.ZipFile(path, "w") as changed:
        for name in archive.namelist():
            content = archive.read(name).replace(b"(50,), }        ", b"(1500000000,), }")
            changed.writestr(name, content)


def no_array(path: Path) -> None:
    np.savez(path, **good())
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("notes.txt", "made on a Monday")


def arrays(**more: np.ndarray) -> Callable[[Path], None]:
    return lambda path: np.savez(path, **good() | more)


def mcap(compression: str, packed: bytes, size: int) -> Callable[[Path], object]:
    """A file of one chunk that says what it unpacks to."""
    records = [
        Header("ros2", "made"),
        Schema(id=1, name="std_msgs/msg/Float64", encoding="ros2msg", data=b"float64 data"),
        Channel(id=1, topic="/probe/position", message_encoding="cdr", metadata={}, schema_id=1),
        Chunk(compression, packed, 0, 0, 0, size),
    ]
    return lambda path: path.write_bytes(MAGIC + as_bytes(records) + MAGIC)


def csv(text: str) -> Callable[[Path], object]:
    return lambda path: path.write_text(text)


def clouds(**changed: list[object]) -> Callable[[Path], None]:
    return arrays(**CLOUD | {f"cloud_{name}": np.array(values) for name, values in changed.items()})


ZEROS = bytes(2 * 10**8)
HUGE = MAGIC + b"\x06" + (11 * 10**9).to_bytes(8, "little")


@pytest.mark.parametrize(
    ("name", "make", "message"),
    [
        ("a.csv", csv(GOOD.replace("\n", '\n"', 2)), "row 1 .* '\"0.0'"),
        ("a.csv", csv(GOOD.replace("\n", '\n"' + 200_000 * "x", 2)), "row 1 .* expected a number"),
        ("a.csv", csv(200_000 * "x" + GOOD), "'time' among them"),
        ("a.csv", lambda path: sparse(path, GOOD.encode()), "bytes without a line end at"),
        ("a.csv", lambda path: sparse(path, b"time,"), "bytes without a line end at 0"),
        ("a.csv", csv("time" + 100_000 * ",c" + "\n"), "found 100001 columns, expected at most 1000"),
        ("a.npz", arrays(**{f"c{i}": np.zeros(1) for i in range(1001)}), "1008 arrays, expected at most"),
        ("a.npz", no_array, "notes.txt: found a member that is no array"),
        ("a.npz", bomb, "that unpack to 3840 MiB .*expected at most 1024 MiB"),
        ("a.npz", lying_header, "time: found 400 bytes, expected 12000000000"),
        (
            "a.npz",
            clouds(points=[[0, 0, 0], [0, np.nan, 0], [0, 0, 0]]),
            "row 2, array 'cloud_points'.*expected finite",
        ),
        ("a.npz", clouds(time=[0, np.nan]), "row 2, array 'cloud_time'"),
        ("a.npz", clouds(time=[0.1, 0.0]), "times that increase"),
        ("a.npz", clouds(size=[4, -1]), "cloud_size: found"),
        ("a.npz", clouds(size=[1.5, 1.5]), "cloud_size: found"),
        ("a.npz", arrays(mass_kg=np.array(np.nan)), "constant 'mass_kg': found nan"),
        ("a.mcap", mcap("zstd", b"", 12 * 10**9), "found a record of .* MiB, expected at most 256 MiB"),
        ("a.mcap", mcap("zstd", zstandard.compress(ZEROS), 100), "damaged data"),
        ("a.mcap", mcap("lz4", lz4.frame.compress(ZEROS), 100), "damaged data"),
        ("a.mcap", lambda path: sparse(path, HUGE), "found a record of"),
    ],
)
def test_what_no_measurement_asks_for_is_refused_before_it_is_read(
    name: str, make: Callable[[Path], object], message: str, tmp_path: Path
) -> None:
    make(tmp_path / name)

    def refused() -> BadInput:
        with pytest.raises(BadInput, match=message) as caught:
            load(tmp_path / name)
        return caught.value

    began = time.monotonic()
    error, peak = peak_of(refused)
    assert time.monotonic() - began < SECONDS and peak < MEMORY and len(str(error)) <= 4100


@pytest.mark.parametrize("compression", Ros1Writer.CompressionFormat)
def test_a_chunk_of_a_ros_1_bag_unpacks_to_so_much_and_no_more(
    compression: Ros1Writer.CompressionFormat, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for size, found in ((10, "cannot be read"), (2**22, "found a record of 1 MiB, expected at most 1 MiB")):
        path = tmp_path / f"{size}.bag"
        bag = Ros1Writer(path)
        bag.set_compression(compression)
        with bag:
            topic, kind, stamp, _ = messages(ROS1)[0]
            bag.write(bag.add_connection(topic, kind, typestore=ROS1), stamp, bytes(size))
        for module in ("bounds", "bags"):
            monkeypatch.setattr(f"mmt_drake.recording.{module}.MOST_AT_ONCE", 2**20)
        with pytest.raises(BadInput, match=found):
            load(path)


def test_a_packed_file_of_a_ros_2_bag_is_not_unpacked_onto_the_disk_whatever_its_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "metadata.yaml").write_text("")
    (tmp_path / "a.db3.zstd").write_bytes(zstandard.compress(bytes(10**7)))
    monkeypatch.setattr("mmt_drake.recording.bounds._ALWAYS", 2**20)
    with pytest.raises(BadInput, match=r"a\.db3\.zstd: found .* that unpack to"):
        load(tmp_path)


def test_numbers_of_one_recording_are_bounded_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = contact(0.5)
    monkeypatch.setattr("mmt_drake.recording.bounds.MOST", 10_000)
    for ending in ("csv", "npz", "mcap"):
        save(written, tmp_path / f"a.{ending}")
        with pytest.raises(BadInput, match=f"a.{ending}: found numbers of .* MiB, expected at most"):
            load(tmp_path / f"a.{ending}")


def test_a_clock_that_jumps_costs_nothing(tmp_path: Path) -> None:
    part = contact(2.5)
    jumping = Recording(part.time + 2e9 * (part.time > 1.2345), part.columns)
    _, written = peak_of(lambda: save(jumping, tmp_path / "a.mcap"))
    read, peak = peak_of(lambda: load(tmp_path / "a.mcap"))
    assert max(written, peak) < MEMORY
    same(jumping, read, clock=1e-6)


@pytest.mark.parametrize("ending", ["npz", "mcap"])
def test_a_constant_may_have_any_name_but_a_column_s(ending: str, tmp_path: Path) -> None:
    part = contact(0.1)
    path = tmp_path / f"a.{ending}"
    save(Recording(part.time, part.columns, constants={"file": 1.5, "allow_pickle": 2.0}), path)
    assert load(path).constants == {"file": 1.5, "allow_pickle": 2.0}
    if ending == "mcap":  # an NPZ file has each name once
        save(Recording(part.time, part.columns, constants={"time": 1.5}), path)
        with pytest.raises(BadInput, match="time: found a constant, expected a column alone"):
            load(path)


def test_reading_csv_takes_one_and_a_half_times_the_file_at_most(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("mmt_drake.recording.csv_file._PIECE", 2**17, raising=False)
    part, path = contact(4.0), tmp_path / "a.csv"
    save(part, path)
    load(path)  # what is compiled at first use does not grow with the file
    read, peak = peak_of(lambda: load(path))
    same(part, read)
    assert peak < 1.5 * path.stat().st_size


def test_rows_and_lines_are_counted_over_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.recording.csv_file._PIECE", 100)
    path = tmp_path / "a.csv"
    path.write_text(GOOD)
    read = load(path)
    np.testing.assert_array_equal(read["force_z"], good()["force_z"])
    lines = GOOD.splitlines()
    path.write_text("\n".join([*lines[:40], lines[40].replace(",", ",x", 1)]))
    with pytest.raises(BadInput, match=r"row 40 \(line 41\), column 'position_x'"):
        load(path)
    path.write_text(GOOD[:-4])
    with pytest.raises(BadInput, match=r"row 50 \(line 51\).* a file cut off"):
        load(path)
    path.write_bytes(GOOD.encode()[:-30] + b"\xff")
    with pytest.raises(BadInput, match=f"no text at {len(GOOD) - 30}"):
        load(path)


def test_a_damaged_file_s_parser_that_says_nothing_is_told_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    np.savez(tmp_path / "a.npz", **good())

    def fail(*_: object) -> None:
        raise EOFError

    monkeypatch.setattr(np.lib.format, "read_magic", fail)
    with pytest.raises(BadInput, match=r"cannot be read \(EOFError\)"):
        load(tmp_path / "a.npz")
