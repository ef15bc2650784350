"""How sure the free-running estimator says it is of its numbers, and how near to the truth they are."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.comparisons.bound import bound_of, sensitivity
from mmt_drake.diagrams.proof.experiments.objects import STEP, drawn, path_of
from mmt_drake.diagrams.proof.experiments.targets import NOT_COVERED, OVER_THE_BOUND
from mmt_drake.diagrams.proof.experiments.tick_by_tick import PLANTS, by_axis, measured_along
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings, each_draw
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.estimation.output_error.fit import HALF_KNOWN
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.unknowns import OBJECT, TABLE, derivatives
from mmt_drake.model.parameters import TANGENTIAL_THETA, FlexibleBoxModel
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

SECONDS: Final = {"strokes": 31.0, "reaches": 40.0, "press_slide_lift": 45.0, "sines": 31.0, "chirp": 31.0}
"""Motion -> how long it takes."""
TOUCHED: Final = (5.0, 10.0, 30.0)
"""Contact [s] after which the numbers are looked at."""
_OPTIONS: Final = OutputErrorOptions(step=STEP, in_plane="vector")


@dataclass(frozen=True)
class CoverageCase:
    """One object under one motion.

    Attributes:
        number: of the draw.
        motion: one of `SECONDS`.
        plant: one of `PLANTS`.
        off: contact of `TOUCHED` -> how far each number of `TANGENTIAL_THETA` is off, in its deviations; None: this
            motion does not tell it, and the estimator says so.
        over_bound: the same for each deviation over the Cramer-Rao bound of the force's noise; of the own plant alone.
    """

    number: int
    motion: str
    plant: str
    off: Mapping[float, list[float | None]]
    over_bound: Mapping[float, list[float | None]]


def run_case(number: int, motion: str, plant: str, seed: int) -> CoverageCase:
    """One object, estimated."""
    model = replace(drawn(number, seed), in_plane="vector")
    time, path = path_of(motion, SECONDS[motion])
    random = np.random.default_rng((seed, number, list(SECONDS).index(motion)))
    measurement, contact, _ = measured_along(time, path, model, NOISE, random, plant)
    trace = estimate_output_error(measurement, contact, _OPTIONS)
    true = model.theta()[OBJECT]
    least = _bound(model, time, path) if plant == "own" else None
    touched = np.cumsum(contact) * STEP
    off: dict[float, list[float | None]] = {}
    over: dict[float, list[float | None]] = {}
    for after in TOUCHED:
        at = int(np.searchsorted(touched, after))
        if at >= len(time):
            continue
        found, deviation = trace.theta[at][OBJECT], trace.deviation[at][OBJECT]
        told = deviation / derivatives(found) < HALF_KNOWN * _BELIEVED
        off[after] = _where(told, (found - true) / deviation)
        if least is not None:
            over[after] = _where(told, deviation / least[min(at // _OPTIONS.ticks, len(least)) - 1])
    return CoverageCase(number, motion, plant, off, over)


_BELIEVED: Final = np.array([unknown.deviation for unknown in TABLE.values()])[OBJECT]


def _where(told: Flags, values: Array) -> list[float | None]:
    return [float(value) if known else None for value, known in zip(values, told, strict=True)]


def _bound(model: FlexibleBoxModel, time: Array, path: Array) -> Array:
    """Deviations (k, 6) of theta that the force's noise alone would leave, after each sample of the fit."""
    contact = path[:, 2] < 0.0
    columns = by_axis({"position": path[:, :3], "velocity": path[:, 3:]}) | {"in_contact": contact.astype(np.float64)}
    _, slope = sensitivity(model, Recording(time, columns, "the true motion"))
    return bound_of(model, slope, contact, NOISE.force, _OPTIONS.ticks)[1]


def _pooled(cases: Sequence[CoverageCase], plant: str) -> Iterator[tuple[float, str, Array, Array, int]]:
    """Contact, number, deviations that it is off, deviations over the bound, and how many do not tell it."""
    some = [case for case in cases if case.plant == plant]
    for after in TOUCHED:
        for index, name in enumerate(TANGENTIAL_THETA):
            off = [case.off[after][index] for case in some if after in case.off]
            over = [case.over_bound[after][index] for case in some if after in case.over_bound]
            known = np.array([value for value in off if value is not None])
            bounds = np.array([value for value in over if value is not None])
            yield after, name, known, bounds, len(off) - len(known)


def _outside(off: ArrayLike) -> float:
    """The share of numbers that are further off than two of their deviations."""
    return float(np.mean(np.abs(off) > 2.0))


def judge(cases: Sequence[CoverageCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    reached, sentences = [], []
    for plant in PLANTS:
        for after, name, off, over, _ in _pooled(cases, plant):
            if len(off):
                reached.append(Reached(f"{name} after {after:g} s, {plant}", NOT_COVERED, _outside(off)))
            if len(over):
                reached.append(Reached(f"{name} after {after:g} s, {plant}", OVER_THE_BOUND, float(np.median(over))))
        every = np.concatenate([off for _, _, off, _, _ in _pooled(cases, plant)])
        if len(every):
            sentences.append(
                f"On the {plant} plant {100.0 * (1.0 - _outside(every)):.1f} % of {len(every)} numbers that a motion "
                f"tells lie within two of their deviations."
            )
    objects = len({case.number for case in cases})
    lead = (
        f"{objects} objects drawn as in `experiment objects`, each under {len(SECONDS)} motions; sensor noise as "
        f"in set-up 1, friction as a vector; one sample a run; seed {seed}. The own plant shares the kernel."
    )
    return DrawnFindings(lead, coverage_table(cases), sentences, reached)


def coverage_table(cases: Sequence[CoverageCase]) -> Table:
    """By plant, contact and number: how many are within two deviations, and how wide these are."""
    rows: list[list[Cell]] = []
    for plant in PLANTS:
        for after, name, off, over, unexcited in _pooled(cases, plant):
            within = of_known(lambda some: 100.0 * (1.0 - _outside(some)), off)
            furthest, wide = of_known(max, np.abs(off)), of_known(np.median, over)
            rows.append([plant, after, name, len(off), within, furthest, wide, unexcited])
    headers = ["plant", "contact [s]", "number", "told by", "within two deviations [%]", "furthest off [deviations]"]
    headers += ["deviation over the bound, median", "not told by"]
    return Table(headers, rows, "The truth and the deviations that the estimator tells.")


CASES: Final = DrawnCases(
    name="coverage",
    label="runs",
    usual=20,
    tasks=each_draw(run_case, SECONDS, PLANTS),
    title="How sure the estimator says it is",
    heading="Truth within two deviations",
    by="By contact and number",
    judge=judge,
)
STUDIES: Final = CASES.studies
