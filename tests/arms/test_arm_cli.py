"""`diagnose` and `simulate` on an arm: what they write, and what they refuse in one line."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import small_arm
import yaml

from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.cli.main import main

Run = Callable[..., SimpleNamespace]


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str]) -> Run:
    """`mmt-drake` with some arguments."""

    def called(*arguments: object) -> SimpleNamespace:
        capfd.readouterr()
        status = main([str(argument) for argument in arguments])
        out, error = capfd.readouterr()
        return SimpleNamespace(status=status, out=out, error=error)

    return called


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An arm with dry friction of 2 N m on one joint, its log, and a model without it."""
    folder = tmp_path_factory.mktemp("arm")
    moves, rigid = small_arm.rigid(1, folder)
    rigid = rigid + np.outer(2.0 * np.sign(moves.v[:, 1]), [0.0, 1.0, 0.0])
    log = small_arm.noisy(moves, rigid, 1)
    np.savez(folder / "log.npz", t_s=log.time, q_rad=log.q, tau_Nm=log.torque)
    (folder / "arm.yaml").write_text("structure: multibody\nrobot: small.urdf\ntorque: {column: tau_Nm}\n")
    return folder


def changed(folder: Path, name: str, part: slice = slice(None), **arrays: np.ndarray) -> Path:
    """The log with other arrays, or a part of it."""
    with np.load(folder / "log.npz") as data:
        every = {key: data[key][part] for key in data.files} | arrays
    np.savez(folder / name, **every)
    return folder / name


def test_a_diagnosis_of_an_arm_is_written_and_its_model_simulates(folder: Path, run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("diagnose", folder / "log.npz", "--model", folder / "arm.yaml", "--out", out)
    assert done.status == 0, done.error
    assert done.out.startswith("missing_physics: ") and "Coulomb friction on lift" in done.out
    written = {path.name for path in out.iterdir()}
    assert written == {"diagnosis.json", "augmented_model.yaml", "report.html"}
    document = json.loads((out / "diagnosis.json").read_text())
    (effect,) = document["effects"]
    assert (document["structure"], document["verdict"]) == ("multibody", "missing_physics")
    assert (effect["name"], effect["joint"], effect["certain"]) == ("coulomb_friction", "lift", "law")
    assert effect["parameters"]["Fc"]["value"] == pytest.approx(2.0, rel=0.01)
    low, high = effect["parameters"]["Fc"]["ci95"]
    assert low < 2.0 < high or abs(effect["parameters"]["Fc"]["value"] - 2.0) < 2.0 * (high - low)
    assert [joint["joint"] for joint in document["joints"]] == list(small_arm.JOINTS)
    assert sum(part["share"] for part in document["budget"]) == pytest.approx(1.0, abs=1e-6)
    page = (out / "report.html").read_text()
    assert "lift" in page and "http://" not in page.replace("http://www.w3.org", "")
    simulated = run(
        "simulate", "--model", out / "augmented_model.yaml", "--operator", folder / "log.npz", "--out", out / "tau.csv"
    )
    assert simulated.status == 0, simulated.error
    assert "nrmse of the torque while it moves: turn 0.00" in simulated.out
    header, *rows = (out / "tau.csv").read_text().splitlines()
    assert header.startswith("time,tau_0,tau_1,tau_2,measured_tau_0,measured_tau_1,measured_tau_2,counted_0,")
    table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    off, moves = table[:, 1:4] - table[:, 4:7], table[:, 7:] == 1.0
    assert off.std(axis=0).max() < 0.05 * table[:, 5].std()
    told = float(re.search(r"lift ([\d.e-]+)", simulated.out)[1])
    own = moves[:, 1]
    assert np.sqrt((off[own, 1] ** 2).mean()) / table[own, 5].std() == pytest.approx(told, rel=1e-3)


def test_a_log_of_joints_without_a_model_is_told_of_arms_in_one_line(folder: Path, run: Run, tmp_path: Path) -> None:
    log = np.load(folder / "log.npz")
    every = {"time": log["t_s"]} | {
        f"{n}_{j}": log[k][:, j] for n, k in (("q", "q_rad"), ("tau", "tau_Nm")) for j in range(3)
    }
    table = np.column_stack(list(every.values()))
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header=",".join(every), comments="")
    done = run("diagnose", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert done.status == 2 and "structure: multibody" in done.error
    assert len(done.error) < 700 and done.error.count("\n") == 1


def test_the_torque_that_is_simulated_is_that_of_the_model(folder: Path, run: Run, tmp_path: Path) -> None:
    done = run(
        "simulate", "--model", folder / "arm.yaml", "--operator", folder / "log.npz", "--out", tmp_path / "a.npz"
    )
    assert done.status == 0, done.error
    moves, rigid = small_arm.rigid(1, folder)
    with np.load(tmp_path / "a.npz") as data:
        inside = slice(20, -20)
        expected = np.stack([np.interp(data["t_s"], moves.time, column) for column in rigid.T], 1)
        np.testing.assert_allclose(data["tau_Nm"][inside], expected[inside], atol=0.02)


def test_a_diagnosis_speaks_json(folder: Path, run: Run, tmp_path: Path) -> None:
    done = run("diagnose", folder / "log.npz", "--model", folder / "arm.yaml", "--out", tmp_path, "--json")
    assert json.loads(done.out)["verdict"] == "missing_physics"


def test_a_motion_that_does_not_tell_says_so(folder: Path, run: Run, tmp_path: Path) -> None:
    """Only the first joint moves: its own inertia shows, what stands along its axis does not."""
    with np.load(folder / "log.npz") as data:
        still = np.where(np.arange(3) == 0, data["q_rad"], 0.2)
    time = np.arange(len(still)) / small_arm.RATE_HZ
    moves = small_arm.sines(3, 1)
    rates = [np.where(np.arange(3) == 0, values, 0.0) for values in (moves.v, moves.a)]
    plant = small_arm.plant_of(small_arm.written(folder))
    plant.Finalize()
    heavier = small_arm.inverse_dynamics(plant, small_arm.Moves(time, still, *rates)) * [1.4, 1.0, 1.0]
    log = changed(folder, "still.npz", q_rad=still, tau_Nm=heavier + 1e-3)
    done = run("diagnose", log, "--model", folder / "arm.yaml", "--out", tmp_path, "--json")
    document = json.loads(done.out)
    assert [joint["moves"] for joint in document["joints"]] == [True, False, False]
    assert any("did not move, and of which nothing is told: lift, bend" in note for note in document["notes"])
    base = document["base_parameters"]
    assert (base["rank"], base["structural_rank"], base["condition_number"]) == (1, 15, None)
    assert len(base["another_motion_tells"]) == 15 and "post.m" in base["never_told"]
    assert {"fore.Ixx", "fore.m"}.isdisjoint(base["unexcited"]) and "upper.mcz" not in base["never_told"]
    (whole,) = base["parameters"]
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, [0.0, 0.2, 0.2])
    mass = plant.CalcMassMatrixViaInverseDynamics(context)
    assert whole["value"] / whole["terms"]["post.Izz"] == pytest.approx(mass[0, 0], rel=1e-3)
    assert whole["relative_deviation"] > 0.0
    assert "mmt-drake excite --model ARM.yaml --log LOG" in (tmp_path / "report.html").read_text()


REFUSED: dict[str, tuple[dict[str, Any], tuple[object, ...], str]] = {
    "too slow a rate": ({"part": slice(None, None, 5)}, (), "found 20 Hz, expected 32 Hz or more for a band of 8 Hz"),
    "too short": ({"part": slice(0, 400)}, (), "found 3.99 s (6 blocks), expected 7 s or more"),
    "nothing moves": ({"q_rad": np.full((3000, 3), 0.3)}, (), "found no joint that moves, expected a way of 0.002"),
    "another station's blocks": ({}, ("--blocks", "setup1"), "--blocks: found a model of an arm"),
    "laws of one's own": ({}, ("--effects", "own.py"), "--effects: found a model of an arm"),
    "a mapping": ({}, ("--map", "time=t:ms"), "--map: found a model of an arm"),
    "one axis of three": ({}, ("--axis", "x"), "--axis: found a model of an arm"),
    "a structure": ({}, ("--structure", "driven_body"), "--structure: found a model of an arm"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_a_diagnosis_refuses_is_told_in_one_line(what: str, folder: Path, run: Run, tmp_path: Path) -> None:
    log, options, told = REFUSED[what]
    path = changed(folder, "refused.npz", **log)
    done = run("diagnose", path, "--model", folder / "arm.yaml", "--out", tmp_path / "out", *options)
    assert done.status == 2 and told in done.error and done.error.count("\n") == 1, done.error
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder_is_refused(folder: Path, run: Run, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("")
    done = run("diagnose", folder / "log.npz", "--model", folder / "arm.yaml", "--out", tmp_path / "out")
    assert done.status == 2 and "found a file, expected a folder" in done.error


@pytest.mark.parametrize(
    ("out", "options", "told"),
    [
        ("out.mcap", ("--operator", "log.npz"), "found the ending '.mcap', expected .npz or .csv"),
        ("out", ("--operator", "log.npz"), "found the ending ''"),
        ("out.csv", ("--windows", "log.npz"), "--windows: found a model of an arm"),
        ("out.csv", ("--operator", "log.npz", "--map", "time=t:ms"), "--map: found a model of an arm"),
    ],
)
def test_what_simulate_refuses_is_told_in_one_line(
    out: str, options: tuple[str, ...], told: str, folder: Path, run: Run, tmp_path: Path
) -> None:
    files = [folder / option if option.endswith(".npz") else option for option in options]
    done = run("simulate", "--model", folder / "arm.yaml", *files, "--out", tmp_path / out)
    assert done.status == 2 and told in done.error and done.error.count("\n") == 1, done.error
    assert not (tmp_path / out).exists()


def test_what_is_written_is_read_again(folder: Path, run: Run, tmp_path: Path) -> None:
    run("diagnose", folder / "log.npz", "--model", folder / "arm.yaml", "--out", tmp_path)
    model = load_arm_model(tmp_path / "augmented_model.yaml")
    assert ArmPlant.of(model).joints == small_arm.JOINTS and model.column == "tau_Nm"
    assert yaml.safe_load((tmp_path / "augmented_model.yaml").read_text())["effects"][0]["joint"] == "lift"
