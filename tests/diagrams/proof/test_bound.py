"""The bound that noise sets is the closed form, and what least squares reach; the verdict follows from it."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.experiments.comparisons.bound import (
    FOUND,
    covariances,
    noise_bound,
    parameters_found,
    sample_means,
    sensitivity,
    true_motion,
)
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.unknowns import HIGH, LOW, MATERIAL, OBJECT, SIZE, Stick, theta_of, unknowns
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.numeric.least_squares import minimise
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed

STEP, NOISE = 1e-3, 0.02


def run(y, y_rate, contact=None):
    """A run without delay whose probe is pressed 5 mm deep and moves along y."""
    n = len(y)
    columns = {f"master_{name}_{axis}": np.zeros(n) for name in ("position", "velocity") for axis in "xyz"}
    columns |= {"master_position_y": y, "master_velocity_y": y_rate, "master_position_z": np.full(n, -0.005)}
    return Recording(STEP * np.arange(n), {**columns, "in_contact": np.ones(n) if contact is None else contact})


def tones(seconds, *amplitudes_and_hertz):
    """Sines, and their rates."""
    time = STEP * np.arange(round(seconds / STEP))
    turns = [(amplitude, 2.0 * np.pi * hertz) for amplitude, hertz in amplitudes_and_hertz]
    return sum(a * np.sin(w * time) for a, w in turns), sum(a * w * np.cos(w * time) for a, w in turns)


def test_of_a_held_body_the_bound_of_the_contact_spring_is_the_noise_over_k_times_the_root_of_the_sum_of_squares():
    # 50 kg at 8 Hz move by 0.4 % of the stroke: the force is -(k2 y + b2 v), and y and v are orthogonal.
    held = FlexibleBoxModel(parameters=BoxParameters(m=50.0, k1=0.0, k2=500.0, b1=60.0, b2=5.0))
    y, rate = tones(1.0, (0.002, 8.0))
    _, slope = sensitivity(held, true_motion(run(y, rate)))
    found = covariances(slope[:, :, MATERIAL], NOISE, np.ones(2))[-1]
    closed = NOISE / np.array([500.0 * np.linalg.norm(y), 5.0 * np.linalg.norm(rate)])
    np.testing.assert_allclose(np.sqrt(np.diag(found)), closed, rtol=0.01)


def test_what_two_parameters_do_alike_noise_hides_for_ever():
    x = np.sin(np.arange(500.0))
    known = covariances(np.stack([x, np.roll(x, 7)], axis=1)[:, np.newaxis], NOISE, np.ones(2))[-1]
    twins = covariances(np.stack([x, 2.0 * x], axis=1)[:, np.newaxis], NOISE, np.ones(2))[-1]
    assert np.sqrt(np.diag(known)).max() < 0.01
    assert np.sqrt(np.diag(twins)).min() > 100.0


def test_means_over_ticks_keep_the_information_of_what_is_slow_and_only_what_is_whole_and_in_contact_counts():
    slope = np.ones((23, 2, 1))
    contact = np.ones(23, dtype=bool)
    assert np.sum(sample_means(slope, contact, 5) ** 2) == pytest.approx(2 * 20)
    contact[7] = False
    assert np.sum(sample_means(slope, contact, 5) ** 2) == pytest.approx(2 * 15)


def test_least_squares_on_the_force_scatter_as_the_bound_says():
    truth = FlexibleBoxModel(parameters=BoxParameters(m=1.0, k1=100.0, k2=500.0, b1=20.0, b2=20.0, Fc=0.5))
    motion = true_motion(run(*tones(2.0, (0.01, 0.9), (0.004, 3.1), (0.001, 7.3))))
    force, slope = sensitivity(truth, motion)
    bound = np.sqrt(np.diag(covariances(slope, NOISE, SIZE[OBJECT])[-1]))
    x, random, fits = unknowns(truth.theta())[OBJECT], np.random.default_rng(0), []

    def simulated(at):
        theta = theta_of(at, Stick(), np.ones(2))
        values = dict(zip(("m", "k1", "k2", "b1", "b2", "Fc"), map(float, theta), strict=False))
        return replayed(truth.with_parameters(**values), motion)["force_y"]

    bounds = LOW[OBJECT], HIGH[OBJECT], SIZE[OBJECT]
    for _ in range(40):
        measured = force[:, 1] + NOISE * random.standard_normal(len(force))
        fit = minimise(lambda at, data=measured: (simulated(at) - data) / NOISE, x, *bounds, steps=4)
        fits.append(fit.x - x)
    scatter = np.sqrt(np.mean(np.square(fits), axis=0))
    # 40 fits tell a deviation to 11 %.
    assert np.all(scatter > 0.7 * bound) and np.all(scatter < 1.35 * bound)


def test_twice_the_noise_takes_four_times_as_long_and_time_off_contact_does_not_count():
    soft = FlexibleBoxModel(parameters=BoxParameters(k1=50.0, b1=20.0, b2=20.0))
    y, rate = tones(24.0, (0.0008, 1.7), (0.0008, 3.1), (0.0004, 6.3))
    less, more = (noise_bound(soft, run(y, rate), noise, 5) for noise in (NOISE, 2.0 * NOISE))
    for name in ("m", "k1", "k2"):
        assert more.allows_s[name] == pytest.approx(4.0 * less.allows_s[name], rel=0.2)
    assert less.allows_s["Fc"] is None  # nothing is near a truth of zero
    assert more.leaves["all"] == pytest.approx(2.0 * less.leaves["all"], rel=1e-6)
    off = np.zeros(len(y))
    off[4000:] = 1.0
    late = noise_bound(soft, run(np.where(off, y, 0.0), np.where(off, rate, 0.0), off), NOISE, 5)
    assert late.allows_s["k2"] == pytest.approx(less.allows_s["k2"], rel=0.2)


def test_a_bound_needs_noise():
    with pytest.raises(BadInput, match="deviation above 0 N"):
        noise_bound(FlexibleBoxModel(), run(*tones(6.0, (0.01, 1.0))), 0.0, 5)


def test_what_noise_alone_allows_within_three_seconds_has_to_be_found_within_three_seconds():
    found = {"m": 2.9, "k2": 3.1, "b1": None, "b2": None, "Fc": 1.0}
    allowed = {"m": 0.2, "k2": 3.0, "b1": 1.0, "b2": 3.1, "Fc": None}
    figures = parameters_found("strokes", found, allowed)
    forbidden = "the noise forbids it"
    said = {name: figure.verdict for name, figure in figures.items()}
    assert said == {"m": "reached", "k2": "missed", "b1": "missed", "b2": forbidden, "Fc": forbidden}
    cells = [figure.cell() for figure in figures.values()]
    assert cells == ["2.9 / 0.2 ✓", "3.1 / 3 ✗", "never / 1 ✗", "never / 3.1", "1"]
    assert tuple(said) == FOUND
