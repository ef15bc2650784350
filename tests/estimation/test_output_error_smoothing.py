"""The filters that take the noise off the motion."""

import numpy as np
import pytest

from mmt_drake.estimation.output_error.smoothing import BANDS, design, filter_bank

H, TICKS = 0.005, 5
BANK = filter_bank(H, TICKS)


def mean_of_sine(hz: float, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means over the ticks of H of a sine of 1 m, and the sine and its rate in the middles."""
    t = np.arange(n) * H
    w = 2 * np.pi * hz
    ticks = (np.arange(TICKS) - TICKS // 2) * H / TICKS
    return np.sin(w * np.add.outer(t, ticks)).mean(axis=1), np.sin(w * t), w * np.cos(w * t)


@pytest.mark.parametrize(("band", "reach"), BANDS)
def test_in_its_band_a_filter_gives_position_and_velocity_and_beyond_twice_that_nothing(
    band: float, reach: float
) -> None:
    taps = design(band, reach, H, TICKS)
    for hz in np.linspace(0.05, 0.9, 9) * band:
        x, wanted, rate = mean_of_sine(hz, 600)
        inner = slice(taps.reach, -taps.reach)
        assert np.abs(np.correlate(x, taps.position, "valid") - wanted[inner]).max() < 2e-3
        assert np.abs(np.correlate(x, taps.velocity, "valid") - rate[inner]).max() < 5e-3 * 2 * np.pi * hz
    for hz in np.linspace(2.1 * band, 80.0, 9):
        x, _, _ = mean_of_sine(hz, 600)
        assert np.abs(np.correlate(x, taps.position, "valid")).max() < 0.03


@pytest.mark.parametrize(("band", "reach"), BANDS)
def test_a_steady_motion_passes_a_filter_exactly(band: float, reach: float) -> None:
    taps = design(band, reach, H, TICKS)
    x = 0.3 + 0.2 * H * np.arange(2 * taps.reach + 1)
    assert x @ taps.position == pytest.approx(x[taps.reach], abs=1e-12)
    assert x @ taps.velocity == pytest.approx(0.2, rel=1e-9)


def test_a_filter_looks_as_far_as_it_is_told_and_over_two_neighbours_is_the_central_difference() -> None:
    for band, reach in BANDS:
        assert design(band, reach, H, TICKS).reach == round(reach / H)
    taps = design(BANDS[0][0], H, H, TICKS)
    np.testing.assert_allclose(taps.velocity, np.array([-0.5, 0.0, 0.5]) / H)
    np.testing.assert_allclose(taps.position[[0, 1]], (taps.position[2], 1.0 - 2.0 * taps.position[2]))


def test_where_the_position_stands_the_velocity_is_zero_whatever_its_own_sensor_says() -> None:
    _, velocity = BANK.smooth(np.zeros(600), np.random.default_rng(2).standard_normal(600), 0.0)
    assert not velocity[BANK.reach : -BANK.reach].any()


def test_what_moves_slowly_is_smoothed_more_than_what_moves_fast() -> None:
    n, random = 1200, np.random.default_rng(0)
    noise = 1e-5 * random.standard_normal(n)
    left = []
    for hz, amplitude in ((0.3, 0.02), (4.0, 0.005), (10.0, 0.002)):
        x, wanted, rate = (amplitude * values for values in mean_of_sine(hz, n))
        found, velocity = BANK.smooth(x + noise, rate, 1e-10)
        inner = slice(250, -250)
        assert np.abs(found - wanted)[inner].max() < 6e-5
        left.append(np.sqrt(np.mean((velocity - rate)[inner] ** 2)))
    assert left[0] < 0.5 * left[1] < left[1] < left[2]


def test_a_blow_is_left_as_it_was_measured() -> None:
    x = np.where(np.arange(400) < 200, 0.0, 0.01)
    found, _ = BANK.smooth(x, np.zeros(400), 1e-10)
    np.testing.assert_array_equal(found[190:210], x[190:210])


def test_white_noise_is_told_from_what_the_widest_filter_leaves() -> None:
    noise = 2e-5 * np.random.default_rng(1).standard_normal(20_000)
    motion, _, _ = (0.01 * values for values in mean_of_sine(3.0, 20_000))
    assert BANK.noise(motion + noise)[50:-50].mean() == pytest.approx(4e-10, rel=0.05)
