"""The estimators on the same motions: how near the rendered force comes to the plant's, and how soon."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from diagrams.experiments.changes import NOISE, sensing
from diagrams.experiments.comparisons.bound import NEAR, NoiseBound, noise_bound
from diagrams.experiments.comparisons.comparison import Cases, Comparison, Judgement, Recordings
from diagrams.experiments.comparisons.cost import COST_S, cost_us
from diagrams.experiments.comparisons.found import FOUND, IN_TIME_S, cells, times_found, told, verdicts
from diagrams.experiments.findings import truth
from diagrams.experiments.plans import SETTLE_S
from diagrams.experiments.runs import Case
from diagrams.scenario import Recorded, Scenario, Scripted, load_scenario
from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING, counted
from mmt_drake.analysis.signals import BAND_NAMES, vector
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import percent
from mmt_drake.estimation.kinds import NAMES, EstimatorOptions
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import LearningOptions, OutputErrorOptions
from mmt_drake.estimation.recursive.options import InstrumentalOptions, KalmanOptions
from mmt_drake.recording import Recording

_ESTIMATORS: Final[Mapping[str, EstimatorOptions]] = {
    "thesis_rls": RlsOptions(),
    "settled_rls": RlsOptions(settle=SETTLE_S),
    "output_error": OutputErrorOptions(),
    "kalman": KalmanOptions(),
    "instrumental_variable": InstrumentalOptions(),
}
_SYSTEM: Final = "free_running_system"
"""Scenario setup1-free-running: `output_error`, a contact detector at the operator, updates without a jump."""
REACH: Final = {"scripted": 0.005, "hand": 0.02}
"""Error of the rendered force to be reached, in each band."""


def public_hands() -> list[Path]:
    """Public recordings of hands (panda_comanipulation), where MMT_RECORDINGS or ../shared/recordings is a folder."""
    beside = Path(__file__).resolve().parents[3] / ".." / "shared" / "recordings"
    folder = Path(os.environ.get("MMT_RECORDINGS", beside)) / "panda_comanipulation"
    return sorted(folder.glob("*.npz"))


def _motions() -> dict[str, Scripted | Recorded]:
    hands = {f"hand_{file.stem}": Recorded(str(file)) for file in public_hands()}
    return {"strokes": Scripted(), "chirp": Scripted("chirp"), "hand_reaching": Recorded(), **hands}


def cases(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
    """Each motion with each estimator, and with the scenario that has all that is better."""
    base = replace(load_scenario("setup1"), seed=seed, clouds="none")
    base = sensing(NOISE)(base)
    systems = {name: replace(base, estimator=estimator) for name, estimator in _ESTIMATORS.items()}
    systems[_SYSTEM] = replace(load_scenario("setup1-free-running"), seed=seed, clouds="none")
    return {
        f"{motion}_{name}": replace(
            system, operator=operator, duration=seconds if seconds or motion[:4] == "hand" else 60.0
        )
        for motion, operator in _motions().items()
        for name, system in systems.items()
    }


def judge(found: Cases, recordings: Recordings) -> Judgement:
    """Errors by band against the force without noise, and when parameters were found, beside what the noise allows."""
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values()), "to reach [%]", "noise leaves [%]"]
    headers += ["over noise", "us a tick", "stable [s]", *(f"{name} [s]" for name in FOUND)]
    rows: list[list[Cell]] = []
    figures: dict[str, dict[str, Any]] = {}
    sentences, pictures = [], {}
    bounds: dict[str, NoiseBound] = {}  # estimators differ, motions do not
    costs: dict[EstimatorOptions, float] = {}  # and the other way round
    for name, case in found.items():
        error, recording = case.metrics.rendered_error_true, recordings[name]
        if error is None:
            continue
        ratios = {band: error.tangential[band] for band in BAND_NAMES}
        matters = [band for band in error.telling if band != "all"]
        reach = REACH["hand" if name.startswith("hand") else "scripted"]
        worst = max((ratios[band] or 0.0 for band in matters), default=0.0)
        over, times = over_noise(case, recording), times_found(recording, truth(case))
        motion = str(case.scenario.operator)
        if motion not in bounds:
            bounds[motion] = _bound(case, recording)
        chosen = case.scenario.estimator
        if chosen not in costs:
            costs[chosen] = cost_us(chosen, recording)
        allows, leaves = bounds[motion].allows_s, bounds[motion].leaves
        rows.append(
            [
                name,
                *(None if ratio is None else 100.0 * ratio for ratio in ratios.values()),
                100.0 * reach,
                100.0 * max((leaves[band] or 0.0 for band in matters), default=0.0),
                over,
                costs[chosen],
                case.metrics.time_to_stable_s,
                *cells(times, allows),
            ]
        )
        figures[name] = {
            "bands_that_matter": matters,
            "worst_band": worst,
            "to_reach": reach,
            "over_noise": over,
            "us_per_tick": costs[chosen],
            "noise_leaves": dict(leaves),
            "found_s": times,
            "noise_allows_s": dict(allows),
            "found": verdicts(times, allows),
        }
        if isinstance(chosen, LearningOptions):
            verdict = "reached" if worst <= reach else "missed"
            sentences.append(
                f"{name}: {percent(worst)} off in the worst band that matters, to reach {percent(reach)}: {verdict}."
            )
            sentences.append(told(name, times, allows))
    for motion in _motions():
        worst_of = {
            each: figures[f"{motion}_{each}"]["worst_band"] for each in _ESTIMATORS if f"{motion}_{each}" in figures
        }
        if len(worst_of) > 1:
            nearest = sorted(worst_of, key=lambda each: worst_of[each])
            in_turn = ", ".join(f"{each} ({percent(worst_of[each])})" for each in nearest)
            sentences.append(f"{motion}, the nearest first: {in_turn}.")
        each_s = {each: found.get(f"{motion}_{each}") for each in (*_ESTIMATORS, _SYSTEM)}
        errors = {each: case.metrics.rendered_error_true for each, case in each_s.items() if case is not None}
        known = {each: error for each, error in errors.items() if error is not None}
        if known:
            pictures[motion] = (charts.error_bars(known, title=f"Error of the rendered force: {motion}"), motion)
    caption = (
        "Error of the rendered force against the plant's without noise, in contact, from 5 s of contact on; to be "
        f"reached in every band that holds {percent(TELLING)} of the force. Over noise: error against the measured "
        "force over that of the plant's own. Us a tick: processor time of the estimator alone, over the first "
        f"{COST_S:g} s of the motion. Stable: from the prior on, 0. Behind it, contact time until a parameter "
        f"stays within {percent(NEAR)} of the truth / after which the force's noise alone would allow that, 95 times "
        "of 100, by the Cramer-Rao bound along the true motion; – where it never does. What that bound allows within "
        f"{IN_TIME_S:g} s has to be found within {IN_TIME_S:g} s. Noise leaves: the error that parameters at the bound "
        "would have in the worst band that matters."
    )
    return Judgement(Table(headers, rows, caption), sentences, figures, pictures)


def over_noise(case: Case, recording: Recording) -> float | None:
    """Error of the rendered against the measured force over that of the plant's force: 1 is as good as can be."""
    chosen = counted(recording)
    noise = (vector(recording, "true_force") - vector(recording, "force"))[chosen, :2]
    least = float(np.sqrt(np.mean(np.sum(noise**2, axis=1))))
    error = case.metrics.rendered_error
    ratio = error.tangential["all"]
    return None if ratio is None or least == 0.0 else ratio * error.reference_rms["all"] / least


def _bound(case: Case, recording: Recording) -> NoiseBound:
    """What the noise of the force would allow the free-running fit."""
    environment, step = case.scenario.environment, case.scenario.step
    return noise_bound(environment.object, recording, environment.noise.force, OutputErrorOptions(step=step).ticks)


ESTIMATORS: Final = Comparison(
    name="estimators",
    title="Does the rendered force equal the measured one?",
    lead=(
        "Set-up 1 with sensor noise of 0.02 N, 0.01 mm and 0.5 mm/s: strokes, a chirp to 10 Hz, a modelled hand and, "
        "where they are at hand, recorded ones; with the thesis's estimator, with the same waiting after each touch, "
        "with the one whose model runs freely over a window, with two recursive ones (a Kalman filter and the refined "
        "instrumental variable), and with the window in a station whose operator has a contact detector too."
    ),
    cases=cases,
    judge=judge,
)


def with_estimator(comparison: Comparison, name: str) -> Comparison:
    """The comparison without the cases of other estimators; `name` is one of `mmt_drake.estimation.kinds.NAMES`."""

    def fewer(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
        made = comparison.cases(seed, seconds)
        return {case: scenario for case, scenario in made.items() if NAMES[type(scenario.estimator)] == name}

    return replace(comparison, cases=fewer)
