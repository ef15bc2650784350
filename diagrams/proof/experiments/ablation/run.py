"""Runs of every cause, as experiment 1, frozen and as experiment 3, and which figures they reproduce."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.signal import hilbert

from mmt_drake.analysis.metrics import counted, measure
from mmt_drake.analysis.signals import BANDS, components, in_band, mean_step, on_even_clock
from mmt_drake.diagrams.proof.experiments.ablation.causes import CAUSES, healthy
from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS, REFERENCES, Claim, Runs
from mmt_drake.diagrams.proof.experiments.changes import Cause
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun
from mmt_drake.diagrams.proof.experiments.targets import RENDERED, answered, bands, estimated, stable
from mmt_drake.diagrams.proof.experiments.thesis import FREEZE_AFTER_S, SCENARIOS
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording, load

SECONDS: Final = 30.0
"""Length of a run, unless a recording says otherwise [s]."""

RUNS: Final = ("running", "frozen", "delayed")
"""Of every cause, see `claims.Runs`."""


@dataclass(frozen=True)
class Verdict:
    """One cause: its runs, and which of the thesis's figures they reproduce.

    Attributes:
        cause: what was put in.
        cases: its runs, by `RUNS`.
        against: the same measured, by `claims.REFERENCES`.
    """

    cause: Cause
    cases: Mapping[str, MeasuredRun]
    against: Mapping[str, Runs]

    def reproduced(self, reference: str) -> tuple[Claim, ...]:
        """What of the thesis's figures these runs show too, against one of `claims.REFERENCES`."""
        return tuple(claim for claim in CLAIMS if claim.holds(self.against[reference]))

    def figures(self, reference: str) -> tuple[int, ...]:
        """The numbers of those figures, in order."""
        return tuple(sorted(figure for claim in self.reproduced(reference) for figure in claim.figures))

    def rendered(self) -> list[Reached]:
        """The rendered force of `running` by band."""
        return bands(self.cause.name, self.cases["running"].metrics.rendered_error_true, RENDERED)

    def figures_to_reach(self) -> list[Reached]:
        """Of these runs."""
        name, running, delayed = self.cause.name, self.cases["running"], self.cases["delayed"]
        by_prior = not isinstance(running.scenario.estimator, RlsOptions)
        return [
            *self.rendered(),
            *estimated(name, running.metrics.estimated_error),
            stable(name, running.metrics, by_prior=by_prior),
            *answered(name, delayed.metrics, delayed.scenario.step),
        ]


def scenarios(cause: Cause, seconds: float | None, seed: int) -> dict[str, Scenario]:
    """What is built for a cause, by `RUNS`; only the thesis's estimator can be frozen, another runs on."""
    running = cause.change(healthy(seconds, seed))
    frozen = running
    if isinstance(running.estimator, RlsOptions):
        frozen = replace(running, estimator=replace(running.estimator, freeze_after=FREEZE_AFTER_S))
    far = load_scenario(SCENARIOS[3])
    return {
        "running": running,
        "frozen": frozen,
        "delayed": replace(running, to_telerobot=far.to_telerobot, to_operator=far.to_operator),
    }


def cases(causes: Sequence[Cause], asked: Asked) -> dict[str, Scenario]:
    """What is built for every cause, as `cause: run`.

    A replayed hand takes the causes away that are another motion of it.
    """
    length = SECONDS if asked.seconds is None and asked.operator is None else asked.seconds
    if asked.operator is not None:
        causes = [cause for cause in causes if cause.change(healthy()).operator == healthy().operator]
    return {
        f"{cause.name}: {run}": scenario
        for cause in causes
        for run, scenario in scenarios(cause, length, asked.seed).items()
    }


def verdicts_of(cases: Cases) -> dict[str, Verdict]:
    """Name of a cause -> what its runs show."""
    causes = {cause.name: cause for cause in CAUSES}
    names = dict.fromkeys(name.rpartition(": ")[0] for name in cases)
    found = {}
    for name in names:
        runs = {run: cases[f"{name}: {run}"] for run in RUNS}
        found[name] = Verdict(causes[name], runs, _measured(runs))
    return found


def _measured(cases: Mapping[str, MeasuredRun]) -> dict[str, Runs]:
    """The runs of one cause against each of `claims.REFERENCES`."""
    recordings = {run: load(case.recording) for run, case in cases.items()}
    running, frozen = (spikes(recordings[run]) for run in ("running", "frozen"))
    raw = {run: case.metrics for run, case in cases.items()}
    filtered = {
        run: measure(recordings[run], delay_s=raw[run].delay_s, measured="filtered_force") for run in recordings
    }
    return {
        name: Runs(**metrics, spikes=running, frozen_spikes=frozen)
        for name, metrics in zip(REFERENCES, (raw, filtered), strict=True)
    }


def spikes(recording: Recording) -> float:
    """By how much the spikes of rendered and estimated force differ in height, where errors count.

    RMS of the difference of their envelopes from 3 to 10 Hz, x and y together, over that of the estimated force's. An
    envelope tells heights and not when: the estimated force is as late as the estimator's filters, which alone makes up
    to 0.1 here.

    What came before is cut off: the first estimates may be larger by orders of magnitude, and a filter rings.

    Raises:
        BadInput: a column is missing or broken, or nothing counts.
    """
    even = on_even_clock(recording)
    chosen, rate = counted(even), 1.0 / mean_step(even)
    wound_up = slice(int(np.argmax(chosen)), None)

    def envelope(name: str) -> Array:
        x, y, _ = (hilbert(in_band(force[wound_up], BANDS["3_to_10_hz"], rate)) for force in components(even, name))
        return np.hypot(np.abs(x), np.abs(y))[chosen[wound_up]]

    rendered, estimated = envelope("rendered_force"), envelope("estimated_force")
    return float(np.linalg.norm(rendered - estimated) / np.linalg.norm(estimated))
