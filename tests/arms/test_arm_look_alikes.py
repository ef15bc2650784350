"""What looks like an effect is said where it does, and nowhere else."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_arm import model, sines

from mmt_drake.arms.conclusion import with_look_alikes
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import arm_problem
from mmt_drake.arms.result import ArmEffectFound

PROBLEM: Any = SimpleNamespace(arm=SimpleNamespace(joints=("turn", "lift")), moving=(0, 1))


def found(name: str, where: str, certain: str | None = "law") -> ArmEffectFound:
    law = ARM_EFFECTS[name]
    return ArmEffectFound(name, law.family, law.block, where, certain, {}, 0.1)


@pytest.mark.parametrize(
    ("effects", "alike"),
    [
        ([("rotor_inertia", "turn")], [("link_inertia",)]),
        ([("rotor_inertia", "lift")], [()]),
        ([("torque_gain", "lift")], [()]),
        ([("torque_gain", "turn"), ("torque_gain", "lift")], [("scaled_inertias",)] * 2),
        ([("payload", "fore")], [("link_inertia",)]),
        ([("time_delay", ""), ("coulomb_friction", "lift")], [("force_lag",), ()]),
    ],
)
def test_look_alikes_are_said_where_they_are(effects: list[tuple[str, str]], alike: list[tuple[str, ...]]) -> None:
    told = with_look_alikes([found(*effect) for effect in effects], PROBLEM)
    assert [effect.looks_like for effect in told] == alike


def test_what_is_not_sure_has_its_rivals_already() -> None:
    (told,) = with_look_alikes([found("payload", "fore", None)], PROBLEM)
    assert told.looks_like == ()


def test_whatever_looks_alike_is_an_effect_or_other_inertial_numbers() -> None:
    others = {name for effect in ARM_EFFECTS.values() for name in effect.near_equal}
    assert others - set(ARM_EFFECTS) == {"link_inertia", "scaled_inertias"}


@pytest.mark.parametrize(("alike", "coupled"), [(True, {0}), (False, {0, 1})])
def test_a_coupling_is_not_sought_between_joints_that_move_alike(
    tmp_path: Path, alike: bool, coupled: set[int]
) -> None:
    moves = sines(3, 4)
    q = np.column_stack([moves.q[:, :2], 0.8 * moves.q[:, 1]]) if alike else moves.q
    believed, log = model(tmp_path), JointLog("log", moves.time, q, np.ones_like(q), "tau")
    problem = arm_problem(ArmPlant.of(believed), believed, [log])
    assert {int(t.shape[0]) for t in problem.rows[2].terms if t.effect == "joint_coupling"} == coupled
