"""Velocity from position: exact on parabolas, as quiet as theory says on noise, without lag."""

from __future__ import annotations

import numpy as np

from mmt_drake.recording.derive import rate_of, touches

STEP = 1e-3


def test_the_rate_of_a_parabola_is_exact_on_an_uneven_clock() -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(2e-4, 4e-3, 500))
    parabolas = np.column_stack([1.0 + 2.0 * time - 3.0 * time**2, -time])
    expected = np.column_stack([2.0 - 6.0 * time, np.full(500, -1.0)])
    np.testing.assert_allclose(rate_of(time, parabolas), expected, atol=1e-9)


def test_white_noise_leaves_the_deviation_of_savitzky_and_golay() -> None:
    noise = 1e-5 * np.random.default_rng(2).standard_normal(200_000)
    rate = rate_of(np.arange(len(noise)) * STEP, noise)
    half = 10  # samples in 10 ms
    expected = 1e-5 * np.sqrt(3.0 / (half * (half + 1) * (2 * half + 1))) / STEP
    assert abs(np.std(rate) / expected - 1.0) < 0.02


def test_clean_fast_motion_is_followed_by_a_narrow_window() -> None:
    time = np.arange(20_000) * STEP
    omega = 2.0 * np.pi * 40.0
    rate = rate_of(time, np.sin(omega * time))[50:-50]
    exact = omega * np.cos(omega * time)[50:-50]
    two_samples = (omega * 2 * STEP) ** 2 / 10.0 * 1.7  # the window of 5 samples: h^2 w^2 / 10 (1 + 1/M ...), M = 2
    assert np.abs(rate - exact).max() / omega < two_samples
    # The whole window would have taken away this much more than that:
    assert (omega * 10 * STEP) ** 2 / 10.0 > 10.0 * two_samples


def test_there_is_no_lag() -> None:
    time = np.arange(20_000) * STEP
    omega = 2.0 * np.pi * 3.0
    noisy = np.sin(omega * time) + 1e-4 * np.random.default_rng(3).standard_normal(len(time))
    rate = rate_of(time, noisy)
    phase = np.angle(np.exp(-1j * omega * time) @ rate) - np.angle(np.exp(-1j * omega * time) @ np.cos(omega * time))
    assert abs(phase / omega) < 2e-5


def test_the_measured_velocity_of_a_real_damper_is_its_position_s_rate(recordings) -> None:
    with np.load(recordings / "mr_damper" / "10mm1Hz1A.npz") as data:
        rate = rate_of(data["t_s"], data["x_m"])
        assert np.std(rate - data["v_mps"]) < 0.005 * np.std(data["v_mps"])


def test_contact_is_below_the_surface_not_on_it() -> None:
    np.testing.assert_array_equal(touches(np.array([1e-9, 0.0, -0.0, -1e-9])), [0.0, 0.0, 0.0, 1.0])
