"""A network in memory between two ends of a link."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

Fault = Callable[[bytes, int], list[tuple[int, bytes]]]
"""What becomes of a datagram sent at a time [ns]: (when it arrives, its bytes), any number of them."""


def at_once(datagram: bytes, now: int) -> list[tuple[int, bytes]]:
    """No fault: a datagram arrives whole when it is sent."""
    return [(now, datagram)]


@dataclass
class FaultyWire:
    """One direction; a socket's `send` at one end, `receive` at the other.

    Attributes:
        clock: of both ends [ns].
        fault: what becomes of each datagram.
        sent: all of them, as they were sent.
        flying: when each arrives [ns], its number, its bytes; a heap.
        numbers: keep those apart that arrive together.
    """

    clock: Callable[[], int]
    fault: Fault = at_once
    sent: list[bytes] = field(default_factory=list)
    flying: list[tuple[int, int, bytes]] = field(default_factory=list)
    numbers: itertools.count[int] = field(default_factory=itertools.count)

    def send(self, datagram: bytes) -> bool:
        """Send a datagram; always taken."""
        self.sent.append(datagram)
        for arrival, content in self.fault(datagram, self.clock()):
            self.inject(content, arrival)
        return True

    def inject(self, content: bytes, arrival: int | None = None) -> None:
        """Have bytes arrive, at a time [ns] or now, that need not have been sent."""
        heapq.heappush(self.flying, (self.clock() if arrival is None else arrival, next(self.numbers), content))

    def receive(self) -> bytes | None:
        """The next datagram that has arrived, if any."""
        if self.flying and self.flying[0][0] <= self.clock():
            return heapq.heappop(self.flying)[2]
        return None


@dataclass
class End:
    """A socket of two wires.

    Attributes:
        out: what it sends on.
        back: what it receives from.
    """

    out: FaultyWire
    back: FaultyWire

    def send(self, datagram: bytes) -> bool:
        """Send a datagram; always taken."""
        return self.out.send(datagram)

    def receive(self) -> bytes | None:
        """The next datagram that has arrived, if any."""
        return self.back.receive()

    def close(self) -> None:
        """Nothing is open."""
