"""What joints say together of a payload or of the links, and what one of them may then have of its own."""

from pathlib import Path

import numpy as np
import small_arm

from mmt_drake.arms.beliefs import by_what_is_left, search_beside, searched, together
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.arms.problem import ArmProblem, arm_problem
from mmt_drake.arms.shared_fit import FREE_SAMPLES, Belief, SharedFit

GEARED, MASS = 0.8, 0.2


def with_payload_and_gearing(folder: Path) -> np.ndarray:
    """Torques of the small arm with a payload on its forearm, and a drive of `lift` geared with that of `bend`."""
    moves, _ = small_arm.rigid(4, folder)
    plant = small_arm.with_point(small_arm.plant_of(small_arm.written(folder)), "fore", MASS, (0.2, 0.03, 0.0))
    plant.Finalize()
    torque = small_arm.inverse_dynamics(plant, moves)
    torque[:, 1] += GEARED * torque[:, 2]
    return torque


def log_of(folder: Path) -> JointLog:
    """The small arm so loaded and geared."""
    moves, _ = small_arm.rigid(4, folder)
    return small_arm.noisy(moves, with_payload_and_gearing(folder), 4)


def problem_of(folder: Path, link: str = "fore") -> tuple[ArmProblem, Belief]:
    """What its log asks for, and the belief in a payload at a link."""
    model = small_arm.model(folder)
    problem = arm_problem(ArmPlant.of(model), model, [log_of(folder)])
    payload = next(t for t in problem.rows[0].terms if t.key == ("payload", link))
    return problem, Belief("payload", (payload,))


def test_a_payload_and_a_coupling_of_two_joints_are_both_named(tmp_path: Path) -> None:
    # By itself the joint takes its coupling for a heavier payload, which no other joint bears out.
    found = diagnose_arm([log_of(tmp_path)], small_arm.model(tmp_path))
    assert small_arm.named(found) == {("payload", "fore"), ("joint_coupling", "lift")}
    np.testing.assert_allclose(small_arm.values(found, "payload", "fore")["m"], MASS, rtol=0.03)
    np.testing.assert_allclose(small_arm.values(found, "joint_coupling", "lift")["gain"], GEARED, atol=0.01)


def test_what_other_joints_say_of_a_payload_is_the_fit_of_these_alone(tmp_path: Path) -> None:
    problem, belief = problem_of(tmp_path)
    weights = np.array([2.0, 3.0, 5.0])
    fit = SharedFit(problem, belief, {0: (), 1: (), 2: ()}, weights)
    known = fit.known_without(1)
    assert known is not None
    columns = list(belief.held[0].columns)
    rows = [
        np.sqrt(weights[j]) * np.column_stack([row.columns[taken][:, columns], row.target[taken]])
        for j in (0, 2)
        for row in (problem.rows[j],)
        for taken in (row.counted & np.isin(row.block, problem.inner),)
    ]
    a = np.concatenate(rows)
    np.testing.assert_allclose(
        known.held * weights[1] / FREE_SAMPLES, a[:, :-1].T @ a[:, :-1], rtol=1e-5, atol=1e-6 * np.abs(a).max()
    )
    expected = np.linalg.lstsq(a[:, :-1], a[:, -1], rcond=None)[0]
    np.testing.assert_allclose(a[:, :-1] @ known.middle, a[:, :-1] @ expected, atol=1e-3 * a[:, -1].std())


def test_searching_joints_together_never_leaves_more(tmp_path: Path) -> None:
    problem, belief = problem_of(tmp_path)
    alone = searched(problem, belief, np.ones(3))
    both = together(alone)
    assert both.cost < alone.cost
    assert {"joint_coupling"} == both.sets[1].names
    assert not both.sets[0].names | both.sets[2].names


def test_without_shared_numbers_a_joint_is_searched_by_itself(tmp_path: Path) -> None:
    problem, _ = problem_of(tmp_path)
    alone = searched(problem, Belief("none"), np.ones(3))
    assert alone.fit.known_without(1) is None
    assert search_beside(alone, 1).fit(alone.sets[1].terms).fit.cost == alone.sets[1].fit.cost
    np.testing.assert_array_less(0.0, by_what_is_left(alone))


def test_a_joint_that_tells_few_of_the_shared_numbers_is_searched_although_no_other_joint_tells_them(
    tmp_path: Path,
) -> None:
    problem, belief = problem_of(tmp_path, "post")  # which only turns
    alone = searched(problem, belief, np.ones(3))
    found = search_beside(alone, 0).fit(alone.sets[0].terms).fit
    assert np.isfinite(found.cost) and np.all(np.isfinite(found.x))
