"""The message from an estimator to a renderer: what it takes, what it refuses, the wire."""

import math

import numpy as np
import pytest

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model_message import (
    MESSAGE_SIZE,
    STRUCTURE,
    UNKNOWN_THETA,
    ModelMessage,
    NotFelt,
    SensorError,
    ToldEffect,
    box_of,
    code_of,
)

THETA = tuple(FlexibleBoxModel(BoxParameters(Fc=0.3)).theta().tolist())
CUBIC = ToldEffect("nonlinear_stiffness", {"k3": 3e6}, {"k3": 1e4})
LUGRE = ToldEffect("presliding_friction", {"sigma0": 600.0, "sigma1": 1.0, "Fs": 0.4, "v_s": 0.01})
MESSAGE = ModelMessage(THETA, (CUBIC, LUGRE), 7, 41, SensorError(bias=0.3, tau=0.01))


def test_it_crosses_the_wire_and_nothing_is_lost():
    assert ModelMessage.from_vector(MESSAGE.vector()) == MESSAGE
    assert MESSAGE.vector().shape == (MESSAGE_SIZE,)


def test_numbers_that_are_not_known_cross_as_nan():
    again = ModelMessage.from_vector(ModelMessage(UNKNOWN_THETA).vector())
    assert np.isnan(again.theta).all() and again.number == 1


def test_what_the_force_sensor_adds_is_told_in_words():
    assert MESSAGE.sensor.words == ["force bias (bias = 0.3 N)", "force lag (tau = 0.01 s)"]


def test_zeros_are_no_message():
    assert ModelMessage.from_vector(np.zeros(MESSAGE_SIZE)) is None


def test_names_are_told_apart_by_their_sums():
    assert len({code_of(name) for name in (*LIBRARY, STRUCTURE)} | {0.0}) == len(LIBRARY) + 2


@pytest.mark.parametrize(
    ("effect", "why"),
    [
        (("force_bias", {"bias": 0.1}), "never felt"),
        (("time_delay", {"delay": 0.1}), "never felt"),
        (("nonlinear_stiffness", {"k3": -1e5}), "k3 = -100000, expected values that give no energy .* k3 >= 0"),
        (("hysteresis", {"alpha": 9.0, "beta": 5.0, "gamma": 6.0}), "gamma. <= beta"),
        (("presliding_friction", {"sigma0": 6e2, "sigma1": 99.0, "Fs": 0.9}), "sigma1 .Fs - Fc. <= b min"),
        (("constant_force", {"F": 1.0}), "of which nobody knows any"),
        (("stiffness_drift", {"rate": 0.1}), "of which nobody knows any"),
        (("coulomb_friction", {"Fc": 0.1}), "told by that"),
        (("mass_change", {"time": 1.0, "dm": -0.1}), "no law with numbers"),
        (("normal_stiffness_drift", {"rate": 0.1}), "of which nobody knows any"),
    ],
)
def test_what_must_not_or_cannot_be_felt_is_refused_with_the_reason(effect, why):
    with pytest.raises(NotFelt, match=why):
        ModelMessage(THETA, effects=(ToldEffect(*effect),))


@pytest.mark.parametrize(
    ("effects", "why"),
    [
        ([("levitation", {"k": 1.0})], "name: found 'levitation'"),
        ([("nonlinear_stiffness", {})], "parameters none, expected k3"),
        ([("hunt_crossley_damping", {"lambda": -1.0})], "lambda: found -1, expected a finite value from 0"),
        ([("nonlinear_stiffness", {"k3": math.nan})], "k3"),
        ([("nonlinear_stiffness", {"k3": 1.0})] * 2, "nonlinear_stiffness beside nonlinear_stiffness"),
        ([("nonlinear_stiffness", {"k3": 1.0}), ("quadratic_drag", {"c": 1.0}), ("end_stop", {})], "2 at most"),
    ],
)
def test_effects_that_are_unknown_out_of_bounds_or_too_many_are_refused(effects, why):
    with pytest.raises(BadInput, match=why):
        ModelMessage(THETA, effects=tuple(ToldEffect(*effect) for effect in effects))


@pytest.mark.parametrize(
    ("at", "value", "why"),
    [
        (0, 1.0, "version: found 1, expected 2"),
        (1, 5.0, "structure: found 5"),
        (2, 0.5, "object: found 0.5"),
        (3, 0.0, "number: found 0"),
        (3, math.nan, "number: found nan"),
        (4, math.inf, "theta.m: found inf"),
        (14, math.nan, "force_bias: found nan"),
        (17, -0.1, "force_lag: found -0.1, expected a finite number >= 0"),
        (18, 12345.0, "effects: found 12345, expected the sum of an effect known here"),
        (19, math.nan, "k3"),
    ],
)
def test_a_vector_that_is_not_sound_is_refused(at, value, why):
    vector = MESSAGE.vector()
    vector[at] = value
    with pytest.raises(BadInput, match=why):
        ModelMessage.from_vector(vector)


def test_a_clearance_is_told_and_has_no_law_of_its_own():
    gap, cubic = ToldEffect("contact_gap", {"gap": 0.002}), ToldEffect("nonlinear_stiffness", {"k3": 1e6})
    message = ModelMessage.from_vector(ModelMessage(THETA, effects=(gap, cubic)).vector())
    assert message is not None and message.clearance == 0.002
    assert [effect.name for effect, _ in message.acting] == ["nonlinear_stiffness"]


@pytest.mark.parametrize(
    "law", [("hysteresis", {"alpha": 9.0, "beta": 5.0}), ("viscoelastic_relaxation", {"k_maxwell": 9.0, "tau": 0.1})]
)
def test_a_clearance_is_not_felt_beside_a_law_of_the_contact_with_a_memory(law):
    with pytest.raises(NotFelt, match=r"contact_gap: found .* beside it, expected no law of the contact with a memory"):
        ModelMessage(THETA, effects=(ToldEffect("contact_gap", {"gap": 0.002}), ToldEffect(*law)))


def test_a_number_that_is_left_to_a_theta_that_is_not_known_is_refused():
    bristles = ToldEffect("presliding_friction", {"sigma0": 600.0})
    assert ModelMessage(THETA, effects=(bristles,)).acting
    with pytest.raises(BadInput, match=r"presliding_friction\.Fs: found none, expected a value: that of Fc"):
        ModelMessage(UNKNOWN_THETA, effects=(bristles,))


def test_estimates_below_zero_count_as_zero_where_laws_are_checked():
    scattered = list(THETA)
    scattered[1], scattered[5] = -3.0, -0.1
    assert box_of(scattered).parameters == BoxParameters(Fc=0.0)
