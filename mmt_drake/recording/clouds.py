"""Point clouds as sensor_msgs/PointCloud2."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.recording.messages import ros2_types
from mmt_drake.recording.signals import CLOUD

LIGHT_POINTS = 5000
"""Points of a cloud that is recorded lightly, at most."""

Coordinate = TypeVar("Coordinate", np.float32, np.float64)

_TYPES = {7: "f4", 8: "f8"}  # sensor_msgs/PointField: FLOAT32, FLOAT64


def thinned(points: NDArray[Coordinate], most: int = LIGHT_POINTS) -> NDArray[Coordinate]:
    """Every k-th point, so that ``most`` are left at most; the same ones each time."""
    return points[:: max(1, -(-len(points) // most))]


def encode(nanoseconds: int, points: NDArray[np.float32], frame: str) -> bytes:
    """The CDR bytes of a cloud.

    Args:
        nanoseconds: its stamp [ns].
        points: (m, 3) [m].
        frame: frame_id of the header.
    """
    types = ros2_types().types
    field = types["sensor_msgs/msg/PointField"]
    stamp = types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 1_000_000_000))
    packed = np.ascontiguousarray(points, dtype="<f4")
    message = types[CLOUD](
        header=types["std_msgs/msg/Header"](stamp, frame),
        height=1,
        width=len(packed),
        fields=[field(name, 4 * i, 7, 1) for i, name in enumerate("xyz")],
        is_bigendian=False,
        point_step=12,
        row_step=12 * len(packed),
        data=packed.view(np.uint8).ravel(),
        is_dense=True,
    )
    return bytes(ros2_types().serialize_cdr(message, CLOUD))


def decode(message: Any, source: str, topic: str) -> NDArray[np.float32]:
    """The points of a deserialised PointCloud2, (m, 3) [m]; points that are not finite are left out.

    Raises:
        BadInput: it has no x, y, z in float32 or float64, or fewer bytes than it announces.
    """
    fields = {field.name: field for field in message.fields}
    if any(name not in fields or fields[name].datatype not in _TYPES for name in "xyz"):
        raise BadInput(
            source, at=topic, found=f"cloud fields {', '.join(fields)}", expected="x, y, z in float32 or float64"
        )
    order = ">" if message.is_bigendian else "<"
    layout = np.dtype(
        {
            "names": list("xyz"),
            "formats": [order + _TYPES[fields[name].datatype] for name in "xyz"],
            "offsets": [fields[name].offset for name in "xyz"],
            "itemsize": message.point_step,
        }
    )
    width, height = message.width * layout.itemsize, message.height
    if message.row_step < width or len(message.data) < height * message.row_step:
        found = f"{len(message.data)} bytes in rows of {message.row_step}"
        raise BadInput(source, at=topic, found=found, expected=f"{height} rows of at least {width} bytes")
    padded = np.asarray(message.data[: height * message.row_step], dtype=np.uint8).reshape(height, message.row_step)
    rows = np.ascontiguousarray(padded[:, :width]).view(layout).ravel()
    points = np.column_stack([rows[name].astype(np.float32) for name in "xyz"])
    return points[np.isfinite(points).all(axis=1)]
