"""MCAP files of other writers and other middleware."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_samples import ROS2, Messages, messages, motion
from mcap.writer import CompressionType, Writer
from samples import same

from mmt_drake.errors import BadInput
from mmt_drake.recording import load


def foreign_mcap(found: Messages, profile: str = "ros2", encoding: str = "cdr", **options: Any) -> bytes:
    """An MCAP file as the mcap package's own writer makes it: schemas and channels inside the chunks."""
    stream = BytesIO()
    writer = Writer(stream, chunk_size=20_000, **options)
    writer.start(profile=profile)
    channels: dict[str, int] = {}
    for topic, kind, log, message in found:
        if topic not in channels:
            text = ROS2.generate_msgdef(kind, ros_version=2)[0]
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channels[topic] = writer.register_channel(topic, encoding, schema)
        writer.add_message(channels[topic], log, bytes(ROS2.serialize_cdr(message, kind)), log)
    writer.finish()
    return stream.getvalue()


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.NONE, "enable_crcs": False},
        {"use_chunking": False},
        {"repeat_channels": False, "repeat_schemas": False},
    ],
)
def test_mcap_files_of_other_writers_are_read(options: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(foreign_mcap(messages(ROS2), **options))
    same(motion(), load(tmp_path / "a.mcap"), clock=1e-9)


def test_a_cut_mcap_file_of_another_writer_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    data = foreign_mcap(messages(ROS2))
    (tmp_path / "a.mcap").write_bytes(data[: len(data) // 2])
    read = load(tmp_path / "a.mcap")
    assert 5 < len(read) < 55 and any("cut off" in note for note in read.notes)
    np.testing.assert_array_equal(read["position_x"], motion()["position_x"][: len(read)])


@pytest.mark.parametrize(
    ("options", "message"), [({"profile": "ros1"}, "profile 'ros1'"), ({"encoding": "json"}, "encoding 'json'")]
)
def test_mcap_files_of_other_middleware_are_refused(options: dict[str, str], message: str, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(foreign_mcap(messages(ROS2), **options))
    with pytest.raises(BadInput, match=message):
        load(tmp_path / "a.mcap")


def test_messages_in_any_order_come_back_in_that_of_their_times(tmp_path: Path) -> None:
    found = messages(ROS2)
    shuffled = [found[i] for i in np.random.default_rng(0).permutation(len(found))]
    (tmp_path / "a.mcap").write_bytes(foreign_mcap(shuffled))
    read = load(tmp_path / "a.mcap")
    expected = motion()
    np.testing.assert_array_equal(read["force_z"], expected["force_z"][-len(read) :])
