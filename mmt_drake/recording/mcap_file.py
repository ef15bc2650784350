"""The container of MCAP files: records, chunks, channels; whole files and those that a crash cut off.

The file is walked record by record from its start, so that no index is needed, and its
chunks are read and unpacked one at a time, so that memory does not grow with them.
"""

import zlib
from collections.abc import Iterator
from io import SEEK_END, BytesIO
from pathlib import Path
from typing import BinaryIO

import lz4.frame
import numba
import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Header, Metadata, Schema

from mmt_drake.errors import BadInput
from mmt_drake.recording.bounds import check_at_once, check_unpacked
from mmt_drake.recording.mcap_layout import CONSTANTS, MADE_BY, MAGIC
from mmt_drake.recording.messages import Bytes, Integers

_HEAD = 9  # opcode and length
_MESSAGE_HEAD = 22  # channel, sequence, log time, publish time
_LOOSE = 1_000_000  # bytes of messages outside chunks that are read together
_TAKEN_IN: dict[int, type[Header | Schema | Channel | Metadata]] = {
    Opcode.HEADER: Header,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.METADATA: Metadata,
}


class McapFile:
    """An MCAP file opened for reading.

    Attributes:
        source: its path, for messages.
        schemas: by id.
        channels: by id.
        constants: see ``Recording.constants``.
        made_by: see ``Recording.made_by``.
        notes: damage that was found, one line each; complete once ``chunks`` has been read.

    Raises:
        BadInput: not an MCAP file, one of another middleware, or more than ``bounds`` allows.
    """

    def __init__(self, path: Path):
        self.source = str(path)
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.constants: dict[str, float] = {}
        self.made_by: dict[str, str] = {}
        self.notes: list[str] = []
        self._path = path
        self._chunks: list[tuple[int, int]] = []
        self._loose: list[tuple[int, int]] = []
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BadInput(self.source, found="another beginning", expected="an MCAP file")
            size = file.seek(0, SEEK_END)
            self._whole = _part(file, size - len(MAGIC), size) == MAGIC
            for opcode, start, end in self._walk(file, size):
                if opcode in (Opcode.CHUNK, Opcode.MESSAGE, *_TAKEN_IN):
                    check_at_once(self.source, end - start, start)
                if opcode == Opcode.CHUNK:
                    self._chunks.append((start, end))
                elif opcode == Opcode.MESSAGE:
                    self._add_loose(start, end)
                elif opcode in _TAKEN_IN:
                    self._take_in(opcode, _part(file, start + _HEAD, end))
        if not self.channels:  # other writers declare them in the chunks, and this file has no summary
            for chunk in self.chunks():
                for opcode, start, end in _declarations(chunk):
                    self._take_in(opcode, chunk[start:end].tobytes())
            self.notes = self.notes[:1]  # damage will be met again

    def chunks(self) -> Iterator[Bytes]:
        """The bytes of each chunk, unpacked; messages outside chunks come last, as chunks of their own.

        Raises:
            BadInput: a chunk is damaged in a file that was completed.
        """
        unpacked = 0
        with self._path.open("rb") as file:
            for start, end in self._chunks:
                packed = Chunk.read(ReadDataStream(BytesIO(_part(file, start + _HEAD, end))))
                check_at_once(self.source, packed.uncompressed_size, start)
                unpacked += packed.uncompressed_size
                check_unpacked(self.source, unpacked, end)
                chunk = self._unpacked(packed)
                if chunk is not None:
                    yield chunk
            for start, end in self._loose:
                yield np.frombuffer(_part(file, start, end), dtype=np.uint8)

    def _walk(self, file: BinaryIO, size: int) -> Iterator[tuple[int, int, int]]:
        """Opcode, start and end of each complete top-level record."""
        position = len(MAGIC)
        while True:
            head = _part(file, position, position + _HEAD)
            end = position + _HEAD + int.from_bytes(head[1:], "little")
            # zeros are what a file system may leave after a power cut
            if len(head) < _HEAD or head[0] == 0 or end > size:
                left = size - position
                self.notes.append(f"cut off: read up to the last complete chunk; {left} bytes after it are left out")
                return
            yield head[0], position, end
            if head[0] == Opcode.FOOTER:
                return
            position = end

    def _add_loose(self, start: int, end: int) -> None:
        """Note a message outside chunks; neighbours are read together."""
        if self._loose and self._loose[-1][1] == start and end - self._loose[-1][0] <= _LOOSE:
            start = self._loose.pop()[0]
        self._loose.append((start, end))

    def _take_in(self, opcode: int, content: bytes) -> None:
        match _TAKEN_IN[opcode].read(ReadDataStream(BytesIO(content))):
            case Header(profile=profile) if profile not in ("ros2", ""):
                raise BadInput(self.source, at="header", found=f"profile {profile!r}", expected="'ros2'")
            case Schema() as schema:
                self.schemas[schema.id] = schema
            case Channel() as channel:
                self.channels[channel.id] = channel
            case Metadata(name=name, metadata=values) if name == CONSTANTS:
                self.constants |= {name: float(value) for name, value in values.items()}
            case Metadata(name=name, metadata=values) if name == MADE_BY:
                self.made_by |= values

    def _unpacked(self, chunk: Chunk) -> Bytes | None:
        """The bytes of a chunk; None for one that a crash has damaged."""
        data = b""
        try:
            if chunk.compression == "zstd":  # a frame's own size comes first, which may be another one
                if zstandard.frame_content_size(chunk.data) <= chunk.uncompressed_size:
                    data = zstandard.ZstdDecompressor().decompress(chunk.data, max_output_size=chunk.uncompressed_size)
            elif chunk.compression == "lz4":
                data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=chunk.uncompressed_size + 1)
            elif chunk.compression == "":
                data = chunk.data
            else:
                raise BadInput(self.source, found=f"compression {chunk.compression!r}", expected="zstd, lz4 or none")
            sound = len(data) == chunk.uncompressed_size
        except (zstandard.ZstdError, RuntimeError):
            sound = False
        if not sound or (chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc):
            at = f"chunk at {chunk.message_start_time * 1e-9:g} s"
            if self._whole:
                raise BadInput(self.source, at=at, found="damaged data", expected="data that fit their checksum")
            self.notes.append(f"{at}: damaged, left out")
            return None
        return np.frombuffer(data, dtype=np.uint8)


def _part(file: BinaryIO, start: int, end: int) -> bytes:
    """The bytes of a file from ``start`` up to ``end``, fewer where it ends before."""
    file.seek(max(start, 0))
    return file.read(end - start)


def messages_in(chunk: Bytes, source: str) -> tuple[Integers, Integers, Integers, Integers]:
    """Channel id, log time [ns], start and size in bytes of each message of a chunk.

    Raises:
        BadInput: a record runs over the end of the chunk.
    """
    found = np.empty((4, len(chunk) // (_HEAD + _MESSAGE_HEAD)), dtype=np.int64)
    count = _scan(chunk, found)
    if count < 0:
        raise BadInput(source, found="a record that runs over the end of its chunk", expected="complete records")
    channels, logs, starts, sizes = found[:, :count]
    return channels, logs, starts, sizes


def _declarations(chunk: Bytes) -> Iterator[tuple[int, int, int]]:
    """Opcode, start and end of the content of each schema and channel within a chunk."""
    position = 0
    while position + _HEAD <= len(chunk):
        opcode = int(chunk[position])
        end = position + _HEAD + int.from_bytes(chunk[position + 1 : position + _HEAD].tobytes(), "little")
        if opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            yield opcode, position + _HEAD, end
        position = end


@numba.njit(cache=True)
def _scan(chunk: Bytes, found: Integers) -> int:
    """Find the message records of a chunk, (4, n) at least, and count them. -1: the last record is cut."""
    position = np.int64(0)
    count = 0
    while position < len(chunk):
        if position + _HEAD > len(chunk):
            return -1
        length = np.int64(0)
        for i in range(8):
            length |= np.int64(chunk[position + 1 + i]) << (8 * i)
        content = position + _HEAD
        if length < 0 or length > len(chunk) - content:
            return -1
        if chunk[position] == 5:  # Opcode.MESSAGE
            if length < _MESSAGE_HEAD:
                return -1
            log = np.int64(0)
            for i in range(8):
                log |= np.int64(chunk[content + 6 + i]) << (8 * i)
            found[0, count] = np.int64(chunk[content]) | (np.int64(chunk[content + 1]) << 8)
            found[1, count] = log
            found[2, count] = content + _MESSAGE_HEAD
            found[3, count] = length - _MESSAGE_HEAD
            count += 1
        position = np.int64(content + length)
    return count
