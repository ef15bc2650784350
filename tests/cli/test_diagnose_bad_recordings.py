"""Recordings that cannot say anything, and models that do not belong to them: the reason, and never a name."""

import json
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_samples import Program
from table_samples import csv_text
from trial_samples import BOX_MODEL, CARRIAGE_MODEL, SPRING_MODEL, carriage, changed, cut, recorded, spring, times

from mmt_drake.recording import Recording, save

Made = Callable[[], Recording]
TRUE_SPRING = SPRING_MODEL.replace("450", "500").replace("22", "20")


def clipped() -> Recording:
    """The tangential force cut off at a part of its deviation."""
    clean = recorded()
    limit = 0.25 * float(np.std(clean["force_y"][clean["in_contact"] > 0.0]))
    return changed(clean, force_y=np.clip(clean["force_y"], -limit, limit))


def above() -> Recording:
    """All of it 5 cm higher: in the air."""
    clean = recorded()
    return changed(clean, position_z=clean["position_z"] + 0.05, in_contact=np.zeros(len(clean)))


def held() -> Recording:
    """A probe that keeps its first position to the last bit."""
    clean = spring()
    return changed(clean, position=np.full(len(clean), clean["position"][0]), velocity=np.zeros(len(clean)))


# One of each kind of recording, and one that no model is run against; more reasons are tested beside the check.
REFUSED: dict[str, tuple[str, Made, str]] = {
    "a force that is clipped": (BOX_MODEL, clipped, "% of the samples: the sensor, or a limit, clips it"),
    "a probe that touches nothing": (
        BOX_MODEL,
        above,
        "The probe never touches the object: its lowest point is z = 41.2",
    ),
    "a probe held still": (SPRING_MODEL, held, "Nothing moves"),
    "an input that is not connected": (
        CARRIAGE_MODEL,
        lambda: times(0.0, "input")(carriage()),
        "is the input connected?",
    ),
}


def diagnosed(recording: Recording, model: str, folder: Path, program: Program) -> dict[str, Any]:
    """What the command says, and only what it may write."""
    save(recording, folder / "recording.npz")
    (folder / "model.yaml").write_text(model)
    out = folder / "out"
    told = program("diagnose", folder / "recording.npz", "--model", folder / "model.yaml", "--out", out, "--jobs", 1)
    assert (told.status, told.err) == (0, "")
    document = json.loads((out / "diagnosis.json").read_text())
    assert " ".join(told.out.split()).startswith(f"{document['verdict']}: {document['summary']} written: ")
    return document


@pytest.mark.parametrize(("model", "made", "reason"), REFUSED.values(), ids=list(REFUSED))
def test_is_refused_with_the_reason_and_without_a_name(
    model: str, made: Made, reason: str, tmp_path: Path, program: Program
) -> None:
    document = diagnosed(made(), model, tmp_path, program)
    assert document["verdict"] == "insufficient_data"
    assert reason in document["summary"] and "\n" not in document["summary"]
    assert document["effects"] == document["alternatives"] == [] and document["parameters"] == {}
    assert document["model"] is None
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"diagnosis.json", "report.html"} <= written
    assert all(name.startswith("forces_") for name in written - {"diagnosis.json", "report.html"})
    assert reason in unescape((tmp_path / "out" / "report.html").read_text())


@pytest.mark.parametrize(
    ("model", "verdict"), [(BOX_MODEL, "no_mismatch"), (BOX_MODEL.replace("b1: 20.0", "b1: 23.0"), "parameters")]
)
def test_a_second_that_is_missing_is_said_and_taken_for_no_physics(
    model: str, verdict: str, tmp_path: Path, program: Program
) -> None:
    clean = recorded()
    document = diagnosed(cut(clean, (clean.time < 6.0) | (clean.time > 7.0)), model, tmp_path, program)
    assert document["verdict"] == verdict and document["effects"] == []
    gaps = next(finding for finding in document["preflight"] if finding["code"] == "gaps")
    assert "the longest gap from 5.999 to 7.001 s" in gaps["text"]


@pytest.mark.parametrize(("made", "model"), [(recorded, BOX_MODEL), (spring, TRUE_SPRING)])
def test_velocities_that_are_all_zero_are_said_and_taken_for_no_physics(
    made: Made, model: str, tmp_path: Path, program: Program
) -> None:
    document = diagnosed(times(0.0, "velocity")(made()), model, tmp_path, program)
    assert document["verdict"] == "no_mismatch" and document["effects"] == []
    assert document["fit"]["heldout_nrmse"]["nominal"] < 2.0 * document["fit"]["noise_floor"]
    assert document["preflight"][0]["code"] == "foreign_rate"


def twice(recording: Recording, row: int) -> Recording:
    """With one time stamp said again."""
    return changed(recording, time=np.insert(np.delete(recording.time, row), row, recording.time[row - 1]))


@pytest.mark.parametrize(
    ("made", "line"),
    [
        (lambda: twice(recorded(), 700), "recording.csv: row 701, column 'time': found the same"),
        (lambda: times(1e3, "position")(recorded()), "are positions, velocities and times all in m, m/s and s?"),
    ],
    ids=["a time stamp twice", "positions in mm beside velocities in m/s"],
)
def test_is_bad_input_in_one_line_and_nothing_is_written(
    made: Made, line: str, tmp_path: Path, program: Program
) -> None:
    recording, file, spoilt = tmp_path / "recording.csv", tmp_path / "model.yaml", made()
    recording.write_text(csv_text({"time": spoilt.time, **spoilt.columns}))
    file.write_text(BOX_MODEL)
    status, out, err = program("diagnose", recording, "--model", file, "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert err.startswith("mmt-drake: ") and err.count("\n") == 1 and line in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.yaml", "recording.csv"]


def test_of_several_recordings_one_that_says_nothing_is_enough_to_refuse(tmp_path: Path, program: Program) -> None:
    save(spring(), tmp_path / "good.npz")
    save(held(), tmp_path / "still.npz")
    (tmp_path / "model.yaml").write_text(SPRING_MODEL)
    both = (tmp_path / "good.npz", tmp_path / "still.npz")
    told = program("diagnose", *both, "--model", tmp_path / "model.yaml", "--out", tmp_path / "out")
    assert told.status == 0 and told.out.startswith(f"insufficient_data: {both[1]}: Nothing moves")
