"""The model of a hand, one imperfection at a time, and the recording made with it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hand_recording import SHIPPED, HandModel, _corrected, hand_motion, hand_plan
from scipy.linalg import expm
from scipy.signal import welch

from mmt_drake.motion.placement import AS_RECORDED, place
from mmt_drake.recording import load

STEADY = HandModel(command_noise=0.0, press_variability=0.0, tremor=0.0, drift=0.0)


def deviation(**noise):
    """What the hand adds to its plan with one imperfection alone."""
    model = replace(STEADY, **noise)
    motion = hand_motion(model)
    return motion.time, motion.position - hand_plan(model).sample(motion.time)[0]


def test_shipped_recording_is_what_the_model_generates():
    made, shipped = hand_motion(), place(load(SHIPPED, forces=False), AS_RECORDED)
    np.testing.assert_array_equal(made.table, shipped.table)
    assert SHIPPED.stat().st_size < 1e6


def test_hand_moves_like_a_hand():
    motion = hand_motion()
    speed = np.linalg.norm(motion.velocity, axis=1)
    z = motion.position[:, 2]
    assert 0.2 < speed.max() < 1.0
    assert np.abs(motion.position[:, :2]).max() < 0.1
    assert -0.010 < z.min() < -0.003
    assert np.sum((z[1:] < 0.0) & (z[:-1] >= 0.0)) >= 4  # touches again and again
    frequency, power = welch(motion.velocity[:, 1], 250.0, nperseg=4096)
    assert power[(frequency > 3.0) & (frequency < 10.0)].sum() > 0.02 * power.sum()
    assert power[frequency < 1.0].sum() > 0.02 * power.sum()


def test_seeds_give_different_hands():
    assert np.abs(hand_motion(HandModel(seed=2)).position - hand_motion().position).max() > 0.01


def test_steady_hand_follows_its_plan():
    assert np.abs(deviation()[1]).max() <= 0.51e-7  # rounding


def test_tremor_lies_between_8_and_12_hz():
    _, extra = deviation(tremor=2e-4)
    np.testing.assert_allclose(extra.std(axis=0), 2e-4, rtol=0.1)
    frequency, power = welch(extra[:, 1], 250.0, nperseg=4096)
    assert power[(frequency > 7.0) & (frequency < 13.0)].sum() > 0.9 * power.sum()


def test_drift_is_slow_and_spares_the_pressing():
    _, extra = deviation(drift=2e-3)
    assert 5e-4 < extra[:, :2].std() < 4e-3  # some six independent stretches in a minute
    frequency, power = welch(extra[:, 0], 250.0, nperseg=8192)
    assert power[frequency < 0.3].sum() > 0.97 * power.sum()
    assert np.abs(extra[:, 2]).max() <= 0.51e-7


def test_press_wanders_in_proportion_to_depth():
    time, extra = deviation(press_variability=0.1)
    depth = -hand_plan(STEADY).sample(time)[0][:, 2]
    assert np.abs(extra[depth <= 0.0]).max() <= 0.51e-7
    share = extra[depth > 0.002, 2] / depth[depth > 0.002]
    assert share.std() == pytest.approx(0.1, rel=0.25)
    deeper = replace(STEADY, press_variability=0.1, press=(0.006, 0.012))
    again = hand_motion(deeper).position - hand_plan(deeper).sample(time)[0]
    np.testing.assert_allclose(
        again[depth > 0.002, 2] / -hand_plan(deeper).sample(time)[0][depth > 0.002, 2], share, atol=5e-5
    )


def test_command_noise_is_there_where_the_hand_is_driven_hard():
    time, extra = deviation(command_noise=0.06)
    speed = np.abs(hand_plan(STEADY).sample(time)[1][:, 1])
    activity = np.convolve(speed, np.ones(250) / 250.0, mode="same")
    busy, calm = activity > np.quantile(activity, 0.8), activity < np.quantile(activity, 0.2)
    assert np.std(extra[busy, 1]) > 3.0 * np.std(extra[calm, 1])
    # A reach of 10 cm misses by millimetres, not by centimetres and not by nothing.
    assert 5e-4 < np.std(extra[busy, 1]) < 8e-3


def test_feedback_brings_the_limb_back_as_its_equation_says():
    dt, w = 0.004, 2.0 * math.pi
    noise = np.zeros((500, 1))
    noise[0] = 1.0
    found = _corrected(noise, dt)[:, 0]
    a = np.array([[0.0, 1.0, 0.0], [-w * w, -2.0 * w, 1.0 / math.sqrt(dt)], [0.0, 0.0, 0.0]])  # the input held
    held, free = expm(a * dt), expm(a[:2, :2] * dt)
    state, expected = held[:2, 2], [0.0]
    for _ in range(499):
        expected.append(state[0])
        state = free @ state
    np.testing.assert_allclose(found, expected, atol=1e-12)
