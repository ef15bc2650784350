"""A force that is measured late, behind a delay and a low pass: whether the estimator finds both, and is right then."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.objects import STEP, drawn, path_of
from mmt_drake.diagrams.proof.experiments.targets import LATE_BY, LATE_ERROR
from mmt_drake.diagrams.proof.experiments.tick_by_tick import PLANTS, behind_sensor, follow, measured_along
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings, each_draw
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.estimation.output_error.options import OutputErrorOptions

SECONDS: Final = {"strokes": 20.0, "reaches": 20.0, "chirp": 30.0}
"""Motion -> how long it takes."""
LATENESS: Final = ((0.0, 0.0), (0.004, 0.0), (0.02, 0.0), (0.0, 0.004), (0.0, 0.008), (0.01, 0.004))
"""Delay and time constant of the low pass (40 and 20 Hz) [s]."""
_FIRST: Final = 0.5  # [s] of contact, which do not count


@dataclass(frozen=True)
class LateCase:
    """One object under one motion, its force late.

    Attributes:
        number: of the draw.
        motion: one of `SECONDS`.
        plant: one of `PLANTS`.
        delay, lag: of the force [s].
        found: what the estimator makes of them, in the order of `mmt_drake.model.parameters.FORCE_LATENESS` [s].
        error: of the rendered force along x and y, against the plant's without noise or delay, after the first 0.5 s.
    """

    number: int
    motion: str
    plant: str
    delay: float
    lag: float
    found: list[float]
    error: float

    @property
    def off(self) -> float:
        """By how much the sum of delay and time constant is off [s]."""
        return abs(self.found[2] - self.delay - self.lag)


def run_case(number: int, motion: str, plant: str, lateness: tuple[float, float], seed: int) -> LateCase:
    """One object, estimated and rendered."""
    model = replace(drawn(number, seed), in_plane="vector")
    time, path = path_of(motion, SECONDS[motion])
    random = np.random.default_rng((seed, number, *(round(1e6 * part) for part in lateness)))
    measurement, contact, force = measured_along(time, path, model, NOISE, random, plant)
    measurement[:, 6:] += behind_sensor(time, force, *lateness) - force
    found = follow(time, measurement, contact, OutputErrorOptions(step=STEP, in_plane="vector"), motion=path)
    counted = (contact > 0.5) & (np.cumsum(contact) * STEP > _FIRST)
    off, true = (values[counted, :2] for values in (found.rendered - force, force))
    error = float(np.linalg.norm(off) / np.linalg.norm(true))
    return LateCase(number, motion, plant, *lateness, found.trace.force_lateness[-1].tolist(), error)


def judge(cases: Sequence[LateCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    objects = len({case.number for case in cases})
    reached = []
    for motion in SECONDS:
        own = [case for case in cases if case.motion == motion]
        reached.append(Reached(motion, LATE_BY, max(case.off for case in own)))
        reached.append(Reached(motion, LATE_ERROR, max(case.error for case in own)))
    worst = max(cases, key=lambda case: case.off)
    sentences = [
        f"Of {len(cases)} contacts the sum of delay and time constant is off by "
        f"{1e3 * float(np.median([case.off for case in cases])):.2g} ms (median), {1e3 * worst.off:.2g} ms at worst."
    ]
    lead = (
        f"{objects} objects drawn as in `experiment objects`, sensor noise as in set-up 1, friction as a vector; "
        f"strokes and reaches of 20 s, a chirp of 30 s; seed {seed}. The own plant shares the kernel."
    )
    return DrawnFindings(lead, late_table(cases), sentences, reached)


def late_table(cases: Sequence[LateCase]) -> Table:
    """By motion and lateness, both plants together: what was found, medians and worst."""
    rows: list[list[Cell]] = []
    for motion in SECONDS:
        for delay, lag in LATENESS:
            some = [case for case in cases if (case.motion, case.delay, case.lag) == (motion, delay, lag)]
            found = 1e3 * np.array([case.found for case in some])
            errors = [100.0 * case.error for case in some]
            of_the_sum: list[Cell] = [1e3 * float(f([case.off for case in some])) for f in (np.median, np.max)]
            lags: list[Cell] = [float(np.median(found[:, column])) for column in (1, 4)]
            rows.append([motion, 1e3 * delay, 1e3 * lag, *of_the_sum, *lags, float(np.median(errors)), max(errors)])
    headers = ["motion", "delay [ms]", "time constant [ms]", "sum off [ms], median", "worst"]
    headers += ["time constant found [ms], median", "its deviation", "force off [%], median", "worst"]
    return Table(headers, rows, "Delay and low pass as found, and the rendered force after the first 0.5 s of contact.")


CASES: Final = DrawnCases(
    name="late",
    label="contacts",
    usual=3,
    tasks=each_draw(run_case, SECONDS, PLANTS, LATENESS),
    title="A force that is measured late",
    heading="Delay and low pass of the force",
    by="By motion",
    judge=judge,
)
STUDIES: Final = CASES.studies
