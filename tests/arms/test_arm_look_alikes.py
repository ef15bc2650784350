"""What looks like an effect is said where it does, and nowhere else."""

from types import SimpleNamespace
from typing import Any

import pytest

from mmt_drake.arms.conclusion import with_look_alikes
from mmt_drake.arms.laws import ARM_EFFECTS
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
