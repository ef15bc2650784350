"""A network in memory between two ends of a link."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

Fault = Callable[[bytes, int], list[tuple[int, bytes]]]
"""What becomes of a datagram sent at a time [ns]: (when it arrives, its bytes), any number of them."""


def at_once(datagram: bytes, now: int) -> list[tuple[int, bytes]]:
    return [(now, datagram)]


@dataclass
class Wire:
    """One direction; a socket's `send` at one end, `receive` at the other."""

    clock: Callable[[], int]
    fault: Fault = at_once
    sent: list[bytes] = field(default_factory=list)
    flying: list[tuple[int, int, bytes]] = field(default_factory=list)
    numbers: itertools.count[int] = field(default_factory=itertools.count)

    def send(self, datagram: bytes) -> bool:
        self.sent.append(datagram)
        for arrival, content in self.fault(datagram, self.clock()):
            self.inject(content, arrival)
        return True

    def inject(self, content: bytes, arrival: int | None = None) -> None:
        heapq.heappush(self.flying, (self.clock() if arrival is None else arrival, next(self.numbers), content))

    def receive(self) -> bytes | None:
        if self.flying and self.flying[0][0] <= self.clock():
            return heapq.heappop(self.flying)[2]
        return None


@dataclass
class End:
    """A socket of two wires."""

    out: Wire
    back: Wire

    def send(self, datagram: bytes) -> bool:
        return self.out.send(datagram)

    def receive(self) -> bytes | None:
        return self.back.receive()

    def close(self) -> None:
        pass
