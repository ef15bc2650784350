"""What Meshcat holds for a browser, read without one."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat

DOUBLE = b"\xcb"  # MessagePack: eight bytes follow, big-endian


def last_numbers(message: bytes) -> NDArray[np.float64]:
    """The doubles that end a MessagePack message."""
    found: list[float] = []
    end = len(message)
    while end >= 9 and message[end - 9 : end - 8] == DOUBLE:
        found.append(struct.unpack(">d", message[end - 8 : end])[0])
        end -= 9
    return np.array(found[::-1])


def transform(meshcat: Meshcat, path: str) -> NDArray[np.float64]:
    """The (4, 4) transform at a path."""
    return last_numbers(meshcat._GetPackedTransform(path)).reshape(4, 4).T  # sent column by column


def samples(meshcat: Meshcat) -> NDArray[np.float64]:
    """The last batch of samples of the charts, a row each."""
    from mmt_drake.viewer.charts import COLUMNS, PATH, PROPERTY

    return last_numbers(meshcat._GetPackedProperty(PATH, PROPERTY)).reshape(-1, len(COLUMNS))


def is_visible(meshcat: Meshcat, path: str) -> bool:
    """Whether what is at a path is shown; it is unless something hid it."""
    message = meshcat._GetPackedProperty(path, "visible")
    return not message or message.endswith(b"\xc3")
