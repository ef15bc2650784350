"""Offsets between signals: closed forms for lines and sines, and the error that is told for them."""

import math

import numpy as np
import pytest

from mmt_drake.diagnosis.signals.lags import best_lag, products

RATE = 250.0
TIME = np.arange(5000) / RATE


def causes(time: np.ndarray) -> np.ndarray:
    """A position of three sines and its rate."""
    w = 2.0 * np.pi * np.array([0.3, 1.1, 2.7])
    return np.column_stack([np.sin(time[:, None] * w).sum(axis=1), (w * np.cos(time[:, None] * w)).sum(axis=1)])


@pytest.mark.parametrize("offset", [0.0, 0.12, -0.3, 0.0413, -0.0018])
def test_coefficients_and_an_offset_between_samples_come_back(offset: float):
    fit = best_lag(causes(TIME), causes(TIME - offset) @ [3.0, -0.2], 0.6, RATE, 10.0)
    assert fit is not None
    assert fit.offset == pytest.approx(offset, abs=0.05 / RATE)
    # The coefficients are those of the nearest sample: there b is off by k times what is left of the offset.
    assert fit.coefficients == pytest.approx([3.0, -0.2], rel=0.03)
    assert fit.explained > 0.999


def test_of_a_sine_a_quarter_period_late_nothing_is_explained_unshifted():
    w = 2.0 * np.pi
    fit = best_lag(np.sin(w * TIME)[:, None], np.sin(w * (TIME - 0.25)), 0.4, RATE, 10.0)
    assert fit is not None
    # Half a period earlier it is the same with the other sign.
    assert abs(fit.offset) == pytest.approx(0.25, abs=1e-4)
    assert fit.coefficients == pytest.approx([math.copysign(1.0, fit.offset)], abs=1e-4)
    assert fit.explained == pytest.approx(1.0, abs=2e-4) and fit.explained_unshifted == pytest.approx(0.0, abs=1e-4)


def test_the_error_that_is_told_is_the_scatter_over_many_noises():
    clean, rng, found = causes(TIME) @ [3.0, 0.1], np.random.default_rng(0), []
    for _ in range(60):
        fit = best_lag(causes(TIME), clean + 0.2 * rng.standard_normal(len(TIME)), 0.1, RATE, math.inf)
        assert fit is not None
        found.append((fit.offset, fit.standard_error))
    offsets, told = np.array(found).T
    assert np.std(offsets) == pytest.approx(told.mean(), rel=0.3)


def test_samples_that_do_not_count_are_left_out_of_every_sum():
    counts = np.ones(len(TIME), dtype=bool)
    counts[1000:2000] = False
    spoilt = causes(TIME - 0.1) @ [3.0, -0.2]
    spoilt[1000:2000] = 50.0
    fit = best_lag(causes(TIME), spoilt, 0.6, RATE, 10.0, counts)
    assert fit is not None and fit.offset == pytest.approx(0.1, abs=1e-3) and fit.explained > 0.999
    scan = products(causes(TIME), spoilt[:, None], 0.2, RATE, counts)
    inner = counts[50:-50]
    assert scan.count == np.count_nonzero(inner)
    k, at = 31, causes(TIME)[50 - (31 - 50) : len(TIME) - 50 - (31 - 50)]
    assert scan.lags[k] == pytest.approx((31 - 50) / RATE)
    np.testing.assert_allclose(scan.gram[k], at[inner].T @ at[inner], rtol=1e-9)
    np.testing.assert_allclose(scan.cross[k], at[inner].T @ spoilt[50:-50][inner][:, None], rtol=1e-9)


def test_nothing_is_said_of_nothing():
    still, few = np.zeros((len(TIME), 1)), np.zeros(len(TIME), dtype=bool)
    few[:1000] = True
    assert best_lag(still, causes(TIME)[:, 0], 0.6, RATE, 10.0) is None
    assert best_lag(causes(TIME), still[:, 0], 0.6, RATE, 10.0) is None
    assert best_lag(causes(TIME), causes(TIME)[:, 0], 0.6, RATE, 10.0, few) is None
