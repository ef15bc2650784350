"""Play of a transmission: found again where it is hidden, not found where it is not, by an integrator of its own."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numba import njit
from scipy.signal import lfilter

from mmt_drake.diagnosis.decide.alike import play_or_friction
from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.search.base import fit_base
from mmt_drake.diagrams.proof.trial.laws import Concealed
from mmt_drake.diagrams.proof.trial.one_axis import TransmissionSession
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import model_data, parse_model
from mmt_drake.recording.check import completed

RATIO, OFFSET, K, C = -0.5, 0.2, 20.0, 0.05
M = K / (2.0 * np.pi * 10.0) ** 2
B = 0.6 * np.sqrt(K * M)
NOISE = 1e-4
NAMES = ("viscous_friction", "coulomb_friction", "gear_play", "dead_band", "nonlinear_stiffness")
SOME = [LIBRARY[name] for name in NAMES]
GEARS = {"ratio": RATIO, "offset": OFFSET, "k": K, "b": B, "m": M, "c": C}


@njit
def geared(time, u, gap, substeps, friction=0.0):
    """Output (n,): flanks with a spring and a damper, and dry friction, by Euler steps that do not pass standstill."""
    h = (time[1] - time[0]) / substeps
    x, v, found = RATIO * u[0] + OFFSET, 0.0, np.empty_like(u)
    found[0] = x
    for i in range(len(u) - 1):
        rate = RATIO * (u[i + 1] - u[i]) / (time[1] - time[0])
        for j in range(substeps):
            ahead = RATIO * u[i] + rate * h * j + OFFSET - x
            force = -C * v
            if abs(ahead) > 0.5 * gap:
                force += K * (ahead - np.sign(ahead) * 0.5 * gap) + B * (rate - v)
            free = v + h * force / M
            v = np.sign(free) * max(abs(free) - h * friction / M, 0.0)
            x += h * v
        found[i + 1] = x
    return found


@njit
def played(place, half):
    """Output (n,) of play without inertia."""
    found = place.copy()
    for i in range(1, len(place)):
        found[i] = min(max(found[i - 1], place[i] - half), place[i] + half)
    return found


def turned(output, u):
    """The recording of an input and an output, both with the noise of an encoder."""
    random = np.random.default_rng(1)
    columns = {"input": u + 0.1 * NOISE * random.standard_normal(len(u)), "output": output.copy()}
    columns["output"] += NOISE * random.standard_normal(len(u))
    return completed(TIME, columns, "gears")


def said(recording, **parameters):
    model = parse_model({"structure": "transmission", "parameters": parameters})
    return diagnose([recording], model, library=SOME)


TIME = np.arange(2000) * 4e-3
_WAVES = [(0.3, 0.0), (0.7, 1.0), (1.6, 2.0), (2.9, 0.5)]
INPUT = sum(0.25 * (np.sin(2.0 * np.pi * f * TIME + phase) - np.sin(phase)) for f, phase in _WAVES)


@pytest.fixture(scope="module")
def hidden():
    """What is said of 30 mm of play that the model does not have, its other numbers 10 % off."""
    wrong = {name: value * (1.0 if name == "k" else 1.1) for name, value in GEARS.items()}
    return said(turned(geared(TIME, INPUT, 0.03, 100), INPUT), **wrong)


def test_hidden_play_is_named_and_measured(hidden):
    diagnosis = hidden.diagnosis
    assert [effect.name for effect in diagnosis.effects] == ["gear_play"], diagnosis.summary
    assert diagnosis.effects[0].parameters["gap"].value == pytest.approx(0.03, rel=0.01)
    assert diagnosis.verdict == "missing_physics" and diagnosis.effects[0].certain == "law"
    errors = diagnosis.fit.heldout_nrmse
    assert errors.augmented < 2.0 * diagnosis.fit.noise_floor < 0.1 * errors.refit


def test_the_augmented_model_handed_in_again_explains_the_recording(hidden):
    fitted = hidden.fits["augmented"]
    hypothesis = fitted.hypothesis
    found = hypothesis.nominal.with_parameters(**hypothesis.structure_values(fitted.x))
    augmented = parse_model(model_data(found, list(hypothesis.effect_values(fitted.x).items())))
    again = diagnose([turned(geared(TIME, INPUT, 0.03, 100), INPUT)], augmented, library=SOME)
    assert again.diagnosis.verdict == "no_mismatch", again.diagnosis.summary


def test_no_play_is_found_where_there_is_none():
    wrong = {name: value * (1.0 if name == "k" else 1.1) for name, value in GEARS.items()}
    diagnosis = said(turned(geared(TIME, INPUT, 0.0, 100), INPUT), **wrong).diagnosis
    assert diagnosis.verdict == "parameters" and not diagnosis.effects, diagnosis.summary
    for name in ("ratio", "offset"):
        assert diagnosis.parameters[name].value == pytest.approx(GEARS[name], rel=2e-3)


@pytest.mark.parametrize("pole", [0.6, 0.8])
def test_right_numbers_under_noise_that_is_not_white_are_no_mismatch_and_the_page_says_what_is_left(pole):
    white = 4.0 * NOISE * np.random.default_rng(5).standard_normal(len(TIME))
    coloured = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], white)
    recording = completed(TIME, {"input": INPUT, "output": geared(TIME, INPUT, 0.0, 10) + coloured}, "gears")
    diagnosis = said(recording, **GEARS).diagnosis
    assert diagnosis.tried > 0  # more is left than white noise would leave
    assert diagnosis.verdict == "no_mismatch" and not diagnosis.parameters, diagnosis.summary
    assert "more than white noise" in diagnosis.summary


RUBBING = {"ratio": 1.886, "offset": -0.04142, "k": 555.7, "b": 5.687, "m": 0.2132, "c": 1.545, "Fc": 0.2887}


def test_noise_of_the_input_s_encoder_does_not_free_an_output_that_friction_holds():
    recording = TransmissionSession(seed=4, noise=2.7e-5).record(RUBBING, ())
    diagnosis = said(recording, **RUBBING).diagnosis
    assert diagnosis.verdict == "no_mismatch" and diagnosis.tried == 0, diagnosis.summary


def test_a_drive_train_that_stiffens_is_named_beside_friction():
    hidden = Concealed("nonlinear_stiffness", {"k3": 1.4e8})
    recording = TransmissionSession(seed=4, noise=2.7e-5).record(RUBBING, (hidden,))
    diagnosis = said(recording, **RUBBING).diagnosis
    (named,) = diagnosis.effects
    assert (named.name, named.family, named.block) == ("nonlinear_stiffness", "drive_stiffness", "drive")
    assert named.certain == "law" and named.parameters["k3"].value == pytest.approx(1.4e8, rel=0.05)


def test_slow_play_may_as_well_be_friction_and_the_offset_need_not_be_known():
    slow = RATIO * INPUT + OFFSET
    diagnosis = said(turned(played(slow, 0.01), INPUT), ratio=1.1 * RATIO).diagnosis
    assert diagnosis.verdict == "ambiguous", diagnosis.summary
    named = {effect.name for effect in diagnosis.effects} | {
        a.name for a in diagnosis.alternatives if a.indistinguishable
    }
    assert named == {"gear_play", "coulomb_friction"}
    assert diagnosis.parameters["offset"].value == pytest.approx(OFFSET, abs=1e-3)
    assert diagnosis.fit.heldout_nrmse.augmented < 2.0 * diagnosis.fit.noise_floor


@pytest.mark.parametrize(("speed", "friction", "told"), [(0.1, 0.3, True), (1.0, 0.02, False)])
def test_where_the_motion_is_slow_friction_is_said_to_be_perhaps_play(speed, friction, told):
    slow = np.interp(speed * TIME, TIME, INPUT)
    recording = turned(geared(TIME, slow, 0.01, 100, friction), slow)
    model = parse_model({"structure": "transmission", "parameters": {**GEARS, "Fc": friction}})
    prepared = prepare([recording], model)
    assert prepared.fine is not None
    with ThreadPoolExecutor(1) as threads:
        _, fitted = fit_base(prepared.fine, model, prepared.skew, threads)
    found = play_or_friction(prepared.fine, fitted)
    assert [one.code for one in found] == (["play_or_friction"] if told else [])
    if told:
        assert fitted.model.Fc == pytest.approx(0.3 + 0.5 * K * 0.01, rel=0.05)
        assert 0.4 < found[0].figures["gap"] * K / (2.0 * fitted.model.Fc) < 1.0
