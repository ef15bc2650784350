"""The ablation: causes do what they say, claims say what the thesis says, and each run is judged by its recording."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.metrics import ForceError, Metrics, measure
from mmt_drake.diagrams.experiments.ablation import (
    CAUSES,
    CLAIMS,
    RUNS,
    findings,
    report_of,
    run,
    run_ablation,
    short_table,
)
from mmt_drake.diagrams.experiments.ablation.causes import healthy
from mmt_drake.diagrams.experiments.ablation.claims import Runs
from mmt_drake.recording import Recording, load

BY_NAME = {cause.name: cause for cause in CAUSES}
FIGURES = {10, 11, 14, *range(24, 32), 35}
TOLD = ("nothing", "velocity of the input lost")


def error(low: float, middle: float, high: float, whole: float | None = None) -> ForceError:
    ratios = {"all": high if whole is None else whole, "below_0.3_hz": low, "0.3_to_3_hz": middle, "3_to_10_hz": high}
    return ForceError(ratios, ratios, dict.fromkeys(ratios, 1.0), dict.fromkeys(ratios, 1.0), 1)


def metrics(rendered: ForceError, estimated: float, late_s: float = 0.0) -> Metrics:
    lags = Lags((10.0,), (late_s,))
    flat = error(estimated, estimated, estimated)
    return Metrics(rendered, None, flat, None, None, rendered, 1.0, lags, lags, {}, 20.0, late_s / 2)


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
    unknown = replace(metrics(error(0.3, 1.0, 1.0), 0.05), estimated_error=None, between_switches_error=None)
    runs = Runs(unknown, unknown, unknown, 0.4, 0.1)
    held = {figure for claim in CLAIMS if claim.holds(runs) for figure in claim.figures}
    assert held == {24, 25, 26, 27, 28}


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


def test_a_replayed_hand_takes_the_place_of_the_causes_that_are_another_motion(monkeypatch, tmp_path):
    built = {}
    monkeypatch.setattr(run, "run_cases", lambda scenarios, files, **_: built.update(scenarios) or ())
    with pytest.raises(KeyError):  # nothing was run, so there is nothing to judge
        run_ablation(out=tmp_path, operator="builtin:hand_reaching")
    assert not any("slow strokes first" in name for name in built)
    moves_the_hand = [cause for cause in CAUSES if "slow strokes first" in cause.name]
    assert len(built) == len(RUNS) * (len(CAUSES) - len(moves_the_hand)) and len(moves_the_hand) == 3


@pytest.fixture(scope="module")
def ablation(tmp_path_factory):
    out = tmp_path_factory.mktemp("ablation")
    return run_ablation([BY_NAME[name] for name in TOLD], out=out, seconds=24.0), out


def test_an_input_without_velocity_reproduces_the_figures_of_experiment_1_and_nothing_does_not(ablation):
    result, _ = ablation
    figures = dict(zip(TOLD, (verdict.figures for verdict in result.verdicts), strict=True))
    assert {10, 24, 26, 27, 28, 29, 30} <= set(figures["velocity of the input lost"])
    assert not {10, 24, 25, 26, 27, 28, 30} & set(figures["nothing"])


def test_the_delayed_run_is_800_ms_late_whatever_is_put_in(ablation):
    result, _ = ablation
    assert all(35 in verdict.figures for verdict in result.verdicts)


def test_every_case_can_be_computed_again_from_its_recording(ablation):
    result, _ = ablation
    for case in json.loads(json.dumps(result.to_json(), allow_nan=False))["cases"]:
        again = measure(load(case["recording"]), delay_s=case["delay_s"])
        assert again.rendered_error.tangential["all"] == case["rendered_error"]["all"]
        assert case["run"] in RUNS and case["cause"] in TOLD


def test_every_cause_stands_beside_the_thesis_and_what_is_to_reach(ablation):
    result, _ = ablation
    told = {(each["case"], each["figure"]): each for each in result.to_json()["figures_to_reach"]}
    for name, verdict in zip(TOLD, result.verdicts, strict=True):
        high = told[name, "rendered force, 3 to 10 Hz"]
        assert (high["thesis"], high["to_reach"]) == (1.0, 0.005)
        assert high["value"] == verdict.cases["running"].metrics.rendered_error_true.tangential["3_to_10_hz"]
        assert told[name, "longest lag of a release"]["verdict"] == "missed"  # 800 ms, as in the thesis
    assert told[TOLD[1], "rendered force, 3 to 10 Hz"]["verdict"] == "missed"


def test_a_rendered_force_without_velocity_has_other_spikes_than_the_estimated_one(ablation):
    result, _ = ablation
    nothing, lost = (verdict.spikes for verdict in result.verdicts)
    assert nothing["running"] < 0.1
    assert lost["running"] > 0.4


@pytest.mark.parametrize("late", [0.0, 0.05])
def test_spikes_are_held_against_each_other_by_their_height_whenever_they_are(late):
    time = 1e-3 * np.arange(20_000)
    one = np.ones_like(time)
    columns = {"in_contact": one}
    for name, height, at in (("rendered", 0.7, time - late), ("estimated", 1.0, time)):
        columns |= {f"{name}_force_{axis}": 0.0 * one for axis in "xz"}
        columns[f"{name}_force_y"] = height * np.sin(2.0 * np.pi * 5.0 * at)
    assert run.spikes(Recording(time, columns)) == pytest.approx(0.3, abs=0.01)


def test_the_page_shows_every_cause_every_figure_and_what_counts(ablation, tmp_path):
    result, _ = ablation
    page = report_of(result).write(tmp_path).read_text()
    assert (tmp_path / "ablation.png").is_file()
    assert all(name in page for name in TOLD)
    assert all(claim.needs in page for claim in CLAIMS)
    thesis, most, *rows = short_table(result).rows
    assert [row[0] for row in rows] == list(TOLD)
    assert thesis[2:6] == pytest.approx([30.0, 100.0, 100.0, 5.0]) and most[2:5] == pytest.approx([0.5] * 3)
    assert rows[1][-2] == "missed in 3 bands"
    told = findings(result)
    assert len(told) == len(CLAIMS) + 1 and told[-1].endswith(f"{TOLD[1]}.")
