"""Each kind of fault at random moments of a session; what is watched is what the supervisor lets through."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.faults.row import Row
from mmt_drake.diagrams.faults.supervisor.kinds import KINDS, SupervisorFault
from mmt_drake.diagrams.faults.supervisor.session import LIMITS, PERIOD, Bench, Inputs, armed_bench, ordinary, press
from mmt_drake.hw.safety.limits import STOP_WITHIN

_SESSION = 2000  # ticks of the session into which the faults are put
_LONGER = 60  # ticks that are watched once the force must be zero


def ordinary_session() -> list[Bench]:
    """The bench at every tick of an ordinary session, from which each fault starts."""
    bench, kept = armed_bench(), []
    for _ in range(_SESSION):
        kept.append(copy(bench))
        bench.run(1)
    return kept


def copy(bench: Bench) -> Bench:
    """A bench that goes on from the same tick."""
    return Bench(bench.limits, bench.memory, bench.tick)


def try_supervisor(moments: int, folder: Path) -> Iterator[Row]:
    """Numbers on the supervisor's inputs."""
    session = ordinary_session()
    for kind in KINDS:
        yield try_fault(kind, session, moments)


def try_fault(name: str, session: list[Bench], moments: int = 50, seed: int = 0) -> Row:
    """Bring about one kind of fault at random moments, while somebody leans on the arm switch.

    Args:
        name: of one of `KINDS`.
        session: from `ordinary_session`.
        moments: how many.
        seed: of the moments.
    """
    kind, rng = KINDS[name], np.random.default_rng([seed, list(KINDS).index(name)])
    allowed = kind.seen_after + STOP_WITHIN
    must_be_zero = round(allowed / PERIOD)
    greatest, slowest, wrong = 0.0, 0.0, []
    for start in rng.integers(0, len(session), moments):
        bench, draw = copy(session[start]), np.random.default_rng(start)
        begun, last = bench.tick, 0
        for since in range(must_be_zero + _LONGER):
            inputs = inputs_under(bench, kind, begun, draw)
            press(inputs)
            force = bench.step(inputs)
            size = float(np.linalg.norm(force))
            greatest = max(greatest, size)
            if size:
                last = since + 1
            if not size <= LIMITS.force * (1 + 1e-12):
                wrong.append(f"tick {start}, {since} ms later: {size:.3g} N")
            power = force @ inputs.motion[3:] if np.isfinite(inputs.motion).all() else 0.0
            if power > LIMITS.power * (1 + 1e-9):
                wrong.append(f"tick {start}, {since} ms later: {power:.3g} W")
        slowest = max(slowest, last * PERIOD)
        if kind.reason is None:
            if not bench.armed:
                wrong.append(f"tick {start}: stopped, reason {bench.reason}")
        elif last > must_be_zero or bench.armed or bench.reason != kind.reason:
            wrong.append(f"tick {start}: a force for {last} ms, reason {bench.reason}")
    goes_on = kind.reason is None
    return Row(
        kind=name,
        where="supervisor",
        moments=moments,
        greatest_force=greatest,
        force_limit=LIMITS.force,
        zero_after=np.nan if goes_on else slowest,
        allowed=np.nan if goes_on else allowed,
        wrong=tuple(wrong),
    )


def inputs_under(bench: Bench, kind: SupervisorFault, start: int, rng: np.random.Generator) -> Inputs:
    """What the supervisor sees at a tick of a session in which a fault began at `start`."""
    inputs, since = ordinary(bench.tick), bench.tick - start
    if kind.lasts is None or since < kind.lasts:
        kind.change(inputs, since, rng)
    return inputs
