"""The layout of the messages of ROS 1 and ROS 2: where each number stands.

Most messages of a recording have a fixed layout: perhaps a header, then float64. Those are
read for all messages of a topic at once. Whatever else comes goes message by message.
"""

import dataclasses
from functools import cache
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from mmt_drake.recording.signals import ARRAY, BOOL, FLOAT, POINT, POSE, TWIST, WRENCH, Quantity

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]

# Number of float64 after the header, if there is one.
_STAMPED = {POSE: 7, TWIST: 6, WRENCH: 6, POINT: 3, "geometry_msgs/msg/Vector3Stamped": 3}
_PLAIN = {
    "geometry_msgs/msg/Pose": 7,
    "geometry_msgs/msg/Twist": 6,
    "geometry_msgs/msg/Wrench": 6,
    "geometry_msgs/msg/Point": 3,
    "geometry_msgs/msg/Vector3": 3,
    FLOAT: 1,
}
_VECTORS = ("geometry_msgs/msg/Vector3Stamped", "geometry_msgs/msg/Vector3", ARRAY)

ACCEPTED: dict[Quantity, tuple[str, ...]] = {
    "position": (POSE, "geometry_msgs/msg/Pose", POINT, "geometry_msgs/msg/Point", *_VECTORS),
    "velocity": (TWIST, "geometry_msgs/msg/Twist", *_VECTORS),
    "force": (WRENCH, "geometry_msgs/msg/Wrench", *_VECTORS),
    "flag": (BOOL, FLOAT, "std_msgs/msg/Int32", "std_msgs/msg/UInt8"),
    "theta": (ARRAY,),
    "code": (FLOAT, "std_msgs/msg/Int32", "std_msgs/msg/UInt8"),
    "scalar": (FLOAT, "std_msgs/msg/Float32"),
    "number": (FLOAT, "std_msgs/msg/Float32"),
}
"""Message types that are read for each quantity."""


@cache
def ros2_types() -> Typestore:
    """The standard message types of ROS 2."""
    return get_typestore(Stores.ROS2_HUMBLE)


@cache
def definition(msgtype: str) -> str:
    """The text of a standard ROS 2 message with the messages that it is made of."""
    return ros2_types().generate_msgdef(msgtype, ros_version=2)[0]


@dataclasses.dataclass(frozen=True)
class MessageBatch:
    """The numbers of several messages of one topic.

    Attributes:
        values: (n, k) in the order of the message's fields.
        stamps: (n,) header stamps [ns], or None without a header.
        frame: the headers' frame_id; empty without one.
    """

    values: NDArray[np.float64]
    stamps: Integers | None
    frame: str


def read_block(msgtype: str, data: Bytes, starts: Integers, sizes: Integers, ros1: bool) -> MessageBatch | None:
    """Read many messages at once.

    Args:
        msgtype: their type, in the naming of ROS 2.
        data: bytes in which they stand.
        starts: (n,) where each begins.
        sizes: (n,) how many bytes each has.
        ros1: ROS 1 serialisation instead of little-endian CDR.

    Returns:
        None if the layout is not one of the fixed ones, or not the same in all of them.
    """
    size = int(sizes[0])
    if (sizes != size).any():
        return None
    shift = 0 if ros1 else 4  # CDR begins with four bytes that tell its byte order
    if not ros1 and (size < shift or (_take(data, starts, 0, 2) != (0, 1)).any()):
        return None
    if msgtype == BOOL:
        return MessageBatch(_take(data, starts, shift, 1).astype(np.float64), None, "") if size > shift else None
    if msgtype in _PLAIN:
        return _doubles(data, starts, size, shift, _PLAIN[msgtype])
    if msgtype == ARRAY:
        return _array(data, starts, size, shift, ros1)
    if msgtype in _STAMPED:
        return _stamped(data, starts, size, shift, _STAMPED[msgtype], ros1)
    return None


def _take(data: Bytes, starts: Integers, offset: int, count: int) -> Bytes:
    """So many bytes of each message from this offset on, (n, count); the messages must be that long."""
    taken = np.empty((len(starts), count), dtype=np.uint8)
    _gather(data, starts, offset, taken)
    return taken


@numba.njit(cache=True)
def _gather(data: Bytes, starts: Integers, offset: int, taken: Bytes) -> None:
    for i in range(len(starts)):
        first = starts[i] + offset
        for j in range(taken.shape[1]):
            taken[i, j] = data[first + j]


def _words(data: Bytes, starts: Integers, offset: int) -> NDArray[np.uint32]:
    return _take(data, starts, offset, 4).view("<u4")[:, 0]


def _doubles(data: Bytes, starts: Integers, size: int, offset: int, count: int) -> MessageBatch | None:
    if size < offset + 8 * count:
        return None
    return MessageBatch(_take(data, starts, offset, 8 * count).view("<f8"), None, "")


def _array(data: Bytes, starts: Integers, size: int, shift: int, ros1: bool) -> MessageBatch | None:
    """Float64MultiArray without dimensions: their number (0), data_offset, count, and the data."""
    if size < shift + 12 or _words(data, starts, shift).any():
        return None
    counts = _words(data, starts, shift + 8)
    if (counts != counts[0]).any():
        return None
    return _doubles(data, starts, size, shift + (12 if ros1 else 16), int(counts[0]))


def _stamped(data: Bytes, starts: Integers, size: int, shift: int, count: int, ros1: bool) -> MessageBatch | None:
    """A header (ROS 1 has a sequence number before the stamp), then float64, aligned in CDR."""
    stamp = shift + (4 if ros1 else 0)
    text = stamp + 12
    if size < text:
        return None
    lengths = _words(data, starts, stamp + 8)
    length = int(lengths[0])
    if (lengths != length).any() or size < text + length:
        return None
    frames = _take(data, starts, text, length)
    if (frames != frames[0]).any():
        return None
    offset = text + length
    if not ros1:
        offset += -(offset - shift) % 8
    block = _doubles(data, starts, size, offset, count)
    if block is None:
        return None
    seconds, nanoseconds = _words(data, starts, stamp), _words(data, starts, stamp + 4)
    stamps = seconds.astype(np.int64) * 1_000_000_000 + nanoseconds
    return MessageBatch(block.values, stamps, frames[0].tobytes().rstrip(b"\0").decode("utf-8", "replace"))


def read_one(message: Any) -> tuple[list[float], int | None, str]:
    """Numbers, header stamp [ns] and frame_id of one deserialised message."""
    header = getattr(message, "header", None)
    if header is None:
        return _numbers(message), None, ""
    return _numbers(message), header.stamp.sec * 1_000_000_000 + header.stamp.nanosec, header.frame_id


def _numbers(part: Any) -> list[float]:
    if isinstance(part, np.ndarray):
        return [float(number) for number in part.ravel()]
    if isinstance(part, bool | int | float | np.number):
        return [float(part)]
    return [
        number
        for field in dataclasses.fields(part)
        if field.name not in ("header", "layout", "__msgtype__")
        for number in _numbers(getattr(part, field.name))
    ]
