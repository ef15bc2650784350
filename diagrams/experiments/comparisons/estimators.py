"""The estimators on the same motions: how near the rendered force comes to the plant's, and how soon."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING, counted
from mmt_drake.analysis.signals import BAND_NAMES, vector
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.experiments.changes import NOISE, sensing
from mmt_drake.diagrams.experiments.comparison import Cases, Comparison, ComparisonFindings, Recordings
from mmt_drake.diagrams.experiments.comparisons.bound import NoiseBound, noise_bound
from mmt_drake.diagrams.experiments.comparisons.found import parameters_found, times_found, told
from mmt_drake.diagrams.experiments.findings import truth
from mmt_drake.diagrams.experiments.runs import MeasuredRun
from mmt_drake.diagrams.experiments.targets import OVER_NOISE, RENDERED, RENDERED_HAND, bands, stable
from mmt_drake.diagrams.experiments.thesis import SETTLE_S
from mmt_drake.diagrams.stations.estimators import KINDS, EstimatorOptions
from mmt_drake.diagrams.stations.hands import Recorded, Scripted
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario, updates_name
from mmt_drake.diagrams.studies.figures import Reached
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.recording import Recording
from mmt_drake.recording.public import public_recordings

COST_S: Final = 10.0
"""Of a motion, from its beginning, over which the cost is taken [s]."""


def cost_us(options: EstimatorOptions, recording: Recording) -> float:
    """Processor time of the estimator alone, each tick [us], along a motion as it was measured.

    The estimator is compiled before the clock starts. Where it learns beside the fast loop this is what both cost
    together.
    """
    count = min(len(recording.time), round(COST_S / options.step))
    measured = [recording.vector(name) for name in ("position", "velocity", "force")]
    measurement, contact = np.hstack(measured)[:count], recording["in_contact"][:count]
    replay = KINDS[type(options)].replay
    replay(measurement[:10], contact[:10], options)
    start = time.process_time()
    replay(measurement, contact, options)
    return 1e6 * (time.process_time() - start) / count


_ESTIMATORS: Final[Mapping[str, EstimatorOptions]] = {
    "thesis_rls": RlsOptions(),
    "settled_rls": RlsOptions(settle=SETTLE_S),
    "output_error": OutputErrorOptions(),
}
_SYSTEM: Final = "free_running_system"
"""Scenario setup1-free-running: `output_error`, a contact detector at the operator, updates without a jump."""


def public_hands() -> list[Path]:
    """Public recordings of hands (panda_comanipulation), where MMT_RECORDINGS or ../shared/recordings is a folder."""
    return sorted((public_recordings() / "panda_comanipulation").glob("*.npz"))


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


def judge(found: Cases, recordings: Recordings) -> ComparisonFindings:
    """Errors by band against the force without noise, and when parameters were found, beside what the noise allows."""
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values()), "z [%]", "k1 at the end [N/m]", "us a tick"]
    rows: list[list[Cell]] = []
    figures: dict[str, dict[str, Any]] = {}
    sentences, pictures, reached = [], {}, []
    bounds: dict[str, NoiseBound] = {}  # estimators differ, motions do not
    costs: dict[EstimatorOptions, float] = {}  # and the other way round
    for name, case in found.items():
        error, recording = case.metrics.rendered_error_true, recordings[name]
        if error is None:
            continue
        motion, hand = str(case.scenario.operator), name.startswith("hand")
        if motion not in bounds:
            bounds[motion] = _bound(case, recording)
        chosen = case.scenario.estimator
        if chosen not in costs:
            costs[chosen] = cost_us(chosen, recording)
        allows, leaves = bounds[motion].allows_s, bounds[motion].leaves
        updates, ours = updates_name(case.scenario), isinstance(chosen, OutputErrorOptions)
        off = bands(name, error, RENDERED_HAND if hand else RENDERED, updates=updates, bound=leaves)
        over = OVER_NOISE if hand else replace(OVER_NOISE, to_reach=None)
        times = times_found(recording, truth(case))
        parameters = parameters_found(name, times, allows, updates=updates)
        noise = Reached(name, over, over_noise(case, recording), updates=updates)
        reached += [*off, noise, stable(name, case.metrics, by_prior=ours, updates=updates), *parameters.values()]
        rows.append([name, *(in_percent(error.tangential[band]) for band in BAND_NAMES)])
        rows[-1] += [in_percent(error.normal["all"]), case.metrics.parameters.get("k1"), costs[chosen]]
        figures[name] = {
            "bands_that_matter": [band for band in error.telling if band != "all"],
            "worst_band": max((figure.value or 0.0 for figure in off), default=0.0),
            "over_noise": noise.value,
            "us_per_tick": costs[chosen],
            "noise_leaves": dict(leaves),
            "found_s": times,
            "noise_allows_s": dict(allows),
            "found": {each: figure.verdict for each, figure in parameters.items()},
        }
        if ours:
            sentences += [_told(name, off), told(name, parameters)]
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
        "Error of the rendered force against the plant's without noise, in contact, from 5 s of contact on; what is to "
        f"be reached is asked of the bands that hold {percent(TELLING)} of the force. k1 is truly 0. Us a tick: "
        f"processor time of the estimator alone, over the first {COST_S:g} s of the motion."
    )
    return ComparisonFindings([Table(headers, rows, caption)], sentences, reached, figures, pictures)


def _told(name: str, off: Sequence[Reached]) -> str:
    """Of the band that is farthest off."""
    if not off:
        return f"{name}: no band holds enough of the force."
    worst = max(off, key=lambda figure: figure.value or 0.0)
    return (
        f"{name}: {percent(worst.value)} off in the worst band that matters (the noise would leave "
        f"{percent(worst.bound)}), to reach {percent(worst.target.to_reach)}: {worst.verdict}."
    )


def over_noise(case: MeasuredRun, recording: Recording) -> float | None:
    """Error of the rendered against the measured force over that of the plant's force: 1 is as good as can be."""
    chosen = counted(recording)
    noise = (vector(recording, "true_force") - vector(recording, "force"))[chosen, :2]
    least = float(np.sqrt(np.mean(np.sum(noise**2, axis=1))))
    error = case.metrics.rendered_error
    ratio = error.tangential["all"]
    return None if ratio is None or least == 0.0 else ratio * error.reference_rms["all"] / least


def _bound(case: MeasuredRun, recording: Recording) -> NoiseBound:
    """What the noise of the force would allow the free-running fit."""
    environment, step = case.scenario.environment, case.scenario.step
    return noise_bound(environment.object, recording, environment.noise.force, OutputErrorOptions(step=step).ticks)


ESTIMATORS: Final = Comparison(
    name="estimators",
    title="Does the rendered force equal the measured one?",
    lead=(
        "Set-up 1 with sensor noise of 0.02 N, 0.01 mm and 0.5 mm/s: strokes, a chirp to 10 Hz, a modelled hand and, "
        "where they are at hand, recorded ones; with the thesis's estimator, with the same waiting after each touch, "
        "with the one whose model runs freely over a window, and with the window in a station whose operator has a "
        "contact detector too."
    ),
    cases=cases,
    judge=judge,
)
