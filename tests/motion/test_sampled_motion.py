"""Motions through samples."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mmt_drake.errors import BadInput
from mmt_drake.motion.sampled import SampledMotion

RNG = np.random.default_rng(4)
UNEVEN = np.cumsum(RNG.uniform(0.01, 0.2, 40))


def cubic(t):
    t = np.asarray(t)[:, None]
    a = np.array([[0.1, -0.2, 0.05]])
    return a * t**3 - 0.3 * a * t + 0.01, 3.0 * a * t**2 - 0.3 * a


@pytest.mark.parametrize("time", [UNEVEN, np.linspace(0.0, 3.0, 31)], ids=["uneven", "even"])
def test_a_cubic_is_reproduced_everywhere(time):
    motion = SampledMotion(time, *cubic(time))
    t = RNG.uniform(time[0], time[-1], 500)
    for found, expected in zip(motion.sample(t), cubic(t), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_samples_are_met_exactly():
    position, velocity = RNG.normal(size=(2, len(UNEVEN), 3))
    motion = SampledMotion(UNEVEN, position, velocity)
    for found, expected in zip(motion.sample(UNEVEN), (position, velocity), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_motion_rests_before_the_first_and_after_the_last_sample():
    motion = SampledMotion([1.0, 2.0], [[0.0, 0.0, 0.0], [0.1, 0.2, 0.3]], np.ones((2, 3)))
    for t, place in ((0.0, 0.0), (0.999, 0.0), (2.001, [0.1, 0.2, 0.3]), (1e6, [0.1, 0.2, 0.3])):
        position, velocity = motion.at(t)
        np.testing.assert_array_equal(position, np.broadcast_to(place, 3))
        np.testing.assert_array_equal(velocity, 0.0)


def test_motion_from_positions_is_the_cubic_spline():
    position = RNG.normal(size=(len(UNEVEN), 3))
    motion, spline = SampledMotion.from_positions(UNEVEN, position), CubicSpline(UNEVEN, position)
    t = RNG.uniform(UNEVEN[0], UNEVEN[-1], 500)
    np.testing.assert_allclose(motion.sample(t)[0], spline(t), atol=1e-11)
    np.testing.assert_allclose(motion.sample(t)[1], spline(t, 1), atol=1e-9)


@pytest.mark.parametrize(
    ("time", "position", "velocity", "words"),
    [
        ([0.0], np.zeros((1, 3)), np.zeros((1, 3)), "two samples"),
        ([0.0, 1.0], np.zeros((3, 3)), np.zeros((2, 3)), r"position: found shape \(3, 3\)"),
        ([0.0, 1.0], np.zeros((2, 3)), np.zeros((2, 2)), "velocity"),
        ([0.0, 2.0, 1.0], np.zeros((3, 3)), np.zeros((3, 3)), "sample 2: found time 1.0 s"),
        ([0.0, 1.0, 1.0], np.zeros((3, 3)), np.zeros((3, 3)), "sample 2"),
        ([0.0, 1.0], [[0, 0, 0], [0, np.nan, 0]], np.zeros((2, 3)), "sample 1: found NaN"),
        ([0.0, np.inf], np.zeros((2, 3)), np.zeros((2, 3)), "sample 1"),
    ],
)
def test_samples_that_are_no_motion_are_bad_input(time, position, velocity, words):
    with pytest.raises(BadInput, match=words):
        SampledMotion(time, position, velocity)


def test_positions_that_are_no_motion_are_bad_input():
    with pytest.raises(BadInput, match="sample 2"):
        SampledMotion.from_positions([0.0, 1.0, 0.5], np.zeros((3, 3)))
