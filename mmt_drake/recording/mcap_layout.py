"""The layout of a tick of a recording as MCAP message records with CDR bytes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.recording.signals import ARRAY, BOOL, FLOAT, POINT, POSE, TWIST, WRENCH, Signal

MAGIC = b"\x89MCAP0\r\n"
CONSTANTS = "mmt_drake.constants"
"""Name of the metadata record that holds ``Recording.constants``."""

FRAME = "table"
"""frame_id of every header that is written."""

STAMPED = {POSE: 7, TWIST: 6, WRENCH: 6, POINT: 3}
"""The messages with a header that are written, and their number of float64."""

RECORD = np.dtype(
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


@dataclass(frozen=True)
class TopicSlot:
    """One topic's place in the row of a tick."""

    channel: int
    signal: Signal
    dtype: np.dtype[np.void]
    offset: int

    @property
    def key(self) -> str:
        """Its field in the row."""
        return str(self.channel)


def layout(signals: Sequence[Signal], path: Path) -> tuple[list[TopicSlot], np.dtype[np.void]]:
    """Where each topic's message record stands in the row of a tick."""
    slots: list[TopicSlot] = []
    for signal in signals:
        if any(slot.signal.topic == signal.topic for slot in slots):
            raise BadInput(path, at=signal.name, found="the same signal twice", expected="each once")
        offset = slots[-1].offset + slots[-1].dtype.itemsize if slots else 0
        slots.append(TopicSlot(len(slots) + 1, signal, _message(signal), offset))
    return slots, np.dtype([(slot.key, slot.dtype) for slot in slots])


def _message(signal: Signal) -> np.dtype[np.void]:
    """MCAP message record with the CDR bytes of a message of this signal; offsets count from after ``cdr``."""
    fields: list[Any] = [("record", RECORD), ("cdr", "V4")]
    if signal.msgtype == BOOL:
        fields += [("value", "u1")]
    elif signal.msgtype == FLOAT:
        fields += [("values", "<f8", (1,))]
    elif signal.msgtype == ARRAY:
        fields += [
            ("dimensions", "<u4"),
            ("data_offset", "<u4"),
            ("count", "<u4"),
            ("pad", "V4"),
            ("values", "<f8", (signal.size,)),
        ]
    else:
        text = f"S{len(FRAME) + 1}"
        pad = -(12 + len(FRAME) + 1) % 8
        fields += [("sec", "<i4"), ("nanosec", "<u4"), ("frame_size", "<u4"), ("frame", text), ("pad", f"V{pad}")]
        fields += [("values", "<f8", (STAMPED[signal.msgtype],))]
    return np.dtype(fields)


def fill_constants(part: NDArray[np.void], slot: TopicSlot) -> None:
    """Put into every row what is the same in each message of a topic."""
    size = part.dtype.itemsize - RECORD.itemsize
    fill_record(part["record"], slot.channel, size, np.zeros(1, dtype=np.uint64), 0)
    part["cdr"] = b"\x00\x01\x00\x00"  # CDR, little-endian
    if slot.signal.msgtype == ARRAY:
        part["count"] = slot.signal.size
    elif slot.signal.msgtype in STAMPED:
        part["frame_size"] = len(FRAME) + 1
        part["frame"] = FRAME.encode()
    if slot.signal.msgtype == POSE:
        part["values"][:, 6] = 1.0  # no rotation: quaternion (0, 0, 0, 1)


def fill_record(record: NDArray[np.void], channel: int, size: int, log_time: NDArray[np.uint64], sequence: int) -> None:
    """The head of a message record; ``size`` is that of the message alone."""
    record["opcode"] = Opcode.MESSAGE
    record["length"] = RECORD.itemsize - 9 + size
    record["channel"] = channel
    record["sequence"] = sequence
    record["log_time"] = record["publish_time"] = log_time


def message_indexes(slots: Sequence[TopicSlot], nanoseconds: NDArray[np.uint64], row_size: int) -> dict[int, bytes]:
    """The message index record of each channel of a block, by channel id; times in ns, (n,)."""
    rows = np.arange(len(nanoseconds), dtype=np.uint64) * np.uint64(row_size)
    return {slot.channel: index_record(slot.channel, nanoseconds, rows + np.uint64(slot.offset)) for slot in slots}


def index_record(channel: int, log_times: NDArray[np.uint64], offsets: NDArray[np.uint64]) -> bytes:
    """A message index record: when each message of a channel was, and where in the chunk it stands."""
    entries = np.empty(len(log_times), dtype=_INDEX_ENTRY)
    entries["log_time"], entries["offset"] = log_times, offsets
    size = entries.nbytes
    head = bytes([Opcode.MESSAGE_INDEX]) + (6 + size).to_bytes(8, "little") + channel.to_bytes(2, "little")
    return head + size.to_bytes(4, "little") + entries.tobytes()
