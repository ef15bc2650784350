"""Objects that the model has the law of, that it has not, and that change: whether the estimator says which."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent
from mmt_drake.diagrams.proof.experiments.changes import NOISE
from mmt_drake.diagrams.proof.experiments.objects import STEP, drawn, path_of
from mmt_drake.diagrams.proof.experiments.targets import FALSE_ALARMS, NOTICED
from mmt_drake.diagrams.proof.experiments.tick_by_tick import PLANTS, measured_along, own_force
from mmt_drake.diagrams.proof.studies.drawn import DrawnCases, DrawnFindings, each_draw
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.studies.study import Reached
from mmt_drake.estimation.output_error.adequacy import ModelStatus
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model_files import with_effects

SECONDS: Final = 12.0
CHANGE: Final = 6.0
"""When an object becomes another one [s]."""
ADEQUATE: Final = tuple(f"{motion}, {plant}" for motion in ("strokes", "reaches", "chirp") for plant in PLANTS)
"""Motions and plants whose law the model has."""
LAWS: Final = {
    "Hunt-Crossley, 300/m": {"name": "hunt_crossley_damping", "parameters": {"lambda": 300.0}},
    "cubic spring, 3e6 N/m^3": {"name": "nonlinear_stiffness", "parameters": {"k3": 3e6}},
    "wall after 4 mm": {"name": "end_stop", "parameters": {"position": 0.004, "stiffness": 3000.0}},
}
"""What the model has not, from the beginning."""
CHANGES: Final = {
    "k2 + 30 %": lambda p: replace(p, k2=1.3 * p.k2),
    "mass doubled": lambda p: replace(p, m=2.0 * p.m),
    "ground spring, 300 N/m": lambda p: replace(p, k1=p.k1 + 300.0),
}
KINDS: Final = (*ADEQUATE, *LAWS, *CHANGES)
_AFTER: Final = (2.0, 4.0)  # [s] after a change, between which the error is taken


@dataclass(frozen=True)
class AdequacyCase:
    """One object of one kind.

    Attributes:
        number: of the draw.
        kind: one of `KINDS`.
        noticed_s: contact until the estimator says MISFIT or CHANGED, from the first touch or the change on [s]; None:
            it never does.
        changed: whether it said CHANGED.
        error: of the estimated force along x and y from 2 to 4 s after a change, against the force without noise.
    """

    number: int
    kind: str
    noticed_s: float | None
    changed: bool
    error: float | None


def run_case(number: int, kind: str, seed: int) -> AdequacyCase:
    """One object under 12 s of motion, estimated."""
    model = replace(drawn(number, seed), in_plane="vector")
    motion, plant = kind.split(", ") if kind in ADEQUATE else ("strokes", "own")
    time, path = path_of(motion, SECONDS)
    random = np.random.default_rng((seed, number, KINDS.index(kind)))
    if kind in LAWS:
        model = with_effects(model, [LAWS[kind]], kind)
    measurement, contact, force = measured_along(time, path, model, NOISE, random, plant)
    if kind in CHANGES:
        changed = own_force(time, path, model, (CHANGE, replace(model, parameters=CHANGES[kind](model.parameters))))
        measurement[:, 6:] += changed - force
        force = changed
    trace = estimate_output_error(measurement, contact, OutputErrorOptions(step=STEP, in_plane="vector"))
    begin = CHANGE if kind in CHANGES else 0.0
    said = np.flatnonzero(np.isin(trace.model_status, (ModelStatus.MISFIT, ModelStatus.CHANGED)) & (time >= begin))
    touched = np.cumsum(contact * (time >= begin)) * STEP
    after = (contact > 0.5) & (time >= CHANGE + _AFTER[0]) & (time < CHANGE + _AFTER[1])
    left, true = (values[after, :2] for values in (trace.estimated_force - force, force))
    return AdequacyCase(
        number,
        kind,
        float(touched[said[0]]) if len(said) else None,
        bool(np.any(trace.model_status == ModelStatus.CHANGED)),
        float(np.linalg.norm(left) / np.linalg.norm(true)) if kind in CHANGES else None,
    )


def judge(cases: Sequence[AdequacyCase], seed: int) -> DrawnFindings:
    """What it comes to."""
    fitting = [case for case in cases if case.kind in ADEQUATE]
    alarms = sum(case.noticed_s is not None for case in fitting)
    others = [case for case in cases if case.kind not in ADEQUATE]
    late = [np.inf if case.noticed_s is None else case.noticed_s for case in others]
    worst = max(late) if late else None
    reached = [
        Reached(f"{len(fitting)} objects that fit", FALSE_ALARMS, float(alarms)),
        Reached(f"{len(others)} that do not", NOTICED, None if worst == np.inf else worst, never=worst == np.inf),
    ]
    sentences = [
        f"Of {len(fitting)} contacts whose law the model has, {alarms} are called MISFIT or CHANGED; of {len(others)} "
        f"others {sum(np.isfinite(late))} are noticed, after {np.median(late):.2f} s of contact (median)."
    ]
    lead = (
        f"Objects drawn as in `experiment objects`, {SECONDS:g} s each, sensor noise as in set-up 1, friction as a "
        f"vector; changes at {CHANGE:g} s; strokes unless said; seed {seed}. The own plant shares the kernel."
    )
    return DrawnFindings(lead, adequacy_table(cases), sentences, reached)


def adequacy_table(cases: Sequence[AdequacyCase]) -> Table:
    """By kind: how many were noticed, how soon, and how far the force is off after a change."""
    rows: list[list[Cell]] = []
    for kind in KINDS:
        some = [case for case in cases if case.kind == kind]
        soon = [case.noticed_s for case in some if case.noticed_s is not None]
        counts: list[Cell] = [f"{len(soon)} of {len(some)}", f"{sum(case.changed for case in some)} of {len(some)}"]
        error = of_known(np.median, (case.error for case in some))
        rows.append([kind, *counts, of_known(np.median, soon), of_known(max, soon), in_percent(error)])
    headers = ["object", "MISFIT or CHANGED", "CHANGED", "after [s of contact], median", "worst"]
    headers += ["force off, 2 to 4 s later [%], median"]
    return Table(headers, rows, "What the estimator says, and how soon.")


CASES: Final = DrawnCases(
    name="adequacy",
    label="contacts",
    usual=10,
    tasks=each_draw(run_case, KINDS),
    title="What the estimator says of its model",
    heading="Adequacy of the model",
    by="By kind",
    judge=judge,
)
STUDIES: Final = CASES.studies
