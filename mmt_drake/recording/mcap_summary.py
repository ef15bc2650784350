"""The frame around the chunks of an MCAP file: declarations before them, summary after them."""

import zlib
from collections.abc import Mapping, Sequence
from typing import Any

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from mmt_drake.recording.mcap_layout import MAGIC
from mmt_drake.recording.messages import definition


def as_bytes(records: Sequence[McapRecord]) -> bytes:
    """Records as they stand in the file."""
    builder: Any = RecordBuilder()  # has no types
    for record in records:
        record.write(builder)
    return bytes(builder.end())


def declarations(topics: Sequence[tuple[str, str]]) -> tuple[list[Schema], list[Channel]]:
    """Schemas (with the text of their messages) and channels, numbered from 1 in order, of topics and their types."""
    types = list(dict.fromkeys(msgtype for _, msgtype in topics))
    schemas = [
        Schema(id=i, name=msgtype, encoding="ros2msg", data=definition(msgtype).encode())
        for i, msgtype in enumerate(types, 1)
    ]
    channels = [
        Channel(id=i, topic=topic, message_encoding="cdr", metadata={}, schema_id=types.index(msgtype) + 1)
        for i, (topic, msgtype) in enumerate(topics, 1)
    ]
    return schemas, channels


def ending(
    position: int,
    schemas: Sequence[Schema],
    channels: Sequence[Channel],
    chunks: Sequence[ChunkIndex],
    metadata: Sequence[MetadataIndex],
    counts: Mapping[int, int],
) -> bytes:
    """Data end, summary (everything a reader needs to find a message), footer and magic.

    Args:
        position: where in the file it will stand.
        counts: channel id -> number of messages.
    """
    data_end = as_bytes([DataEnd(0)])
    start = position + len(data_end)
    statistics = Statistics(
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
    groups: list[tuple[Opcode, Sequence[McapRecord]]] = [
        (Opcode.SCHEMA, schemas),
        (Opcode.CHANNEL, channels),
        (Opcode.STATISTICS, [statistics]),
        (Opcode.CHUNK_INDEX, chunks),
        (Opcode.METADATA_INDEX, metadata),
    ]
    summary = b""
    offsets = []
    for opcode, records in groups:
        if records:
            group = as_bytes(records)
            offsets.append(SummaryOffset(opcode, start + len(summary), len(group)))
            summary += group
    offset_start = start + len(summary)
    summary += as_bytes(offsets)
    footer = as_bytes([Footer(start, offset_start, 0)])
    # The checksum covers the summary and the footer up to the checksum itself.
    footer = as_bytes([Footer(start, offset_start, zlib.crc32(summary + footer[:-4]))])
    return data_end + summary + footer + MAGIC
