"""Experiment 2: the arm's force is cleared of its probe, and the object that it slides is found."""

import json
from dataclasses import replace
from importlib import metadata

import numpy as np
import pytest

import mmt_drake.diagrams.proof.experiments.second as second
from mmt_drake.analysis.signals import mean_step
from mmt_drake.cli.main import main
from mmt_drake.diagrams.proof.experiments.second import (
    ESTIMATORS,
    Contact,
    findings,
    known_contacts,
    report_of,
    run_second,
    second_table,
)
from mmt_drake.diagrams.proof.experiments.second_contacts import OBJECT, slide
from mmt_drake.diagrams.proof.experiments.tick_by_tick import by_axis, follow
from mmt_drake.diagrams.proof.studies import Asked
from mmt_drake.diagrams.stations import arm
from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed

SECONDS = 9.0
TRUTH = {name: OBJECT.parameter(name) for name in ("m", "k1", "k2", "b1", "b2", "Fc")}


def stroked(seconds: float | None, seed: int) -> Recording:
    """Strokes over the object without an arm, with the noise of set-up 1."""
    t = np.arange(round((seconds or SECONDS) / 1e-3)) * 1e-3
    position, velocity = scripted_motion("strokes", duration=max(t[-1], 8.0), lifts=0).sample(t)
    force, body = np.empty((len(t), 3)), np.empty((len(t), 4))
    box.replay(t, position, velocity, np.full(len(t), box.CONTACT_BY_GEOMETRY), OBJECT.kernel_vector(), force, body)
    noise = np.random.default_rng(seed).normal(0.0, np.repeat([1e-5, 5e-4, 0.02], 3), (len(t), 9))
    measured = np.hsplit(np.hstack([position, velocity, force]) + noise, 3)
    vectors = dict(zip(("position", "velocity", "force"), measured, strict=True)) | {"true_force": force}
    return completed(t, {"in_contact": (position[:, 2] < 0.0).astype(float), **by_axis(vectors)}, "strokes")


HERE = Contact("here", "strokes over the object", TRUTH, stroked)
AWAY = Contact("away", "nothing", {}, None, "it is away")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run_second([HERE, AWAY], Asked(tmp_path_factory.mktemp("second"), seconds=SECONDS))


def test_every_estimator_runs_over_the_same_contact_and_says_how_far_off_it_is(result):
    assert [case.name for case in result.cases] == [f"here_{name}" for name in ESTIMATORS]
    errors = {case.estimator: case.free_running for case in result.cases}
    assert errors["output_error"] < 0.05
    assert errors["thesis_rls"] is None or errors["thesis_rls"] > errors["output_error"]


def test_what_is_stable_by_construction_gets_no_verdict(result):
    assert second_table(result).rows[-1][6 - 1] == "by its prior"
    assert [case.stable_by_prior for case in result.cases] == [False, False, True]
    assert report_of(result, 0).document["scenario"] is None  # none that is shipped was run


def test_what_is_not_there_is_left_out_and_told(result):
    assert result.left_out == {"away": "it is away"}
    assert findings(result)[-1] == "away was left out: it is away."


def test_the_document_is_plain_and_holds_the_thesis_s_own_figures(result):
    document = json.loads(json.dumps(report_of(result, 0).document))
    told = {(each["case"], each["figure"]): each for each in document["figures_to_reach"]}
    assert document["experiment"] == 2
    stable = told["here_thesis_rls", "stable after"]
    assert (stable["thesis"], stable["to_reach"]) == (16.1, 0.5)
    assert told["here_output_error", "stable after"]["verdict"] == "by its prior"
    assert told["here_output_error", "estimated force"]["thesis"] == 0.05
    m = told["here_output_error", "m within 5 % after"]
    assert m["to_reach"] == 3.0 and m["value"] == document["cases"][-1]["found_s"]["m"]
    assert document["cases"][-1]["truth"] == TRUTH
    assert {"rendered_error", "free_running_error", "time_to_stable_s"} <= set(document["cases"][0])


def test_the_page_shows_every_contact(result, tmp_path):
    page = report_of(result, 0).write(tmp_path).read_text()
    assert all(case.name in page for case in result.cases)
    assert (tmp_path / "forces_here.png").is_file()
    assert len(second_table(result).rows) == len(result.cases) + 3


def test_the_command_tells_what_it_ran(result, monkeypatch, tmp_path, capsys):
    asked = []
    monkeypatch.setattr(second, "known_contacts", lambda: [HERE, AWAY])
    monkeypatch.setattr(second, "run_second", lambda _, given, progress: asked.append(given) or result)
    assert main(["experiment", "2", "--seconds", "7", "--out", str(tmp_path)]) == 0
    assert [(given.seconds, given.seed) for given in asked] == [(7.0, 0)]
    told = capsys.readouterr().out
    assert "here_output_error" in told and "it is away" in told


def test_without_anything_to_estimate_from_there_is_no_experiment(tmp_path):
    with pytest.raises(BadInput, match="it is away"):
        run_second([AWAY], Asked(tmp_path / "none"))
    assert not (tmp_path / "none").exists()


def test_without_the_arm_s_model_the_extra_is_named(monkeypatch):
    def nothing(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    arm.robot_file.cache_clear()
    monkeypatch.setattr(arm.metadata, "files", nothing)
    try:
        assert "pip install -e '.[arm]'" in str(arm.missing_arm())
        assert all(contact.take is None for contact in known_contacts() if contact.name.startswith("arm"))
    finally:
        arm.robot_file.cache_clear()


@pytest.fixture(scope="module")
def slid() -> Recording:
    if reason := arm.missing_arm():
        pytest.skip(reason)
    return slide(OBJECT, SECONDS, seed=1)


def test_the_wrist_s_force_is_cleared_of_weight_inertia_and_offset(slid):
    touching = slid["in_contact"] > 0.5
    error = (slid.vector("force") - slid.vector("true_force"))[touching]
    assert (np.abs(error.mean(axis=0)) < 0.02).all()
    assert (error.std(axis=0) < 0.06).all()  # noise of 0.02 N, and a probe that tilts
    assert np.sqrt((slid.vector("true_force")[touching] ** 2).mean()) > 1.0


def test_two_slides_are_the_same_to_the_bit(slid):
    again = slide(OBJECT, 1.5, seed=1)
    assert len(again) > 1400 and all(
        (slid[name][: len(again)] == values).all() for name, values in again.columns.items()
    )


def test_the_object_under_the_arm_is_found(slid, tmp_path, monkeypatch):
    contact = Contact("arm", "arm", TRUTH, lambda seconds, seed: slid)
    monkeypatch.setattr(second, "ESTIMATORS", {"output_error": ESTIMATORS["output_error"]})
    found = run_second([contact], Asked(tmp_path)).cases[-1]
    for name, value in TRUTH.items():
        assert found.metrics.parameters[name] == pytest.approx(value, rel=0.06, abs=2.0 if name == "k1" else 0.0)
    assert found.free_running < 0.06


def test_recorded_palpation_can_be_estimated_from(recordings):
    palpation = [contact for contact in known_contacts() if contact.name.startswith("palpation")]
    assert len(palpation) == 4
    short = palpation[0].take(20.0, 0)
    assert short.time[-1] - short.time[0] == pytest.approx(20.0, abs=0.1)
    measurement = np.hstack([short.vector(part) for part in ("position", "velocity", "force")])
    options = replace(ESTIMATORS["output_error"], step=mean_step(short))
    assert np.isfinite(follow(short.time, measurement, short["in_contact"], options).theta).all()
