"""What looks like an effect and is none has no name; what seldom comes alone is found beside others."""

from pathlib import Path

import numpy as np
import pytest
import small_arm
from scipy.spatial.transform import Rotation
from small_arm import Moves

from mmt_drake.arms.arm_file import JointEffect
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.result import ArmDiagnosis

DRY = 3.0


def torques(
    folder: Path, seed: int, *, rx: float = 0.0, ry: float = 0.0, load_kg: float = 0.0
) -> tuple[Moves, np.ndarray]:
    """A motion of the small arm on a foot that is turned, with a load, by Drake alone."""
    moves = small_arm.sines(3, seed)
    turned = Rotation.from_rotvec([rx, ry, 0.0]).apply([0.0, 0.0, -9.81])
    plant = small_arm.plant_of(small_arm.written(folder), tuple(turned))
    if load_kg:
        small_arm.with_point(plant, "fore", load_kg, (0.3, 0.03, -0.02))
    plant.Finalize()
    return moves, small_arm.inverse_dynamics(plant, moves)


def later(moves: Moves, torque: np.ndarray, seconds: float) -> np.ndarray:
    """Torques that come later."""
    return np.stack([np.interp(moves.time - seconds, moves.time, column) for column in torque.T], 1)


def bristles(moves: Moves, metres: float) -> np.ndarray:
    """Dry friction of 1 N m on each joint that gives way over a few milliradians before it slips (Dahl), by Euler."""
    z, found = np.zeros(moves.q.shape[1]), []
    parts = np.linspace(0.0, 1.0, 41)[:-1]
    step = (moves.time[1] - moves.time[0]) / len(parts)
    for v, following in zip(moves.v, np.roll(moves.v, -1, axis=0), strict=True):
        found.append(z / metres)
        for part in parts:
            speed = v + part * (following - v)
            z = z + step * (speed - np.abs(speed) * z / metres)
    return np.array(found)


def found_in(folder: Path, moves: Moves, torque: np.ndarray, *effects: JointEffect) -> ArmDiagnosis:
    return diagnose_arm([small_arm.noisy(moves, torque, 5)], small_arm.model(folder, effects=effects))


@pytest.mark.parametrize("angles", [(0.03, 0.0), (0.0, 0.03), (0.0, -0.1)])
def test_a_foot_turned_about_one_axis_alone_is_found(angles: tuple[float, float], tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3, rx=angles[0], ry=angles[1])
    found = found_in(tmp_path, moves, torque)
    assert small_arm.named(found) == {("gravity_offset", "")}
    told = small_arm.values(found, "gravity_offset", "")
    assert (told["rx"], told["ry"]) == pytest.approx(angles, abs=0.001)


def test_a_turn_that_the_model_has_and_the_arm_has_not_is_taken_back(tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3)
    found = found_in(tmp_path, moves, torque, JointEffect("gravity_offset", "", {"rx": 0.05, "ry": -0.1}))
    told = {e.name: e.parameters for e in found.model.effects}["gravity_offset"]
    assert (told["rx"], told["ry"]) == pytest.approx((0.0, 0.0), abs=1e-3)
    assert max(joint.augmented for joint in found.joints) < 0.02


def test_a_payload_on_an_arm_whose_foot_is_turned_is_found_with_that(tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3, ry=0.03, load_kg=0.8)
    found = found_in(tmp_path, moves, torque)
    assert small_arm.named(found) == {("gravity_offset", ""), ("payload", "fore")}
    assert small_arm.values(found, "payload", "fore")["m"] == pytest.approx(0.8, rel=0.02)
    assert small_arm.values(found, "gravity_offset", "")["ry"] == pytest.approx(0.03, abs=0.001)


def test_a_late_torque_of_an_arm_with_a_payload_is_found_with_that(tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3, load_kg=0.8)
    found = found_in(tmp_path, moves, later(moves, torque, 0.008))
    assert small_arm.named(found) == {("time_delay", ""), ("payload", "fore")}
    assert small_arm.values(found, "time_delay", "")["delay"] == pytest.approx(0.008, rel=0.05)


KNOWN = tuple(JointEffect("coulomb_friction", joint, {"Fc": DRY}) for joint in small_arm.JOINTS)


def test_friction_that_gives_way_is_no_late_torque(tmp_path: Path) -> None:
    # Its torque turns over later than the motion does; under way it does not lag.
    moves, torque = torques(tmp_path, 3)
    found = found_in(tmp_path, moves, torque + DRY * bristles(moves, 2e-3), *KNOWN)
    assert not [e for e in found.effects if e.name in ("time_delay", "force_lag")], small_arm.named(found)


def test_a_late_torque_beside_known_friction_is_found(tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3)
    found = found_in(tmp_path, moves, later(moves, torque + DRY * np.sign(moves.v), 0.008), *KNOWN)
    assert small_arm.named(found) == {("time_delay", "")}


@pytest.mark.parametrize("curved", [1.0, 0.1])
def test_a_curve_over_the_way_is_no_offset_although_it_has_a_mean(curved: float, tmp_path: Path) -> None:
    moves, torque = torques(tmp_path, 3)
    q = moves.q[:, 1] - moves.q[:, 1].mean()
    pull = 2.0 + curved * np.cos(4.0 * q / np.abs(q).max())
    found = found_in(tmp_path, moves, torque + np.outer(pull, [0.0, 1.0, 0.0]))
    offset = ("constant_force", "lift") in small_arm.named(found)
    assert offset == (curved < 0.5), found.summary
    assert found.places == ("lift",) or curved > 0.5
