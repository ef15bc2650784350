"""Kinds of fault that a network can have, and strangers on it."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

from mmt_drake.diagrams.faults.link.wires import Fault

MS = 1_000_000  # [ns]


@dataclass(frozen=True)
class LinkFault:
    """One kind of fault.

    Attributes:
        make: gives what becomes of each packet, given what draws at random.
        must: the peer counts as lost meanwhile.
        may: it may.
    """

    make: Callable[[random.Random], Fault]
    must: bool
    may: bool


def _corrupted(draw: random.Random) -> Fault:
    def spoil(packet: bytes, now: int) -> list[tuple[int, bytes]]:
        spoiled = bytearray(packet)
        spoiled[draw.randrange(len(packet))] ^= 1 + draw.randrange(255)
        return [(now, bytes(spoiled))]

    return spoil


def _replayed(draw: random.Random) -> Fault:
    seen: list[bytes] = []

    def replay(packet: bytes, now: int) -> list[tuple[int, bytes]]:
        seen.append(packet)
        return [(now + MS * draw.randrange(5), draw.choice(seen)) for _ in range(3)]

    return replay


KINDS: dict[str, LinkFault] = {
    "cut cable": LinkFault(lambda draw: lambda p, now: [], True, True),
    "corrupted": LinkFault(_corrupted, True, True),
    "forged": LinkFault(lambda draw: lambda p, now: [(now, p[:16] + draw.randbytes(len(p) - 16))], True, True),
    "noise": LinkFault(lambda draw: lambda p, now: [(now, draw.randbytes(draw.randrange(200)))], True, True),
    "cut short": LinkFault(lambda draw: lambda p, now: [(now, p[: draw.randrange(len(p))])], True, True),
    "late": LinkFault(lambda draw: lambda p, now: [(now + 300 * MS, p)], True, True),
    "replayed": LinkFault(_replayed, False, True),
    "duplicated": LinkFault(lambda draw: lambda p, now: [(now, p), (now, p), (now + 7 * MS, p)], False, False),
    "reordered": LinkFault(lambda draw: lambda p, now: [(now + draw.randrange(8) * MS, p)], False, False),
    "lossy": LinkFault(lambda draw: lambda p, now: [] if draw.random() < 0.3 else [(now, p)], False, False),
}
