"""A torque with the other sign is refused with the names of its joints; one with the right sign is not."""

from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import arm_problem
from mmt_drake.arms.signs import check_signs
from mmt_drake.errors import BadInput


def checked(folder: Path, torque: np.ndarray, seed: int = 1) -> None:
    moves, _ = small_arm.rigid(seed, folder)
    model = small_arm.model(folder)
    log: JointLog = small_arm.noisy(moves, torque, seed)
    check_signs(arm_problem(ArmPlant.of(model), model, [log]), "log.csv")


def rubbing(folder: Path, seed: int = 1) -> np.ndarray:
    """Torques of the links, with 8 N m of dry friction on the first joint, which is most of what it has."""
    moves, rigid = small_arm.rigid(seed, folder)
    return rigid + np.outer(np.sign(moves.v[:, 0]), [8.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("signs", "told"), [((1, -1, 1), "on lift:"), ((-1, 1, 1), "on turn:"), ((-1, -1, -1), "on turn, lift, bend:")]
)
def test_joints_whose_torque_has_the_other_sign_are_named(signs: tuple[int, ...], told: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput) as error:
        checked(tmp_path, rubbing(tmp_path) * signs)
    assert told in str(error.value) and "\n" not in str(error.value) and "factor" in str(error.value)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("scale", [0.4, 1.0, 2.0])
def test_torques_of_wrong_size_are_no_matter_of_signs(seed: int, scale: float, tmp_path: Path) -> None:
    checked(tmp_path, scale * rubbing(tmp_path, seed), seed)


def test_a_torque_that_has_nothing_to_do_with_the_motion_is_no_matter_of_signs(tmp_path: Path) -> None:
    _, rigid = small_arm.rigid(1, tmp_path)
    checked(tmp_path, np.random.default_rng(0).normal(size=rigid.shape))
