"""The ablation: causes do what they say, claims say what the thesis says, and each run is judged by its recording."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.metrics import ForceError, Metrics
from mmt_drake.diagrams.proof.experiments.ablation import run
from mmt_drake.diagrams.proof.experiments.ablation.causes import CAUSES, healthy
from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS, Runs
from mmt_drake.diagrams.proof.experiments.ablation.findings import conclusions
from mmt_drake.diagrams.proof.experiments.ablation.report import ablation
from mmt_drake.diagrams.proof.experiments.ablation.run import RUNS, Verdict
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.recording import Recording

BY_NAME = {cause.name: cause for cause in CAUSES}
FIGURES = {10, 11, 14, *range(24, 32), 35}


def error(low: float, middle: float, high: float, whole: float | None = None) -> ForceError:
    ratios = {"all": high if whole is None else whole, "below_0.3_hz": low, "0.3_to_3_hz": middle, "3_to_10_hz": high}
    return ForceError(ratios, ratios, dict.fromkeys(ratios, 1.0), dict.fromkeys(ratios, 1.0), 1)


def metrics(rendered: ForceError, estimated: float, late_s: float = 0.0) -> Metrics:
    lags = Lags((10.0,), (late_s,))
    flat = error(estimated, estimated, estimated)
    return Metrics(rendered, None, flat, flat, None, rendered, 1.0, lags, lags, {}, 20.0, late_s / 2)


def verdict(name: str, raw: Metrics, filtered: Metrics) -> Verdict:
    """Of a cause all of whose runs are alike, spikes too."""
    against = {"raw": Runs(*[raw] * 3, 0.0, 0.0), "filtered": Runs(*[filtered] * 3, 0.0, 0.0)}
    return Verdict(BY_NAME[name], {}, against)


def test_every_figure_of_the_question_has_a_claim():
    figures = [figure for claim in CLAIMS for figure in claim.figures]
    assert set(figures) == FIGURES and len(figures) == len(FIGURES)


def test_what_the_thesis_says_of_its_figures_fulfils_every_claim():
    running = metrics(error(0.3, 1.0, 1.0), 0.05)
    frozen = metrics(error(0.3, 1.0, 1.0), 0.9)
    delayed = metrics(error(0.5, 0.3, 0.1), 0.05, late_s=0.8)
    assert all(claim.holds(Runs(running, frozen, delayed, 0.4, 0.1)) for claim in CLAIMS)


def test_a_renderer_that_follows_fulfils_none():
    good = metrics(error(0.01, 0.01, 0.01), 0.01)
    assert not any(claim.holds(Runs(good, good, good, 0.0, 0.0)) for claim in CLAIMS)


def test_an_unknown_error_fulfils_none():
    unknown = replace(metrics(error(0.3, 1.0, 1.0), 0.05), between_switches_error=None)
    unknown = replace(unknown, estimated_error=None, estimated_error_raw=None)
    runs = Runs(unknown, unknown, unknown, 0.4, 0.1)
    held = {figure for claim in CLAIMS if claim.holds(runs) for figure in claim.figures}
    assert held == {24, 25, 26, 27, 28}


def test_an_estimate_far_off_the_reference_follows_it_in_no_figure_that_shows_both():
    late = replace(metrics(error(0.3, 1.0, 1.0), 0.05), estimated_error_raw=error(0.9, 0.9, 0.9))
    held = {figure for claim in CLAIMS if claim.holds(Runs(late, late, late, 0.4, 0.1)) for figure in claim.figures}
    assert held == set(range(24, 30))  # 29 shows the force that the estimator sees


def test_conclusions_follow_from_what_each_force_shows():
    good, thesis = metrics(error(0.01, 0.01, 0.01), 0.01), metrics(error(0.3, 1.0, 1.0), 0.05)
    far = replace(thesis, estimated_error=error(0.9, 0.9, 0.9), estimated_error_raw=error(0.9, 0.9, 0.9))
    nothing, lost = "nothing", "velocity of the input lost"
    told = conclusions([verdict(nothing, good, thesis), verdict(lost, far, far)])
    assert told == [
        "If it was the filtered force, none is needed for 10, 24 to 30.",
        "The filtered force, or the raw force and a cause: these runs do not tell which for 24 to 28.",
        "Only against the filtered force does any run here show 10, 29, 30.",
        "Nothing here reproduces 11, 14, 31, 35.",
    ]
    told = conclusions([verdict(nothing, good, good), verdict(lost, thesis, good)])
    assert told == [
        "Only against the raw force does any run here show 10, 24 to 30.",
        "Whichever was measured, a cause is needed for 10, 24 to 30.",
        "Nothing here reproduces 11, 14, 31, 35.",
    ]
    told = conclusions([verdict(nothing, good, good), verdict("slow strokes first", good, thesis)])
    assert (
        told[0] == "If it was the filtered force, no more than another motion of the hand is needed for 10, 24 to 30."
    )
    assert conclusions([verdict(lost, thesis, thesis)]) == []


def test_every_cause_has_a_name_of_its_own_and_changes_the_scenario():
    assert len(BY_NAME) == len(CAUSES)
    base = healthy(15.0)
    made = [cause.change(base) for cause in CAUSES]
    assert [cause.name for cause, scenario in zip(CAUSES, made, strict=True) if scenario == base] == ["nothing"]
    assert all(made.count(scenario) == 1 for scenario in made)
    assert {cause.group for cause in CAUSES} == {"none", "estimator", "plant", "renderer", "hand", "together"}


def test_a_cause_is_run_as_experiment_1_frozen_and_as_experiment_3():
    runs = run.scenarios(BY_NAME["input 20 ms late"], 15.0, seed=3)
    assert tuple(runs) == RUNS
    assert {run: scenario.estimator.freeze_after for run, scenario in runs.items()} == {
        "running": None,
        "frozen": 5.0,
        "delayed": None,
    }
    assert runs["delayed"].to_telerobot.delay == runs["delayed"].to_operator.delay == 0.4
    assert all(scenario.to_renderer.delay == 0.02 and scenario.seed == 3 for scenario in runs.values())


def test_a_replayed_hand_takes_the_place_of_the_causes_that_are_another_motion(tmp_path):
    built = ablation().scenarios(Asked(tmp_path, operator="builtin:hand_reaching"))
    assert not any("slow strokes first" in name for name in built)
    moves_the_hand = [cause for cause in CAUSES if "slow strokes first" in cause.name]
    assert len(built) == len(RUNS) * (len(CAUSES) - len(moves_the_hand)) and len(moves_the_hand) == 3


@pytest.mark.parametrize("late", [0.0, 0.05])
def test_spikes_are_held_against_each_other_by_their_height_whenever_they_are(late):
    time = 1e-3 * np.arange(20_000)
    one = np.ones_like(time)
    columns = {"in_contact": one}
    for name, height, at in (("rendered", 0.7, time - late), ("estimated", 1.0, time)):
        columns |= {f"{name}_force_{axis}": 0.0 * one for axis in "xz"}
        columns[f"{name}_force_y"] = height * np.sin(2.0 * np.pi * 5.0 * at)
    assert run.spikes(Recording(time, columns)) == pytest.approx(0.3, abs=0.01)
