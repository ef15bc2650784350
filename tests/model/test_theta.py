"""Estimates as they cross the network: which of them can be integrated, and the kernel vector that they make."""

import numpy as np
import pytest

from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model.theta import NO_FLAW, NO_MODEL, TOO_STIFF, adopt_theta, flaw_of_theta, write_theta

MODEL = FlexibleBoxModel(BoxParameters(2.0, 30.0, 400.0, 5.0, 7.0), NormalContact(600.0, 8.0), Friction(0.5, 0.3, 0.01))
THETA, STEP = MODEL.theta(), 1e-5


def changed(**numbers):
    theta = THETA.copy()
    for at, number in numbers.items():
        theta[int(at[1:])] = number
    return theta


@pytest.mark.parametrize(
    ("theta", "flaw"),
    [(THETA, NO_FLAW), (changed(_0=1e-9), TOO_STIFF), (changed(_0=0.0), NO_MODEL), (changed(_0=-1.0), NO_MODEL)]
    + [(changed(**{f"_{i}": wrong}), NO_MODEL) for i in range(10) for wrong in (np.nan, np.inf)],
)
def test_an_estimate_is_a_model_if_it_is_finite_and_has_a_mass_that_the_steps_can_follow(theta, flaw):
    p = np.full(len(MODEL.kernel_vector()), 7.0)
    assert flaw_of_theta(theta, STEP) == flaw
    assert adopt_theta(theta, 1e-3, STEP, p) == (flaw == NO_FLAW)
    np.testing.assert_array_equal(p, MODEL.kernel_vector(1e-3) if flaw == NO_FLAW else 7.0)


@pytest.mark.parametrize(
    ("Fc", "Fs", "v_d"), [(0.3, 0.5, 0.01), (0.5, 0.3, 0.0), (-0.2, 0.4, 0.01), (-0.2, -0.3, -0.01)]
)
def test_a_negative_level_counts_as_none_and_a_break_away_level_below_it_as_it(Fc, Fs, v_d):
    p = np.empty(len(MODEL.kernel_vector()))
    write_theta(changed(_5=Fc, _8=Fs, _9=v_d), 1e-3, p)
    Fd = max(Fc, 0.0)
    meant = FlexibleBoxModel(MODEL.parameters, MODEL.normal, Friction(max(Fs, Fd), Fd, max(v_d, 0.0)))
    np.testing.assert_array_equal(p, meant.kernel_vector(1e-3))
