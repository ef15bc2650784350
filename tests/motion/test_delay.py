"""A motion some time ago: exact on straight lines, and no noisier than it was."""

import numpy as np
import pytest
from scipy.signal import TransferFunction, lsim

from mmt_drake.motion.delay import delayed_flag, delayed_input, delayed_motion, input_behind, lagged

TIME = np.arange(2000) / 1000.0
DELAYS = [0.0, 0.0004, 0.002, 0.0025, 0.0123]


@pytest.mark.parametrize("delay", DELAYS)
def test_a_uniform_motion_is_where_it_was_and_rests_before_it_begins(delay):
    rate = np.array([0.3, -0.1, 0.05])
    position, velocity = delayed_motion(TIME, TIME[:, None] * rate, np.tile(rate, (len(TIME), 1)), delay)
    was = TIME - delay
    began = was >= -1e-12
    np.testing.assert_allclose(position[began], was[began, None] * rate, atol=1e-12)
    np.testing.assert_array_equal(velocity[began], np.tile(rate, (np.count_nonzero(began), 1)))
    assert not position[~began].any() and not velocity[~began].any()


@pytest.mark.parametrize("delay", DELAYS)
def test_position_and_velocity_keep_the_noise_of_their_own_sensor(delay):
    rng = np.random.default_rng(0)
    noise = 1e-5 * rng.standard_normal((len(TIME), 3)), 5e-4 * rng.standard_normal((len(TIME), 3))
    late = delayed_motion(TIME, *noise, delay)
    for before, after in zip(noise, late, strict=True):
        assert after[20:].std() < 1.05 * before.std()


def test_a_hand_of_4_hz_is_met_far_below_its_sensors_noise():
    w = 2.0 * np.pi * 4.0
    x, v = 0.02 * np.sin(w * TIME), 0.02 * w * np.cos(w * TIME)
    position, velocity = delayed_motion(TIME, np.column_stack([x] * 3), np.column_stack([v] * 3), 0.0125)
    was = TIME - 0.0125
    np.testing.assert_allclose(position[20:, 1], (0.02 * np.sin(w * was))[20:], atol=2e-6)
    np.testing.assert_allclose(velocity[20:, 1], (0.02 * w * np.cos(w * was))[20:], atol=5e-5)


def test_inputs_and_flags_are_what_they_were():
    np.testing.assert_allclose(delayed_input(TIME, 2.0 * TIME, 0.0015)[2:], 2.0 * (TIME[2:] - 0.0015), atol=1e-12)
    flag = TIME > 0.5
    assert delayed_input(TIME, TIME, 0.0) is TIME and delayed_flag(TIME, flag, 0.0) is flag
    np.testing.assert_array_equal(delayed_flag(TIME, flag, 0.0105), TIME > 0.511)


def test_a_lag_answers_as_scipys_low_pass_and_has_settled_at_the_first_sample():
    time = np.arange(400) * 0.004
    u = 1.5 + np.cumsum(np.random.default_rng(2).standard_normal(400))
    expected = u[0] + lsim(TransferFunction([1.0], [0.03, 1.0]), u - u[0], time)[1]
    np.testing.assert_allclose(input_behind(time, u, 0.0, 0.03), expected, atol=1e-9)
    late = np.interp(time - 0.0104, time, u)
    np.testing.assert_array_equal(input_behind(time, u, 0.0104, 0.03), lagged(time, late, 0.03))
    assert input_behind(time, u, 0.0, 0.0) is u


def test_a_lag_on_uneven_samples_is_that_of_the_line_between_them():
    time = np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 50))
    u = 2.0 * time - 1.0  # lag y' = u - y
    expected = u - 2.0 * 0.07 * (1.0 - np.exp(-(time - time[0]) / 0.07))
    np.testing.assert_allclose(lagged(time, u, 0.07), expected, atol=1e-12)
