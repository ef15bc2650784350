"""A log that lacks samples is used for the rest; one in other units, or without torques, is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import JointLog, load_joint_log
from mmt_drake.arms.motion import gaps
from mmt_drake.errors import BadInput


def without(log: JointLog, begins: float, ends: float) -> JointLog:
    """The log without what was sampled between two times."""
    kept = (log.time <= begins) | (log.time >= ends)
    return replace(log, time=log.time[kept], q=log.q[kept], torque=log.torque[kept])


@pytest.mark.parametrize("length", [0.1, 0.5, 2.0])
def test_what_was_not_sampled_is_no_physics(length: float, tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(3, tmp_path)
    log = without(small_arm.noisy(moves, rigid, 3), 11.0, 11.0 + length)
    found = diagnose_arm([log], small_arm.model(tmp_path))
    assert (found.verdict, small_arm.named(found)) == ("no_mismatch", set())
    assert [note for note in found.notes if f"lacks {length:.2g} s" in note]


def test_dry_friction_is_found_beside_a_gap(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(3, tmp_path)
    torque = rigid + np.outer(np.sign(moves.v[:, 1]), [0.0, 2.0, 0.0])
    found = diagnose_arm([without(small_arm.noisy(moves, torque, 3), 11.0, 13.0)], small_arm.model(tmp_path))
    assert small_arm.named(found) == {("coulomb_friction", "lift")}
    assert small_arm.values(found, "coulomb_friction", "lift")["Fc"] == pytest.approx(2.0, rel=0.02)


def test_an_uneven_clock_has_no_gaps() -> None:
    time = np.cumsum(np.random.default_rng(0).uniform(0.006, 0.014, 3000))
    assert len(gaps(time, 8.0)) == 0
    np.testing.assert_allclose(gaps(np.concatenate([time, time + time[-1] + 0.5]), 8.0)[:, 0], [time[-1]])


def test_positions_in_degrees_are_refused_with_what_to_do(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    log = small_arm.noisy(moves, rigid, 1)
    np.savez(tmp_path / "log.npz", t_s=log.time, q_rad=np.degrees(log.q), tau_Nm=log.torque)
    text = "structure: multibody\nrobot: small.urdf\n"
    models = []
    for name, more in (("plain", ""), ("turned", "position: {factor: 0.017453292519943295}\n")):
        (tmp_path / f"{name}.yaml").write_text(text + more)
        models.append(load_arm_model(tmp_path / f"{name}.yaml"))
    plain, turned = models
    with pytest.raises(
        BadInput, match=r"position of turn: found a way of .* rad.*expected radians.*position: \{factor"
    ):
        diagnose_arm([load_joint_log(tmp_path / "log.npz", plain, small_arm.JOINTS)], plain)
    read = load_joint_log(tmp_path / "log.npz", turned, small_arm.JOINTS)
    np.testing.assert_allclose(read.q, log.q, atol=1e-12)
    assert diagnose_arm([read], turned).verdict == "no_mismatch"


def test_torques_in_thousandths_are_refused_with_what_to_do(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    log = small_arm.noisy(moves, 1e3 * (rigid + 2.0 * np.sign(moves.v)), 1)
    with pytest.raises(BadInput, match=r"torque: found .* times what the links ask for on lift.*torque: \{factor"):
        diagnose_arm([log], small_arm.model(tmp_path))


def test_torques_that_stand_still_are_refused(tmp_path: Path) -> None:
    moves, rigid = small_arm.rigid(1, tmp_path)
    log = JointLog("log.csv", moves.time, moves.q, np.zeros_like(rigid), "tau")
    with pytest.raises(BadInput, match=r"log\.csv: torque \(tau\): found the same throughout"):
        diagnose_arm([log], small_arm.model(tmp_path))
