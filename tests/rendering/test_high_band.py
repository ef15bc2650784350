"""The second model: it finds a spring where there is one, and takes over only where it is the better."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.rendering.high_band import ESTIMATE_SIZE, FUSE_SIZE, HighBand, estimate, fuse, settings

STEP = 1e-3
TIME = np.arange(4000) * STEP
THETA = FlexibleBoxModel().theta()


def strokes(frequency=6.0, size=0.005):
    w = 2 * np.pi * frequency
    position, velocity = np.zeros((2, len(TIME), 3))
    position[:, 1], velocity[:, 1] = size * np.sin(w * TIME), size * w * np.cos(w * TIME)
    position[:, 2] = -0.004
    return position, velocity


def estimated(force, position, velocity, options, theta=THETA, stable=1.0):
    """(n, 3) k, b, weight after every tick."""
    memory, fixed, found = np.zeros(ESTIMATE_SIZE), settings(options, STEP), np.zeros((len(TIME), 3))
    for k, t in enumerate(TIME):
        measurement = np.concatenate([position[k], velocity[k], force[k]])
        estimate(memory, t, measurement, 1.0, theta, stable, fixed)
        found[k] = memory[:3]
    return found


def plant(position, velocity, parameters=None):
    from mmt_drake.model import flexible_box as box

    model = FlexibleBoxModel() if parameters is None else FlexibleBoxModel(parameters)
    force, body = np.empty((len(TIME), 3)), np.empty((len(TIME), 4))
    box.replay(TIME, position, velocity, np.ones(len(TIME)), model.kernel_vector(), force, body)
    return force


@pytest.mark.parametrize(("damper", "b"), [(False, 0.0), (True, 25.0)])
def test_the_stiffness_and_damping_of_a_spring_and_damper_are_found(damper, b):
    position, velocity = strokes()
    found = estimated(-800.0 * position - b * velocity, position, velocity, HighBand(damper=damper))
    assert found[-1, 0] == pytest.approx(800.0, rel=0.01)
    assert found[-1, 1] == pytest.approx(b, rel=0.02)
    assert found[-1, 2] > 0.95  # the first model, a damper at 6 Hz, is wrong about it


def test_where_the_first_model_is_right_the_second_has_no_weight():
    position, velocity = strokes()
    found = estimated(plant(position, velocity), position, velocity, HighBand(damper=False))
    assert found[-1, 2] < 1e-6


def test_before_there_is_a_first_model_the_second_has_all_the_weight():
    position, velocity = strokes()
    found = estimated(plant(position, velocity), position, velocity, HighBand(damper=True), stable=0.0)
    assert found[-1, 2] > 0.99


def test_a_hand_at_rest_leaves_nothing_of_the_second_model():
    position, velocity = strokes(size=1e-9)
    force = np.random.default_rng(0).normal(0.0, 0.02, position.shape)
    found = estimated(force, position, velocity, HighBand(damper=False))
    assert np.abs(found[1000:, 0]).max() < 50.0


def test_a_fused_force_is_the_first_below_and_the_second_above_the_crossover():
    for frequency, expected in ((0.1, -60.0), (40.0, -300.0)):
        fixed, bank = settings(HighBand(), STEP), np.zeros(FUSE_SIZE)
        fused, position = np.zeros((2, len(TIME)))
        w = 2 * np.pi * frequency
        for k, t in enumerate(TIME):
            motion = np.array([0.0, 0.01 * np.sin(w * t), 0.0, 0.0, 0.01 * w * np.cos(w * t), 0.0])
            force = np.array([0.0, -60.0 * motion[1], 0.0])
            fuse(bank, motion, np.array([300.0, 0.0, 1.0]), 1.0, fixed, force)
            fused[k], position[k] = force[1], motion[1]
        late = slice(2000, None)
        stiffness = np.sum(fused[late] * position[late]) / np.sum(position[late] ** 2)
        assert stiffness == pytest.approx(expected, rel=0.03)


def test_without_weight_or_contact_the_force_is_the_first_models():
    fixed, bank = settings(HighBand(), STEP), np.zeros(FUSE_SIZE)
    for weight, contact in ((0.0, 1.0), (1.0, 0.0)):
        force = np.array([0.3, -0.2, 1.0])
        fuse(bank, np.ones(6), np.array([300.0, 0.0, weight]), contact, fixed, force)
        np.testing.assert_array_equal(force, [0.3, -0.2, 1.0])


@pytest.mark.parametrize("name", ["crossover", "memory"])
def test_numbers_without_meaning_are_refused(name):
    with pytest.raises(BadInput, match=f"high band: {name}"):
        HighBand(**{name: 0.0})


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_a_sample_that_is_not_finite_is_skipped_and_forgotten(wrong):
    position, velocity = strokes()
    force = -800.0 * position
    expected = estimated(force, position, velocity, HighBand(damper=False))
    force[2000, 0] = position[2100, 1] = velocity[2200, 2] = wrong
    found = estimated(force, position, velocity, HighBand(damper=False))
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(found[2000], found[1999])
    np.testing.assert_allclose(found[-1], expected[-1], rtol=1e-3)


def test_nothing_that_is_not_finite_reaches_the_hand_or_stays():
    fixed, bank = settings(HighBand(), STEP), np.zeros(FUSE_SIZE)
    given = np.array([0.3, -0.2, 1.0])
    force = given.copy()
    fuse(bank, np.ones(6), np.array([np.nan, 0.0, 0.0]), 1.0, fixed, force)
    np.testing.assert_array_equal(force, given)
    fuse(bank, np.full(6, np.nan), np.array([300.0, 0.0, 1.0]), 1.0, fixed, force)
    np.testing.assert_array_equal(force, given)
    assert np.isfinite(bank).all()


def test_a_crossover_above_half_the_rate_of_the_clock_is_refused():
    settings(HighBand(crossover=499.0), STEP)
    with pytest.raises(BadInput, match=r"high_band\.crossover: found 600"):
        settings(HighBand(crossover=600.0), STEP)


@pytest.mark.parametrize("damper", [False, True])
def test_the_fit_is_least_squares_with_a_forgetting_memory_and_the_weight_that_of_the_errors(damper):
    random, options = np.random.default_rng(6), HighBand(memory=0.05, damper=damper)
    position, velocity, force = np.zeros((3, len(TIME), 3))
    for i in range(2):  # two axes whose position, rate and force hang together, each with a part of its own
        x, v, noise = sosfilt(butter(1, 20.0, fs=1.0 / STEP, output="sos"), random.normal(size=(3, len(TIME))))
        position[:, i], velocity[:, i] = x, 20.0 * v + 50.0 * x
        force[:, i] = -300.0 * position[:, i] - 4.0 * velocity[:, i] + 300.0 * noise
    found = estimated(force, position, velocity, options, stable=0.0)
    high = butter(2, options.crossover, "highpass", fs=1.0 / STEP, output="sos")
    x, v, F = (sosfilt(high, signal[:, :2], axis=0) for signal in (position, velocity, force))
    before = np.vstack([np.zeros(3), found[:-1]])  # a sample is foretold before it is fitted
    second = (F + before[:, :1] * x + before[:, 1:2] * v) ** 2
    for n in (500, 1700, 3999):
        kept = np.exp(-STEP / options.memory * (n - np.arange(n + 1)))
        root = np.sqrt(np.repeat(kept, 2))
        system = np.column_stack([x[: n + 1].ravel(), v[: n + 1].ravel()][: 1 + damper]) * root[:, None]
        fitted = np.linalg.lstsq(system, -F[: n + 1].ravel() * root)[0]
        np.testing.assert_allclose(found[n, : 1 + damper], fitted, rtol=1e-3)
        first, missed = kept @ F[: n + 1] ** 2, kept @ second[: n + 1]  # the first model says 0
        assert found[n, 2] == pytest.approx(first.sum() / (first + missed).sum(), rel=1e-9)
        assert 0.05 < missed.sum() / first.sum() < 2.0
    assert (found[:, 1] != 0.0).any() == damper
