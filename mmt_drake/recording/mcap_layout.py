"""The layout of an MCAP file: message records with CDR bytes, declarations before them, a summary after them."""

import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

from mmt_drake.recording.messages import STAMPED, definition, layout
from mmt_drake.recording.signals import ARRAY, POSE, Signal

MAGIC = b"\x89MCAP0\r\n"
CONSTANTS = "mmt_drake.constants"
"""Name of the metadata record that holds ``Recording.constants``."""

MADE_BY = "mmt_drake.run"
"""Name of the metadata record that holds ``Recording.made_by``."""

FRAME = "table"
"""frame_id of every header that is written."""

_FRAME = np.frombuffer(FRAME.encode() + b"\0", dtype=np.uint8)
_RECORD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
_INDEX_ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])


def row_of(signals: Sequence[Signal]) -> np.dtype[np.void]:
    """The bytes of a tick: of each signal the message record, as a field with its topic's name."""
    return np.dtype([(signal.topic, [("record", _RECORD), ("message", _message(signal))]) for signal in signals])


def _message(signal: Signal) -> np.dtype[np.void]:
    made = layout(signal.msgtype, signal.size if signal.msgtype == ARRAY else len(_FRAME))
    assert made is not None  # whatever is written has a fixed one
    return made


def fill_constants(part: NDArray[np.void], channel: int, signal: Signal) -> None:
    """Put into every row what is the same in each message of a topic."""
    record, message = part["record"], part["message"]
    record["opcode"] = Opcode.MESSAGE
    record["length"] = part.dtype.itemsize - 9
    record["channel"] = channel
    message["cdr"] = (0, 1, 0, 0)  # CDR, little-endian
    if signal.msgtype == ARRAY:
        message["length"] = signal.size
    elif signal.msgtype in STAMPED:
        message["length"] = len(_FRAME)
        message["frame"] = _FRAME
    if signal.msgtype == POSE:
        message["values"][:, 6] = 1.0  # no rotation: quaternion (0, 0, 0, 1)


def message_indexes(row: np.dtype[np.void], nanoseconds: NDArray[np.uint64]) -> dict[int, bytes]:
    """The message index record of each channel of a block, by channel id: when each message was [ns], (n,), and where
    in the chunk it stands.
    """
    entries = np.empty(len(nanoseconds), dtype=_INDEX_ENTRY)
    entries["log_time"] = nanoseconds
    size, offset, indexes = entries.nbytes, 0, {}
    for channel, topic in enumerate(row.names or (), 1):
        entries["offset"] = np.arange(len(nanoseconds)) * row.itemsize + offset
        offset += row[topic].itemsize
        head = bytes([Opcode.MESSAGE_INDEX]) + (6 + size).to_bytes(8, "little") + channel.to_bytes(2, "little")
        indexes[channel] = head + size.to_bytes(4, "little") + entries.tobytes()
    return indexes


def as_bytes(written: Sequence[records.McapRecord]) -> bytes:
    """Records as they stand in the file."""
    builder: Any = RecordBuilder()  # has no types
    for record in written:
        record.write(builder)
    return bytes(builder.end())


def declarations(
    topics: Sequence[tuple[str, str]], signals: Sequence[Signal]
) -> tuple[list[records.Schema], list[records.Channel]]:
    """Schemas (with the text of their messages) and channels, numbered from 1 in order, of topics and their types.

    A signal's channel has its columns and their units as metadata: an array of numbers says neither.
    """
    labels = {s.topic: {"columns": ", ".join(s.columns), "units": ", ".join(s.units)} for s in signals}
    types = list(dict.fromkeys(msgtype for _, msgtype in topics))
    schemas = [
        records.Schema(id=i, name=msgtype, encoding="ros2msg", data=definition(msgtype).encode())
        for i, msgtype in enumerate(types, 1)
    ]
    channels = [
        records.Channel(i, topic, "cdr", labels.get(topic, {}), types.index(msgtype) + 1)
        for i, (topic, msgtype) in enumerate(topics, 1)
    ]
    return schemas, channels


def ending(
    position: int,
    schemas: Sequence[records.Schema],
    channels: Sequence[records.Channel],
    chunks: Sequence[records.ChunkIndex],
    metadata: Sequence[records.MetadataIndex],
    counts: Mapping[int, int],
) -> bytes:
    """Data end, summary (everything a reader needs to find a message), footer and magic.

    Args:
        position: where in the file it will stand.
        counts: channel id -> number of messages.
    """
    data_end = as_bytes([records.DataEnd(0)])
    start = position + len(data_end)
    statistics = records.Statistics(
        attachment_count=0,
        channel_count=len(channels),
        channel_message_counts=dict(counts),
        chunk_count=len(chunks),
        message_count=sum(counts.values()),
        message_end_time=max((index.message_end_time for index in chunks), default=0),
        message_start_time=min((index.message_start_time for index in chunks), default=0),
        metadata_count=len(metadata),
        schema_count=len(schemas),
    )
    groups: list[tuple[Opcode, Sequence[records.McapRecord]]] = [
        (Opcode.SCHEMA, schemas),
        (Opcode.CHANNEL, channels),
        (Opcode.STATISTICS, [statistics]),
        (Opcode.CHUNK_INDEX, chunks),
        (Opcode.METADATA_INDEX, metadata),
    ]
    summary = b""
    offsets = []
    for opcode, group_records in groups:
        if group_records:
            group = as_bytes(group_records)
            offsets.append(records.SummaryOffset(opcode, start + len(summary), len(group)))
            summary += group
    offset_start = start + len(summary)
    summary += as_bytes(offsets)
    footer = as_bytes([records.Footer(start, offset_start, 0)])
    # The checksum covers the summary and the footer up to the checksum itself.
    footer = as_bytes([records.Footer(start, offset_start, zlib.crc32(summary + footer[:-4]))])
    return data_end + summary + footer + MAGIC
