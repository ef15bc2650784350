"""The trial of arms: its engine is the plant that it says, and a score counts what is true."""

from pathlib import Path

import numpy as np
import pytest

from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.joint_log import load_joint_log
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.diagrams.proof.trial.arms.cases import EFFECTS, ArmTrialCase, draw_case
from mmt_drake.diagrams.proof.trial.arms.engine import Concealment
from mmt_drake.diagrams.proof.trial.arms.run import ArmAnswer, NamedThing, diagnosed, scored


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> ArmTrialCase:
    pytest.importorskip("mujoco")
    return draw_case(tmp_path_factory.mktemp("arms"), "plain", 5, 0, None, 0.2)


def test_torques_of_the_engine_are_those_of_drake_s_dynamics(plain: ArmTrialCase) -> None:
    model = load_arm_model(plain.folder / "model.yaml")
    arm = ArmPlant.of(model)
    errors = predicted(arm, model, load_joint_log(plain.folder / "log.npz", model, arm.joints)).nrmse
    assert np.median(errors) < 0.02 and errors.max() < 0.1


def test_where_nothing_is_concealed_nothing_is_named(plain: ArmTrialCase) -> None:
    answer = diagnosed(plain.folder)
    assert not any(thing.certain for thing in answer.things) and not answer.places
    assert answer.verdict == "no_mismatch" and answer.payload_kg is None


def test_the_same_seed_gives_the_same_case(plain: ArmTrialCase, tmp_path: Path) -> None:
    again = draw_case(tmp_path, "again", 5, 0, None, 0.2)
    with np.load(plain.folder / "log.npz") as one, np.load(again.folder / "log.npz") as other:
        assert all(np.array_equal(one[name], other[name]) for name in one.files)


def test_a_concealed_friction_is_named_where_it_is(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    case = draw_case(tmp_path, "friction", 0, 0, "coulomb_friction", 0.2)
    score = scored(case, diagnosed(case.folder))
    assert score.families == score.places == len(case.concealed) and not score.false


def thing(name: str, where: str, certain: str, family: str = "dry_friction", block: str = "friction") -> NamedThing:
    return NamedThing(name, family, block, where, certain)


@pytest.mark.parametrize(
    ("named", "false"),
    [
        (thing("coulomb_friction", "a", "law"), 0),
        (thing("stribeck_friction", "a", "law"), 1),
        (thing("stribeck_friction", "a", "family"), 0),
        (thing("coulomb_friction", "b", "law"), 1),
        (thing("viscous_friction", "a", "family", "viscous"), 1),
        (thing("viscous_friction", "a", "block", "viscous"), 0),
    ],
)
def test_a_name_is_false_if_it_is_so_at_the_depth_called_certain(named: NamedThing, false: int, tmp_path: Path) -> None:
    case = ArmTrialCase("c", "ur5", (Concealment("coulomb_friction", "a", {"Fc": 1.0}),), tmp_path)
    score = scored(case, ArmAnswer((named,), (named.where,), "missing_physics", None, 1.0))
    assert len(score.false) == false


def test_every_effect_of_the_trial_is_known_to_the_diagnosis() -> None:
    assert set(EFFECTS) <= set(ARM_EFFECTS)
