"""Estimates as they cross the network: which of them can be integrated, and the kernel vector that they make."""

import numpy as np
import pytest

from mmt_drake.model.parameters import THETA, BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model.theta import NO_FLAW, NO_MODEL, TOO_STIFF, adopt_theta, flaw_of_theta, write_theta

MODEL = FlexibleBoxModel(
    BoxParameters(2.0, 30.0, 400.0, 5.0, 7.0), NormalContact(600.0, 8.0), Friction(0.5, 0.3, 0.01), "per_axis"
)


def changed(**numbers):
    return np.array(list((dict(zip(THETA, MODEL.theta(), strict=True)) | numbers).values()))


@pytest.mark.parametrize(
    ("theta", "flaw"),
    [(changed(), NO_FLAW), (changed(m=1e-9), TOO_STIFF), (changed(m=0.0), NO_MODEL), (changed(m=-1.0), NO_MODEL)]
    + [(changed(**{symbol: wrong}), NO_MODEL) for symbol in THETA for wrong in (np.nan, np.inf)],
)
def test_an_estimate_is_a_model_if_it_is_finite_and_has_a_mass_that_the_steps_can_follow(theta, flaw):
    p = np.full(len(MODEL.kernel_vector()), 7.0)
    assert flaw_of_theta(theta, 1e-5) == flaw and adopt_theta(theta, 1e-3, 1e-5, 0.0, p) == (flaw == NO_FLAW)
    np.testing.assert_array_equal(p, MODEL.kernel_vector(1e-3) if flaw == NO_FLAW else 7.0)


@pytest.mark.parametrize(
    ("Fc", "Fs", "v_d"), [(0.3, 0.5, 0.01), (0.5, 0.3, 0.0), (-0.2, 0.4, 0.01), (-1.0, -0.3, -1.0)]
)
def test_a_negative_level_counts_as_none_and_a_break_away_level_below_it_as_it(Fc, Fs, v_d):
    p, Fd = np.empty(len(MODEL.kernel_vector())), max(Fc, 0.0)
    write_theta(changed(Fc=Fc, Fs=Fs, v_d=v_d), 1e-3, 0.0, p)
    meant = FlexibleBoxModel(MODEL.parameters, MODEL.normal, Friction(max(Fs, Fd), Fd, max(v_d, 0.0)), "per_axis")
    np.testing.assert_array_equal(p, meant.kernel_vector(1e-3))
