"""`diagnose`: files in, the contract's files out; bad input in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli_samples import Program

from diagrams.trial.laws import Concealed
from diagrams.trial.session import ContactSession
from mmt_drake.recording import save

BASE = {"m": 0.5, "k1": 0.0, "k2": 450.0, "b1": 20.0, "b2": 25.0, "Fc": 0.0, "normal_k": 400.0, "normal_b": 8.0}
MODEL = """\
structure: flexible_box
parameters: {m: 0.5, k1: 0.0, k2: 430.0, b1: 21.0, b2: 25.0, Fc: 0.0}
normal: {k: 400.0, b: 8.0}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with concealed Coulomb friction, and the model that knows of none."""
    folder = tmp_path_factory.mktemp("diagnose")
    session = ContactSession(seed=3, noise=0.015, duration=15.0)
    save(session.record(BASE, (Concealed("coulomb_friction", {"Fc": 0.4}),)), folder / "contact.csv")
    (folder / "model.yaml").write_text(MODEL)
    return folder


def test_what_is_missing_is_named_and_the_delivered_model_keeps_its_promise(folder: Path, program: Program):
    out = folder / "out"
    told = program("diagnose", folder / "contact.csv", "--model", folder / "model.yaml", "--out", out)
    assert told.status == 0, told.err
    document = json.loads((out / "diagnosis.json").read_text())
    assert document["verdict"] == "missing_physics"
    assert [effect["name"] for effect in document["effects"]] == ["coulomb_friction"]
    assert "Coulomb friction" in told.out
    assert "<svg" in (out / "report.html").read_text() or "data:image" in (out / "report.html").read_text()
    assert "coulomb_friction" in (out / "augmented_model.yaml").read_text()
    model, target = out / "augmented_model.yaml", out / "simulated.csv"
    again = program("simulate", "--model", model, "--operator", folder / "contact.csv", "--out", target)
    assert again.status == 0, again.err


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("missing.csv", "--model", "model.yaml", "--out", "out2"), "missing.csv"),
        (("contact.csv", "--model", "missing.yaml", "--out", "out2"), "missing.yaml"),
        (("contact.csv", "--model", "tissue.yaml", "--out", "out2"), "structure"),
        (("contact.csv", "--model", "model.yaml", "--out", "contact.csv"), "contact.csv"),
        (("contact.csv", "--model", "model.yaml", "--out", "out2", "--jobs", "0"), "whole number"),
        (("contact.csv", "--model", "model.yaml", "--out", "out2", "--effects", "none.py"), "none.py"),
    ],
)
def test_bad_input_ends_with_one_line(
    arguments: tuple[str, ...], told: str, folder: Path, program: Program, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(folder)
    (folder / "tissue.yaml").write_text("structure: kelvin_voigt\nparameters: {k: 300.0, b: 20.0}\n")
    outcome = program("diagnose", *arguments)
    assert outcome.status == 2
    assert outcome.err.count("\n") == 1 and told in outcome.err
    assert not (folder / "out2").exists()
