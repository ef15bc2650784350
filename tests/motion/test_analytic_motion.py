"""Motions in closed form: steps, waves, and what they are together."""

import math

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import AnalyticMotion, step, wave
from mmt_drake.motion.reaching import FITTS_INTERCEPT, FITTS_SLOPE, fitts_duration, reach


def test_step_is_the_minimum_jerk_polynomial():
    motion = AnalyticMotion((0.1, 0.0, 0.0), steps=[step(0, 1.0, 3.0, 0.2), step(0, 5.0, 6.0, -0.2)], cycle=10.0)
    s = np.linspace(0.0, 1.0, 21)
    position, velocity = motion.sample(1.0 + 2.0 * s)
    np.testing.assert_allclose(position[:, 0], 0.1 + 0.2 * (10 * s**3 - 15 * s**4 + 6 * s**5), atol=1e-15)
    np.testing.assert_allclose(velocity[:, 0], 0.1 * (30 * s**2 - 60 * s**3 + 30 * s**4), atol=1e-15)
    np.testing.assert_allclose(motion.at(4.0)[0], [0.3, 0.0, 0.0])
    np.testing.assert_allclose(motion.at(7.0)[0], [0.1, 0.0, 0.0])


def test_overlapping_steps_add():
    one = AnalyticMotion((0, 0, 0), steps=[step(1, 0.0, 2.0, 0.3), step(1, 8.0, 9.0, -0.3)], cycle=10.0)
    two = AnalyticMotion((0, 0, 0), steps=[step(1, 1.0, 4.0, -0.1), step(1, 8.0, 9.0, 0.1)], cycle=10.0)
    both = AnalyticMotion((0, 0, 0), steps=[*two.steps, *one.steps], cycle=10.0)
    t = np.linspace(0.0, 10.0, 333)
    for i in range(2):
        np.testing.assert_allclose(both.sample(t)[i], one.sample(t)[i] + two.sample(t)[i], atol=1e-16)


def test_wave_is_a_plain_sine_where_the_window_is_open():
    motion = AnalyticMotion((0, 0, 0), steps=[], waves=[wave(1, 1.0, 9.0, 0.02, 1.7, phase=0.3, ramp=0.5)], cycle=10.0)
    t = np.linspace(1.5, 8.5, 200)
    omega = 2.0 * math.pi * 1.7
    position, velocity = motion.sample(t)
    np.testing.assert_allclose(position[:, 1], 0.02 * np.sin(omega * (t - 1.0) + 0.3), atol=1e-15)
    np.testing.assert_allclose(velocity[:, 1], 0.02 * omega * np.cos(omega * (t - 1.0) + 0.3), atol=1e-14)
    np.testing.assert_array_equal(motion.sample([0.5, 1.0, 9.0, 9.5])[0][:, 1], 0.0)


def test_sweep_ends_at_its_end_frequency_and_amplitude():
    length, f0, f1 = 20.0, 0.5, 8.0
    motion = AnalyticMotion(
        (0, 0, 0),
        steps=[],
        waves=[wave(0, 0.0, length, 0.02, f0, end_amplitude=0.005, end_frequency=f1, ramp=0.1)],
        cycle=length,
    )
    t = np.arange(0.1, length - 0.1, 1e-4)
    x = motion.sample(t)[0][:, 0]
    up = t[1:][(x[1:] > 0.0) & (x[:-1] <= 0.0)]
    # Cycles of an exponential sweep: the integral of f0 (f1 / f0)^(t / T).
    assert len(up) == pytest.approx(length * (f1 - f0) / math.log(f1 / f0), abs=1.5)
    middle = 0.5 * (up[-1] + up[-2])
    assert 1.0 / (up[-1] - up[-2]) == pytest.approx(f0 * (f1 / f0) ** (middle / length), rel=1e-3)
    assert np.abs(x[t > up[-2]]).max() == pytest.approx(0.005, rel=0.03)


def test_motion_repeats_after_its_cycle():
    motion = AnalyticMotion((0, 0, 0), steps=[], waves=[wave(0, 0.0, 3.0, 0.01, 2.0)], cycle=3.0)
    t = np.linspace(0.0, 3.0, 100, endpoint=False)
    np.testing.assert_allclose(motion.sample(t + 3600.0)[0], motion.sample(t)[0], atol=1e-12)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: step(0, 2.0, 2.0, 0.1), "end"),
        (lambda: wave(0, 0.0, 1.0, 0.1, 0.0), "frequency"),
        (lambda: wave(0, 0.0, 1.0, 0.1, 1.0, ramp=0.6), "ramp"),
        (lambda: wave(0, 0.0, 1.0, 0.1, 1.0, end_amplitude=-0.1, ramp=0.1), "end_amplitude"),
        (lambda: AnalyticMotion((0, 0, 0), steps=[step(0, 0.0, 1.0, 0.1)], cycle=2.0), "net displacement"),
        (lambda: AnalyticMotion((0, 0, 0), steps=[], waves=[wave(0, 0.0, 3.0, 0.1, 1.0)], cycle=2.0), "cycle"),
        (lambda: AnalyticMotion((0, 0, 0), steps=[], cycle=0.0), "cycle"),
        (lambda: fitts_duration(0.1, 0.0), "width"),
    ],
)
def test_pieces_that_make_no_motion_are_bad_input(make, word):
    with pytest.raises(BadInput, match=word):
        make()


def test_fitts_duration_grows_by_its_slope_per_bit():
    assert fitts_duration(0.0, 0.01) == pytest.approx(FITTS_INTERCEPT)
    assert fitts_duration(0.07, 0.01) == pytest.approx(FITTS_INTERCEPT + 3.0 * FITTS_SLOPE)  # 8 widths: 3 bits


def test_reach_bows_sideways_and_arrives():
    there, back = reach(0.0, 1.0, (0.06, 0.08), bow=0.004), reach(2.0, 3.0, (-0.06, -0.08))
    motion = AnalyticMotion((0, 0, 0), steps=[*there, *back], cycle=4.0)
    np.testing.assert_allclose(motion.at(1.5)[0], [0.06, 0.08, 0.0], atol=1e-16)
    # Half-way, to the left of (0.6, 0.8): (-0.8, 0.6).
    np.testing.assert_allclose(motion.at(0.5)[0], [0.03 - 0.0032, 0.04 + 0.0024, 0.0], atol=1e-16)
