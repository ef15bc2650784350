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


def test_a_parabola_has_its_slope_at_the_last_reading_however_late_readings_are() -> None:
    rng = np.random.default_rng(0)
    t = 5.0 + np.cumsum(rng.uniform(0.5e-3, 2e-3, 60))
    s, axes = t - 5.0, np.array([1.0, -2.0, 0.5])
    x, v = np.outer(0.3 * s - 4.0 * s**2, axes), np.outer(0.3 - 8.0 * s, axes)
    np.testing.assert_allclose(velocities(t, x)[15:], v[15:], atol=1e-9)


@pytest.mark.parametrize(("hertz", "off"), [(1.0, 0.001), (3.6, 0.005), (10.0, 0.04)])
def test_a_hand_s_velocity_is_hardly_late(hertz: float, off: float) -> None:
    assert abs(response(hertz) - 1.0) < off


def test_no_motion_is_amplified_so_much_that_a_damper_of_a_hundred_sings() -> None:
    """By Nyquist: a handle and a hand of 0.4 kg and 8 N s/m on 600 N/m, and a damper that answers two ticks later."""
    assert max(abs(response(hertz)) for hertz in np.linspace(5.0, 450.0, 90)) < 1.6
    w = 2.0 * np.pi * np.linspace(20.0, 450.0, 400)
    arm = 1j * w / (600.0 - 0.4 * w**2 + 8j * w)
    loop = np.array([response(hertz) for hertz in w / (2.0 * np.pi)]) * arm * np.exp(-2e-3j * w)
    crosses = np.flatnonzero((loop.imag[:-1] * loop.imag[1:] < 0.0) & (loop.real[:-1] < 0.0))
    assert len(crosses) and 100.0 * np.abs(loop.real[crosses]).max() < 1.0


def response(hertz: float) -> complex:
    """What is told of a sine over its velocity."""
    t, w = STEP * np.arange(40), 2.0 * np.pi * hertz
    turning = np.exp(1j * w * t)
    parts = velocities(t, np.stack([turning.real, turning.imag, np.zeros(40)], axis=1))[-1]
    return complex(parts[0], parts[1]) / (1j * w * turning[-1])


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
    assert len(own) > 1500 and own.std() < MOST_NOISE * 1e-6


def test_more_readings_than_there_is_room_for_push_out_the_oldest() -> None:
    t = 1e-5 * np.arange(3 * MOST_READINGS)
    found = velocities(t, np.outer(0.1 * t, np.ones(3)))
    assert (found[:50] == REPORTED).all()
    np.testing.assert_allclose(found[-50:], 0.1, rtol=1e-6)
