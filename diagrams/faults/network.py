"""Faults of the network between two sides of set-up 1, with an emulated device in the operator's hand."""

from __future__ import annotations

import random
from collections.abc import Iterator
from pathlib import Path

from mmt_drake.diagrams.faults.emulated import emulated_omega
from mmt_drake.diagrams.faults.link.kinds import KINDS, LinkFault
from mmt_drake.diagrams.faults.link.wires import at_once
from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.session import PERIOD, TIMEOUT, Session
from mmt_drake.diagrams.faults.tally import Tally
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.hw.safety import STOP_WITHIN

_ALLOWED = TIMEOUT + STOP_WITHIN
_WATCHED = round(_ALLOWED / PERIOD) + 20  # ticks
_LATEST = 400  # ticks until what was late has come, and is too old


def try_network(moments: int, folder: Path) -> Iterator[Row]:
    """Every kind of fault that a network in memory can have."""
    omega = emulated_omega(folder)
    for name, kind in KINDS.items():
        yield try_kind(name, kind, omega, moments, folder / "network.mcap")


def try_kind(name: str, kind: LinkFault, omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """One kind, in one session, with a person who arms again after each."""
    draw = random.Random(name)
    with Session(omega, record, apart=True) as session:
        tally = Tally(session)
        for moment in range(moments):
            if not tally.armed(moment):
                break
            session.go(draw.randrange(40))
            start = tally.begin()
            session.there.fault = session.back.fault = kind.make(draw)
            session.go(_WATCHED)
            on_for = tally.force_for(moment, start)
            if (kind.must and (session.armed or on_for > _ALLOWED + 1e-9)) or not (kind.may or session.armed):
                tally.surprise(moment, on_for)
            session.there.fault = session.back.fault = at_once
            if kind.must:
                tally.must_stay_off(moment, _LATEST if name == "late" else 100)
        if not tally.felt:
            tally.wrong.append("no force was felt at any moment")
        if session.shown:
            tally.wrong.append(f"{session.shown} times something was shown that was not sent")
    return tally.row(name, "network", moments, tally.recorded(record), _ALLOWED if kind.must else None)
