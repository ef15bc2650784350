"""The estimators on the same motions: how near the rendered force comes to the plant's, and how soon."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING, counted
from mmt_drake.analysis.page import Picture
from mmt_drake.analysis.signals import BAND_NAMES, vector
from mmt_drake.analysis.table import Cell
from mmt_drake.analysis.wording import in_percent, percent
from mmt_drake.diagrams.proof.experiments.changes import noisy
from mmt_drake.diagrams.proof.experiments.comparison import CaseFindings, Comparison, Findings, findings_of
from mmt_drake.diagrams.proof.experiments.comparisons.bound import (
    NoiseBound,
    noise_bound,
    parameters_found,
    times_found,
)
from mmt_drake.diagrams.proof.experiments.runs import Cases, MeasuredRun
from mmt_drake.diagrams.proof.experiments.targets import OVER_NOISE, RENDERED, RENDERED_HAND, bands, stable
from mmt_drake.diagrams.proof.experiments.thesis import ESTIMATOR_OPTIONS
from mmt_drake.diagrams.proof.studies.study import Asked, Reached
from mmt_drake.diagrams.stations.estimators import KINDS, EstimatorOptions, OwnEstimator
from mmt_drake.diagrams.stations.hands import Recorded, Scripted
from mmt_drake.diagrams.stations.scenario import Scenario, load_scenario
from mmt_drake.errors import BadInput
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


_SYSTEM: Final = "free_running_system"
"""Scenario setup1-free-running: `output_error`, a contact detector at the operator, updates without a jump."""


def _motions() -> dict[str, Scripted | Recorded]:
    """Public recordings of hands among them, where MMT_RECORDINGS or ../shared/recordings is a folder."""
    files = sorted((public_recordings() / "panda_comanipulation").glob("*.npz"))
    hands = {f"hand_{file.stem}": Recorded(str(file)) for file in files}
    return {"strokes": Scripted(), "chirp": Scripted("chirp"), "hand_reaching": Recorded(), **hands}


def cases(asked: Asked) -> Mapping[str, Scenario]:
    """Each motion with each estimator, one's own among them, and with the scenario that has all that is better.

    Raises:
        BadInput: one's own has the name of another.
    """
    base = noisy("setup1", seed=asked.seed, clouds="none")
    systems = {name: replace(base, estimator=estimator) for name, estimator in ESTIMATOR_OPTIONS.items()}
    if asked.with_ is not None:
        own = OwnEstimator.of(asked.with_)
        own.made(base.step)  # or refused, before the first run
        if own.called in (*systems, _SYSTEM):
            raise BadInput("--with", found=own.called, expected=f"another name than {', '.join((*systems, _SYSTEM))}")
        systems[own.called] = replace(base, estimator=own)
    systems[_SYSTEM] = replace(load_scenario("setup1-free-running"), seed=asked.seed, clouds="none")
    return {
        f"{motion}_{name}": replace(
            system, operator=operator, duration=asked.seconds if asked.seconds or motion[:4] == "hand" else 60.0
        )
        for motion, operator in _motions().items()
        for name, system in systems.items()
    }


def judge(found: Cases) -> Findings:
    """Errors by band against the force without noise, and when parameters were found, beside what the noise allows."""
    # Estimators differ, motions do not; and the other way round.
    of_motion = {str(case.scenario.operator): case for case in reversed([*found.values()])}
    bounds = {motion: _bound(case) for motion, case in of_motion.items()}
    of_estimator = {case.scenario.estimator: case for case in reversed([*found.values()])}
    costs = {options: cost_us(options, case.samples) for options, case in of_estimator.items()}
    each = {
        name: _judged(case, bounds[str(case.scenario.operator)], costs[case.scenario.estimator])
        for name, case in found.items()
    }
    sentences, pictures = [], []
    for motion, operator in _motions().items():
        of_this = [name for name, case in found.items() if case.scenario.operator == operator]
        here = {name.removeprefix(f"{motion}_"): name for name in of_this}
        worst_of = {way: each[name].figures["worst_band"] for way, name in here.items() if way != _SYSTEM}
        if len(worst_of) > 1:
            nearest = sorted(worst_of, key=lambda way: worst_of[way])
            in_turn = ", ".join(f"{way} ({percent(worst_of[way])})" for way in nearest)
            sentences.append(f"{motion}, the nearest first: {in_turn}.")
        if here:
            errors = {way: found[name].true_error for way, name in here.items()}
            drawn = charts.error_bars(errors, title=f"Error of the rendered force: {motion}")
            pictures.append(Picture(drawn, motion, name=motion))
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values()), "z [%]", "k1 at the end [N/m]", "us a tick"]
    caption = (
        "Error of the rendered force against the plant's without noise, in contact, from 5 s of contact on; what is to "
        f"be reached is asked of the bands that hold {percent(TELLING)} of the force. k1 is truly 0. Us a tick: "
        f"processor time of the estimator alone, over the first {COST_S:g} s of the motion."
    )
    return findings_of(each, headers, caption, sentences, pictures)


def _judged(case: MeasuredRun, bound: NoiseBound, cost: float) -> CaseFindings:
    name, error, hand = case.name, case.true_error, case.name.startswith("hand")
    ours = isinstance(case.scenario.estimator, OutputErrorOptions)
    off = bands(name, error, RENDERED_HAND if hand else RENDERED, bound.leaves)
    over = OVER_NOISE if hand else replace(OVER_NOISE, to_reach=None)
    times = times_found(case.samples, case.truth)
    parameters = parameters_found(name, times, bound.allows_s)
    noise = Reached(name, over, over_noise(case))
    figures = {
        "bands_that_matter": [band for band in error.telling if band != "all"],
        "worst_band": max((figure.value or 0.0 for figure in off), default=0.0),
        "over_noise": noise.value,
        "us_per_tick": cost,
        "noise_leaves": dict(bound.leaves),
        "found_s": times,
        "noise_allows_s": dict(bound.allows_s),
        "found": {each: figure.verdict for each, figure in parameters.items()},
    }
    row: list[Cell] = [name, *(in_percent(error.tangential[band]) for band in BAND_NAMES)]
    return CaseFindings(
        [*row, in_percent(error.normal["all"]), case.metrics.parameters.get("k1"), cost],
        figures,
        [*off, noise, stable(name, case.metrics, by_prior=ours), *parameters.values()],
    )


def over_noise(case: MeasuredRun) -> float | None:
    """Error of the rendered against the measured force over that of the plant's force: 1 is as good as can be."""
    recording, chosen = case.samples, counted(case.samples)
    noise = (vector(recording, "true_force") - vector(recording, "force"))[chosen, :2]
    least = float(np.sqrt(np.mean(np.sum(noise**2, axis=1))))
    error = case.metrics.rendered_error
    ratio = error.tangential["all"]
    return None if ratio is None or least == 0.0 else ratio * error.reference_rms["all"] / least


def _bound(case: MeasuredRun) -> NoiseBound:
    """What the noise of the force would allow the free-running fit."""
    environment, step = case.scenario.environment, case.scenario.step
    return noise_bound(environment.object, case.samples, environment.noise.force, OutputErrorOptions(step=step).ticks)


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
    takes=("seconds", "seed", "estimator", "with_"),  # the cases differ in their motion
)
