"""Writes recordings as one MCAP file of standard ROS 2 messages, block by block.

Every tick puts one message on every topic, and all of these messages have a fixed size. So
a block of ticks is one numpy array with a row of bytes per tick, laid out once and filled
column by column: no message is ever encoded on its own.
"""

import os
import zlib
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import zstandard
from mcap.records import Chunk, ChunkIndex, Header, Message, MessageIndex, Metadata, MetadataIndex
from numpy.typing import ArrayLike, NDArray

from mmt_drake.closing import Closing
from mmt_drake.errors import BadInput
from mmt_drake.recording.atomic import begin_part, beside, file_id, is_at, part_of, writing
from mmt_drake.recording.clouds import encode
from mmt_drake.recording.in_turn import InTurn
from mmt_drake.recording.mcap_layout import (
    CONSTANTS,
    FRAME,
    MADE_BY,
    MAGIC,
    as_bytes,
    declarations,
    ending,
    fill_constants,
    message_indexes,
    row_of,
)
from mmt_drake.recording.messages import STAMPED
from mmt_drake.recording.signals import BOOL, CLOUD, CLOUD_TOPIC, Signal, signal_of

_LIBRARY = "mmt_drake"
_COMPRESSION_LEVEL = 1
_LATEST = 2**31 - 1  # seconds; nanoseconds are written in 64 bits, their seconds in headers in 32


class McapWriter(Closing):
    """A recording that grows on disk.

    Each ``write_block`` becomes one compressed chunk that is handed to the operating system at
    once, so that a crash of the process loses only what was not yet handed over. Compression and writing
    run in a thread of their own, one block behind; memory stays at a few blocks whatever the length.

    The file grows beside its name, ``out.part.mcap`` for ``out.mcap``, locked against a second writer, and takes
    that name when it is complete: an older file stays until then. What a crash leaves there is readable up to its
    last complete chunk. If writing fails, the file is cut back to that, stays there, and the error says so. So it does,
    completed, where an error ends a `with`.

    Attributes:
        name: under which messages tell of it.
        path: where it stands now.

    Args:
        path: the ``.mcap`` file.
        signals: base name and number of columns of each, as in ``signals.SIGNALS``.
        clouds: whether point clouds will come too.
        constants: what stands still, see ``Recording.constants``.
        made_by: how it is made, see ``Recording.made_by``.

    Raises:
        BadInput: an unknown signal, the same one twice, a file that cannot be begun, or that another writer has begun.
    """

    def __init__(
        self,
        path: str | Path,
        signals: Sequence[tuple[str, int]],
        *,
        clouds: bool = False,
        constants: Mapping[str, float] | None = None,
        made_by: Mapping[str, str] | None = None,
    ):
        self._target = Path(path)
        self.name = str(path)
        self.path = part_of(self._target)
        self._signals = [signal_of(*signal) for signal in signals]
        topics = [(signal.topic, signal.msgtype) for signal in self._signals]
        for number, signal in enumerate(self._signals):
            if signal.topic in dict(topics[:number]):
                raise BadInput(path, at=signal.name, found="the same signal twice", expected="each once")
        self._row = row_of(self._signals)
        self._template = np.zeros(0, dtype=self._row)
        self._indexes: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}
        self._last_nanoseconds = -1
        self._ticks = 0
        self._compressor = zstandard.ZstdCompressor(level=_COMPRESSION_LEVEL)
        self._schemas, self._channels = declarations(topics + [(CLOUD_TOPIC, CLOUD)] * clouds, self._signals)
        self._cloud_channel = len(self._signals) + 1 if clouds else None
        if clouds:
            encode(0, np.zeros((1, 3), dtype=np.float32), FRAME)  # the first one makes the message's code
        still = {name: repr(float(value)) for name, value in (constants or {}).items()}
        self._begin({CONSTANTS: still, MADE_BY: dict(made_by or {})})
        self._thread = InTurn(1, "mcap")
        self._pending: Future[None] | None = None
        self._open = True

    def write_block(self, time: ArrayLike, columns: Mapping[str, ArrayLike]) -> None:
        """Write one message per tick on every topic, as one chunk.

        Args:
            time: (n,) [s], increasing strictly, by a nanosecond at least, also over blocks; not negative.
            columns: base name -> (n,) or (n, size) values of every signal announced.

        Raises:
            BadInput: a signal is missing or of another shape, times do not increase, or the disk
                refused (possibly the block before this one).
        """
        seconds = np.asarray(time, dtype=np.float64)
        if len(seconds) == 0:
            return
        self.settle()
        nanoseconds = self._checked_clock(seconds)
        rows = self._rows(len(seconds))
        for signal in self._signals:
            self._fill(rows[signal.topic], signal, nanoseconds, columns)
        index = message_indexes(self._row, nanoseconds)
        self._ticks += len(seconds)
        self._counts |= dict.fromkeys(index, self._ticks)
        self._last_nanoseconds = int(nanoseconds[-1])
        self._submit(rows.view(np.uint8).data, index, int(nanoseconds[0]), int(nanoseconds[-1]))

    def write_cloud(self, time: float, points: NDArray[np.float32]) -> None:
        """Write one point cloud, as a chunk of its own.

        Args:
            time: when it was taken [s].
            points: (m, 3) [m], table frame.

        Raises:
            BadInput: no clouds were announced, another shape, a negative time, or the disk refused.
        """
        if self._cloud_channel is None:
            raise BadInput(self.name, found="a point cloud", expected="none, as announced")
        if points.ndim != 2 or points.shape[1] != 3:
            raise BadInput(self.name, at=CLOUD_TOPIC, found=f"shape {points.shape}", expected="(points, 3)")
        if not 0.0 <= time <= _LATEST:
            raise BadInput(self.name, at=CLOUD_TOPIC, found=f"time {time} s", expected="0 s or later, and finite")
        self.settle()
        stamp = round(time * 1e9)
        channel, written = self._cloud_channel, self._counts.get(self._cloud_channel, 0)
        data = encode(stamp, points, FRAME)
        message = Message(channel_id=channel, log_time=stamp, data=data, publish_time=stamp, sequence=written)
        self._counts[channel] = written + 1
        index = as_bytes([MessageIndex(channel, [(stamp, 0)])])
        self._submit(memoryview(as_bytes([message])), {channel: index}, stamp, stamp)

    def settle(self) -> None:
        """Wait until the latest block is with the operating system.

        Raises:
            BadInput: the disk refused; or the recording is closed.
        """
        if not self._open:
            raise BadInput(self.name, found="a block after the end", expected="none: the recording is closed")
        pending, self._pending = self._pending, None
        if pending is None:
            return
        try:
            pending.result()
        except OSError as error:
            self._open = False
            self._thread.close()
            self._give_up(error)

    def close(self, *, whole: bool = True) -> None:
        """Write what is pending, the index and the footer, and name the file. A second call does nothing.

        Args:
            whole: whether all is recorded that was meant to be; if not, the file does not get its name.

        Raises:
            BadInput: the disk refused.
        """
        if not self._open:
            return
        self.settle()
        self._open = False
        self._thread.close()
        try:
            self._append(
                ending(self._position, self._schemas, self._channels, self._indexes, self._metadata, self._counts)
            )
            if whole:
                os.replace(self.path, self._target)
                self.path = self._target
        except OSError as error:
            self._give_up(error)
        os.close(self._file)

    @property
    def stands(self) -> bool:
        """True if it is this recording that stands at `path`: another writer may have taken the name since."""
        return is_at(self._identity, self.path)

    def discard(self) -> None:
        """Remove the file where it did not get its name."""
        if self.path != self._target and self.stands:
            self.path.unlink()

    def __exit__(self, *error: object) -> None:
        self.close(whole=not any(error))

    def _begin(self, metadata: Mapping[str, dict[str, str]]) -> None:
        """Write header, schemas, channels and the metadata records that are not empty."""
        beside(self._target)
        with writing(self.name):
            self._file = begin_part(self._target)
            self._identity = file_id(self._file)
            self._position = 0
            try:
                header = [Header("ros2", _LIBRARY), *self._schemas, *self._channels]
                self._append(MAGIC + as_bytes(header))
                for name, values in metadata.items():
                    if values:
                        record = as_bytes([Metadata(name, values)])
                        self._metadata.append(MetadataIndex(self._position, len(record), name))
                        self._append(record)
            except OSError:
                self.discard()
                os.close(self._file)
                raise

    def _append(self, data: bytes | memoryview) -> None:
        """Write all of it, or leave the position where it was."""
        view = memoryview(data)
        while len(view):
            view = view[os.write(self._file, view) :]
        self._position += len(data)

    def _checked_clock(self, seconds: NDArray[np.float64]) -> NDArray[np.uint64]:
        def refuse(bad: NDArray[np.bool_], expected: str) -> None:
            if bad.any():
                at = int(np.argmax(bad))
                found = f"time {seconds[at]} s"
                raise BadInput(self.name, at=f"row {self._ticks + at + 1}", found=found, expected=expected)

        refuse(~(seconds >= 0.0) | (seconds > _LATEST), "0 s or later, and finite")
        nanoseconds = np.rint(seconds * 1e9).astype(np.int64)
        refuse(np.diff(nanoseconds, prepend=self._last_nanoseconds) <= 0, "times that increase strictly")
        return nanoseconds.astype(np.uint64)

    def _rows(self, count: int) -> NDArray[np.void]:
        """Rows to fill; what never changes is in them already."""
        if len(self._template) < count:
            self._template = np.zeros(count, dtype=self._row)
            for channel, signal in enumerate(self._signals, 1):
                fill_constants(self._template[signal.topic], channel, signal)
        return self._template[:count]

    def _fill(
        self, part: NDArray[np.void], signal: Signal, nanoseconds: NDArray[np.uint64], columns: Mapping[str, ArrayLike]
    ) -> None:
        count, record, message = len(part), part["record"], part["message"]
        if signal.name not in columns:
            raise BadInput(self.name, found=f"signals {', '.join(columns)}", expected=f"also {signal.name!r}")
        values = np.asarray(columns[signal.name], dtype=np.float64)
        if values.shape != (count, signal.size) and not (signal.size == 1 and values.shape == (count,)):
            found = f"shape {values.shape}"
            raise BadInput(self.name, at=signal.name, found=found, expected=f"({count}, {signal.size})")
        values = values.reshape(count, signal.size)
        record["sequence"] = np.arange(self._ticks, self._ticks + count, dtype=np.uint32)
        record["log_time"] = record["publish_time"] = nanoseconds
        message["values"][:, : signal.size] = values != 0.0 if signal.msgtype == BOOL else values
        if signal.msgtype in STAMPED:
            message["sec"], message["nanosec"] = np.divmod(nanoseconds, np.uint64(1_000_000_000))

    def _submit(self, data: memoryview, indexes: Mapping[int, bytes], start: int, end: int) -> None:
        pending = self._pending = Future[None]()

        def write() -> None:
            try:
                self._write_chunk(data, indexes, start, end)
            except BaseException as error:
                pending.set_exception(error)
            else:
                pending.set_result(None)

        if not self._thread.offer(write):
            raise RuntimeError("the block before this one has not settled")

    def _write_chunk(self, data: memoryview, indexes: Mapping[int, bytes], start: int, end: int) -> None:
        """Compress and write one chunk and its message indexes; runs in the writer's thread."""
        packed = self._compressor.compress(data)
        chunk = as_bytes([Chunk("zstd", packed, end, start, zlib.crc32(data), len(data))])
        offsets, position = {}, self._position + len(chunk)
        for channel, index in indexes.items():
            offsets[channel] = position
            position += len(index)
        entry = ChunkIndex(
            chunk_length=len(chunk),
            chunk_start_offset=self._position,
            compression="zstd",
            compressed_size=len(packed),
            message_end_time=end,
            message_index_length=position - self._position - len(chunk),
            message_index_offsets=offsets,
            message_start_time=start,
            uncompressed_size=len(data),
        )
        self._append(b"".join([chunk, *indexes.values()]))
        self._indexes.append(entry)

    def _give_up(self, error: OSError) -> None:
        """Cut the file back to its last complete chunk and say what is left."""
        with suppress(OSError):  # a reader stops at the last complete chunk all the same
            os.ftruncate(self._file, self._position)
        os.close(self._file)
        end = max((index.message_end_time for index in self._indexes), default=0) * 1e-9
        kept = f"what was recorded until {end:g} s is kept in {self.path}"
        raise BadInput(self.name, found=error.strerror, expected=f"a place to write to; {kept}") from error


@contextmanager
def whole_or_none(writer: McapWriter, name: object = None) -> Iterator[None]:
    """Leave no part of a recording behind where bad input ends it, and say where it is where anything else does.

    Args:
        writer: of the recording; alone it keeps what it has, for those who have only that.
        name: the name in the message where the file could not be written; its own by default.

    Raises:
        BadInput: as raised within; a full disk without the promise that its beginning is kept.
    """
    try:
        yield
    except BadInput as error:
        writer.discard()
        if str(error.source) != writer.name or not isinstance(error.__cause__, OSError):
            raise
        expected = "room for the recording; its beginning is removed"
        raise BadInput(name or writer.name, found=error.found, expected=expected) from error
    except Exception as error:
        if writer.stands:
            error.add_note(f"recorded until then: {writer.path}")
        raise
