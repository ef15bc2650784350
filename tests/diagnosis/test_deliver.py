"""The model that is delivered: the file holds all of it, and Drake gives the promised figure again."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from outcome_samples import FRICTION, WRONG, fitted, outcome, rubbing_box

from mmt_drake.cli.main import main
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.tell.outcome import Outcome
from mmt_drake.diagnosis.tell.written import MODEL_FILE, augmented_model, deliver
from mmt_drake.errors import MmtError
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording, load, save


@pytest.fixture(scope="module")
def found() -> Outcome:
    """Of the rubbing box, handed in with a wrong normal axis."""
    return outcome(rubbing_box(), WRONG, {"coulomb_friction": {"Fc": 0.2}})


def by_definition(recording: Recording, simulated: Recording, blocks) -> float:
    """The contract's held-out error, from the columns of two files."""
    t = recording.time
    chosen = np.any([(t >= a) & (t <= b) for a, b in blocks], axis=0) & (recording["in_contact"] == 1.0)
    measured, answered = (np.concatenate([r[f"force_{axis}"][chosen] for axis in "yz"]) for r in (recording, simulated))
    return float(np.sqrt(np.mean((measured - answered) ** 2)) / np.std(measured))


def test_the_file_gives_the_held_out_figure_again_through_the_program(found: Outcome, tmp_path: Path) -> None:
    path = deliver(found, tmp_path)
    assert path == tmp_path / MODEL_FILE
    recording = found.prepared.recordings[0]
    save(recording, tmp_path / "recording.npz")
    arguments = ["--model", path, "--operator", tmp_path / "recording.npz", "--out", tmp_path / "simulated.npz"]
    assert main(["simulate", *map(str, arguments)]) == 0
    fit = found.diagnosis.fit
    again = by_definition(recording, load(tmp_path / "simulated.npz"), fit.heldout_s)
    assert again == pytest.approx(fit.heldout_nrmse.augmented, rel=1e-6)
    assert again < 1.1 * fit.noise_floor < fit.heldout_nrmse.refit


def test_what_was_left_out_stays_zero_and_is_listed_as_an_effect(found: Outcome, tmp_path: Path) -> None:
    data = yaml.safe_load(deliver(found, tmp_path).read_text())
    assert data["parameters"]["Fc"] == 0.0
    assert data["parameters"]["k1"] == 0.0
    (effect,) = data["effects"]
    assert effect["name"] == "coulomb_friction"
    assert effect["parameters"]["Fc"] == pytest.approx(FRICTION, rel=0.02)
    assert data["parameters"]["k2"] == pytest.approx(400.0, rel=0.02)
    assert data["normal"]["k"] == pytest.approx(400.0, rel=0.01)  # handed in as 370


def test_parameters_with_a_default_are_written_out(found: Outcome) -> None:
    both = {"coulomb_friction": {"Fc": FRICTION}, "presliding_friction": {"sigma0": 2e4}}
    fit = fitted(found.prepared, WRONG, both)
    listed = {entry["name"]: entry["parameters"] for entry in augmented_model(fit)["effects"]}
    level = listed["coulomb_friction"]["Fc"]
    assert listed["presliding_friction"] == {
        "sigma0": fit.hypothesis.effect_values(fit.x)["presliding_friction"]["sigma0"],
        "sigma1": 0.0,
        "Fs": level,
        "v_s": 1e-3,
    }
    assert parse_model(augmented_model(fit)) == fit.model


def test_a_promise_that_the_file_does_not_keep_is_an_error_and_leaves_nothing(found: Outcome, tmp_path: Path) -> None:
    fit = found.diagnosis.fit
    errors = replace(fit.heldout_nrmse, augmented=fit.heldout_nrmse.augmented * (1.0 + 1e-6))
    promising = replace(found, diagnosis=replace(found.diagnosis, fit=replace(fit, heldout_nrmse=errors)))
    with pytest.raises(MmtError, match="held-out error"):
        deliver(promising, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_delivered_where_nothing_was_fitted(found: Outcome, tmp_path: Path) -> None:
    assert deliver(replace(found, best=None), tmp_path) is None
    assert list(tmp_path.iterdir()) == []


def test_the_model_of_a_driven_body_has_the_numbers_of_its_fit() -> None:
    t = np.arange(4000) / 400.0
    x = 0.1 * (t - np.sin(t))
    recording = Recording(
        t, {"input": 0.2 * np.sin(t), "output": x + 1e-5 * np.random.default_rng(0).normal(size=4000)}
    )
    fit = fitted(prepare([recording], DrivenBodyModel(m=2.0)), DrivenBodyModel(m=2.0))
    assert augmented_model(fit)["parameters"]["m"] == pytest.approx(2.0, rel=0.01)
