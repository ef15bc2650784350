"""Model files and logs of arms: what is read is what was written, and what is wrong is told in one line."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import small_arm
import yaml

from mmt_drake.arms.arm_file import ArmModel, Held, JointEffect, load_arm_model, save_arm_model
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import load_joint_log
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.structure import is_arm_file
from mmt_drake.cli.main import main
from mmt_drake.errors import BadInput

JOINTS = small_arm.JOINTS


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "small.urdf").write_text(small_arm.URDF)
    return tmp_path / "small.urdf"


def written(folder: Path, **keys: object) -> Path:
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump({"structure": "multibody", "robot": "small.urdf", **keys}))
    return path


def test_a_model_that_is_saved_is_read_back_as_it_was(robot: Path) -> None:
    model = ArmModel(
        robot=robot,
        joints=JOINTS,
        gravity=(0.0, 1.0, -9.0),
        column="i_A",
        factor=(1.0, 2.0, -3.0),
        held=(Held("fore", 0.3, (0.0, 0.1, 0.2)),),
        band_hz=6.0,
        links={"fore": (1.0, 0.1, 0.0, 0.0, 0.2, 0.3, 0.3, 0.0, 0.0, 0.0)},
        effects=(
            JointEffect("stribeck_friction", "lift", {"Fc": 1.0, "Fs": 2.0, "v_s": 0.1}),
            JointEffect("joint_coupling", "bend", {"joint": "lift", "gain": 0.1}),
            JointEffect("gravity_offset", "", {"rx": 0.01, "ry": 0.0}),
        ),
    )
    path = save_arm_model(model, robot.parent / "saved.yaml")
    read = load_arm_model(path)
    assert is_arm_file(path)
    assert {**vars(read), "source": "model", "robot": read.robot.resolve()} == {**vars(model), "robot": robot.resolve()}


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"colour": "red"}, "colour"),
        ({"robot": "none.urdf"}, "no file"),
        ({"plant": "a.py:b"}, "robot and plant"),
        ({"torque": {"factor": [0.0, 1.0, 1.0]}}, "torque.factor"),
        ({"gravity": [0.0, 1.0]}, "2 numbers"),
        ({"effects": [{"name": "glue", "joint": "lift", "parameters": {}}]}, "glue"),
        ({"effects": [{"name": "coulomb_friction", "parameters": {"Fc": 1.0}}]}, "effects[0].joint"),
        ({"effects": [{"name": "coulomb_friction", "joint": "lift", "parameters": {"Fc": "much"}}]}, "much"),
        ({"effects": [{"name": "coulomb_friction", "joint": "lift", "parameters": {}}]}, "parameters"),
        ({"held": [{"link": "fore", "m": -1.0}]}, "held[0].m"),
        ({"links": {"fore": {"m": 1.0}}}, "links.fore"),
        ({"band_hz": 0.0}, "band_hz"),
    ],
)
def test_a_model_file_that_is_wrong_is_refused_in_one_line(robot: Path, keys: dict[str, object], said: str) -> None:
    with pytest.raises(BadInput) as refused:
        load_arm_model(written(robot.parent, **keys))
    assert said in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"joints": ["lift", "knee"]}, "knee"),
        ({"joints": ["lift", "lift"]}, "one twice"),
        ({"held": [{"link": "tail", "m": 1.0}]}, "tail"),
    ],
)
def test_a_joint_or_a_link_that_is_not_there_is_told(robot: Path, keys: dict[str, object], said: str) -> None:
    with pytest.raises(BadInput, match=said):
        ArmPlant.of(load_arm_model(written(robot.parent, **keys)))


def log(folder: Path, change: Callable[[dict[str, np.ndarray]], None] = lambda d: None, n: int = 1000) -> Path:
    rng = np.random.default_rng(0)
    time = np.arange(n) * 0.01
    data = {"t_s": time, "q_rad": np.sin(np.outer(time, (1.0, 1.3, 0.7))), "tau_Nm": rng.normal(size=(n, 3))}
    change(data)
    np.savez(folder / "log.npz", **data)
    return folder / "log.npz"


def set_nan(data: dict[str, np.ndarray]) -> None:
    data["tau_Nm"][7, 1] = np.nan


def turn_back(data: dict[str, np.ndarray]) -> None:
    data["t_s"][50] = data["t_s"][49]


def two_joints(data: dict[str, np.ndarray]) -> None:
    data["q_rad"] = data["q_rad"][:, :2]


def no_torque(data: dict[str, np.ndarray]) -> None:
    del data["tau_Nm"]


@pytest.mark.parametrize(
    ("change", "said"),
    [(set_nan, "torque, row 7"), (turn_back, "time, row 50"), (two_joints, "2 columns"), (no_torque, "torque")],
)
def test_a_log_that_is_wrong_is_refused_in_one_line(
    robot: Path, change: Callable[[dict[str, np.ndarray]], None], said: str
) -> None:
    model = load_arm_model(written(robot.parent))
    with pytest.raises(BadInput) as refused:
        load_joint_log(log(robot.parent, change), model, JOINTS)
    assert said in str(refused.value) and "\n" not in str(refused.value)


def test_too_few_samples_a_slow_clock_and_a_wrong_count_of_factors_are_told(robot: Path) -> None:
    model = load_arm_model(written(robot.parent))
    with pytest.raises(BadInput, match="100 samples"):
        load_joint_log(log(robot.parent, n=100), model, JOINTS)
    slow = load_joint_log(log(robot.parent, lambda d: d.update(t_s=d["t_s"] * 10.0)), model, JOINTS)
    with pytest.raises(BadInput, match="10 Hz"):
        ArmMotion.of(slow, 8.0)
    two = load_arm_model(written(robot.parent, torque={"factor": [1.0, 2.0]}))
    with pytest.raises(BadInput, match="2 numbers"):
        load_joint_log(log(robot.parent), two, JOINTS)


def test_an_arm_that_does_not_move_is_told(robot: Path) -> None:
    model = load_arm_model(written(robot.parent))
    still = load_joint_log(log(robot.parent, lambda d: d.update(q_rad=d["q_rad"] * 1e-6)), model, JOINTS)
    with pytest.raises(BadInput, match="no joint that moves"):
        diagnose_arm([still], model)


@pytest.mark.parametrize("name", ["q_{}", "q[{}]", "actual_q_{}", "q.{}"])
@pytest.mark.parametrize("separator", [",", ";"])
def test_columns_of_a_csv_are_joined_by_the_number_at_their_end(robot: Path, name: str, separator: str) -> None:
    model = load_arm_model(written(robot.parent))
    expected = load_joint_log(log(robot.parent), model, JOINTS)
    header = ["timestamp", *(name.format(j) for j in range(3)), *(f"tau_{j}" for j in range(3))]
    path = robot.parent / "log.csv"
    table = np.column_stack([expected.time, expected.q, expected.torque])
    np.savetxt(path, table, delimiter=separator, header=separator.join(header), comments="", fmt="%.12g")
    read = load_joint_log(path, model, JOINTS)
    assert read.q == pytest.approx(expected.q, abs=1e-11)
    assert read.torque == pytest.approx(expected.torque, abs=1e-11)


def test_a_torque_is_its_column_times_its_factor(robot: Path) -> None:
    model = load_arm_model(written(robot.parent, torque={"column": "tau_Nm", "factor": [2.0, -1.0, 0.5]}))
    read = load_joint_log(log(robot.parent), model, JOINTS)
    plain = load_joint_log(log(robot.parent), load_arm_model(written(robot.parent)), JOINTS)
    assert read.torque == pytest.approx(plain.torque * [2.0, -1.0, 0.5])


def test_options_that_say_nothing_of_an_arm_are_refused(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model, own = str(written(robot.parent)), str(log(robot.parent))
    assert main(["diagnose", own, "--model", model, "--out", str(robot.parent / "o"), "--blocks", "setup1"]) == 2
    assert "--blocks" in capsys.readouterr().err
    assert main(["simulate", "--model", model, "--operator", own, "--out", str(robot.parent / "o.mcap")]) == 2
    assert ".npz or .csv" in capsys.readouterr().err
    assert not (robot.parent / "o").exists()


def test_the_commands_write_what_they_say_and_the_model_found_predicts_the_log(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, model = robot.parent, str(written(robot.parent))
    moves, torque = small_arm.rigid(1, folder)
    torque = torque + 2.0 * np.sign(moves.v) * [0.0, 1.0, 0.0]
    np.savez(folder / "arm_log.npz", t_s=moves.time, q_rad=moves.q, tau_Nm=torque)
    out, recorded = folder / "out", str(folder / "arm_log.npz")
    assert main(["diagnose", recorded, "--model", model, "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(e["name"], e["joint"]) for e in told["effects"]] == [("coulomb_friction", "lift")]
    assert {file.name for file in out.iterdir()} == {
        "diagnosis.json",
        "augmented_model.yaml",
        "robot.urdf",
        "report.html",
    }
    found = str(out / "augmented_model.yaml")
    assert main(["simulate", "--model", found, "--operator", recorded, "--out", str(folder / "torque.csv")]) == 0
    errors = [float(word) for word in re.findall(r"(?:turn|lift|bend) ([\d.e-]+)", capsys.readouterr().out)]
    assert len(errors) == 3 and max(errors) < 0.03
    assert np.loadtxt(folder / "torque.csv", delimiter=",", skiprows=1).shape[1] == 7
