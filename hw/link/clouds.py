"""Surfaces in many small packets.

A surface is its points and where a rigid translation has taken them. Points are sent in blocks, one or few a tick, over
and over until the peer says that it has them all; so a lost block costs one more round, not the surface. Where they
are now fits one packet, which goes out with every frame.
"""

import struct

import numpy as np
from numpy.typing import NDArray

from mmt_drake.cloud import Cloud
from mmt_drake.recording.clouds import thinned

BLOCK_POINTS = 96
"""Points in a block."""

MOST_POINTS = 1_000_000
"""Points of a surface that are taken from a peer at most."""

_BLOCK = struct.Struct("<IHHI")
_TRANSLATION = struct.Struct("<I4d")
_POINT = np.dtype("<f4")


class CloudSender:
    """Cuts the newest surface into packets.

    Args:
        points: of a surface that are sent at most; of more, every k-th.
        interval: between two surfaces whose points differ [ns].
    """

    def __init__(self, points: int, interval: int) -> None:
        self._most, self._interval = points, interval
        self._base: NDArray[np.float64] | None = None
        self._number = 0
        self._blocks: list[bytes] = []
        self._turn = 0
        self._since = 0
        self._translation: bytes | None = None

    def offer(self, cloud: Cloud, now: int) -> None:
        """The surface as it is now; at most one set of points per interval is taken, the newest at that time."""
        if cloud.base is not self._base:
            if self._base is not None and now - self._since < self._interval:
                return
            self._since, self._base = now, cloud.base
            self._number += 1
            self._turn = 0
            points = thinned(cloud.base.astype(_POINT), self._most)
            count = -(-len(points) // BLOCK_POINTS)
            self._blocks = [
                _BLOCK.pack(self._number, index, count, len(points))
                + points[index * BLOCK_POINTS : (index + 1) * BLOCK_POINTS].tobytes()
                for index in range(count)
            ]
        self._translation = _TRANSLATION.pack(self._number, cloud.stamp, *cloud.translation)

    def translation(self) -> bytes | None:
        """Where the points are, once for every surface offered."""
        translation, self._translation = self._translation, None
        return translation

    def block(self, complete: int) -> bytes | None:
        """The next block; None if the peer's newest complete surface is this one, or there is none."""
        if not self._blocks or complete == self._number:
            return None
        block = self._blocks[self._turn % len(self._blocks)]
        self._turn += 1
        return block


class CloudCollector:
    """Puts surfaces together again.

    Attributes:
        cloud: the newest surface that is complete, where it was last seen.
        number: its number; 0 before the first.
    """

    def __init__(self) -> None:
        self.cloud = Cloud.empty()
        self.number = 0
        self._collected = 0
        self._points = np.empty((0, 3), dtype=_POINT)
        self._missing: set[int] = set()
        self._latest: tuple[int, int, tuple[float, ...]] = (0, -1, ())  # surface, packet, stamp and translation

    def clear(self) -> None:
        """Another peer counts its surfaces anew."""
        self.number = self._collected = 0
        self._latest = (0, -1, ())

    def add_block(self, body: bytes) -> bool:
        """Take a block; False if it is none."""
        if len(body) < _BLOCK.size:
            return False
        number, index, count, points = _BLOCK.unpack_from(body)
        size = min(BLOCK_POINTS, points - index * BLOCK_POINTS)
        if not (0 < points <= MOST_POINTS and count == -(-points // BLOCK_POINTS) and index < count):
            return False
        if len(body) != _BLOCK.size + size * 3 * _POINT.itemsize:
            return False
        part = np.frombuffer(body, dtype=_POINT, offset=_BLOCK.size).reshape(-1, 3)
        if not np.isfinite(part).all():
            return False
        if number < self._collected or number <= self.number:
            return True
        if number > self._collected:
            self._collected = number
            self._points = np.empty((points, 3), dtype=_POINT)
            self._missing = set(range(count))
        elif points != len(self._points):
            return False
        self._points[index * BLOCK_POINTS : index * BLOCK_POINTS + size] = part
        self._missing.discard(index)
        if not self._missing:
            self.number = number
            self.cloud = Cloud(self._points)
            self._show()
        return True

    def add_translation(self, body: bytes, sequence: int) -> bool:
        """Take a translation; False if it is none. Later packets count, whatever their order."""
        if len(body) != _TRANSLATION.size:
            return False
        number, *stamped = _TRANSLATION.unpack(body)
        if not np.isfinite(stamped).all():
            return False
        if (number, sequence) > self._latest[:2]:
            self._latest = (number, sequence, tuple(stamped))
            self._show()
        return True

    def _show(self) -> None:
        number, _, stamped = self._latest
        if number == self.number and stamped:
            self.cloud = self.cloud.moved(stamped[1:], stamped[0])
