"""The trial's sensor chain: each stage in closed form, and their order."""

import math

import numpy as np
import pytest

from mmt_drake.diagrams.proof.trial.sensor import Sensor

FINE = np.arange(40_001) * 5e-5
TIME = np.arange(2_001) * 1e-3
W = 2.0 * math.pi * 3.0
NOTHING = np.zeros_like(TIME)


def test_a_lag_has_the_gain_and_phase_of_a_first_order_filter() -> None:
    read = Sensor(lag=0.02).arrival(FINE, np.sin(W * FINE), TIME)
    answer = 1.0 / (1.0 + 1j * W * 0.02)
    exact = abs(answer) * np.sin(W * TIME + np.angle(answer))
    settled = TIME > 0.4
    assert read[settled] == pytest.approx(exact[settled], abs=1e-5)


def test_a_lag_starts_settled_at_the_first_force() -> None:
    assert Sensor(lag=0.05).arrival(FINE, np.full_like(FINE, 2.0), TIME) == pytest.approx(2.0, rel=1e-12)


def test_a_delayed_force_is_the_force_of_earlier() -> None:
    read = Sensor(delay=0.0123).arrival(FINE, np.sin(W * FINE), TIME)
    late = TIME > 0.0123
    assert read[late] == pytest.approx(np.sin(W * (TIME[late] - 0.0123)), abs=1e-6)
    assert np.all(read[~late] == 0.0)


def test_a_drifting_clock_delays_more_and_more() -> None:
    read = Sensor(delay_rate=0.01).arrival(FINE, np.sin(W * FINE), TIME)
    assert read == pytest.approx(np.sin(W * 0.99 * TIME), abs=1e-6)


def test_what_is_added_is_added_in_recorded_time() -> None:
    sensor = Sensor(bias=0.2, drift=0.3, crosstalk=-0.1, amplitude=0.5, frequency=2.0, phase=0.7, delay=0.1)
    normal = np.cos(TIME)
    time = TIME + 100.0
    exact = 1.0 + 0.2 + 0.3 * TIME - 0.1 * normal + 0.5 * np.sin(4.0 * math.pi * TIME + 0.7)
    assert sensor.tangential(time, np.ones_like(TIME), normal) == pytest.approx(exact, abs=1e-9)


def test_what_is_added_is_clipped_with_the_rest() -> None:
    sensor = Sensor(bias=1.0, limit=1.2)
    read = sensor.clipped(sensor.tangential(TIME, np.sin(W * TIME), NOTHING))
    assert read == pytest.approx(np.clip(np.sin(W * TIME) + 1.0, -1.2, 1.2), abs=1e-12)


def test_play_lags_by_half_its_width_in_the_direction_of_motion() -> None:
    read = Sensor(play=0.4).tangential(TIME, np.sin(W * TIME), NOTHING)
    phase = (W * TIME) % (2.0 * math.pi)
    rising = (TIME > 0.4) & (phase > 1.8 * math.pi)
    falling = (TIME > 0.4) & (phase > 0.8 * math.pi) & (phase < math.pi)
    assert read[rising] == pytest.approx(np.sin(W * TIME[rising]) - 0.2, abs=1e-12)
    assert read[falling] == pytest.approx(np.sin(W * TIME[falling]) + 0.2, abs=1e-12)
