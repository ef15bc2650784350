"""Windows that are simulated forward: in open loop and behind the arm's own controller."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import small_arm

from mmt_drake.arms.arm_file import ArmModel, JointEffect, load_arm_model, save_arm_model
from mmt_drake.arms.believed import check_places
from mmt_drake.arms.forward import WINDOW_S, _Loop, forward
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.plant import ArmPlant
from mmt_drake.errors import BadInput
from mmt_drake.model.controller import Controller

INERTIA, FORCE = 0.5, 2.0
KP, KD = 300.0, 12.0
ROD = small_arm.robot(
    '<link name="foot"/>',
    small_arm.link("rod", 2.0, (0.0, 0.0, -0.5), (1e-9, 1e-9, 1e-9)),
    small_arm.joint("swing", "foot", "rod", "0 0 0", "0 1 0"),
)


def swinging(folder: Path, *controller: Controller) -> tuple[ArmModel, JointLog, list[tuple[float, float]]]:
    """A rod of 0.5 kg m^2 without gravity, whose model has a force that the rod has not; its log, and windows of it."""
    (folder / "rod.urdf").write_text(ROD)
    time = np.arange(0.0, 8.0, 0.005)
    w = 2.0 * np.pi * 0.5
    q, a = 0.4 * np.sin(w * time), -0.4 * w**2 * np.sin(w * time)
    force = JointEffect("constant_force", "swing", {"F": FORCE})
    model = ArmModel(folder / "rod.urdf", gravity=(0.0, 0.0, 0.0), effects=(force,), controller=controller)
    spans = [(float(start), float(start) + 0.4) for start in np.arange(1.0, 6.0, 0.5)]
    return model, JointLog("log", time, q[:, None], INERTIA * a[:, None], "tau"), spans


def test_in_open_loop_a_force_takes_the_joint_away_as_it_must(tmp_path: Path) -> None:
    model, log, spans = swinging(tmp_path)
    time = np.linspace(0.0, WINDOW_S, 2000)
    found = forward(model, log, spans)
    assert not found.closed and found.windows == len(spans)
    assert found.rms[0] == pytest.approx(np.sqrt(np.mean((0.5 * FORCE / INERTIA * time**2) ** 2)), rel=0.05)


def test_a_controller_holds_the_joint_as_its_equation_says(tmp_path: Path) -> None:
    """I e'' + kd e' + kp e = F from rest: a damped oscillation about F/kp."""
    model, log, spans = swinging(tmp_path, Controller("pd", kp=KP, kd=KD))
    time = np.linspace(0.0, WINDOW_S, 2000)
    s = KD / (2.0 * INERTIA)
    w = np.sqrt(KP / INERTIA - s**2)
    e = FORCE / KP * (1.0 - np.exp(-s * time) * (np.cos(w * time) + s / w * np.sin(w * time)))
    found = forward(model, log, spans)
    assert found.closed
    assert found.rms[0] == pytest.approx(np.sqrt(np.mean(e**2)), rel=0.05)


def test_a_controller_gives_no_more_than_its_limits_and_winds_up_no_further() -> None:
    loop = _Loop([Controller("pid", kp=10.0, ki=5.0, kd=1.0, low=-3.0, high=2.0)])
    one, zero = np.ones(1), np.zeros(1)
    for _ in range(1000):
        assert loop.torque(zero, one, zero, 0.01) == [2.0]
    assert loop.torque(zero, zero, zero, 0.01) == [0.0], "it waited while the torque was at its limit"
    assert loop.torque(zero, -one, zero, 0.01) == [-3.0]
    assert loop.torque(0.5 * one, zero, 0.25 * one, 0.01) == pytest.approx([0.75])


def test_an_integral_takes_away_what_stays(tmp_path: Path) -> None:
    loop = _Loop([Controller("pi", kp=0.0, ki=2.0)])
    one, zero = np.ones(1), np.zeros(1)
    given = [float(loop.torque(zero, 0.5 * one, zero, 0.01)[0]) for _ in range(101)]
    assert given[-1] == pytest.approx(2.0 * 0.5 * 1.0)


def test_controllers_are_read_from_a_model_file_and_written_again(tmp_path: Path) -> None:
    small_arm.written(tmp_path)
    one = "{kind: pd, gains: {kp: 40, kd: 1.5}, limits: 8}"
    (tmp_path / "arm.yaml").write_text(f"structure: multibody\nrobot: small.urdf\ncontroller: {one}\n")
    model = load_arm_model(tmp_path / "arm.yaml")
    assert model.controller == (Controller("pd", kp=40.0, kd=1.5, low=-8.0, high=8.0),)
    each = replace(model, controller=tuple(Controller("p", kp=float(k)) for k in (1, 2, 3)))
    save_arm_model(each, tmp_path / "each.yaml")
    assert load_arm_model(tmp_path / "each.yaml").controller == each.controller


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{kind: pdf, gains: {kp: 1}}", "controller.kind: found 'pdf'"),
        ("{kind: pd, gains: {kp: 1}}", "controller.gains: found kp, expected kd, kp of a pd"),
        ("[{kind: p, gains: {kp: 1}}, {kind: p, gains: {kp: -1}}]", "controller[1].kp"),
        ("[3]", "controller[0]"),
        ("7", "controller: found int, expected a list"),
    ],
)
def test_a_controller_that_is_none_is_refused_with_its_place(text: str, told: str, tmp_path: Path) -> None:
    small_arm.written(tmp_path)
    (tmp_path / "arm.yaml").write_text(f"structure: multibody\nrobot: small.urdf\ncontroller: {text}\n")
    with pytest.raises(BadInput) as error:
        load_arm_model(tmp_path / "arm.yaml")
    assert told in str(error.value)


def test_another_number_of_controllers_than_joints_is_refused(tmp_path: Path) -> None:
    model = small_arm.model(tmp_path, controller=(Controller("p", kp=1.0),) * 2)
    with pytest.raises(BadInput, match="found 2 controllers, expected 1, or 3: one for each joint"):
        check_places(ArmPlant.of(model), model)
