"""Damping of a robot's file is the viscous friction of its joints, once."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm
from pydrake.systems.analysis import Simulator

from mmt_drake.arms.arm_file import ArmModel, JointEffect
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.deliver import arm_diagram
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.forward import forward
from mmt_drake.arms.plant import ArmPlant

DAMPING = 0.7


def damped(folder: Path, **keys: object) -> ArmModel:
    """The small arm, each joint damped by its file."""
    text = small_arm.URDF.replace("<limit ", f'<dynamics damping="{DAMPING}"/><limit ')
    (folder / "damped.urdf").write_text(text)
    return replace(small_arm.model(folder), robot=folder / "damped.urdf", **keys)


def test_an_arm_that_is_damped_as_its_file_says_lacks_nothing(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    log = small_arm.noisy(moves, rigid + DAMPING * moves.v, 1)
    found = diagnose_arm([log], damped(tmp_path))
    assert (found.verdict, small_arm.named(found)) == ("no_mismatch", set())


def test_damping_of_the_file_that_is_not_there_is_told_as_another_value(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    model = damped(tmp_path)
    found = diagnose_arm([small_arm.noisy(moves, rigid, 1)], model)
    assert max(joint.augmented for joint in found.joints) < 0.02 < max(joint.nominal for joint in found.joints)
    viscous = {e.where: e.parameters["b"] for e in found.model.effects}
    for joint in small_arm.JOINTS:
        assert 0.0 <= viscous[joint] < 0.02


def test_damping_of_the_file_is_not_taken_off_a_torque_that_a_log_tells_with_a_gain(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    gained = (rigid + DAMPING * moves.v) * [1.0, 1.2, 1.0]
    log = small_arm.noisy(moves, gained, 1, part=0.0)
    gain = JointEffect("torque_gain", "lift", {"gain": 0.2})
    viscous = tuple(JointEffect("viscous_friction", joint, {"b": DAMPING}) for joint in small_arm.JOINTS)
    by_file, by_model = damped(tmp_path, effects=(gain,)), small_arm.model(tmp_path, effects=(gain, *viscous))
    spans = [(5.0, 6.0), (12.0, 13.0)]
    np.testing.assert_allclose(forward(by_file, log, spans).rms, forward(by_model, log, spans).rms, rtol=1e-6)


@pytest.mark.parametrize("b", [None, 0.0, 0.3])
def test_the_plant_is_damped_once_by_what_the_model_says_or_else_by_its_file(b: float | None, tmp_path: Path) -> None:
    own = () if b is None else tuple(JointEffect("viscous_friction", j, {"b": b}) for j in small_arm.JOINTS)
    model = damped(tmp_path, effects=own)
    bare = small_arm.model(
        tmp_path,
        effects=tuple(JointEffect("viscous_friction", j, {"b": DAMPING if b is None else b}) for j in small_arm.JOINTS),
    )
    ends = []
    for one in (model, bare):
        diagram, _ = arm_diagram(one)
        simulator = Simulator(diagram)
        diagram.GetInputPort("torque").FixValue(simulator.get_mutable_context(), [3.0, 10.0, 1.0])
        simulator.AdvanceTo(0.3)
        ends.append(diagram.GetOutputPort("state").Eval(simulator.get_context()))
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)
    moves, rigid = small_arm.rigid(1, tmp_path)
    log = small_arm.noisy(moves, rigid, 1)
    arm = ArmPlant.of(model)
    np.testing.assert_allclose(predicted(arm, model, log).predicted, predicted(arm, bare, log).predicted, atol=1e-9)
