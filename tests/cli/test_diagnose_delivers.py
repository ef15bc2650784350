"""`diagnose` with its whole library: what it names, and that what it delivers keeps its promise."""

import json
from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program


def heldout_error(recording: Path, simulation: Path, fit: dict) -> float:
    """The contract's figure from the two files alone."""
    measured, simulated = (np.genfromtxt(file, delimiter=",", names=True) for file in (recording, simulation))
    time = measured["time"]
    np.testing.assert_array_equal(simulated["time"], time)
    counts = np.any([(start <= time) & (time <= end) for start, end in fit["heldout_s"]], axis=0)
    counts &= measured["in_contact"] > 0.0
    assert fit["axes"] and 0.1 < counts.mean() < 0.5
    true, said = (np.concatenate([t[f"force_{axis}"][counts] for axis in fit["axes"]]) for t in (measured, simulated))
    return float(np.sqrt(np.mean((true - said) ** 2)) / np.std(true))


def test_what_is_missing_is_named_and_the_delivered_model_keeps_its_promise(folder: Path, program: Program):
    out = folder / "out"
    told = program("diagnose", folder / "contact.csv", "--model", folder / "model.yaml", "--out", out)
    assert told.status == 0, told.err
    document = json.loads((out / "diagnosis.json").read_text())
    assert document["verdict"] == "missing_physics"
    assert [effect["name"] for effect in document["effects"]] == ["coulomb_friction"]
    assert "Coulomb friction" in told.out
    assert 'class="plot"' in (out / "report.html").read_text() and list(out.glob("forces_*.svg"))
    assert "coulomb_friction" in (out / "augmented_model.yaml").read_text()
    model, target = out / "augmented_model.yaml", out / "simulated.csv"
    again = program("simulate", "--model", model, "--operator", folder / "contact.csv", "--out", target)
    assert again.status == 0, again.err
    errors = document["fit"]["heldout_nrmse"]
    assert heldout_error(folder / "contact.csv", target, document["fit"]) == pytest.approx(
        errors["augmented"], rel=1e-3
    )
    assert errors["augmented"] < 1.3 * document["fit"]["noise_floor"] < errors["refit"]
