"""A diagnosis of an arm heeds its time, says what there was no time for, and tells what is known when it is ended."""

from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.beliefs import OTHER_LINKS
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.folds import HELD, Folds, SharedNumbers
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.result import as_json
from mmt_drake.cli.main import main
from mmt_drake.diagnosis.search import watch as clocks
from mmt_drake.diagnosis.search.watch import Stage


@pytest.fixture
def log(tmp_path: Path) -> JointLog:
    """Of the small arm, with dry friction of 2 N m on a joint that the model has not."""
    moves, rigid = small_arm.rigid(1, tmp_path)
    rigid = rigid + np.outer(2.0 * np.sign(moves.v[:, 1]), [0.0, 1.0, 0.0])
    return small_arm.noisy(moves, rigid, 1)


def test_without_time_the_joints_alone_are_searched_and_the_rest_is_listed(log: JointLog, tmp_path: Path) -> None:
    found = diagnose_arm([log], small_arm.model(tmp_path), time_budget=0.0)
    assert {"other inertial numbers", "gravity_offset", "time_delay", "torque_gain"} <= set(found.untried)
    assert {f"payload of {link}" for link in small_arm.LINKS} <= set(found.untried)
    assert "what else it could be on lift" in found.untried and "windows of forward simulation" in found.untried
    assert [(e.name, e.where) for e in found.effects] == [("coulomb_friction", "lift")]
    assert not small_arm.named(found) and found.forward is None
    assert all(joint.refit is None for joint in found.joints)
    assert "There was no time to try ground spring, joint coupling" in found.summary
    document = as_json(found, "model.yaml")
    assert document["untried"] == list(found.untried)
    assert document["joints"][0]["heldout_nrmse"]["refit"] is None


def test_with_time_enough_nothing_is_left_untried(log: JointLog, tmp_path: Path) -> None:
    found = diagnose_arm([log], small_arm.model(tmp_path))
    assert found.untried == () and "no time" not in found.summary


def test_a_name_is_no_surer_than_what_there_was_time_for(
    log: JointLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The clock stops the beliefs about payloads; an offset of a joint might have been one."""
    offset = JointLog("log", log.time, log.q, log.torque + np.array([0.0, 0.0, 1.5]), "tau")
    surely = {e.where: e.certain for e in diagnose_arm([offset], small_arm.model(tmp_path)).effects}
    late = clocks.Watch.is_late

    def is_late(self: clocks.Watch) -> bool:
        return self._stage.name.startswith("a payload") or late(self)

    monkeypatch.setattr(clocks.Watch, "is_late", is_late)
    hasty = {e.where: e.certain for e in diagnose_arm([offset], small_arm.model(tmp_path)).effects}
    assert surely == {"lift": "law", "bend": "law"} and hasty == {"lift": "law", "bend": "block"}


def test_what_is_known_is_told_when_it_is_ended(log: JointLog, tmp_path: Path) -> None:
    def ended(stage: Stage) -> None:
        if stage.name == OTHER_LINKS:
            raise KeyboardInterrupt

    answers: list[str] = []
    with pytest.raises(KeyboardInterrupt, match=r"so far the error over the noise is .* Coulomb friction on lift"):
        diagnose_arm([log], small_arm.model(tmp_path), on_stage=ended, on_answer=answers.append)
    assert answers and "Coulomb friction on lift added" in answers[0]


def test_ctrl_c_ends_the_command_with_what_is_known(
    log: JointLog, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    np.savez(tmp_path / "log.npz", t_s=log.time, q_rad=log.q, tau_Nm=log.torque)
    (tmp_path / "arm.yaml").write_text("structure: multibody\nrobot: small.urdf\n")
    begin = clocks.Watch.begin

    def interrupted(self: clocks.Watch, stage: str) -> None:
        begin(self, stage)
        if stage == OTHER_LINKS:
            raise KeyboardInterrupt

    monkeypatch.setattr(clocks.Watch, "begin", interrupted)
    files = ["diagnose", tmp_path / "log.npz", "--model", tmp_path / "arm.yaml", "--out", tmp_path]
    status = main([str(file) for file in files])
    assert status == 130
    assert "interrupted; so far the error over the noise is" in capfd.readouterr().err


@pytest.mark.parametrize("free", [0, 4])
def test_folds_are_held_out_as_if_each_were_fitted_by_itself(free: int) -> None:
    """Against least squares on the rows of the other folds, what is known of shared numbers as further rows."""
    rng = np.random.default_rng(3)
    blocks, rows, columns = 6, 30, 9
    x, y = rng.normal(size=(blocks, rows, columns)), rng.normal(size=(blocks, rows))
    sums = (
        np.einsum("bij,bik->bjk", x, x),
        np.einsum("bij,bi->bj", x, y),
        np.einsum("bi,bi->b", y, y),
        np.full(blocks, float(rows)),
    )
    root, middle = rng.normal(size=(free, free)), rng.normal(size=free)
    shared = SharedNumbers(range(free), middle, root.T @ root) if free else None
    chosen = [5, 7]
    used = [*range(free), *chosen]
    held = np.hstack([root, np.zeros((free, len(chosen)))])

    def fitted(others: list[int]) -> np.ndarray:
        a = np.vstack([*(x[b][:, used] for b in others), held])
        return np.linalg.lstsq(a, np.concatenate([*(y[b] for b in others), root @ middle]), rcond=None)[0]

    found = Folds(sums, range(blocks), shared).fit(chosen)
    expected = []
    for b in range(blocks):
        left = y[b] - x[b][:, used] @ fitted([other for other in range(blocks) if other != b])
        expected.append((left**2).mean())
    np.testing.assert_allclose(found.held_out, expected, rtol=100 * HELD)
    np.testing.assert_allclose(found.x, fitted(list(range(blocks))), rtol=100 * HELD)
