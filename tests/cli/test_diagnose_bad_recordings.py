"""Recordings that cannot say anything, and models that do not belong to them: the reason, and never a name."""

import json
from collections.abc import Callable
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_samples import Program
from diagnose_samples import (
    CARRIAGE_MODEL,
    MODEL,
    SPRING_MODEL,
    carriage,
    changed,
    contact,
    first,
    kept,
    later,
    material,
    scaled,
)
from table_samples import csv_text

from mmt_drake.recording import Recording, save

Made = Callable[[], Recording]
TRUE_SPRING = SPRING_MODEL.replace("450", "500").replace("22", "20")


def pressed(recording: Recording) -> np.ndarray:
    return recording["in_contact"] > 0.0


def still() -> Recording:
    """A hand that presses and does not stroke."""
    clean, rng = contact(), np.random.default_rng(0)
    noise = {"position": 1e-5, "velocity": 5e-4, "force": 0.015}
    names = [f"{quantity}_{axis}" for quantity in noise for axis in "xy"]
    return changed(clean, **{n: noise[n.partition("_")[0]] * rng.standard_normal(len(clean)) for n in names})


def held(recording: Recording, *names: str) -> Recording:
    """Columns that keep their first value to the last bit, and velocities of 0."""
    rates = {name: 0.0 * recording[name] for name in recording.columns if "velocity" in name or "rate" in name}
    return changed(recording, **rates, **{name: np.full(len(recording), recording[name][0]) for name in names})


def dashed(seconds: float) -> Recording:
    """Contacts of so long, four times a second."""
    clean = contact()
    touches = clean.time % 0.25 < seconds
    forces = {f"force_{axis}": touches * clean[f"force_{axis}"] for axis in "xyz"}
    height = np.where(touches, -0.005, 0.005)
    return changed(clean, in_contact=1.0 * touches, position_z=height, velocity_z=0.0 * height, **forces)


def clipped(recording: Recording, part: float) -> Recording:
    """The tangential force cut off at a part of its deviation."""
    limit = part * float(np.std(recording["force_y"][pressed(recording)]))
    return changed(recording, force_y=np.clip(recording["force_y"], -limit, limit))


def above() -> Recording:
    """All of it 5 cm higher: in the air."""
    clean = contact()
    return changed(clean, position_z=clean["position_z"] + 0.05, in_contact=np.zeros(len(clean)))


def touching(seconds: float) -> Recording:
    """A cut of the middle of a press."""
    clean = contact()
    begin = clean.time[np.flatnonzero(pressed(clean))[500]]
    return kept(clean, (clean.time >= begin) & (clean.time < begin + seconds))


def without(recording: Recording, begin: float, end: float) -> Recording:
    return kept(recording, (recording.time < begin) | (recording.time > end))


CONTACTS: dict[str, tuple[Made, str]] = {
    "half a second": (lambda: touching(0.5), "Too short: 0.50 s"),
    "a hand that stays where it is": (still, "Nothing moves: x and y stay within noise while in contact"),
    "a probe held still": (
        lambda: held(contact(), "position_x", "position_y"),
        "Nothing moves: x and y stay within noise while in contact",
    ),
    "contacts of 40 ms": (lambda: dashed(0.04), "contacts are so short"),
    "a hand that only goes one way": (lambda: contact(one_way=True), "y moves toward + alone"),
    "a force that is clipped": (lambda: clipped(contact(), 0.25), "% of the samples: the sensor, or a limit, clips it"),
    "a probe that touches nothing": (above, "The probe never touches the object: its lowest point is z = 41.2"),
    "a force that comes 0.3 s late": (lambda: later(contact(), 0.3, "force"), "The force comes 29"),
    "a force that comes 0.3 s early": (lambda: later(contact(), -0.3, "force"), "before the motion that causes it"),
    "the middle of every second missing": (lambda: kept(contact(), contact().time % 1.0 < 0.3), "No samples for 7."),
    "forces on the object": (lambda: scaled(contact(), -1.0, "force"), "the forces are those on the object"),
    "forces in kN": (lambda: scaled(contact(), 1e-3, "force"), "forces in kN?"),
}
SPRINGS: dict[str, tuple[Made, str]] = {
    "a probe held still": (lambda: held(material(), "position"), "Nothing moves"),
    "a force that comes 0.3 s late": (lambda: later(material(), 0.3, "force"), "The force comes 0.30 s after"),
    "forces on the object": (lambda: scaled(material(), -1.0, "force"), "the forces are those on the object"),
    "forces in mN": (lambda: scaled(material(), 1e3, "force"), "are forces in mN"),
}
CARRIAGES: dict[str, tuple[Made, str]] = {
    "a body held still": (lambda: held(carriage(), "output"), "Nothing moves"),
    "an output that comes 0.3 s late": (lambda: later(carriage(), 0.3, "output"), "The output comes 0.30 s after"),
    "an input with the other sign": (lambda: scaled(carriage(), -1.0, "input"), "one of the two has the other sign"),
    "an input that is not connected": (lambda: scaled(carriage(), 0.0, "input"), "is the input connected?"),
}
REFUSED = [
    pytest.param(model, made, reason, id=f"{kind}: {what}")
    for kind, model, cases in (
        ("contact", MODEL, CONTACTS),
        ("one axis", SPRING_MODEL, SPRINGS),
        ("driven body", CARRIAGE_MODEL, CARRIAGES),
    )
    for what, (made, reason) in cases.items()
]


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


@pytest.mark.parametrize(("model", "made", "reason"), REFUSED)
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
    ("model", "verdict"), [(MODEL, "no_mismatch"), (MODEL.replace("b1: 20.0", "b1: 23.0"), "parameters")]
)
def test_a_second_that_is_missing_is_said_and_taken_for_no_physics(
    model: str, verdict: str, tmp_path: Path, program: Program
) -> None:
    document = diagnosed(without(contact(), 6.0, 7.0), model, tmp_path, program)
    assert document["verdict"] == verdict and document["effects"] == []
    gaps = next(finding for finding in document["preflight"] if finding["code"] == "gaps")
    assert "the longest gap from 5.999 to 7.001 s" in gaps["text"]


@pytest.mark.parametrize(("made", "model"), [(contact, MODEL), (material, TRUE_SPRING)])
def test_velocities_that_are_all_zero_are_said_and_taken_for_no_physics(
    made: Made, model: str, tmp_path: Path, program: Program
) -> None:
    document = diagnosed(scaled(made(), 0.0, "velocity"), model, tmp_path, program)
    assert document["verdict"] == "no_mismatch" and document["effects"] == []
    assert document["fit"]["heldout_nrmse"]["nominal"] < 2.0 * document["fit"]["noise_floor"]
    assert document["preflight"][0]["code"] == "foreign_rate"


@pytest.mark.parametrize("factor", [20.0, 0.05])
def test_a_model_that_is_twenty_times_off_belongs_to_another_object(
    factor: float, tmp_path: Path, program: Program
) -> None:
    values = {"m": 0.5, "k2": 450.0, "b1": 20.0, "b2": 25.0}
    parameters = ", ".join(f"{symbol}: {factor * value:g}" for symbol, value in values.items())
    model = f"structure: flexible_box\nparameters: {{{parameters}}}\nnormal: {{k: 400.0, b: 8.0}}\n"
    document = diagnosed(contact(), model, tmp_path, program)
    assert document["verdict"] == "insufficient_data" and document["effects"] == []
    assert f"is {1.0 / factor:.3g} times what the model answers to this motion" in document["summary"]
    assert "does the model belong to this object" in document["summary"]


def twice(recording: Recording, row: int) -> dict[str, np.ndarray]:
    """The columns with one time stamp said again."""
    time = recording.time.copy()
    time[row] = time[row - 1]
    return {"time": time, **recording.columns}


BAD_INPUT: dict[str, tuple[Callable[[], dict[str, np.ndarray]], str, str]] = {
    "a time stamp twice": (
        lambda: twice(contact(), 700),
        MODEL,
        "recording.csv: row 701, column 'time': found the same",
    ),
    "positions in mm beside velocities in m/s": (
        lambda: columns_of(scaled(contact(), 1e3, "position")),
        MODEL,
        "are positions, velocities and times all in m, m/s and s?",
    ),
    "a contact, and the model of a driven body": (
        lambda: columns_of(first(contact(), 2.0)),
        CARRIAGE_MODEL,
        "expected time, input, output for this structure of model",
    ),
    "a contact, and the model of one axis": (
        lambda: columns_of(first(contact(), 2.0)),
        SPRING_MODEL,
        "expected time, position, force for this structure of model",
    ),
    "a driven body, and the model of a contact": (
        lambda: columns_of(carriage()),
        MODEL,
        "found input, output, expected time, position_x",
    ),
    "half a dozen samples": (
        lambda: columns_of(first(contact(), 0.006)),
        MODEL,
        "found 6 samples, expected at least 8",
    ),
}


def columns_of(recording: Recording) -> dict[str, np.ndarray]:
    return {"time": recording.time, **recording.columns}


@pytest.mark.parametrize(("made", "model", "line"), BAD_INPUT.values(), ids=list(BAD_INPUT))
def test_is_bad_input_in_one_line_and_nothing_is_written(
    made: Callable[[], dict[str, np.ndarray]], model: str, line: str, tmp_path: Path, program: Program
) -> None:
    recording, file = tmp_path / "recording.csv", tmp_path / "model.yaml"
    recording.write_text(csv_text(made()))
    file.write_text(model)
    status, out, err = program("diagnose", recording, "--model", file, "--out", tmp_path / "out")
    assert (status, out) == (2, "")
    assert err.startswith("mmt-drake: ") and err.count("\n") == 1 and line in err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.yaml", "recording.csv"]


def test_of_several_recordings_one_that_says_nothing_is_enough_to_refuse(tmp_path: Path, program: Program) -> None:
    save(contact(), tmp_path / "good.npz")
    save(still(), tmp_path / "still.npz")
    (tmp_path / "model.yaml").write_text(MODEL)
    both = (tmp_path / "good.npz", tmp_path / "still.npz")
    told = program("diagnose", *both, "--model", tmp_path / "model.yaml", "--out", tmp_path / "out")
    assert told.status == 0 and told.out.startswith(f"insufficient_data: {both[1]}: Nothing moves")
