"""The page on arms tells every key, column and effect that there is, and its examples work."""

import re
from pathlib import Path

import pytest
import small_arm
import yaml

from mmt_drake.arms import arm_file
from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.joint_log import POSITIONS, TIMES, TORQUES
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.wording import _VERDICTS


@pytest.fixture(scope="module")
def page(checkout: Path) -> str:
    return (checkout / "docs" / "arms.md").read_text()


def test_every_key_of_a_model_file_is_told(page: str) -> None:
    shown = [yaml.safe_load(text) for text in re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)]
    assert {*shown[-1], "plant"} == set(arm_file._KEYS)


def test_the_model_that_is_shown_is_one(page: str, tmp_path: Path) -> None:
    text = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[-1]
    for there, here in (("base", "turn"), ("shoulder", "lift"), ("elbow", "bend"), ("forearm", "fore")):
        text = text.replace(there, here)
    (tmp_path / "arm.urdf").write_text(small_arm.URDF)
    (tmp_path / "arm.yaml").write_text(text)
    model = load_arm_model(tmp_path / "arm.yaml")
    assert (model.joints, model.column) == (small_arm.JOINTS, "i_A")


def test_every_column_effect_and_verdict_is_told(page: str) -> None:
    for name in (*TIMES, *POSITIONS, *TORQUES, *ARM_EFFECTS, *_VERDICTS):
        assert f"`{name}`" in page, name


def test_the_plant_in_drake_runs_as_shown(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small_arm.written(tmp_path)
    (tmp_path / "out" / "arm").mkdir(parents=True)
    (tmp_path / "out" / "arm" / "augmented_model.yaml").write_text("structure: multibody\nrobot: ../../small.urdf\n")
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    exec(code, {})
