"""Faults of the network between two sides of set-up 1, with an emulated device in the operator's hand."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from diagrams.faults.emulated import emulated_omega
from diagrams.faults.row import Row
from diagrams.faults.session import FORCE, PERIOD, TIMEOUT, Session
from hw.link.trial.kinds import KINDS, Kind
from hw.link.trial.wires import at_once
from hw.omega.emulator import EmulatedOmega
from hw.safety import STOP_WITHIN
from mmt_drake.recording import load

_ALLOWED = TIMEOUT + STOP_WITHIN
_WATCHED = round(_ALLOWED / PERIOD) + 20  # ticks
_LATEST = 400  # ticks until what was late has come, and is too old


def try_network(moments: int, folder: Path) -> Iterator[Row]:
    """Every kind of fault that a network in memory can have."""
    omega = emulated_omega(folder)
    for name, kind in KINDS.items():
        yield try_kind(name, kind, omega, moments, folder / "network.mcap")


def try_kind(name: str, kind: Kind, omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """One kind, in one session, with a person who arms again after each."""
    draw = random.Random(name)
    felt, greatest, slowest, wrong = 0, 0.0, 0.0, []
    with Session(omega, record, apart=True) as session:
        for moment in range(moments):
            if not session.arm():
                wrong.append(f"{moment}: cannot be armed: {session.told()}")
                break
            session.go(draw.randrange(40))
            felt += bool(omega.vector("applied").any())
            start = session.begin_moment()
            session.there.fault = session.back.fault = kind.make(draw)
            session.go(_WATCHED)
            force, on_for = omega.get("greatest_force"), omega.get("last_force_at") - start
            greatest, slowest = max(greatest, force), max(slowest, on_for)
            if force > FORCE * (1 + 1e-9) or omega.get("not_finite"):
                wrong.append(f"{moment}: {force:.3g} N")
            if (kind.must and (session.armed or on_for > _ALLOWED + 1e-9)) or not (kind.may or session.armed):
                wrong.append(f"{moment}: {session.told()}, a force for {1e3 * on_for:.1f} ms")
            session.there.fault = session.back.fault = at_once
            if kind.must:
                session.begin_moment()
                session.go(_LATEST if name == "late" else 100)
                if omega.get("greatest_force"):
                    wrong.append(f"{moment}: it went on by itself")
        if not felt:
            wrong.append("no force was felt at any moment")
        if session.shown:
            wrong.append(f"{session.shown} times something was shown that was not sent")
    recorded = load(record, forces=False).time
    if len(recorded) != session.tick:
        wrong.append(f"{session.tick} ticks, of which {len(recorded)} were recorded")
    return Row(
        kind=name,
        where="network",
        moments=moments,
        greatest_force=greatest,
        force_limit=FORCE,
        zero_after=slowest if kind.must else np.nan,
        allowed=_ALLOWED if kind.must else np.nan,
        unreadable=(session.tick - 1) * PERIOD - float(recorded[-1]),
        wrong=tuple(wrong),
    )
