"""Faults of the network between two sides of set-up 1, with an emulated device in the operator's hand."""

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from mmt_drake.diagrams.proof.faults.injection import Injection, Tally, emulated_omega, inject
from mmt_drake.diagrams.proof.faults.session import FORCE, TIMEOUT, Session
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.diagrams.proof.faults.wires import Fault, at_once
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety.reasons import Reason

MS = 1_000_000  # [ns]
LOST = (Reason.STALE,)


@dataclass(frozen=True)
class LinkFault:
    """One kind of fault.

    Attributes:
        make: gives what becomes of each packet, given what draws at random.
        reasons: as of an `Injection`.
    """

    make: Callable[[random.Random], Fault]
    reasons: tuple[int, ...] | None


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
    "cut cable": LinkFault(lambda draw: lambda p, now: [], LOST),
    "corrupted": LinkFault(_corrupted, LOST),
    "forged": LinkFault(lambda draw: lambda p, now: [(now, p[:16] + draw.randbytes(len(p) - 16))], LOST),
    "noise": LinkFault(lambda draw: lambda p, now: [(now, draw.randbytes(draw.randrange(200)))], LOST),
    "cut short": LinkFault(lambda draw: lambda p, now: [(now, p[: draw.randrange(len(p))])], LOST),
    "late": LinkFault(lambda draw: lambda p, now: [(now + 300 * MS, p)], LOST),
    "replayed": LinkFault(_replayed, None),
    "duplicated": LinkFault(lambda draw: lambda p, now: [(now, p), (now, p), (now + 7 * MS, p)], ()),
    "reordered": LinkFault(lambda draw: lambda p, now: [(now + draw.randrange(8) * MS, p)], ()),
    "lossy": LinkFault(lambda draw: lambda p, now: [] if draw.random() < 0.3 else [(now, p)], ()),
}


_LATEST = 400  # ticks until what was late has come, and is too old


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """Every kind of fault that a network in memory can have."""
    omega = emulated_omega(folder)
    for name, kind in KINDS.items():
        yield try_kind(name, kind, omega, moments, folder / "network.mcap")


def try_kind(name: str, kind: LinkFault, omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """One kind, in one session, with a person who arms again after each."""
    draw, tally = random.Random(name), Tally(FORCE)

    def start(session: Session) -> None:
        session.there.fault = session.back.fault = kind.make(draw)

    def stop(session: Session) -> None:
        session.there.fault = session.back.fault = at_once

    fault = Injection(start, stop, kind.reasons, TIMEOUT, after=_LATEST if name == "late" else 100)
    with Session(omega, record, apart=True) as session:
        inject(session, fault, moments, lambda: session.go(draw.randrange(40)), tally)
    tally.must_have_felt(1, moments)
    if session.shown:
        tally.wrong.append(f"{session.shown} times something was shown that was not sent")
    tally.recorded(session, record)
    return tally.row(name, "network", moments, fault.allowed)
