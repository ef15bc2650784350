"""Model files of arms: what is written is read again, and each mistake is told in one line."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_arm
import yaml

from mmt_drake.arms.arm_file import INERTIA, ArmModel, Held, JointEffect, load_arm_model, save_arm_model
from mmt_drake.arms.believed import check_places, inertias
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.structure import is_arm_file
from mmt_drake.errors import BadInput

COULOMB = {"name": "coulomb_friction", "joint": "lift", "parameters": {"Fc": 1.0}}


def write(folder: Path, **keys: Any) -> Path:
    """A model file beside the small arm's URDF; a key of None is left out."""
    small_arm.written(folder)
    data = {"structure": "multibody", "robot": "small.urdf", **keys}
    path = folder / "arm.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in data.items() if value is not None}))
    return path


def refused(path: Path) -> str:
    """The one line of a file that is refused, when it is read or when its arm is made."""
    with pytest.raises(BadInput) as error:
        model = load_arm_model(path)
        arm = ArmPlant.of(model)
        check_places(arm, model)
        inertias(arm, model)
    line = str(error.value)
    assert "\n" not in line and ": found " in line and ", expected " in line
    return line


def test_a_model_that_was_saved_is_read_again(tmp_path: Path) -> None:
    values: dict[str, dict[str, float | str]] = {
        name: {s: "turn" if s == "joint" else 0.1 + i for i, s in enumerate(law.symbols)}
        for name, law in ARM_EFFECTS.items()
    }
    places = {"joint": "lift", "link": "fore", "arm": ""}
    model = small_arm.model(
        tmp_path,
        joints=("turn", "lift", "bend"),
        gravity=(0.0, 1.0, -9.7),
        column="i_A",
        factor=(1.0, -2.0, 3.5),
        held=(Held("fore", 0.5, (0.1, 0.0, 0.02)),),
        band_hz=6.0,
        links={"upper": tuple(0.1 * np.arange(1, 11))},
        effects=tuple(JointEffect(name, places[ARM_EFFECTS[name].place], values[name]) for name in ARM_EFFECTS),
    )
    read = load_arm_model(save_arm_model(model, tmp_path / "saved.yaml"))
    assert replace(read, robot=model.robot, source=model.source) == model
    assert read.robot == tmp_path / "small.urdf"


def test_a_model_that_is_saved_elsewhere_still_finds_its_robot(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    read = load_arm_model(save_arm_model(small_arm.model(tmp_path), tmp_path / "deep" / "saved.yaml"))
    assert read.robot.resolve() == (tmp_path / "small.urdf").resolve()


def test_what_is_not_said_has_a_default(tmp_path: Path) -> None:
    model = load_arm_model(write(tmp_path))
    assert (model.gravity, model.band_hz, model.joints, model.factor) == ((0.0, 0.0, -9.81), 8.0, (), ())
    assert ArmPlant.of(model).joints == small_arm.JOINTS


def test_one_factor_is_that_of_every_joint(tmp_path: Path) -> None:
    model = load_arm_model(write(tmp_path, torque={"factor": 2.5}))
    assert model.factor == (2.5,)


def test_a_plant_may_come_from_a_function_of_one_s_own(tmp_path: Path) -> None:
    small_arm.written(tmp_path)
    (tmp_path / "own.py").write_text(
        "from pathlib import Path\n"
        "from pydrake.multibody.parsing import Parser\n"
        "from pydrake.multibody.plant import MultibodyPlant\n"
        "def made():\n"
        "    plant = MultibodyPlant(0.0)\n"
        "    Parser(plant).AddModels(str(Path(__file__).parent / 'small.urdf'))\n"
        "    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName('foot'))\n"
        "    return plant\n"
        "def other():\n    return 3\n"
        "def broken():\n    raise ValueError('no robot today')\n"
    )
    model = load_arm_model(write(tmp_path, robot=None, plant="own.py:made"))
    np.testing.assert_allclose(ArmPlant.of(model).inertias(), ArmPlant.of(small_arm.model(tmp_path)).inertias())
    read = load_arm_model(save_arm_model(model, tmp_path / "saved.yaml"))
    assert replace(read, source=model.source, robot=model.robot) == model
    assert "int, expected a MultibodyPlant" in refused(write(tmp_path, robot=None, plant="own.py:other"))
    assert "no robot today" in refused(write(tmp_path, robot=None, plant="own.py:broken"))
    assert "no absent" in refused(write(tmp_path, robot=None, plant="own.py:absent"))
    assert "expected FILE.py:FUNCTION" in refused(write(tmp_path, robot=None, plant="own.py"))


TEN = dict.fromkeys(INERTIA, 0.1)
BAD: dict[str, tuple[dict[str, Any], str]] = {
    "an unknown key": ({"torques": {}}, "torques"),
    "another structure": ({"structure": "driven_body"}, "structure: found 'driven_body', expected multibody"),
    "a robot's file that is missing": ({"robot": "none.urdf"}, "none.urdf, no file"),
    "both robot and plant": ({"plant": "own.py:f"}, "found robot and plant"),
    "neither": ({"robot": None}, "found neither robot nor plant"),
    "a robot that is none": ({"robot": "arm.yaml"}, "expected one robot, as URDF, SDF or MJCF"),
    "an unknown joint": ({"joints": ["turn", "knee"]}, "joints: found knee, expected one of turn, lift, bend"),
    "a joint twice": ({"joints": ["turn", "turn"]}, "found one twice"),
    "joints that are no list": ({"joints": "turn"}, "joints: found str, expected a list"),
    "a factor of 0": ({"torque": {"factor": [1.0, 0.0, 1.0]}}, "torque.factor: found 0"),
    "a factor that is text": ({"torque": {"factor": ["one"]}}, "torque.factor[0]: found 'one'"),
    "an unknown key of torque": ({"torque": {"gain": 1.0}}, "gain"),
    "gravity of two numbers": ({"gravity": [0.0, -9.81]}, "gravity: found [0.0, -9.81], expected a list of 3"),
    "a band of nothing": ({"band_hz": 0.0}, "band_hz: found 0.0, expected a number of 0.1 or more"),
    "what is held, without a mass": ({"held": [{"link": "fore"}]}, "held[0].m: found None"),
    "what is held, lighter than nothing": ({"held": [{"link": "fore", "m": -1.0}]}, "held[0].m: found -1.0"),
    "held by no link": ({"held": [{"link": "claw", "m": 1.0}]}, "held[0].link: found claw"),
    "a link that is none": ({"links": {"claw": TEN}}, "links.claw: found claw, expected one of post, upper, fore"),
    "one number of a link": ({"links": {"fore": {"m": 1.0}}}, "links.fore: found m, expected m, mcx"),
    "nine numbers of a link": ({"links": {"fore": {**TEN, "Izz": None}}}, "links.fore.Izz: found None"),
    "an unknown effect": ({"effects": [{"name": "magic"}]}, "effects[0].name: found 'magic', expected one of"),
    "an effect without its joint": (
        {"effects": [{"name": "coulomb_friction", "parameters": {"Fc": 1.0}}]},
        "effects[0].joint: found None, expected a joint",
    ),
    "an effect at a joint that is none": (
        {"effects": [{**COULOMB, "joint": "knee"}]},
        "effects[0].joint: found knee, expected one of turn, lift, bend",
    ),
    "an effect of another place": ({"effects": [{**COULOMB, "link": "fore"}]}, "link"),
    "a payload at a link that is none": (
        {"effects": [{"name": "payload", "link": "claw", "parameters": {"m": 1, "cx": 0, "cy": 0, "cz": 0}}]},
        "effects[0].link: found claw",
    ),
    "a number that an effect has not": (
        {"effects": [{**COULOMB, "parameters": {"Fs": 1.0}}]},
        "effects[0].parameters: found Fs, expected Fc",
    ),
    "an effect without its number": (
        {"effects": [{**COULOMB, "parameters": {}}]},
        "effects[0].parameters: found none, expected Fc",
    ),
    "a number that is none": ({"effects": [{**COULOMB, "parameters": {"Fc": "much"}}]}, "parameters.Fc: found 'much'"),
    "a coupling with no joint": (
        {"effects": [{"name": "joint_coupling", "joint": "bend", "parameters": {"joint": "knee", "gain": 0.1}}]},
        "effects[0].parameters.joint: found knee",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_a_mistake_is_told_in_one_line(what: str, tmp_path: Path) -> None:
    keys, told = BAD[what]
    path = write(tmp_path, **keys)
    line = refused(path)
    assert told in line
    assert "arm.yaml" in line


def test_files_of_arms_are_known_by_their_structure(tmp_path: Path) -> None:
    assert is_arm_file(write(tmp_path))
    assert not is_arm_file(write(tmp_path, structure="driven_body"))
    assert not is_arm_file(tmp_path / "none.yaml")


def test_a_model_says_where_it_came_from(tmp_path: Path) -> None:
    assert isinstance(load_arm_model(write(tmp_path)), ArmModel)
    assert load_arm_model(write(tmp_path)).source == str(tmp_path / "arm.yaml")
