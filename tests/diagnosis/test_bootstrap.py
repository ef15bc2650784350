"""Deviations of least squares hold for residuals that are alike for a while, not for white ones only."""

import numpy as np
import pytest
from scipy import stats

from mmt_drake.diagnosis.fit.bootstrap import Deviations, deviations

BLOCKS, LENGTH = 20, 25
NUMBERS = np.repeat(np.arange(BLOCKS), LENGTH)
SAMPLES = BLOCKS * LENGTH


def of_mean(values: np.ndarray) -> Deviations:
    """How well the mean of some values, with noise of strength 1 each, is known."""
    return deviations(-np.ones((len(values), 1)), values - values.mean(), NUMBERS, len(values))


def test_of_white_noise_the_mean_is_known_to_one_over_the_root_of_their_number():
    ripple = np.tile([1.0, -1.0], SAMPLES // 2)  # nothing is left of it over two samples
    known = of_mean(0.5 * ripple)
    assert known.deviation == pytest.approx(1.0 / np.sqrt(SAMPLES))  # never better than the noise said to be there
    assert known.strength == 1.0
    louder = of_mean(3.0 * ripple)
    assert louder.strength == pytest.approx(9.0 * SAMPLES / (SAMPLES - 1))
    assert louder.deviation == pytest.approx(3.0 / np.sqrt(SAMPLES - 1))


def test_of_noise_that_is_the_same_all_through_a_block_the_mean_is_known_as_the_mean_of_blocks():
    means = np.random.default_rng(2).standard_normal(BLOCKS)
    known = of_mean(np.repeat(means, LENGTH))
    assert known.deviation == pytest.approx(means.std(ddof=1) / np.sqrt(BLOCKS), rel=0.03)  # of 1000 draws
    assert known.half_width == pytest.approx(stats.t.ppf(0.975, BLOCKS - 1) * known.deviation)


def test_intervals_cover_the_truth_under_coloured_noise_as_often_as_they_say():
    rng, t = np.random.default_rng(4), np.arange(SAMPLES)
    jacobian = -np.column_stack([np.sin(0.11 * t), np.cos(0.07 * t), np.sin(0.031 * t + 1.0)])
    covered, white = [], []
    for _ in range(300):
        noise = np.convolve(rng.standard_normal(SAMPLES + 19), np.ones(20) / np.sqrt(20.0), mode="valid")
        error, *_ = np.linalg.lstsq(-jacobian, noise, rcond=None)  # of the numbers; what is left is the residual
        residual = noise + jacobian @ error
        covered += list(np.abs(error) <= deviations(jacobian, residual, NUMBERS, SAMPLES).half_width)
        white += list(np.abs(error) <= deviations(jacobian, residual, t, SAMPLES).half_width)
    assert np.mean(white) < 0.8  # the noise is coloured: samples taken for independent promise too much
    assert 0.92 <= np.mean(covered) <= 0.99


def test_units_do_not_matter_and_a_number_that_no_residual_depends_on_is_not_known_at_all():
    rng = np.random.default_rng(5)
    jacobian, residual = rng.standard_normal((SAMPLES, 3)), rng.standard_normal(SAMPLES)
    known = deviations(jacobian, residual, NUMBERS, SAMPLES)
    units = np.array([1e6, 1.0, 1e-9])
    assert deviations(jacobian * units, residual, NUMBERS, SAMPLES).deviation * units == pytest.approx(known.deviation)
    without = deviations(jacobian * [1.0, 0.0, 1.0], residual, NUMBERS, SAMPLES).deviation
    assert np.isinf(without[1]) and np.isfinite(without[[0, 2]]).all()


def test_where_every_number_is_held_there_is_no_deviation_and_no_error():
    known = deviations(np.empty((SAMPLES, 0)), np.ones(SAMPLES), NUMBERS, SAMPLES, [np.ones((SAMPLES, 1))])
    assert known.deviation.shape == (0,) and known.strength == pytest.approx(1.0)
