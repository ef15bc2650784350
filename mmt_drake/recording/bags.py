"""Recordings from bags: MCAP files, ROS 1 bags, ROS 2 databases and bag folders."""

import bz2
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from mcap.records import Schema
from rosbags.highlevel import AnyReader
from rosbags.rosbag1.reader import Chunk
from rosbags.rosbag1.reader import Reader as Ros1Reader
from rosbags.typesys import get_types_from_msg
from rosbags.typesys.store import Typestore

from mmt_drake.errors import BadInput, readable
from mmt_drake.recording import clouds
from mmt_drake.recording.bounds import MOST_AT_ONCE, check_at_once, check_size, check_unpacked
from mmt_drake.recording.check import completed
from mmt_drake.recording.mcap_file import McapFile, messages_in
from mmt_drake.recording.messages import Bytes, Integers, ros2_types
from mmt_drake.recording.one_clock import joined
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import CLOUD, REQUIRED, SIGNALS, Signal, kind_of
from mmt_drake.recording.stored import StoredClouds, StoredPoints
from mmt_drake.recording.streams import TopicStream, shared, wanted_topics

_BATCH = 1_000_000
"""Bytes of one topic that are read together from a bag without chunks."""


class _Gathering:
    """The topics of one bag that are read, and what has come of them so far."""

    def __init__(self, source: str, available: Mapping[str, str], topics: Mapping[str, str]):
        self.source, self.available = source, available
        self.wanted: dict[str, list[Signal]] = wanted_topics(available, topics, source)
        self.streams: list[TopicStream] = []
        self.clouds: list[tuple[int, int, int]] = []
        self._points = StoredPoints()
        self._size = 0

    def add(self, stream: TopicStream, logs: Integers, data: Bytes, starts: Integers, sizes: Integers) -> None:
        """Take in messages of one topic; arguments as of ``TopicStream.add``."""
        if stream.msgtype != CLOUD:
            self._take(8 * len(logs) * (2 + max(signal.size for signal in stream.signals)))  # two clocks beside it
            stream.add(logs, data, starts, sizes, self.source)
            return
        for log, start, size in zip(logs, starts, sizes, strict=True):
            message = stream.parse(data[start : start + size].tobytes())
            points = clouds.decode(message, self.source, stream.topic)
            self._take(points.nbytes)
            self.clouds.append((int(log), *self._points.add(points)))

    def _take(self, size: int) -> None:
        self._size += size
        check_size(self.source, self._size)

    def recording(self, forces: bool, notes: list[str], constants: Mapping[str, float]) -> Recording:
        """Everything on one clock, checked."""
        time, columns, joining, zero = joined(self.streams, self.source)
        unread = sorted(set(self.available) - set(self.wanted))
        if unread:
            joining.append(f"topics not read: {', '.join(unread)}")
        self._check_probe(columns, forces)
        late = sorted((cloud for cloud in self.clouds if cloud[0] >= zero), key=lambda cloud: cloud[0])
        if len(late) < len(self.clouds):
            joining.append(f"left out {len(self.clouds) - len(late)} point clouds before the first sample")
        surfaces = StoredClouds(self._points, [((stamp - zero) / 1e9, start, count) for stamp, start, count in late])
        return completed(
            time, columns, self.source, forces=forces, notes=notes + joining, clouds=surfaces, constants=constants
        )

    def _check_probe(self, columns: Mapping[str, object], forces: bool) -> None:
        """Refuse a bag without what every recording must have, named as topics."""
        kind = kind_of(columns)
        required = REQUIRED["contact" if kind == "motion" and forces else kind]
        for signal in SIGNALS:
            if set(signal.columns) <= set(required) and signal.columns[0] not in columns:
                expected = f"also {signal.topic}, or --topic {signal.name}=/its/name"
                raise BadInput(self.source, found=f"topics {', '.join(sorted(self.available))}", expected=expected)


def load_mcap(path: Path, topics: Mapping[str, str], forces: bool) -> Recording:
    """Read a recording from an ``.mcap`` file with ROS 2 messages.

    Args:
        path: the file; it may end anywhere, then what is complete is read and ``notes`` says so.
        topics: see ``streams.wanted_topics``.
        forces: see ``check.completed``.

    Raises:
        BadInput: no MCAP file, a damaged one, one without the topics of a recording, or what
            ``check.completed`` finds.
    """
    with readable(path, "a file", "a sound MCAP file"):
        return _load_mcap(path, topics, forces)


def _load_mcap(path: Path, topics: Mapping[str, str], forces: bool) -> Recording:
    file = McapFile(path)
    typed = {number: file.schemas.get(channel.schema_id) for number, channel in file.channels.items()}
    available = {file.channels[number].topic: schema.name for number, schema in typed.items() if schema}
    gathering = _Gathering(file.source, available, topics)
    streams = {}
    for number, channel in file.channels.items():
        schema = typed[number]
        if schema is None or channel.topic not in gathering.wanted:
            continue
        if channel.message_encoding != "cdr":
            found = f"encoding {channel.message_encoding!r}"
            raise BadInput(file.source, at=channel.topic, found=found, expected="'cdr' (ROS 2)")
        signals = gathering.wanted[channel.topic]
        streams[number] = TopicStream(channel.topic, schema.name, _parser(schema, file.source), signals)
    gathering.streams = [stream for stream in streams.values() if stream.msgtype != CLOUD]
    for chunk in file.chunks():
        channels, logs, starts, sizes = messages_in(chunk, file.source)
        clocks: list[Integers] = []
        for number, stream in streams.items():
            mine = np.flatnonzero(channels == number)
            gathering.add(stream, shared(logs[mine], clocks), chunk, starts[mine], sizes[mine])
    return replace(gathering.recording(forces, file.notes, file.constants), made_by=file.made_by)


def _parser(schema: Schema, source: str) -> Callable[[bytes], Any]:
    """Deserialises messages of a schema, which is read when the first of them comes."""
    store: list[Typestore] = []

    def parse(message: bytes) -> Any:
        if not store:
            if schema.encoding != "ros2msg":
                raise BadInput(source, at=schema.name, found=f"encoding {schema.encoding!r}", expected="'ros2msg'")
            store.append(Typestore())
            store[0].register(get_types_from_msg(schema.data.decode(), schema.name))
        return store[0].deserialize_cdr(message, schema.name)

    return parse


def load_bag(path: Path, topics: Mapping[str, str], forces: bool) -> Recording:
    """Read a recording from a ROS 1 ``.bag``, a ROS 2 ``.db3`` or the folder of a ROS 2 bag.

    Arguments and errors are those of ``load_mcap``.
    """
    with opened_bag(path) as bag:
        available = {connection.topic: connection.msgtype for connection in bag.connections}
        gathering = _Gathering(str(path), available, topics)
        _gather(bag, gathering)
        return gathering.recording(forces, [], {})


@contextmanager
def opened_bag(path: Path) -> Iterator[AnyReader]:
    """A bag of ROS 1 or 2, or a file of MCAP, that asks for no more than ``bounds`` allows.

    Args:
        path: ``.bag``, ``.db3``, ``.mcap`` or the folder of a ROS 2 bag.

    Raises:
        BadInput: it cannot be read, within the block too, or asks for more.
    """
    source = str(path)
    with readable(source, "a bag", "a complete bag", PermissionError):
        _check_packed(path)
        with AnyReader([path], default_typestore=ros2_types()) as bag:
            for reader in bag.readers:
                if isinstance(reader, Ros1Reader):
                    reader.chunks = {at: _bounded(chunk, source) for at, chunk in reader.chunks.items()}
            yield bag


def _check_packed(path: Path) -> None:
    """Check what rosbags unpacks whole, whatever comes of it: a file of MCAP, or those of a ROS 2 bag's folder."""
    for file in [path] if path.suffix == ".mcap" and path.is_file() else sorted(path.glob("*.mcap")):
        for _ in McapFile(file).chunks():
            pass
    for file in sorted(path.glob("*.zstd")):
        with zstandard.open(file, "rb") as unpacked:
            size = 0
            while part := unpacked.read(_BATCH):
                size += len(part)
                check_unpacked(file, size, file.stat().st_size)


def _bounded(chunk: Chunk, source: str) -> Chunk:
    """A chunk of a ROS 1 bag that unpacks to no more than it may."""
    check_at_once(source, chunk.datasize, chunk.datapos)

    def unpack(data: bytes) -> bytes:
        if chunk.decompressor is bz2.decompress:
            unpacked = bz2.BZ2Decompressor().decompress(data, MOST_AT_ONCE + 1)
        elif chunk.decompressor is lz4.frame.decompress:
            unpacked = lz4.frame.LZ4FrameDecompressor().decompress(data, MOST_AT_ONCE + 1)
        else:
            unpacked = data
        check_at_once(source, len(unpacked), chunk.datapos)
        return unpacked

    return chunk._replace(decompressor=unpack)


def _gather(bag: AnyReader, gathering: _Gathering) -> None:
    """Read the wanted connections, a batch at a time; several of one topic and type count as one."""
    connections = [connection for connection in bag.connections if connection.topic in gathering.wanted]
    batches: dict[str, _Batch] = {}
    for connection, log, data in bag.messages(connections) if connections else ():
        if connection.topic not in batches:
            parse = partial(bag.deserialize, typ=connection.msgtype)
            signals = gathering.wanted[connection.topic]
            stream = TopicStream(connection.topic, connection.msgtype, parse, signals, ros1=not bag.is2)
            batches[connection.topic] = _Batch(stream)
            if connection.msgtype != CLOUD:
                gathering.streams.append(stream)
        batch = batches[connection.topic]
        batch.logs.append(log)
        batch.messages.append(data)
        batch.size += len(data)
        if batch.size >= _BATCH:
            batch.hand_to(gathering)
    for batch in batches.values():
        batch.hand_to(gathering)


@dataclass
class _Batch:
    """Messages of one topic that wait to be read together."""

    stream: TopicStream
    logs: list[int] = field(default_factory=list)
    messages: list[bytes | memoryview] = field(default_factory=list)
    size: int = 0

    def hand_to(self, gathering: _Gathering) -> None:
        sizes = np.array([len(message) for message in self.messages], dtype=np.int64)
        joint = np.frombuffer(b"".join(self.messages), dtype=np.uint8)
        gathering.add(self.stream, np.array(self.logs, dtype=np.int64), joint, np.cumsum(sizes) - sizes, sizes)
        self.logs, self.messages, self.size = [], [], 0
