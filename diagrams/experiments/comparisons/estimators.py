"""The estimators on the same motions: how near the rendered force comes to the plant's, and how soon."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from diagrams.experiments.comparisons.comparison import Cases, Comparison, Judgement, Recordings
from diagrams.experiments.findings import truth
from diagrams.experiments.plans import SETTLE_S
from diagrams.experiments.runs import Case
from diagrams.scenario import Recorded, Scenario, Scripted, load_scenario
from mmt_drake.analysis import charts
from mmt_drake.analysis.metrics import TELLING, counted
from mmt_drake.analysis.signals import BAND_NAMES, contact_time, flag, mean_step, vector
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import percent
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.recording import Recording
from mmt_drake.systems.flexible_box import SensorNoise

_ESTIMATORS: Final[Mapping[str, RlsOptions | OutputErrorOptions]] = {
    "thesis_rls": RlsOptions(),
    "settled_rls": RlsOptions(settle=SETTLE_S),
    "output_error": OutputErrorOptions(),
}
_NOISE: Final = SensorNoise(force=0.02, position=1e-5, velocity=5e-4)
_NEAR: Final = 0.05
"""Parameters count as found once they stay so near to the truth."""
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
    """Each motion with each estimator."""
    base = replace(load_scenario("setup1"), seed=seed, clouds="none")
    base = replace(base, environment=replace(base.environment, noise=_NOISE))
    return {
        f"{motion}_{name}": replace(
            base, operator=operator, estimator=estimator, duration=seconds if seconds or motion[:4] == "hand" else 60.0
        )
        for motion, operator in _motions().items()
        for name, estimator in _ESTIMATORS.items()
    }


def judge(found: Cases, recordings: Recordings) -> Judgement:
    """Errors by band against the force without noise, what the noise leaves, and when the parameters were found."""
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values()), "to reach [%]", "over noise"]
    headers += ["stable [s]", *(f"{name} [s]" for name in _FOUND)]
    rows: list[list[Cell]] = []
    figures: dict[str, dict[str, Any]] = {}
    sentences, pictures = [], {}
    for name, case in found.items():
        error, recording = case.metrics.rendered_error_true, recordings[name]
        if error is None:
            continue
        ratios = {band: error.tangential[band] for band in BAND_NAMES}
        matters = [band for band in error.telling if band != "all"]
        reach = REACH["hand" if name.startswith("hand") else "scripted"]
        worst = max((ratios[band] or 0.0 for band in matters), default=0.0)
        over, times = over_noise(case, recording), times_found(recording, truth(case))
        rows.append(
            [
                name,
                *(None if ratio is None else 100.0 * ratio for ratio in ratios.values()),
                100.0 * reach,
                over,
                case.metrics.time_to_stable_s,
                *(times[symbol] for symbol in _FOUND),
            ]
        )
        figures[name] = {
            "bands_that_matter": matters,
            "worst_band": worst,
            "to_reach": reach,
            "over_noise": over,
            "found_s": times,
        }
        if isinstance(case.scenario.estimator, OutputErrorOptions):
            verdict = "reached" if worst <= reach else "missed"
            sentences.append(
                f"{name}: {percent(worst)} off in the worst band that matters, to reach {percent(reach)}: {verdict}."
            )
    for motion in _motions():
        each_s = {each: found.get(f"{motion}_{each}") for each in _ESTIMATORS}
        errors = {each: case.metrics.rendered_error_true for each, case in each_s.items() if case is not None}
        known = {each: error for each, error in errors.items() if error is not None}
        if known:
            pictures[motion] = (charts.error_bars(known, title=f"Error of the rendered force: {motion}"), motion)
    caption = (
        "Error of the rendered force against the plant's without noise, in contact, from 5 s of contact on; to be "
        f"reached in every band that holds {percent(TELLING)} of the force. Over noise: error against the measured "
        "force over that of the plant's own. Contact time until a parameter stays within "
        f"{percent(_NEAR)} of the truth; – where it never does. Stable: from the prior on, 0."
    )
    return Judgement(Table(headers, rows, caption), sentences, figures, pictures)


_FOUND: Final = ("m", "k2", "b1", "b2")


def over_noise(case: Case, recording: Recording) -> float | None:
    """Error of the rendered against the measured force over that of the plant's force: 1 is as good as can be."""
    chosen = counted(recording)
    noise = (vector(recording, "true_force") - vector(recording, "force"))[chosen, :2]
    least = float(np.sqrt(np.mean(np.sum(noise**2, axis=1))))
    error = case.metrics.rendered_error
    ratio = error.tangential["all"]
    return None if ratio is None or least == 0.0 else ratio * error.reference_rms["all"] / least


def times_found(recording: Recording, true: Mapping[str, float]) -> dict[str, float | None]:
    """Contact time [s] from which on each parameter stays near the truth; None where it does not."""
    touched = contact_time(flag(recording, "in_contact"), mean_step(recording))
    found: dict[str, float | None] = {}
    for name in _FOUND:
        near = np.abs(recording[f"theta_{name}"] - true[name]) <= _NEAR * true[name]
        astray = np.flatnonzero(~near)
        first = 0 if len(astray) == 0 else int(astray[-1]) + 1
        found[name] = float(touched[first]) if first < len(touched) else None
    return found


ESTIMATORS: Final = Comparison(
    name="estimators",
    title="Does the rendered force equal the measured one?",
    lead=(
        "Set-up 1 with sensor noise of 0.02 N, 0.01 mm and 0.5 mm/s: strokes, a chirp to 10 Hz, a modelled hand and, "
        "where they are at hand, recorded ones; with the thesis's estimator, with the same waiting after each touch, "
        "and with the one whose model runs freely."
    ),
    cases=cases,
    judge=judge,
)
