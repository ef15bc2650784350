"""Systems drawn at random, recorded, and fitted from nothing but the recording: whether what is told is true."""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagnosis.first_model import fit
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.diagrams.proof.experiments.targets import TOLD_TRULY
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings, each_draw
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.diagrams.proof.trial.cases import draw_base
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession
from mmt_drake.diagrams.proof.trial.plants import PLANTS
from mmt_drake.diagrams.proof.trial.session import draw_session
from mmt_drake.errors import attempt
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed

SECONDS: Final = 15.0
"""Of a contact; the others are 30 s long."""
LATE: Final = "box, foreign plant, force 4 ms late"
KINDS: Final = ("box, own plant", "box, foreign plant", "spring and damper", "servo", LATE)
"""Of the last the structure has not all the physics: there nothing should be called determined."""


@dataclass(frozen=True)
class FittedCase:
    """One system.

    Attributes:
        number: of the draw.
        kind: one of `KINDS`.
        truth: its numbers.
        told: what a fit says of each: value, interval and whether it is determined.
        explains: whether the fit leaves next to nothing but noise.
        heldout, noise: error on held-out data, and that of noise alone; None where the fit refused the recording.
        seconds: the fit took.
    """

    number: int
    kind: str
    truth: dict[str, float]
    told: dict[str, dict[str, Any]]
    explains: bool
    heldout: float | None
    noise: float | None
    seconds: float

    def holds(self) -> list[bool]:
        """Of each number that is called determined, whether the truth lies in its interval."""
        some = [(self.truth[s], n["ci95"]) for s, n in self.told.items() if n["told"] == "determined"]
        return [low <= truth <= high for truth, (low, high) in some]


def run_case(number: int, kind: str, seed: int) -> FittedCase:
    """One system, drawn, recorded and fitted."""
    recording, truth = drawn_recording(np.random.default_rng((seed, number, KINDS.index(kind))), kind)
    begun = time.perf_counter()
    with workers(1) as executor:
        found = attempt(fit, [recording], executor=executor)
    if found is None:
        return FittedCase(number, kind, truth, {}, False, None, None, round(time.perf_counter() - begun, 1))
    told = {n.symbol: {"value": n.value, "ci95": n.ci95, "told": n.told} for n in found.numbers}
    seconds = round(time.perf_counter() - begun, 1)
    return FittedCase(number, kind, truth, told, found.explains, found.heldout[0], found.noise[0], seconds)


def drawn_recording(rng: np.random.Generator, kind: str) -> tuple[Recording, dict[str, float]]:
    """A system of a kind: what was recorded, and its true numbers by their names in a first model."""
    if kind == "spring and damper":
        base = {"k": _between(rng, 80.0, 8e3), "b": _between(rng, 1.0, 100.0), "x0": 0.0, "F0": rng.uniform(-3.0, 3.0)}
        session = MaterialSession(int(rng.integers(2**31)), noise=_between(rng, 0.005, 0.05))
        return session.record(base, ()), {symbol: base[symbol] for symbol in ("k", "b", "F0")}
    if kind == "servo":
        base = {"m": _between(rng, 0.2, 20.0), "b": _between(rng, 2.0, 60.0), "k": 0.0, "Fc": 0.0}
        base |= {"k": _between(rng, 5.0, 200.0)} if rng.random() < 0.5 else {}
        base |= {"Fc": _between(rng, 0.1, 3.0)} if rng.random() < 0.5 else {}
        base |= {"offset": rng.uniform(-0.5, 0.5), "gravity": 0.0, "pendulum": 0.0}
        driven = DrivenSession(int(rng.integers(2**31)), noise=_between(rng, 5e-6, 5e-5))
        return driven.record(base, ()), {symbol: base[symbol] for symbol in ("m", "b", "k", "Fc", "offset")}
    base = draw_base(rng, ())
    contact = replace(draw_session(rng, PLANTS["own" if "own" in kind else "foreign"]), duration=SECONDS)
    late = (Concealed("time_delay", {"delay": 0.004}),) if kind == LATE else ()
    recorded = contact.record(base, late)
    return completed(recorded.time, recorded.columns, "drawn"), {
        symbol.replace("normal_", "normal."): v for symbol, v in base.items()
    }


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Drawn evenly on a logarithmic scale."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def judge(cases: Sequence[FittedCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    holds = [held for case in cases for held in case.holds()]
    missed = 1.0 - sum(holds) / max(len(holds), 1)
    late = [case for case in cases if case.kind == LATE]
    seen = sum(not case.explains for case in late)
    lead = (
        f"Systems drawn at random, seed {seed}, recorded by plants that share no simulation with the fit, and "
        f"fitted by `mmt-drake fit`'s search from that alone. Contacts of {SECONDS:g} s, the others 30 s, at 0.5 "
        "to 1 kHz."
    )
    sentences = [
        f"{sum(holds)} of {len(holds)} numbers called determined lie in their 95 % intervals.",
        f"Where the force is 4 ms late, which the structure has no word for, {seen} of {len(late)} fits say that "
        "they leave more than noise, or refuse, and call no number determined.",
    ]
    reached = [Reached(f"{len(holds)} numbers", TOLD_TRULY, missed)]
    return DrawnFindings(lead, told_table(cases), sentences, reached)


def told_table(cases: Sequence[FittedCase]) -> Table:
    """By kind: how many numbers are determined, how many of these intervals hold the truth, how wide they are."""
    rows: list[list[Cell]] = []
    for kind in dict.fromkeys(case.kind for case in cases):
        some = [case for case in cases if case.kind == kind]
        holds = [held for case in some for held in case.holds()]
        told = [n for case in some for n in case.told.values()]
        ratios = [case.heldout / case.noise for case in some if case.heldout is not None and case.noise]
        widths = [
            50.0 * (n["ci95"][1] - n["ci95"][0]) / abs(n["value"])
            for n in told
            if n["told"] == "determined" and n["value"] != 0.0
        ]
        rows.append(
            [
                kind,
                len(some),
                f"{len(holds)} of {len(told)}",
                f"{sum(holds)} of {len(holds)}",
                of_known(np.median, widths),
                f"{sum(case.explains for case in some)} of {len(some)}",
                of_known(np.median, ratios),
                float(np.median([case.seconds for case in some])),
            ]
        )
    headers = ["system", "recordings", "determined", "truth in the interval", "half of it [%], median"]
    headers += ["called explained", "held-out error over that of noise, median", "time [s], median"]
    return Table(headers, rows, "What is told of each kind of system, and whether it is true.")


CASES: Final = DrawnCases(
    name="fit",
    label="systems",
    usual=8,
    tasks=each_draw(run_case, KINDS),
    title="First models from recordings alone",
    heading="First models",
    by="By kind",
    judge=judge,
)
STUDIES: Final = CASES.studies
