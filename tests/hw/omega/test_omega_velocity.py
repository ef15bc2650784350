"""The velocity of a hand from its positions: exact for a cubic, in time, and no more noise than is said."""

import numpy as np
import pytest

from mmt_drake.hw.omega.velocity import MOST_NOISE, MOST_READINGS, take_position, velocity_memory

STEP = 1e-3


REPORTED = 77.0  # [m/s] by the device


def velocities(times, positions):
    """(n, 3) of positions (n, 3), reading by reading."""
    memory, found = velocity_memory(), np.empty((len(times), 3))
    for i, t in enumerate(times):
        reading = np.concatenate([positions[i], np.full(3, REPORTED)])
        take_position(memory, t, reading)
        found[i] = reading[3:]
    return found


def test_a_cubic_has_its_slope_at_the_last_reading_however_late_readings_are() -> None:
    rng = np.random.default_rng(0)
    t = 5.0 + np.cumsum(rng.uniform(0.5e-3, 2e-3, 60))
    s, axes = t - 5.0, np.array([1.0, -2.0, 0.5])
    x = np.outer(0.3 * s - 4.0 * s**2 + 30.0 * s**3, axes)
    v = np.outer(0.3 - 8.0 * s + 90.0 * s**2, axes)
    np.testing.assert_allclose(velocities(t, x)[30:], v[30:], atol=1e-9)


@pytest.mark.parametrize(("hertz", "off"), [(1.0, 0.001), (3.6, 0.002), (10.0, 0.025)])
def test_a_hand_s_velocity_is_not_late(hertz: float, off: float) -> None:
    t, w = STEP * np.arange(2000), 2.0 * np.pi * hertz
    x = np.outer(0.01 * np.sin(w * t), np.ones(3))
    found = velocities(t, x)[100:, 0]
    true = 0.01 * w * np.cos(w * t)[100:]
    assert np.sqrt(np.mean((found - true) ** 2)) < off * np.sqrt(np.mean(true**2))


def test_steps_of_the_encoders_leave_a_millimetre_a_second() -> None:
    t = STEP * np.arange(5000)
    x = np.outer(0.02 * np.sin(2.0 * np.pi * 0.7 * t), np.ones(3))
    noise = velocities(t, 1e-5 * np.round(x / 1e-5)) - velocities(t, x)
    assert noise[100:].std() < 1.0e-3


def test_too_few_readings_or_too_close_leave_the_device_s_own_velocity() -> None:
    t = np.concatenate([STEP * np.arange(50), 1.0 + STEP * np.arange(9)])
    x = np.outer(np.concatenate([0.1 * STEP * np.arange(50), 7.0 + 0.2 * STEP * np.arange(9)]), np.ones(3))
    found = velocities(t, x)[:, 0]
    assert found[0] == found[1] == found[50] == found[51] == REPORTED
    assert found[49] == pytest.approx(0.1)
    np.testing.assert_allclose(found[54:], 0.2)
    assert (velocities(np.zeros(5), np.outer(np.arange(5.0), np.ones(3))) == REPORTED).all(), "a clock stands still"


def test_readings_at_random_times_never_have_more_noise_than_is_said() -> None:
    rng = np.random.default_rng(1)
    t = np.cumsum(rng.choice([1e-4, 1e-3, 2e-3, 15e-3], 4000))
    found = velocities(t, rng.normal(0.0, 1e-6, (4000, 3)))
    own = found[found[:, 0] != REPORTED]
    assert len(own) > 2000 and own.std() < MOST_NOISE * 1e-6


def test_more_readings_than_there_is_room_for_push_out_the_oldest() -> None:
    t = 1e-5 * np.arange(3 * MOST_READINGS)
    found = velocities(t, np.outer(0.1 * t, np.ones(3)))
    assert (found[:50] == REPORTED).all()
    np.testing.assert_allclose(found[-50:], 0.1, rtol=1e-6)
