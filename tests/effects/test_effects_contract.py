"""What every effect of the library promises."""

import numpy as np
import pytest

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model import flexible_box as box
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel

NOMINAL = FlexibleBoxModel(BoxParameters(m=0.8, k1=0, k2=400, b1=5, b2=20))
TIME = np.arange(4000) * 1e-3
SOME = {"coulomb_friction": {"Fc": 0.7}, "static_friction": {"Fs": 0.9, "Fd": 0.6, "v_d": 0.004}}
SOME |= {"viscous_friction": {"b": 9.0}, "ground_spring": {"k": 60.0}}


def force_of(model):
    """Tangential force and body under a stroke that stops halfway, in contact throughout."""
    swing = np.minimum(TIME, 2.5)
    position, velocity = np.zeros((2, len(TIME), 3))
    position[:, 1], velocity[:, 1] = 0.03 * np.sin(6 * swing), np.where(TIME < 2.5, 0.18 * np.cos(6 * TIME), 0.0)
    position[:, 2] = -0.004
    force, body = np.empty((len(TIME), 3)), np.empty((len(TIME), 4))
    contact = np.full(len(TIME), box.CONTACT_BY_GEOMETRY)
    box.replay(TIME, position, velocity, contact, model.kernel_vector(), force, body)
    return force[:, 1], velocity[:, 1], body


def applied(name, values):
    return LIBRARY[name].apply(NOMINAL, LIBRARY[name].checked(values, "test"))


def test_every_effect_is_tried_here():
    assert set(SOME) == set(LIBRARY)


@pytest.mark.parametrize("name", LIBRARY)
def test_at_its_vanishing_value_it_changes_nothing(name):
    vanished = {p.symbol: p.vanishes_at for p in LIBRARY[name].parameters}
    np.testing.assert_allclose(force_of(applied(name, vanished))[0], force_of(NOMINAL)[0], atol=1e-9)


@pytest.mark.parametrize("name", LIBRARY)
def test_it_changes_the_force_where_it_is_there(name):
    assert np.abs(force_of(applied(name, SOME[name]))[0] - force_of(NOMINAL)[0]).max() > 0.05


@pytest.mark.parametrize("name", LIBRARY)
def test_it_is_passive(name):
    # The work that the probe puts in never falls below zero: nothing here is a source of energy.
    force, velocity, _ = force_of(applied(name, SOME[name]))
    power = -force * velocity
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * 1e-3)])
    assert work.min() > -1e-6


@pytest.mark.parametrize("name", LIBRARY)
def test_missing_unknown_and_impossible_parameters_are_refused(name):
    effect = LIBRARY[name]
    first = effect.parameters[0].symbol
    for wrong in ({}, {**SOME[name], "q": 1.0}, {**SOME[name], first: -1.0}, {**SOME[name], first: "much"}):
        with pytest.raises(BadInput, match="test: "):
            effect.checked(wrong, "test")
