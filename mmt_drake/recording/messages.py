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

from mmt_drake.recording.signals import ARRAY, BOOL, FLOAT, POINT, POSE, QUATERNION, TWIST, WRENCH, Quantity

Bytes = NDArray[np.uint8]
Integers = NDArray[np.int64]

# Number of float64 after the header, if there is one.
_PLAIN = {
    "geometry_msgs/msg/Pose": 7,
    "geometry_msgs/msg/Twist": 6,
    "geometry_msgs/msg/Wrench": 6,
    "geometry_msgs/msg/Point": 3,
    "geometry_msgs/msg/Vector3": 3,
    "geometry_msgs/msg/Quaternion": 4,
    FLOAT: 1,
}
STAMPED = {POSE: 7, TWIST: 6, WRENCH: 6, POINT: 3, QUATERNION: 4, "geometry_msgs/msg/Vector3Stamped": 3}
"""The messages of numbers with a header, and how many float64 they have."""

_VECTORS = ("geometry_msgs/msg/Vector3Stamped", "geometry_msgs/msg/Vector3", ARRAY)

ACCEPTED: dict[Quantity, tuple[str, ...]] = {
    "position": (POSE, "geometry_msgs/msg/Pose", POINT, "geometry_msgs/msg/Point", *_VECTORS),
    "velocity": (TWIST, "geometry_msgs/msg/Twist", *_VECTORS),
    "force": (WRENCH, "geometry_msgs/msg/Wrench", *_VECTORS),
    "orientation": (QUATERNION, "geometry_msgs/msg/Quaternion", ARRAY),
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


def layout(msgtype: str, length: int = 0, *, ros1: bool = False) -> np.dtype[np.void] | None:
    """The fields of a message as they stand in its bytes; None for a type without a fixed layout.

    Args:
        msgtype: its type, in the naming of ROS 2.
        length: of the header's frame_id [bytes], or how many numbers the array has.
        ros1: ROS 1 serialisation (whose header has a sequence number) instead of little-endian CDR (which is aligned).
    """
    fields: list[Any] = [] if ros1 else [("cdr", "u1", (4,))]  # it tells the byte order
    kind, count, pad = "<f8", length, 0
    if msgtype == BOOL:
        kind, count = "u1", 1
    elif msgtype in _PLAIN:
        count = _PLAIN[msgtype]
    elif msgtype == ARRAY:
        fields += [("dimensions", "<u4"), ("data_offset", "<u4"), ("length", "<u4")]
        pad = 4
    elif msgtype in STAMPED:
        fields += [("sequence", "<u4")] * ros1
        fields += [("sec", "<u4"), ("nanosec", "<u4"), ("length", "<u4"), ("frame", "u1", (length,))]
        count, pad = STAMPED[msgtype], -(12 + length) % 8
    else:
        return None
    padding = [] if ros1 else [("pad", "u1", (pad,))]
    return np.dtype([*fields, *padding, ("values", kind, (count,))])


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
    size, length = int(sizes[0]), 0
    if msgtype == ARRAY or msgtype in STAMPED:
        at = (0 if ros1 else 4) + (12 if ros1 and msgtype in STAMPED else 8)
        if size < at + 4:
            return None
        length = int(_first_bytes(data, starts[:1] + at, 4).view("<u4")[0, 0])
        if (8 if msgtype == ARRAY else 1) * length > size:
            return None
    dtype = layout(msgtype, length, ros1=ros1)
    if dtype is None or dtype.itemsize > size or (sizes != size).any():
        return None
    messages = _first_bytes(data, starts, dtype.itemsize).view(dtype)[:, 0]
    if not ros1 and (messages["cdr"][:, :2] != (0, 1)).any():
        return None
    if msgtype == ARRAY and (messages["dimensions"].any() or (messages["length"] != length).any()):
        return None
    values = messages["values"].astype(np.float64, copy=False)
    if msgtype not in STAMPED:
        return MessageBatch(values, None, "")
    frame = messages["frame"][0]
    if (messages["length"] != length).any() or (messages["frame"] != frame).any():
        return None
    stamps = messages["sec"].astype(np.int64) * 1_000_000_000 + messages["nanosec"]
    return MessageBatch(values, stamps, frame.tobytes().rstrip(b"\0").decode("utf-8", "replace"))


def _first_bytes(data: Bytes, starts: Integers, count: int) -> Bytes:
    """So many bytes from each start on, (n, count)."""
    taken = np.empty((len(starts), count), dtype=np.uint8)
    _gather(data, starts, taken)
    return taken


@numba.njit(cache=True)
def _gather(data: Bytes, starts: Integers, taken: Bytes) -> None:
    for i in range(len(starts)):
        for j in range(taken.shape[1]):
            taken[i, j] = data[starts[i] + j]


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
