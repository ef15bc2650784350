"""What is delivered: the robot's file with other inertias, and a diagram that falls and slows down as it should."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_arm
from pydrake.systems.analysis import Simulator

from mmt_drake.arms.arm_file import ArmModel, Held, JointEffect
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.deliver import arm_diagram, set_links, write_urdf
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.plant import ArmPlant, spatial_inertia
from mmt_drake.errors import BadInput

LENGTH, MASS = 0.5, 2.0
PENDULUM = small_arm.robot(
    '<link name="foot"/>',
    small_arm.link("rod", MASS, (0.0, 0.0, -LENGTH), (1e-6, 1e-6, 1e-6)),
    small_arm.joint("swing", "foot", "rod", "0 0 0", "0 1 0"),
)
FLAT = (0.0, 0.0, 0.0)
INERTIA = MASS * LENGTH**2 + 1e-6
WITH_HAND = small_arm.URDF.replace(
    "</robot>",
    small_arm.link("hand", 0.7, (0.05, 0.0, 0.01), (0.001, 0.002, 0.003))
    + small_arm.joint("wrist", "fore", "hand", "0.3 0 0.02", kind="fixed")
    + "</robot>",
)


def pendulum(folder: Path, *effects: JointEffect, **keys: Any) -> ArmModel:
    (folder / "pendulum.urdf").write_text(PENDULUM)
    return ArmModel(folder / "pendulum.urdf", effects=effects, **keys)


def after(model: ArmModel, seconds: float, q: list[float], v: list[float], torque: float = 0.0) -> np.ndarray:
    """State of a diagram some time later, its drives giving the same torque all the while."""
    diagram, plant = arm_diagram(model)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    own = plant.GetMyMutableContextFromRoot(context)
    set_links(model, plant, own)
    plant.SetPositionsAndVelocities(own, [*q, *v])
    diagram.GetInputPort("torque").FixValue(context, np.full(len(q), torque))
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    simulator.AdvanceTo(seconds)
    state: np.ndarray = diagram.GetOutputPort("state").Eval(context)
    return state


def test_without_effects_an_arm_falls_as_drake_s_plant_does(tmp_path: Path) -> None:
    plant = small_arm.plant_of(small_arm.written(tmp_path))
    plant.Finalize()
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetPositionsAndVelocities(context, [0.1, -0.4, 0.5, 0.3, 0.0, 0.0])
    simulator.get_mutable_integrator().set_target_accuracy(1e-8)
    simulator.AdvanceTo(0.5)
    found = after(small_arm.model(tmp_path), 0.5, [0.1, -0.4, 0.5], [0.3, 0.0, 0.0])
    np.testing.assert_allclose(found, plant.GetPositionsAndVelocities(context), atol=1e-5)


def test_coulomb_friction_slows_a_pendulum_evenly_and_then_it_rests(tmp_path: Path) -> None:
    model = pendulum(tmp_path, JointEffect("coulomb_friction", "swing", {"Fc": 0.6}), gravity=FLAT)
    q, v = after(model, 0.5, [0.0], [2.0])
    rate = 0.6 / INERTIA
    assert v == pytest.approx(2.0 - rate * 0.5, rel=1e-6)
    assert q == pytest.approx(2.0 * 0.5 - 0.5 * rate * 0.25, rel=1e-6)
    assert abs(after(model, 3.0, [0.0], [2.0])[1]) < 1e-6


def test_static_friction_has_another_level_below_a_speed(tmp_path: Path) -> None:
    numbers = {"Fs": 1.0, "Fd": 0.4, "v_d": 0.8}
    model = pendulum(tmp_path, JointEffect("static_friction", "swing", numbers), gravity=FLAT)
    until = (2.0 - 0.8) * INERTIA / 0.4  # it reaches v_d
    assert after(model, 0.5 * until, [0.0], [2.0])[1] == pytest.approx(1.4, rel=1e-4)
    slower = 0.8 - (0.3 / INERTIA) * 1.0
    assert after(model, until + 0.3, [0.0], [2.0])[1] == pytest.approx(slower, abs=2e-3)


def test_viscous_friction_lets_the_speed_decay_and_a_drive_balances_it(tmp_path: Path) -> None:
    model = pendulum(tmp_path, JointEffect("viscous_friction", "swing", {"b": 0.8}), gravity=FLAT)
    assert after(model, 0.7, [0.0], [2.0])[1] == pytest.approx(2.0 * np.exp(-0.8 * 0.7 / INERTIA), rel=1e-6)
    assert after(model, 8.0, [0.0], [2.0], torque=0.4)[1] == pytest.approx(0.5, rel=1e-5)


def test_a_spring_and_a_rotor_set_the_frequency(tmp_path: Path) -> None:
    stiffness, rotor = 5.0, 0.3
    model = pendulum(
        tmp_path,
        JointEffect("ground_spring", "swing", {"k": stiffness}),
        JointEffect("rotor_inertia", "swing", {"I": rotor}),
        gravity=FLAT,
    )
    w = np.sqrt(stiffness / (INERTIA + rotor))
    q, v = after(model, 1.3, [0.2], [0.0])
    assert (q, v) == pytest.approx((0.2 * np.cos(1.3 * w), -0.2 * w * np.sin(1.3 * w)), abs=1e-5)


def test_dahl_s_friction_is_a_spring_first_and_holds_its_level_then(tmp_path: Path) -> None:
    numbers = {"Fc": 0.6, "sigma": 60.0}
    model = pendulum(tmp_path, JointEffect("dahl_friction", "swing", numbers), gravity=FLAT)
    q, v = after(model, 0.4, [0.0], [2.0])
    # Energy: Dahl's force over a way s is Fc (1 - exp(-sigma s/Fc)).
    work = 0.6 * (q - 0.6 / 60.0 * (1.0 - np.exp(-60.0 * q / 0.6)))
    assert 0.5 * INERTIA * (4.0 - v**2) == pytest.approx(work, rel=1e-4)


def test_a_constant_force_pushes_along_the_joint(tmp_path: Path) -> None:
    model = pendulum(tmp_path, JointEffect("constant_force", "swing", {"F": 0.6}), gravity=FLAT)
    assert after(model, 0.5, [0.0], [0.0])[1] == pytest.approx(0.5 * 0.6 / INERTIA, rel=1e-6)


@pytest.mark.parametrize(
    "effect",
    [
        JointEffect("viscous_friction", "lift", {"b": 0.9}),
        JointEffect("coulomb_friction", "lift", {"Fc": 1.5}),
        JointEffect("stribeck_friction", "turn", {"Fc": 1.0, "Fs": 2.0, "v_s": 0.2}),
        JointEffect("torque_ripple", "bend", {"amplitude": 0.7, "period": 0.3, "phase": 0.4}),
        JointEffect("constant_force", "bend", {"F": 0.7}),
        JointEffect("rotor_inertia", "turn", {"I": 0.3}),
        JointEffect("payload", "fore", {"m": 0.6, "cx": 0.3, "cy": 0.02, "cz": -0.03}),
        JointEffect(
            "payload",
            "fore",
            {"m": 0.6, "cx": 0.3, "cy": 0.0, "cz": 0.0}
            | {"Ixx": 0.02, "Iyy": 0.05, "Izz": 0.06, "Ixy": 0.004, "Ixz": 0.0, "Iyz": 0.003},
        ),
        JointEffect("gravity_offset", "", {"rx": 0.02, "ry": -0.03}),
    ],
    ids=lambda effect: f"{effect.name} of {len(effect.parameters)} numbers",
)
def test_the_diagram_and_the_torque_that_a_model_predicts_are_of_one_arm(effect: JointEffect, tmp_path: Path) -> None:
    """Driven by the torque that inverse dynamics asks for, the diagram's joints accelerate as in the motion."""
    model = small_arm.model(tmp_path, effects=(effect,), held=(Held("upper", 0.5, (0.1, 0.0, 0.0)),))
    moves = small_arm.sines(3, 9)
    log = JointLog("log", moves.time, moves.q, np.ones_like(moves.q), "tau")
    one = predicted(ArmPlant.of(model), replace(model, band_hz=12.0), log)
    diagram, plant = arm_diagram(model)
    context = diagram.CreateDefaultContext()
    off = []
    for row in range(40, len(one.time) - 40, 37):
        at = int(np.argmin(np.abs(moves.time - one.time[row])))
        if np.abs(moves.v[at]).min() < 0.1:  # smooth torque has no step where friction turns over
            continue
        own = plant.GetMyMutableContextFromRoot(context)
        plant.SetPositionsAndVelocities(own, [*moves.q[at], *moves.v[at]])
        diagram.GetInputPort("torque").FixValue(context, one.predicted[row])
        rates = plant.EvalTimeDerivatives(own).CopyToVector()[3:]
        off.append(rates - moves.a[at])
    assert len(off) > 5
    assert np.abs(np.median(off, axis=0)).max() < 0.03 * moves.a.std(), np.median(off, axis=0)


def test_a_payload_of_moments_that_no_body_has_is_refused(tmp_path: Path) -> None:
    moments = {"Ixx": 0.5, "Iyy": 0.1, "Izz": 0.1}
    effect = JointEffect("payload", "fore", {"m": 0.6, "cx": 0.3, "cy": 0.0, "cz": 0.0} | moments)
    with pytest.raises(BadInput, match=r"payload: found moments 0\.5, 0\.1, 0\.1, .*, expected moments that a body"):
        arm_diagram(small_arm.model(tmp_path, effects=(effect,)))


def test_what_is_held_counts_once_where_links_have_other_numbers(tmp_path: Path) -> None:
    held = small_arm.model(tmp_path, held=(Held("fore", 0.9, (0.2, 0.0, 0.05)),))
    numbers = ArmPlant.of(held).inertias()[2]
    told = held.with_found((), {"fore": tuple(map(float, numbers))})
    first = after(held, 0.4, [0.1, -0.4, 0.5], [0.3, 0.0, 0.0])
    np.testing.assert_allclose(after(told, 0.4, [0.1, -0.4, 0.5], [0.3, 0.0, 0.0]), first, atol=1e-4)


@pytest.mark.parametrize(
    "text",
    [small_arm.URDF, WITH_HAND, WITH_HAND.replace("fixed", "revolute")],
    ids=["bare", "with a hand welded on", "with a hand on a joint that was not recorded"],
)
def test_the_robot_s_file_that_is_written_has_the_links_numbers(text: str, tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(text)
    believed = ArmModel(tmp_path / "robot.urdf", joints=small_arm.JOINTS)
    arm = ArmPlant.of(believed)
    numbers = arm.inertias() * np.array([1.1, *[1.08] * 3, *[1.12] * 6])
    links = {name: tuple(map(float, row)) for name, row in zip(arm.links, numbers, strict=True)}
    written = write_urdf(believed.with_found((), links), tmp_path / "out.urdf")
    found = ArmPlant.of(replace(believed, robot=written)).inertias()
    np.testing.assert_allclose(found, numbers, rtol=1e-6, atol=1e-8)


def test_a_link_that_is_not_told_keeps_the_file_s_numbers(tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_text(WITH_HAND)
    believed = ArmModel(tmp_path / "robot.urdf")
    before = ArmPlant.of(believed).inertias()
    written = write_urdf(believed.with_found((), {"post": tuple(1.1 * before[0])}), tmp_path / "out.urdf")
    np.testing.assert_allclose(ArmPlant.of(ArmModel(written)).inertias()[1:], before[1:], rtol=1e-9)


def test_spatial_inertia_has_the_ten_numbers(tmp_path: Path) -> None:
    numbers = ArmPlant.of(small_arm.model(tmp_path)).inertias()[1]
    one = spatial_inertia(numbers)
    moments = one.CalcRotationalInertia().CopyToFullMatrix3()
    assert one.get_mass() == pytest.approx(numbers[0])
    np.testing.assert_allclose(one.get_mass() * one.get_com(), numbers[1:4], atol=1e-12)
    np.testing.assert_allclose([moments[0, 0], moments[0, 1]], [numbers[4], numbers[7]], atol=1e-12)


def test_what_is_no_urdf_is_not_written_as_one(tmp_path: Path) -> None:
    robot = tmp_path / "robot.sdf"
    robot.write_text("<sdf/>")
    with pytest.raises(BadInput, match=r"robot\.sdf, expected a URDF"):
        write_urdf(ArmModel(robot), tmp_path / "out.urdf")
