"""A second encoder behind the gear tells a joint's spring, and when it is read; without a spring it tells none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import ArmModel, load_arm_model
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.elasticity import deflections
from mmt_drake.arms.joint_log import JointLog, load_joint_log
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.errors import BadInput

STIFFNESS, LATE_S = 4000.0, 0.002


def log_of(folder: Path, stiffness: float = STIFFNESS, late: float = LATE_S) -> JointLog:
    """The drive of one joint is ahead of its link by the torque over k; the second encoders are read later."""
    moves, rigid = small_arm.rigid(1, folder)
    ahead = moves.q + np.outer(rigid[:, 1] / stiffness, [0.0, 1.0, 0.0])
    read = np.stack([np.interp(moves.time - late, moves.time, column) for column in moves.q.T], 1)
    resolution = 2.0 * np.pi / 2**19
    link = np.round(read / resolution) * resolution
    return replace(small_arm.noisy(moves, rigid, 1), q=ahead, link=np.where([True, True, False], link, 0.0))


def told_of(log: JointLog, folder: Path) -> list[tuple[int, float, float]]:
    _, rigid = small_arm.rigid(1, folder)
    clock = ArmMotion.of(log, 8.0).time
    torque = np.stack([np.interp(clock, log.time, column) for column in rigid.T], 1)
    return [(one.joint, one.stiffness, one.late) for one in deflections([log], 8.0, [torque])]


def test_the_spring_and_the_lateness_of_the_second_encoder_are_told(tmp_path: Path) -> None:
    told = dict((j, (k, late)) for j, k, late in told_of(log_of(tmp_path), tmp_path))
    assert told[1] == pytest.approx((STIFFNESS, LATE_S), rel=0.05)
    assert 2 not in told, "a second encoder that stands still is none"


def test_a_stiff_joint_has_no_spring(tmp_path: Path) -> None:
    """Read exactly: what is apart then is the lateness of the encoder and its resolution."""
    assert told_of(log_of(tmp_path, stiffness=np.inf, late=0.0), tmp_path) == []


def test_a_diagnosis_names_the_spring_and_delivers_it(tmp_path: Path) -> None:
    found = diagnose_arm([log_of(tmp_path)], small_arm.model(tmp_path))
    assert ("joint_elasticity", "lift") in small_arm.named(found)
    (one,) = [e for e in found.effects if (e.name, e.where) == ("joint_elasticity", "lift")]
    assert one.certain == "law" and one.value("k") == pytest.approx(STIFFNESS, rel=0.1)
    assert any("Second encoders" in note and "lift (2 ms)" in note for note in found.notes)
    assert not any("looks like rotor inertia" in note for note in found.notes), "the encoders tell it"
    (kept,) = [e for e in found.model.effects if e.name == "joint_elasticity"]
    assert kept.parameters["k"] == one.value("k")


@pytest.mark.parametrize("ending", ["npz", "csv"])
def test_positions_of_links_are_read_from_a_log(ending: str, tmp_path: Path) -> None:
    log = log_of(tmp_path)
    path = tmp_path / f"log.{ending}"
    if ending == "npz":
        np.savez(path, t_s=log.time, q_rad=log.q, q_link_rad=log.link, tau_Nm=log.torque)
    else:
        names = [f"{what}_{j}" for what in ("q_rad", "q_link_rad", "tau_Nm") for j in range(3)]
        table = np.column_stack([log.time, log.q, log.link, log.torque])
        np.savetxt(path, table, delimiter=",", header=",".join(["t_s", *names]), comments="", fmt="%.12g")
    model: ArmModel = small_arm.model(tmp_path)
    read = load_joint_log(path, model, small_arm.JOINTS)
    assert read.link is not None and log.link is not None
    np.testing.assert_allclose(read.link, log.link, atol=1e-9)


def test_positions_of_links_that_are_no_numbers_are_refused(tmp_path: Path) -> None:
    log = log_of(tmp_path)
    link = np.array(log.link)
    link[7, 1] = np.nan
    np.savez(tmp_path / "log.npz", t_s=log.time, q_rad=log.q, q_link_rad=link, tau_Nm=log.torque)
    with pytest.raises(BadInput, match=r"link of .*, row 8: found nan"):
        load_joint_log(tmp_path / "log.npz", small_arm.model(tmp_path), small_arm.JOINTS)


def test_a_stiffness_in_a_model_file_is_no_mismatch_of_the_torque(tmp_path: Path) -> None:
    """With the spring in the model handed in, the drive's positions explain the torque."""
    (tmp_path / "small.urdf").write_text(small_arm.URDF)
    (tmp_path / "arm.yaml").write_text(
        "structure: multibody\nrobot: small.urdf\neffects:\n"
        "- {name: joint_elasticity, joint: lift, parameters: {k: 1500.0}}\n"
    )
    moves, rigid = small_arm.rigid(1, tmp_path)
    ahead = moves.q + np.outer(rigid[:, 1] / 1500.0, [0.0, 1.0, 0.0])
    log = replace(small_arm.noisy(moves, rigid, 1), q=ahead)
    found = diagnose_arm([log], load_arm_model(tmp_path / "arm.yaml"))
    assert not small_arm.named(found) and max(joint.nominal for joint in found.joints) < 0.03
