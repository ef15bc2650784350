"""Runs every cause three times, as experiment 1, with frozen parameters and as experiment 3, and judges the figures."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import hilbert

from mmt_drake.analysis.metrics import counted
from mmt_drake.analysis.signals import BANDS, components, in_band, mean_step, on_even_clock
from mmt_drake.diagrams.experiments.ablation.causes import CAUSES, Cause, healthy
from mmt_drake.diagrams.experiments.ablation.claims import CLAIMS, Claim, Runs
from mmt_drake.diagrams.experiments.runs import MeasuredRun, run_cases
from mmt_drake.diagrams.experiments.targets import RENDERED, answered, bands, estimated, stable
from mmt_drake.diagrams.experiments.thesis import FREEZE_AFTER_S, SCENARIOS
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, operator_name
from mmt_drake.diagrams.studies.figures import Reached, to_json
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.recording import Recording, load

Array = NDArray[np.float64]

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
        spikes: of `running` and `frozen`, see `spikes`.
    """

    cause: Cause
    cases: Mapping[str, MeasuredRun]
    spikes: Mapping[str, float]

    @property
    def reproduced(self) -> tuple[Claim, ...]:
        """What of the thesis's figures these runs show too."""
        metrics = {name: self.cases[name].metrics for name in RUNS}
        runs = Runs(**metrics, spikes=self.spikes["running"], frozen_spikes=self.spikes["frozen"])
        return tuple(claim for claim in CLAIMS if claim.holds(runs))

    @property
    def figures(self) -> tuple[int, ...]:
        """The numbers of those figures, in order."""
        return tuple(sorted(figure for claim in self.reproduced for figure in claim.figures))

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


@dataclass(frozen=True)
class AblationResult:
    """All causes.

    Attributes:
        seed: of everything random.
        operator: name of the motion, or the recording that was replayed.
        verdicts: one per cause.
    """

    seed: int
    operator: str
    verdicts: tuple[Verdict, ...]

    def reproducing(self, claim: Claim) -> tuple[Verdict, ...]:
        """The causes that reproduce what a figure shows."""
        return tuple(verdict for verdict in self.verdicts if claim in verdict.reproduced)

    def figures_to_reach(self) -> list[Reached]:
        """Of every cause: errors by band and time until stable as experiment 1, lags as experiment 3."""
        return [figure for verdict in self.verdicts for figure in verdict.figures_to_reach()]

    def to_json(self) -> dict[str, Any]:
        """The document that `experiment ablation --json` prints."""
        return {
            "experiment": "ablation",
            "scenario": SCENARIOS[1],
            "seed": self.seed,
            "operator": self.operator,
            "cases": [
                {**case.to_json(), "cause": verdict.cause.name, "group": verdict.cause.group, "run": run}
                for verdict in self.verdicts
                for run, case in verdict.cases.items()
            ],
            "causes": [
                {
                    "name": verdict.cause.name,
                    "group": verdict.cause.group,
                    "figures": list(verdict.figures),
                    "spikes": dict(verdict.spikes),
                }
                for verdict in self.verdicts
            ],
            "figures": [
                {
                    "figure": figure,
                    "thesis": claim.says,
                    "needs": claim.needs,
                    "reproduced": bool(self.reproducing(claim)),
                    "reproduced_by": [verdict.cause.name for verdict in self.reproducing(claim)],
                }
                for claim in CLAIMS
                for figure in claim.figures
            ],
            "figures_to_reach": to_json(self.figures_to_reach()),
        }


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


def run_ablation(
    causes: Sequence[Cause] = CAUSES,
    *,
    out: str | Path,
    operator: str | Path | Recording | None = None,
    seed: int = 0,
    seconds: float | None = None,
    jobs: int = 1,
    progress: Callable[[float], None] | None = None,
) -> AblationResult:
    """Put in every cause, alone or with others as it says, and measure.

    Args:
        causes: what is put in.
        out: folder for the recordings, `ablation_00_running.mcap` and so on; made if need be.
        operator: a recording whose probe motion replaces the scripted strokes, and with them the causes that are
            another motion of the hand.
        seed: of everything random.
        seconds: how long each run is; `SECONDS` by default, or the operator's recording's length.
        jobs: processes at work at the same time; the numbers do not depend on it.
        progress: called with the number of runs done, of three per cause.

    Raises:
        BadInput: a recording that is none, a value out of range, a folder that cannot be made.
    """
    recording = operator if isinstance(operator, Recording | None) else load_operator(operator)
    length = seconds if seconds is not None or recording is not None else SECONDS
    if recording is not None:
        causes = [cause for cause in causes if cause.change(healthy()).operator == healthy().operator]
    built, files = {}, {}
    for number, cause in enumerate(causes):
        for run, scenario in scenarios(cause, length, seed).items():
            name = f"{cause.name}: {run}"
            built[name] = scenario if length is not None else replace(scenario, duration=None)
            files[name] = Path(out) / f"ablation_{number:02d}_{run}.mcap"
    cases = {case.name: case for case in run_cases(built, files, operator=recording, jobs=jobs, progress=progress)}
    verdicts = tuple(_judged(cause, {run: cases[f"{cause.name}: {run}"] for run in RUNS}) for cause in causes)
    return AblationResult(seed, operator_name(next(iter(built.values())), recording), verdicts)


def _judged(cause: Cause, cases: Mapping[str, MeasuredRun]) -> Verdict:
    return Verdict(cause, cases, {run: spikes(load(cases[run].recording)) for run in ("running", "frozen")})


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
