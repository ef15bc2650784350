"""A network between two sockets on loopback, in a thread of its own, with every fault in its hands."""

from __future__ import annotations

import heapq
import itertools
import random
import select
import socket
import threading
import time
from collections.abc import Callable


class Proxy:
    """Takes packets for either end at a port of its own, and passes them on as `fault` says.

    Args:
        ports: where both ends listen; each end is told the proxy's port as its peer.
        fault: (packet, to which end) -> (delay [s], packet), any number of them.
    """

    def __init__(self, ports: list[int], fault: Callable[[bytes, int], list[tuple[float, bytes]]]) -> None:
        self.fault = fault
        self.passed: list[bytes] = []
        self._ports = ports
        self._sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in ports]
        for item in self._sockets:
            item.bind(("127.0.0.1", 0))
            item.setblocking(False)
        #: `ports[k]` is where end k finds its peer.
        self.ports = [item.getsockname()[1] for item in self._sockets]
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Proxy:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        for item in self._sockets:
            item.close()

    def inject(self, packet: bytes, end: int) -> None:
        """A packet to an end, from where its peer's come."""
        self._sockets[end].sendto(packet, ("127.0.0.1", self._ports[end]))

    def _run(self) -> None:
        flying: list[tuple[float, int, int, bytes]] = []
        number = itertools.count()
        while not self._over.is_set():
            wait = 0.02 if not flying else min(0.02, max(0.0, flying[0][0] - time.monotonic()))
            for ready in select.select(self._sockets, [], [], wait)[0]:
                end = 1 - self._sockets.index(ready)
                try:
                    packet = ready.recv(2048)
                except OSError:
                    continue
                self.passed.append(packet)
                for delay, content in self.fault(packet, end):
                    heapq.heappush(flying, (time.monotonic() + delay, next(number), end, content))
            while flying and flying[0][0] <= time.monotonic():
                _, _, end, content = heapq.heappop(flying)
                self.inject(content, end)


class Everything:
    """Delay, jitter and so reordering, loss, duplicates, corruption; seeded by count, not by time."""

    def __init__(self, seed: int) -> None:
        self._draw = random.Random(seed)
        self.corrupted = self.lost = self.copied = 0

    def __call__(self, packet: bytes, end: int) -> list[tuple[float, bytes]]:
        draw = self._draw
        if draw.random() < 0.05:
            self.lost += 1
            return []
        if draw.random() < 0.05:
            self.corrupted += 1
            spoiled = bytearray(packet)
            spoiled[draw.randrange(len(packet))] ^= 1 << draw.randrange(8)
            packet = bytes(spoiled)
        copies = 1 + (draw.random() < 0.05)
        self.copied += copies - 1
        return [(0.002 + 0.006 * draw.random(), packet) for _ in range(copies)]
