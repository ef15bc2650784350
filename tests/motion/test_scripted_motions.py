"""The named motions: what a hand can do, and what the estimator needs."""

import numpy as np
import pytest
from scipy.signal import welch

from mmt_drake.errors import BadInput
from mmt_drake.motion.scripted import SCRIPTED, scripted_motion, scripted_parameters

RATE = 1000.0


def sampled(name, **parameters):
    motion = scripted_motion(name, **parameters)
    time = np.arange(round(motion.cycle * RATE)) / RATE
    return time, *motion.sample(time)


def touches(z):
    return int(np.sum((z[1:] < 0.0) & (z[:-1] >= 0.0)))


@pytest.mark.parametrize("name", SCRIPTED)
def test_hand_stays_within_its_workspace_and_speed(name):
    _, position, velocity = sampled(name)
    assert np.linalg.norm(velocity, axis=1).max() < 1.0
    if name in ("visits", "carry_over"):  # to three objects, of which the lowest is 20 mm lower
        assert np.abs(position[:, :2]).max() < 0.2
        highest = 0.0155 if name == "visits" else 0.07  # the lowest is lifted by 90 mm
        assert -0.030 <= position[:, 2].min() <= -0.022 and position[:, 2].max() <= highest
        return
    assert np.abs(position[:, :2]).max() < 0.1
    assert -0.010 <= position[:, 2].min() <= -0.002  # pressed by millimetres
    assert position[:, 2].max() <= (0.075 if name == "carry" else 0.0105)


@pytest.mark.parametrize("name", SCRIPTED)
def test_velocity_is_the_derivative_and_acceleration_is_continuous(name):
    motion = scripted_motion(name)
    t = np.random.default_rng(0).uniform(0.0, motion.cycle, 4000)
    h = 1e-5
    slope = (motion.sample(t + h)[0] - motion.sample(t - h)[0]) / (2.0 * h)
    np.testing.assert_allclose(motion.sample(t)[1], slope, atol=2e-7)

    def kink(h):
        """Largest change of acceleration over h: proportional to h if and only if there is no jump."""
        grid = np.arange(-2.0 * h, motion.cycle + 2.0 * h, h)  # across the seam of the cycle, too
        acceleration = np.diff(motion.sample(grid)[1], axis=0) / h
        return np.abs(np.diff(acceleration, axis=0)).max()

    assert kink(2e-4) < 0.6 * kink(4e-4)


@pytest.mark.parametrize("name", SCRIPTED)
def test_cycle_begins_and_ends_at_rest_above_the_object(name):
    motion = scripted_motion(name, clearance=0.02)
    for t in (0.0, motion.cycle - 1e-9):
        position, velocity = motion.at(t)
        np.testing.assert_allclose(position, [0.0, 0.0, 0.02], atol=1e-12)
        np.testing.assert_allclose(velocity, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "parameters", "count"),
    [
        ("strokes", {}, 3),
        ("strokes", {"lifts": 0}, 1),
        ("strokes", {"lifts": 5}, 6),
        ("strokes", {"first": "slow"}, 3),
        ("press_slide_lift", {}, 4),
        ("press_slide_lift", {"touches": 7}, 7),
        ("chirp", {}, 1),
        ("sines", {}, 1),
    ],
)
def test_contact_is_made_as_often_as_asked(name, parameters, count):
    assert touches(sampled(name, **parameters)[1][:, 2]) == count


def test_strokes_are_fast_first_then_slow_and_reach_the_highest_mode():
    time, position, velocity = sampled("strokes")
    fast = np.std(velocity[(time > 1.0) & (time < 5.0), 1])
    slow = np.std(velocity[(time > 7.0) & (time < 18.0), 1])
    assert fast > 3.0 * slow
    frequency, power = welch(velocity[:, 1], RATE, nperseg=8192)
    assert power[(frequency > 3.2) & (frequency < 4.0)].sum() > 0.1 * power.sum()
    assert power[frequency > 4.5].sum() < 0.01 * power.sum()
    assert np.ptp(position[:, 1]) > 5.0 * np.ptp(position[:, 0])  # mostly along y


def test_strokes_may_begin_each_touch_slowly():
    time, _, velocity = sampled("strokes", first="slow")
    slow = np.std(velocity[(time > 1.0) & (time < 12.0), 1])
    fast = np.std(velocity[(time > 14.0) & (time < 18.0), 1])
    assert fast > 3.0 * slow


def test_strokes_along_x_are_those_along_y():
    _, along_y, _ = sampled("strokes")
    _, along_x, _ = sampled("strokes", axis="x")
    np.testing.assert_array_equal(along_x[:, [1, 0, 2]], along_y)


def test_chirp_sweeps_from_its_first_to_its_last_frequency():
    time, position, _ = sampled("chirp")
    y = position[:, 1]
    crossings = time[1:][(y[1:] > 0.0) & (y[:-1] <= 0.0)]
    periods = np.diff(crossings)
    assert periods[0] > 4.0
    assert 1.0 / periods[-3:].mean() == pytest.approx(10.0, rel=0.05)


def test_press_slide_lift_touches_elsewhere_each_time():
    _, position, _ = sampled("press_slide_lift")
    z = position[:, 2]
    places = position[1:][(z[1:] < 0.0) & (z[:-1] >= 0.0), :2]
    gaps = np.linalg.norm(places[:, None] - places[None], axis=2)[~np.eye(len(places), dtype=bool)]
    assert gaps.min() > 0.01


def test_reaches_tremble_between_8_and_12_hz():
    _, position, _ = sampled("reaches", tremor=2e-4)
    _, still, _ = sampled("reaches", tremor=0.0)
    tremor = (position - still)[1000:-1000]
    np.testing.assert_allclose(tremor.std(axis=0), 2e-4, rtol=0.1)
    frequency, power = welch(tremor[:, 0], RATE, nperseg=8192)
    assert power[(frequency > 7.8) & (frequency < 12.2)].sum() > 0.99 * power.sum()


@pytest.mark.parametrize("name", ["press_slide_lift", "sines", "reaches"])
def test_seed_alone_decides_random_choices(name):
    first, again, other = (sampled(name, seed=seed)[1] for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1e-3


@pytest.mark.parametrize("name", SCRIPTED)
def test_every_parameter_has_an_effect(name):
    motion = scripted_motion(name)
    for key, value in scripted_parameters(name).items():
        changed = {"axis": "x", "first": "slow", "seed": 5}.get(key, value + 1 if isinstance(value, int) else None)
        if changed is None:
            changed = 1.25 * value
        other = scripted_motion(name, **{key: changed})
        assert other.table.shape != motion.table.shape or np.any(other.table != motion.table), key


@pytest.mark.parametrize(
    ("name", "parameters", "words"),
    [
        ("stroke", {}, ["'stroke'", "strokes, chirp"]),
        ("strokes", {"speed": 1.0}, ["speed", "duration, amplitude"]),
        ("strokes", {"depth": -0.001}, ["depth", "> 0"]),
        ("strokes", {"depth": float("nan")}, ["depth", "finite"]),
        ("strokes", {"amplitude": "wide"}, ["amplitude", "'wide'"]),
        ("strokes", {"axis": "z"}, ["axis", "x or y"]),
        ("strokes", {"first": "x"}, ["first", "fast or slow"]),
        ("strokes", {"lifts": 1.5}, ["lifts", "integer"]),
        ("strokes", {"duration": 3.0}, ["duration", ">= 12"]),
        ("chirp", {"duration": 1.0}, ["duration"]),
        ("reaches", {"duration": 1.0}, ["duration"]),
        ("sines", {"seed": True}, ["seed"]),
        ("sines", {"count": 3000}, ["count", "3000", "at most 20"]),
    ],
)
def test_unknown_names_and_senseless_values_are_bad_input(name, parameters, words):
    with pytest.raises(BadInput) as error:
        scripted_motion(name, **parameters)
    for word in words:
        assert word in str(error.value)
