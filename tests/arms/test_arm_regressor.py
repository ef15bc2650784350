"""The regressor times a link's numbers is Drake's inverse dynamics, and its turns of gravity are a derivative."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import ArmModel, Held
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.regressor import regressor


def random_urdf(rng: np.random.Generator, kinds: tuple[str, ...]) -> str:
    """A chain of links of random numbers; a hand is welded to the last, and a branch hangs on the first."""
    names = ["l0"]
    parts = [
        '<link name="foot"/>',
        random_link(rng, "l0"),
        small_arm.joint("base", "foot", "l0", "0 0 0", kind="fixed"),
    ]
    for i, kind in enumerate(kinds, start=1):
        at = " ".join(f"{x:.3f}" for x in rng.uniform(-0.3, 0.3, 3))
        axis = rng.standard_normal(3)
        axis /= np.linalg.norm(axis)
        parts.append(random_link(rng, f"l{i}"))
        parts.append(small_arm.joint(f"j{i}", names[-1], f"l{i}", at, " ".join(f"{x:.9f}" for x in axis), kind))
        names.append(f"l{i}")
    parts += [random_link(rng, "hand"), small_arm.joint("weld", names[-1], "hand", "0.1 0 0.05", kind="fixed")]
    return small_arm.robot(*parts)


def random_link(rng: np.random.Generator, name: str) -> str:
    """A link that a body can be: its moments are those of some points."""
    points, m = 0.1 * rng.standard_normal((6, 3)), rng.uniform(0.5, 4.0)
    about = m / 6 * sum(p @ p * np.eye(3) - np.outer(p, p) for p in points - points.mean(0))
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    centre = rng.uniform(-0.2, 0.2, 3)
    return small_arm.link(name, m, tuple(centre), tuple(float(about[i, j]) for i, j in order))


def states(rng: np.random.Generator, joints: int) -> small_arm.Moves:
    q, v, a = (size * rng.uniform(-1.0, 1.0, (20, joints)) for size in (2.0, 3.0, 8.0))
    return small_arm.Moves(np.arange(20.0), q, v, a)


def drake(path: Path, moves: small_arm.Moves, gravity: Any) -> np.ndarray:
    plant = small_arm.plant_of(path, gravity)
    plant.Finalize()
    return small_arm.inverse_dynamics(plant, moves)


CHAINS = [("revolute",), ("revolute", "prismatic", "revolute"), ("prismatic", "revolute", "continuous", "revolute")]


@pytest.mark.parametrize("kinds", CHAINS, ids=lambda kinds: "-".join(kind[0] for kind in kinds))
@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (3.0, -2.0, 7.0)])
def test_regressor_times_nominal_numbers_is_drake_s_inverse_dynamics(
    kinds: tuple[str, ...], gravity: tuple[float, float, float], tmp_path: Path
) -> None:
    rng = np.random.default_rng(len(kinds))
    path = tmp_path / "random.urdf"
    path.write_text(random_urdf(rng, kinds))
    moves = states(rng, len(kinds))
    arm = ArmPlant.of(ArmModel(path, gravity=gravity))
    found = regressor(arm, moves.q, moves.v, moves.a).inertial @ arm.inertias().ravel()
    np.testing.assert_allclose(found, drake(path, moves, gravity), atol=1e-9)


def test_joints_that_were_not_recorded_rest_and_are_carried(tmp_path: Path) -> None:
    """The middle and the last joint of five were not recorded, and the log has the others in another order."""
    rng = np.random.default_rng(7)
    path = tmp_path / "random.urdf"
    path.write_text(random_urdf(rng, ("revolute", "prismatic", "revolute", "revolute", "prismatic")))
    recorded = ("j4", "j1", "j2")
    arm = ArmPlant.of(ArmModel(path, joints=recorded))
    assert arm.links == ("l4", "l1", "l2") and arm.slides == (False, False, True)
    moves = states(rng, 3)
    at = [3, 0, 1]
    whole = [np.zeros((20, 5)) for _ in range(3)]
    for full, own in zip(whole, (moves.q, moves.v, moves.a), strict=True):
        full[:, at] = own
    asked = drake(path, small_arm.Moves(moves.time, *whole), (0.0, 0.0, -9.81))[:, at]
    found = regressor(arm, moves.q, moves.v, moves.a).inertial @ arm.inertias().ravel()
    np.testing.assert_allclose(found, asked, atol=1e-9)


def test_columns_of_a_turn_of_gravity_are_a_derivative(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    path = tmp_path / "random.urdf"
    path.write_text(random_urdf(rng, ("revolute", "prismatic", "revolute")))
    arm, moves = ArmPlant.of(ArmModel(path)), states(rng, 3)
    tilted = np.einsum("njpk,p->njk", regressor(arm, moves.q, moves.v, moves.a).tilted, arm.inertias().ravel())
    step = 1e-5
    for k, axis in enumerate(np.eye(3)[:2]):
        gravity = np.array([0.0, 0.0, -9.81])
        turn = np.cross(axis, gravity)
        more, less = (drake(path, moves, tuple(gravity + sign * step * turn)) for sign in (1.0, -1.0))
        np.testing.assert_allclose(tilted[:, :, k], (more - less) / (2.0 * step), atol=1e-6)
    twice = drake(path, moves, (0.0, 0.0, -19.62)) - drake(path, moves, (0.0, 0.0, -9.81))
    np.testing.assert_allclose(tilted[:, :, 2], twice, atol=1e-9)


def test_what_is_held_is_part_of_its_link(tmp_path: Path) -> None:
    model = small_arm.model(tmp_path)
    at, m = np.array([0.2, 0.01, -0.03]), 0.7
    bare = ArmPlant.of(model).inertias()
    held = ArmPlant.of(small_arm.model(tmp_path, held=(Held("fore", m, tuple(at)),))).inertias()
    moments = m * (at @ at * np.eye(3) - np.outer(at, at))
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    more = np.array([m, *(m * at), *(moments[i, j] for i, j in order)])
    np.testing.assert_allclose(held - bare, np.array([np.zeros(10), np.zeros(10), more]), atol=1e-5)
