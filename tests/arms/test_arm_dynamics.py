"""The dynamics of arms against Drake's own and against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator

from mmt_drake.arms.arm_file import ArmModel, Held, JointEffect
from mmt_drake.arms.believed import inertias
from mmt_drake.arms.consistency import is_consistent, nearest_consistent, pseudo_inertia
from mmt_drake.arms.deliver import arm_diagram, set_links, write_urdf
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.regressor import regressor

SLIDING = small_arm.robot(
    '<link name="foot"/>',
    small_arm.link("post", 4.0, (0.02, -0.01, 0.12), (0.03, 0.03, 0.02)),
    small_arm.link("box", 2.0, (0.1, 0.03, 0.02), (0.01, 0.02, 0.02, 0.001)),
    small_arm.link("hand", 0.7, (0.05, 0.0, 0.01), (0.001, 0.001, 0.001)),
    small_arm.link("finger", 0.2, (0.02, 0.0, 0.0), (0.0001, 0.0001, 0.0001)),
    small_arm.joint("turn", "foot", "post", "0 0 0.1", "0.6 0 0.8"),
    small_arm.joint("slide", "post", "box", "0.1 0 0.2", "1 0 0", "prismatic"),
    small_arm.joint("bend", "box", "hand", "0.2 0 0", "0 1 0"),
    small_arm.joint("grip", "hand", "finger", "0.1 0 0", "0 0 1"),
)


def model_of(folder: Path, urdf: str, **changes: object) -> ArmModel:
    (folder / "robot.urdf").write_text(urdf)
    return replace(ArmModel(robot=folder / "robot.urdf"), **changes)


def test_the_regressor_gives_drake_s_inverse_dynamics(tmp_path: Path) -> None:
    """With a joint that slides, one that was not recorded, and something held in the hand."""
    model = model_of(tmp_path, SLIDING, joints=("turn", "slide", "bend"), held=(Held("finger", 0.4, (0.0, 0.02, 0.1)),))
    arm, rng = ArmPlant.of(model), np.random.default_rng(1)
    q, v, a = rng.normal(size=(3, 20, 3))
    torque = regressor(arm, q, v, a).inertial @ arm.inertias().ravel()
    plant = arm.plant
    context = plant.CreateDefaultContext()
    for i in range(20):
        positions, velocities, rates = np.zeros(4), np.zeros(4), np.zeros(4)
        positions[arm.position_index], velocities[arm.velocity_index], rates[arm.velocity_index] = q[i], v[i], a[i]
        plant.SetPositions(context, positions)
        plant.SetVelocities(context, velocities)
        forces = MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        expected = plant.CalcInverseDynamics(context, rates, forces)[arm.velocity_index]
        assert torque[i] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_columns_of_a_tilt_are_the_difference_that_a_small_one_makes(tmp_path: Path) -> None:
    model = model_of(tmp_path, small_arm.URDF)
    rng = np.random.default_rng(2)
    q, v, a = rng.normal(size=(3, 5, 3))
    arm, h = ArmPlant.of(model), 1e-6
    found = np.einsum("njpk,p->njk", regressor(arm, q, v, a).tilted, arm.inertias().ravel())
    for k, gravity in enumerate(((0.0, h * 9.81, -9.81), (-h * 9.81, 0.0, -9.81))):
        turned = ArmPlant.of(replace(model, gravity=gravity))
        moved, before = (regressor(one, q, v, a).inertial @ arm.inertias().ravel() for one in (turned, arm))
        assert found[:, :, k] == pytest.approx((moved - before) / h, rel=1e-4, abs=1e-4)


def test_consistent_numbers_stay_and_others_become_consistent_nearer_than_by_clipping() -> None:
    rng = np.random.default_rng(3)
    good = np.array([[2.0, 0.1, 0.0, 0.2, 0.1, 0.1, 0.05, 0.0, 0.0, 0.0]])
    weight = np.diag(rng.uniform(0.5, 2.0, 10))
    assert nearest_consistent(good, weight, good) is good
    bad = good.copy()
    bad[0, 4] = -0.05
    found = nearest_consistent(bad, weight, good)
    assert not is_consistent(bad[0]) and is_consistent(found[0])
    values, axes = np.linalg.eigh(pseudo_inertia(bad[0]))
    clipped = axes @ np.diag(np.maximum(values, 1e-6)) @ axes.T
    moments = np.trace(clipped[:3, :3]) * np.eye(3) - clipped[:3, :3]
    naive = np.array([clipped[3, 3], *clipped[:3, 3], *np.diag(moments), moments[0, 1], moments[0, 2], moments[1, 2]])
    step, naive_step = found[0] - bad[0], naive - bad[0]
    assert step @ weight @ step <= naive_step @ weight @ naive_step


def test_the_urdf_that_is_written_has_the_numbers_that_were_found(tmp_path: Path) -> None:
    model = model_of(tmp_path, SLIDING, joints=("turn", "slide", "bend"))
    arm = ArmPlant.of(model)
    numbers = arm.inertias() * 1.1
    found = replace(model, links=dict(zip(arm.links, map(tuple, numbers.tolist()), strict=True)))
    path = write_urdf(found, tmp_path / "found.urdf")
    assert ArmPlant.of(replace(model, robot=path)).inertias() == pytest.approx(numbers, rel=1e-6, abs=1e-9)
    assert inertias(arm, found) == pytest.approx(numbers)


PENDULUM = small_arm.robot(
    '<link name="foot"/>',
    small_arm.link("rod", 2.0, (0.0, 0.0, 0.0), (0.3, 0.5, 0.3)),
    small_arm.joint("swing", "foot", "rod", "0 0 0", "0 1 0"),
)


@pytest.mark.parametrize(
    ("effects", "expected"),
    [
        ((JointEffect("coulomb_friction", "swing", {"Fc": 0.2}),), 3.0 - 0.2 / 0.5),
        ((JointEffect("viscous_friction", "swing", {"b": 0.5}),), 3.0 * np.exp(-1.0)),
        ((JointEffect("constant_force", "swing", {"F": 0.25}),), 3.0 + 0.5),
        (
            (JointEffect("rotor_inertia", "swing", {"I": 0.5}), JointEffect("constant_force", "swing", {"F": 0.5})),
            3.0 + 0.5,
        ),
    ],
)
def test_a_wheel_slows_down_by_its_friction_as_it_should(
    tmp_path: Path, effects: tuple[JointEffect, ...], expected: float
) -> None:
    """A wheel of 0.5 kg m^2, from 3 rad/s, after a second."""
    model = model_of(tmp_path, PENDULUM, effects=effects)
    diagram, plant = arm_diagram(model)
    context = diagram.CreateDefaultContext()
    inside = diagram.GetMutableSubsystemContext(plant, context)
    set_links(model, plant, inside)
    plant.SetVelocities(inside, [3.0])
    diagram.GetInputPort("torque").FixValue(context, [0.0])
    Simulator(diagram, context).AdvanceTo(1.0)
    assert plant.GetVelocities(inside)[0] == pytest.approx(expected, abs=2e-3)
