"""The trial's driven body and Kelvin-Voigt contact: closed forms, and the model they have to agree with."""

import math

import numpy as np
import pytest
from scipy.signal import TransferFunction, lsim
from trial_plant_samples import VANISHED

from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import DrivenSession, MaterialSession, TransmissionSession, run_servo
from mmt_drake.diagrams.proof.trial.other_cases import DRIVEN, MATERIAL
from mmt_drake.diagrams.proof.trial.physics import Physics
from mmt_drake.model_files import parse_model
from mmt_drake.simulation import simulate

CARRIAGE = {"m": 1.2, "b": 8.0, "k": 60.0, "Fc": 0.5, "offset": 0.2, "gravity": 0.0, "pendulum": 0.0}
MATERIAL_BASE = {"k": 400.0, "b": 15.0, "x0": 0.02, "F0": 0.0}


def test_a_driven_body_is_pushed_at_constant_speed_with_the_force_that_its_friction_takes() -> None:
    time = np.arange(3001) * 1e-3
    physics = Physics(m=0.8, b_plus=5.0, b_minus=9.0, Fd_plus=0.4, Fs_plus=0.7, v_s=0.05, c=30.0, F=0.1)
    command, position = run_servo(time, 0.1 * time, np.full_like(time, 0.1), (300.0, 30.0), physics)
    level = 0.4 + 0.3 * math.exp(-((0.1 / 0.05) ** 2))
    assert command[-1] == pytest.approx(5.0 * 0.1 + level + 30.0 * 0.1**2 - 0.1, rel=1e-5)
    assert np.diff(position)[-1] == pytest.approx(1e-4, rel=1e-6)


def test_a_body_at_rest_is_held_below_the_break_away_level_of_either_direction() -> None:
    time = np.arange(2001) * 1e-3
    for sign, level in ((1.0, 0.7), (-1.0, 0.3)):
        physics = Physics(Fd_plus=0.7, Fs_plus=0.7, Fd_minus=0.3, Fs_minus=0.3)
        command, position = run_servo(time, sign * time, np.full_like(time, sign), (1.0, 0.0), physics)
        moved = int(np.argmax(position != 0.0))
        assert abs(command[moved]) == pytest.approx(level, abs=2e-3)


@pytest.mark.parametrize("pendulum", [0.0, 4.0])
def test_the_driven_body_agrees_with_the_model(pendulum: float) -> None:
    base = {**CARRIAGE, "pendulum": pendulum}
    recording = DrivenSession(3, noise=0.0).record(base, ())
    file = {"structure": "driven_body", "parameters": {name: base[name] for name in ("m", "b", "k", "Fc", "offset")}}
    if pendulum:
        file["gravity"] = {"kind": "pendulum", "value": pendulum}
    output = simulate(parse_model(file), recording)["output"]
    assert np.sqrt(np.mean((output - recording["output"]) ** 2)) < 2e-4 * np.std(recording["output"])


GEARS = {"ratio": -0.7, "offset": 0.02, "k": 400.0, "b": 2.0, "m": 0.1, "c": 1.0, "Fc": 0.2}


@pytest.mark.parametrize("gap", [0.0, 0.003])
def test_the_transmission_agrees_with_the_model(gap: float) -> None:
    play = (Concealed("gear_play", {"gap": gap}),) if gap else ()
    recording = TransmissionSession(3, noise=0.0).record(GEARS, play)
    file = {"structure": "transmission", "parameters": GEARS}
    file["effects"] = [{"name": effect.name, "parameters": dict(effect.parameters)} for effect in play]
    output = simulate(parse_model(file), recording)["output"]
    assert np.sqrt(np.mean((output - recording["output"]) ** 2)) < 1e-3 * np.std(recording["output"])


def test_the_material_agrees_with_the_model() -> None:
    recording = MaterialSession(3, noise=0.0).record({**MATERIAL_BASE, "F0": 0.3}, ())
    file = {"structure": "kelvin_voigt", "parameters": {**MATERIAL_BASE, "F0": 0.3}}
    force = simulate(parse_model(file), recording)["force"]
    noise = 400.0 * 1e-5 + 15.0 * 5e-4  # of the recorded motion, through the model
    assert np.sqrt(np.mean((force - recording["force"]) ** 2)) < noise


DRIVEN_VANISHED = VANISHED | {
    "asymmetric_viscous_friction": {"b_plus": 8.0, "b_minus": 8.0},
    "asymmetric_friction": {"Fc_plus": 0.5, "Fc_minus": 0.5},
    "stribeck_friction": {"Fs": 0.5, "v_s": 0.02},
    "mass_change": {"time": 10.0, "dm": 0.0},
    "input_lag": {"tau": 0.0},
}


@pytest.mark.parametrize("name", DRIVEN)
def test_a_driven_body_s_effect_at_its_vanishing_value_changes_nothing(name: str) -> None:
    session = DrivenSession(5)
    without, effect = session.record(CARRIAGE, ()), Concealed(name, DRIVEN_VANISHED[name])
    assert np.array_equal(session.record(CARRIAGE, (effect,))["output"], without["output"])


def test_a_drive_lags_behind_its_command_as_scipys_low_pass() -> None:
    session, tau = DrivenSession(5), 0.02
    drive, command = (
        session.record(CARRIAGE, effects)["input"] for effects in ((), (Concealed("input_lag", {"tau": tau}),))
    )
    lagged = drive[0] + lsim(TransferFunction([1.0], [tau, 1.0]), command - drive[0], np.arange(len(drive)) * 1e-3)[1]
    np.testing.assert_allclose(lagged[200:], drive[200:], atol=2e-3 * np.abs(drive).max())


@pytest.mark.parametrize("name", MATERIAL)
def test_a_material_s_effect_at_its_vanishing_value_changes_nothing(name: str) -> None:
    session = MaterialSession(5)
    effect = Concealed(name, {**VANISHED, "hardening_relaxation": {"k3_maxwell": 0.0, "tau": 0.1}}[name])
    same = session.true_reading(MATERIAL_BASE, (effect,))
    assert np.array_equal(same, session.true_reading(MATERIAL_BASE, ()))


def fine_deflection(session: MaterialSession) -> np.ndarray:
    """What is pressed, every 0.1 ms."""
    d = session.record({**MATERIAL_BASE, "x0": 0.0}, ())["position"]  # its noise is 1e-5 m, of several mm
    return np.interp(np.arange(0.0, 3.0, 1e-4), np.arange(len(d)) * 1e-3, np.convolve(d, np.ones(9) / 9.0, "same"))


def test_of_the_material_s_hardening_branch_the_cube_of_the_deflection_relaxes() -> None:
    """q' = (d^3 - q)/tau, by explicit steps a hundred times finer."""
    session, k3, tau = MaterialSession(7), 1e6, 0.3
    effect = Concealed("hardening_relaxation", {"k3_maxwell": k3, "tau": tau})
    force = session.true_reading(MATERIAL_BASE, (effect,)) - session.true_reading(MATERIAL_BASE, ())
    fine = fine_deflection(session)
    q, found = 0.0, []
    for cube in fine[1:] ** 3:
        q += 1e-4 * (cube - q) / tau
        found.append(cube - q)
    reached = -k3 * np.array(found)[9::10]
    assert np.sqrt(np.mean((force[1 : len(reached) + 1] - reached) ** 2)) < 0.03 * np.std(reached)


def test_the_material_s_hysteresis_solves_bouc_and_wen_s_equation() -> None:
    """z' = d' - beta |d'| z - beta d' |z|, by explicit steps a hundred times finer."""
    session, alpha, beta = MaterialSession(7), 200.0, 150.0
    effect = Concealed("hysteresis", {"alpha": alpha, "beta": beta})
    force = session.true_reading(MATERIAL_BASE, (effect,)) - session.true_reading(MATERIAL_BASE, ())
    fine = fine_deflection(session)
    z, found = 0.0, []
    for step in np.diff(fine):
        z += step - beta * abs(step) * z - beta * step * abs(z)
        found.append(z)
    reached = -alpha * np.array(found)[9::10]
    assert np.sqrt(np.mean((force[1 : len(reached) + 1] - reached) ** 2)) < 0.03 * np.std(reached)
