"""Every effect of arms is found again in torques made by Drake and an independent formula, and nothing else is."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import small_arm
from small_arm import JOINTS, Moves

from mmt_drake.arms.arm_file import JointEffect
from mmt_drake.arms.deliver import arm_diagram
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.laws import ARM_EFFECTS


@dataclass(frozen=True)
class Concealed:
    """An effect, its numbers, and what it makes of torques (n, 3) in a formula of its own.

    Attributes:
        where: joint or link.
        numbers: by symbol.
        torque: (motion, torques of the links alone) -> torques as logged.
        within: relative error that is allowed.
        depth: to which its name has to hold.
    """

    where: str
    numbers: Mapping[str, float | str]
    torque: Callable[[Moves, np.ndarray], np.ndarray]
    within: float = 0.03
    depth: str = "law"


def on(joint: int, column: Callable[[Moves, np.ndarray], np.ndarray]) -> Callable[[Moves, np.ndarray], np.ndarray]:
    """Torques with something added to one joint's."""

    def changed(moves: Moves, rigid: np.ndarray) -> np.ndarray:
        torque = rigid.copy()
        torque[:, joint] += column(moves, rigid)
        return torque

    return changed


def dahl(moves: Moves, joint: int, Fc: float, sigma: float) -> np.ndarray:
    """F' = sigma v (1 - F/Fc sgn v) by steps of a hundredth of a sample."""
    fine = 100
    time = np.linspace(moves.time[0], moves.time[-1], fine * (len(moves.time) - 1) + 1)
    q = np.interp(time, moves.time, moves.q[:, joint])
    force = np.zeros(len(q))
    for i, step in enumerate(np.diff(q)):
        force[i + 1] = force[i] + sigma * step * (1.0 - force[i] / Fc * np.sign(step))
    return force[::fine]


def tilted(moves: Moves, rigid: np.ndarray, folder: Path) -> np.ndarray:
    """Torques under gravity turned by 0.02 rad about x and -0.03 rad about y, to all orders."""
    from pydrake.math import RollPitchYaw

    turned = RollPitchYaw(0.02, -0.03, 0.0).ToRotationMatrix().matrix() @ [0.0, 0.0, -9.81]
    plant = small_arm.plant_of(small_arm.written(folder), tuple(turned))
    plant.Finalize()
    return small_arm.inverse_dynamics(plant, moves)


def loaded(moves: Moves, rigid: np.ndarray, folder: Path) -> np.ndarray:
    """Torques with 0.8 kg in the hand."""
    plant = small_arm.with_point(small_arm.plant_of(small_arm.written(folder)), "fore", 0.8, (0.3, 0.03, -0.02))
    plant.Finalize()
    return small_arm.inverse_dynamics(plant, moves)


def late(moves: Moves, rigid: np.ndarray) -> np.ndarray:
    """Torques that come 4 ms later."""
    return np.stack([np.interp(moves.time - 0.004, moves.time, column) for column in rigid.T], 1)


CASES: dict[str, Concealed] = {
    "viscous_friction": Concealed("lift", {"b": 0.9}, on(1, lambda m, r: 0.9 * m.v[:, 1])),
    "asymmetric_viscous_friction": Concealed(
        "turn", {"b_plus": 1.2, "b_minus": 0.5}, on(0, lambda m, r: np.where(m.v[:, 0] > 0.0, 1.2, 0.5) * m.v[:, 0])
    ),
    "quadratic_drag": Concealed("lift", {"c": 0.8}, on(1, lambda m, r: 0.8 * m.v[:, 1] * np.abs(m.v[:, 1]))),
    "coulomb_friction": Concealed("lift", {"Fc": 2.0}, on(1, lambda m, r: 2.0 * np.sign(m.v[:, 1]))),
    "smooth_coulomb_friction": Concealed(
        "turn", {"Fc": 1.5}, on(0, lambda m, r: 1.5 * np.tanh(m.v[:, 0] / 0.2)), within=0.05, depth="family"
    ),
    "stribeck_friction": Concealed(
        "turn",
        {"Fc": 1.0, "Fs": 2.0},
        on(0, lambda m, r: (1.0 + np.exp(-((m.v[:, 0] / 0.2) ** 2))) * np.sign(m.v[:, 0])),
        within=0.1,
        depth="family",
    ),
    "dahl_friction": Concealed(
        "turn", {"Fc": 1.5}, on(0, lambda m, r: dahl(m, 0, 1.5, 30.0)), within=0.05, depth="family"
    ),
    "static_friction": Concealed(
        "turn",
        {"Fs": 2.0, "Fd": 1.0},
        on(0, lambda m, r: np.where(np.abs(m.v[:, 0]) < 0.2, 2.0, 1.0) * np.sign(m.v[:, 0])),
        within=0.15,
        depth="family",
    ),
    "load_dependent_friction": Concealed(
        "lift", {"mu": 0.15}, on(1, lambda m, r: 0.15 * np.abs(r[:, 1]) * np.sign(m.v[:, 1]))
    ),
    "constant_force": Concealed("bend", {"F": 1.1}, on(2, lambda m, r: np.full(len(m.v), -1.1))),
    "ground_spring": Concealed("turn", {"k": 2.0}, on(0, lambda m, r: 2.0 * m.q[:, 0])),
    "torque_ripple": Concealed(
        "turn",
        {"amplitude": 1.2, "period": 0.25},
        on(0, lambda m, r: -1.2 * np.sin(2.0 * np.pi * m.q[:, 0] / 0.25 + 0.4)),
        within=0.1,
    ),
    "rotor_inertia": Concealed("lift", {"I": 0.4}, on(1, lambda m, r: 0.4 * m.a[:, 1])),
    "torque_gain": Concealed("lift", {"gain": 0.2}, on(1, lambda m, r: 0.2 * r[:, 1])),
    "joint_coupling": Concealed("bend", {"joint": "lift", "gain": 0.1}, on(2, lambda m, r: 0.1 * r[:, 1])),
}


def diagnosed(folder: Path, torque: np.ndarray, moves: Moves, seed: int) -> object:
    return diagnose_arm([small_arm.noisy(moves, torque, seed)], small_arm.model(folder))


@pytest.mark.parametrize("name", CASES)
def test_an_effect_on_a_joint_is_found_with_its_numbers_and_nothing_else(name: str, tmp_path: Path) -> None:
    case = CASES[name]
    moves, rigid = small_arm.rigid(1, tmp_path)
    found = diagnosed(tmp_path, case.torque(moves, rigid), moves, 1)
    sure = [e for e in found.effects if e.certain]
    depths = ("block", "family", "law")
    assert [e.where for e in sure] == [case.where], small_arm.named(found)
    (one,) = sure
    if case.depth == "law":
        assert (one.name, one.certain) == (name, "law")
    else:
        assert one.family == ARM_EFFECTS[name].family and depths.index(one.certain) >= depths.index(case.depth)
    told = small_arm.values(found, one.name, case.where)
    for symbol, value in case.numbers.items():
        if isinstance(value, str):
            assert told[symbol] == value
        elif symbol in told:
            assert told[symbol] == pytest.approx(value, rel=case.within), symbol
    for joint in found.joints:
        assert joint.augmented < (0.07 if joint.name == case.where else 0.02), joint
    assert found.verdict in ("missing_physics", "partly_explained")


def test_a_ripple_that_is_above_the_band_at_full_speed_is_found_by_what_is_slower(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    fastest, band = np.abs(moves.v[:, 0]).max(), small_arm.model(tmp_path).band_hz
    period = 0.6 * fastest / band
    found = diagnosed(tmp_path, on(0, lambda m, r: np.sin(2.0 * np.pi * m.q[:, 0] / period))(moves, rigid), moves, 1)
    assert small_arm.named(found) == {("torque_ripple", "turn")}
    assert small_arm.values(found, "torque_ripple", "turn")["period"] == pytest.approx(period, rel=0.02)


def test_what_takes_no_more_than_what_has_no_name_has_none_beside_others(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    wandering = np.sin(0.9 * moves.time + 2.0 * np.sin(0.37 * moves.time))  # nothing of the library

    def beside_a_rotor(ripple: float) -> set[tuple[str, str]]:
        def column(m: Moves, r: np.ndarray) -> np.ndarray:
            return 0.4 * m.a[:, 1] + ripple * np.sin(2.0 * np.pi * m.q[:, 1] / 0.3) + 0.15 * wandering

        return small_arm.named(diagnosed(tmp_path, on(1, column)(moves, rigid), moves, 1))

    rotor, ripple = ("rotor_inertia", "lift"), ("torque_ripple", "lift")
    assert beside_a_rotor(0.2) == {rotor}
    assert beside_a_rotor(0.6) == {rotor, ripple}


@pytest.mark.parametrize("seed", range(5))
def test_where_nothing_is_concealed_nothing_is_named(seed: int, tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(20 + seed, tmp_path)
    found = diagnosed(tmp_path, rigid, moves, seed)
    assert not small_arm.named(found) and not found.parameters
    assert found.verdict == "no_mismatch" and found.believed == "none"


def test_a_payload_is_found_at_its_link_with_its_place(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(2, tmp_path)
    found = diagnosed(tmp_path, loaded(moves, rigid, tmp_path), moves, 2)
    assert small_arm.named(found) == {("payload", "fore")}
    told = small_arm.values(found, "payload", "fore")
    assert told["m"] == pytest.approx(0.8, rel=0.02)
    assert [told[f"c{axis}"] for axis in "xyz"] == pytest.approx([0.3, 0.03, -0.02], abs=0.01)
    (kept,) = found.model.effects
    moments = [float(kept.parameters[f"I{axes}"]) for axes in ("xx", "yy", "zz")]
    assert all(0.0 <= moment < 0.002 for moment in moments), "it was a point"
    arm_diagram(found.model)  # refuses what is no body
    assert any("Payload of fore looks like" in note for note in found.notes)
    assert not any("factor" in note for note in found.notes)


def test_the_mass_of_a_payload_that_is_read_by_gains_calls_these_in_question(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(2, tmp_path)
    log = small_arm.noisy(moves, loaded(moves, rigid, tmp_path), 2)
    found = diagnose_arm([log], small_arm.model(tmp_path, factor=(2.0,)))  # which the log has by now
    assert any("as right as `torque: factor`" in note for note in found.notes)


def test_a_foot_that_is_not_level_is_found(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(3, tmp_path)
    found = diagnosed(tmp_path, tilted(moves, rigid, tmp_path), moves, 3)
    assert small_arm.named(found) == {("gravity_offset", "")}
    told = small_arm.values(found, "gravity_offset", "")
    assert (told["rx"], told["ry"]) == pytest.approx((0.02, -0.03), abs=0.001)


def test_a_torque_that_is_late_is_found(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(4, tmp_path)
    found = diagnosed(tmp_path, late(moves, rigid), moves, 4)
    assert small_arm.named(found) == {("time_delay", "")}
    assert small_arm.values(found, "time_delay", "")["delay"] == pytest.approx(0.004, rel=0.05)


def test_a_delay_is_told_from_a_lag_where_both_are_long(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(4, tmp_path)
    delayed = np.stack([np.interp(moves.time - 0.03, moves.time, column) for column in rigid.T], 1)
    found = diagnosed(tmp_path, delayed, moves, 4)
    assert small_arm.named(found) == {("time_delay", "")}
    assert small_arm.values(found, "time_delay", "")["delay"] == pytest.approx(0.03, rel=0.03)


def test_a_torque_that_is_read_through_a_filter_is_found(tmp_path: Path) -> None:
    """tau y' = u - y, by the exact answer to a torque that is linear between samples."""
    moves, rigid = small_arm.rigid(4, tmp_path)
    tau, step = 0.04, moves.time[1] - moves.time[0]
    passed, y = -np.expm1(-step / tau), rigid[0]
    read = [y]
    for before, now in itertools.pairwise(rigid):
        y = y + passed * (before - y) + (1.0 - passed * tau / step) * (now - before)
        read.append(y)
    found = diagnosed(tmp_path, np.array(read), moves, 4)
    assert small_arm.named(found) == {("force_lag", "")}
    assert small_arm.values(found, "force_lag", "")["tau"] == pytest.approx(tau, rel=0.03)


def test_a_joint_that_gives_way_is_found_by_its_torque_alone(tmp_path: Path) -> None:
    """The log has the drive's position, which is ahead of the link's by the torque over k."""
    moves, rigid = small_arm.rigid(1, tmp_path)
    stiffness = 1500.0
    ahead = moves.q + np.outer(rigid[:, 1] / stiffness, [0.0, 1.0, 0.0])
    log = small_arm.noisy(moves, rigid, 1)
    found = diagnose_arm([replace(log, q=ahead)], small_arm.model(tmp_path))
    assert small_arm.named(found) == {("joint_elasticity", "lift")}
    assert small_arm.values(found, "joint_elasticity", "lift")["k"] == pytest.approx(stiffness, rel=0.1)


def test_every_effect_of_arms_has_a_test_here() -> None:
    of_no_table = {"payload", "gravity_offset", "time_delay", "force_lag", "joint_elasticity"}
    assert {*CASES} | of_no_table == set(ARM_EFFECTS)


def test_another_link_s_numbers_are_parameters_and_no_effect(tmp_path: Path) -> None:
    """A lighter link with another moment than the file says."""
    wrong = small_arm.URDF.replace('<mass value="3.0"/>', '<mass value="2.4"/>').replace('ixx="0.006"', 'ixx="0.012"')
    believed = tmp_path / "wrong"
    believed.mkdir()
    (believed / "small.urdf").write_text(wrong)
    moves, rigid = small_arm.rigid(5, tmp_path)
    model = small_arm.model(tmp_path)
    found = diagnose_arm([small_arm.noisy(moves, rigid, 5)], replace(model, robot=believed / "small.urdf"))
    joints = {e.where for e in found.effects if e.certain and e.where in JOINTS}
    assert not joints
    assert all(joint.augmented < 0.02 for joint in found.joints)
    assert found.parameters or small_arm.named(found) == {("payload", "upper")}


def test_what_a_model_has_already_is_not_named_again_and_its_number_is_mended(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(6, tmp_path)
    torque = on(1, lambda m, r: 2.0 * np.sign(m.v[:, 1]))(moves, rigid)
    believed = small_arm.model(tmp_path, effects=(JointEffect("coulomb_friction", "lift", {"Fc": 1.2}),))
    found = diagnose_arm([small_arm.noisy(moves, torque, 6)], believed)
    assert not small_arm.named(found)
    (kept,) = found.model.effects
    assert kept.parameters["Fc"] == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("joint", range(3))
def test_a_gain_of_one_joint_s_torque_is_no_matter_of_the_links(joint: int, tmp_path: Path) -> None:
    """Scaled links explain that joint as well as the gain does, and then the other joints no more."""
    moves, rigid = small_arm.rigid(7, tmp_path)
    torque = rigid * np.where(np.arange(3) == joint, 1.2, 1.0)
    found = diagnosed(tmp_path, torque, moves, 7)
    assert small_arm.named(found) == {("torque_gain", JOINTS[joint])}
    assert small_arm.values(found, "torque_gain", JOINTS[joint])["gain"] == pytest.approx(0.2, rel=0.02)


def test_gains_of_all_joints_are_called_in_question_and_what_is_not_told_is_listed(tmp_path: Path) -> None:
    """The same gain on every joint is links that are heavier; of the first one only what turns about its axis shows."""
    moves, rigid = small_arm.rigid(8, tmp_path)
    found = diagnosed(tmp_path, 1.2 * rigid, moves, 8)
    assert found.believed == "refit" and found.verdict == "parameters" and not small_arm.named(found)
    assert any("a gain of every torque, look alike" in note for note in found.notes)
    assert {"m", "mcz", "Ixx", "Iyy"} <= set(found.untold["post"])
