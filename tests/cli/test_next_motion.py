"""What `diagnose` cannot tell, the motion that it prescribes settles: `run` plays it, and what that records decides."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_samples import Program

import mmt_drake.diagnosis.diagnose
from mmt_drake.diagnosis.tell.prescribe import MOTION_FILE
from mmt_drake.effects import LIBRARY
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.recording import Recording, load, save

FRICTION, DEPTH = 0.4, 0.004
PARAMETERS, NORMAL = "m: 0.5, k1: 0.0, k2: 400.0, b1: 18.0, b2: 17.0", "normal: {k: 400.0, b: 8.0}"
TRUTH = (
    f"environment.object={{parameters: {{{PARAMETERS}}}, {NORMAL}, friction: {{Fs: {FRICTION}, Fd: {FRICTION}}}}}",
    "environment.noise={force: 0.015, position: 1.0e-5, velocity: 5.0e-4}",
    "clouds=none",
)
SOME = ("coulomb_friction", "load_dependent_friction")


def pressing_alike(path: Path) -> None:
    """A hand that slides about and presses equally deep throughout: friction of any law of the load is one number."""
    time = np.arange(2.0, 14.0, 1e-3)
    position, velocity = scripted_motion("sines", duration=16.0, depth=DEPTH).sample(time)
    columns = {f"position_{axis}": position[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"velocity_{axis}": velocity[:, i] for i, axis in enumerate("xyz")}
    assert np.ptp(position[:, 2]) == 0.0
    save(Recording(time - time[0], columns), path)


def recorded(program: Program, hand: Path, path: Path) -> Recording:
    """What the station records of the object with Coulomb friction under a hand's motion."""
    changes = [word for change in TRUTH for word in ("--set", change)]
    told = program("run", "setup1", "--operator", hand, *changes, "--record", path)
    assert told.status == 0, told.err
    return load(path)


def diagnosed(program: Program, recording: Path, out: Path) -> dict[str, Any]:
    """What `diagnose` says with a model that knows of no friction."""
    model = out.with_suffix(".yaml")
    model.write_text(f"structure: flexible_box\nparameters: {{{PARAMETERS}}}\n{NORMAL}\n")
    told = program("diagnose", recording, "--model", model, "--out", out)
    assert told.status == 0, told.err
    document: dict[str, Any] = json.loads((out / "diagnosis.json").read_text())
    return document


def test_the_prescribed_motion_is_played_and_settles_what_was_ambiguous(
    tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mmt_drake.diagnosis.diagnose, "LIBRARY", {name: LIBRARY[name] for name in SOME})
    pressing_alike(tmp_path / "hand.npz")
    first = recorded(program, tmp_path / "hand.npz", tmp_path / "first.npz")
    before = diagnosed(program, tmp_path / "first.npz", tmp_path / "before")
    assert before["effects"][0]["certain"] == "family"
    named = {before["effects"][0]["name"]} | {a["name"] for a in before["alternatives"] if a["indistinguishable"]}
    assert named == {"coulomb_friction", "load_dependent_friction"}
    assert MOTION_FILE in before["next_recording"]

    prescribed = tmp_path / "before" / MOTION_FILE
    second = recorded(program, prescribed, tmp_path / "second.npz")
    motion = load(prescribed, forces=False)
    assert second.time[-1] == pytest.approx(motion.time[-1] - motion.time[0])
    for axis in "xyz":
        planned = np.interp(second.time, motion.time - motion.time[0], motion[f"position_{axis}"])
        np.testing.assert_allclose(second[f"master_position_{axis}"], planned, atol=1e-5)
    # Within what the recorded hand did, and half as much again; as deep as a hand presses, never far above.
    assert np.ptp(second["position_y"]) < 1.6 * np.ptp(first["position_y"])
    assert np.abs(second["velocity_y"]).max() < 1.6 * max(np.abs(first["velocity_y"]).max(), 0.1)
    assert -4.0 * DEPTH < second["position_z"].min() < 0.0 < second["position_z"].max() < 0.02

    after = diagnosed(program, tmp_path / "second.npz", tmp_path / "after")
    assert after["verdict"] == "missing_physics"
    (effect,) = after["effects"]
    assert (effect["name"], effect["certain"]) == ("coulomb_friction", "law")
    assert effect["parameters"]["Fc"]["value"] == pytest.approx(FRICTION, rel=0.01)
    assert not any(alternative["indistinguishable"] for alternative in after["alternatives"])
