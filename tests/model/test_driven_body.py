"""The driven body against closed forms."""

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.model import driven_body as driven
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity


def replay(model, time, u, start=0.0):
    n = len(time)
    state, load, output, rate = np.empty(driven.STATE_SIZE), np.zeros(n), np.empty(n), np.empty(n)
    driven.begin(state, time[0], u[0], 0.0, start)
    driven.replay_part(0, n, time, u, load, model.kernel_vector(), state, output, rate)
    return output, rate


def test_a_falling_ball_follows_the_parabola():
    t = np.arange(0, 3, 1 / 15)
    output, rate = replay(DrivenBodyModel(m=0.2, gravity=Gravity("constant", 9.81)), t, 0 * t, start=47.0)
    np.testing.assert_allclose(output, 47 - 0.5 * 9.81 * t**2, rtol=1e-13)
    np.testing.assert_allclose(rate, -9.81 * t, atol=1e-12)


def test_viscous_friction_gives_the_exponential():
    t = np.arange(0, 2, 1e-3)
    _, rate = replay(DrivenBodyModel(m=2, b=6, gain=3, offset=1.5), t, np.ones_like(t))
    np.testing.assert_allclose(rate, 4.5 / 6 * (1 - np.exp(-3 * t)), atol=1e-8)


def test_a_linear_input_is_integrated_exactly():
    t = np.cumsum(np.random.default_rng(0).uniform(0.002, 0.02, 200))
    output, _ = replay(DrivenBodyModel(m=0.5, gain=2), t, 3 * (t - t[0]))
    np.testing.assert_allclose(output, 2 * 3 * (t - t[0]) ** 3 / 6 / 0.5, rtol=1e-11, atol=1e-13)


def test_a_pendulum_swings_with_its_large_amplitude_period():
    # Period 4 sqrt(J / value) K(sin(a / 2)) of the mathematical pendulum, K the elliptic integral.
    from scipy.special import ellipk

    t = np.arange(0, 30, 5e-3)
    amplitude = 2.0
    output, _ = replay(DrivenBodyModel(m=0.03, gravity=Gravity("pendulum", 0.3)), t, 0 * t, start=amplitude)
    crossings = np.flatnonzero((output[:-1] > 0) & (output[1:] <= 0))
    period = np.diff(t[crossings] + 5e-3 * output[crossings] / (output[crossings] - output[crossings + 1])).mean()
    assert period == pytest.approx(4 * np.sqrt(0.03 / 0.3) * ellipk(np.sin(amplitude / 2) ** 2), rel=1e-5)
    assert np.abs(output).max() == pytest.approx(amplitude, rel=1e-6)


@pytest.mark.parametrize("wrong", [{"m": 0}, {"m": 1, "b": -1}, {"m": 1, "gain": float("inf")}])
def test_meaningless_parameters_are_refused(wrong):
    with pytest.raises(BadInput, match="parameters"):
        DrivenBodyModel(**wrong)


def test_between_two_samples_a_body_may_turn_eight_hundred_times_but_not_without_end():
    # Coulomb friction takes 2 Fc / k from the amplitude of a spring's swing at every turn.
    m, k, Fc, turns = 0.5, 40.0, 0.01, 800
    half = np.pi * np.sqrt(m / k)
    output, _ = replay(DrivenBodyModel(m=m, k=k, Fc=Fc), np.array([0.0, turns * half]), np.zeros(2), start=1.0)
    assert output[1] == pytest.approx(1.0 - 2.0 * Fc / k * turns, rel=1e-3)
    with pytest.raises(RuntimeError, match="sticks and slides more than 1000 times"):
        replay(DrivenBodyModel(m=m, k=k, Fc=Fc / 10.0), np.array([0.0, 1100 * half]), np.zeros(2), start=1.0)


def test_the_state_at_a_windows_begin_is_the_weighted_least_squares_one():
    # A body that a damper alone holds: x = x0 + v0 (1 - exp(-b t / m)) m / b, linear in its state.
    random, m, b = np.random.default_rng(4), 0.5, 2.0
    model, t, n = DrivenBodyModel(m=m, b=b), np.cumsum(random.uniform(0.002, 0.02, 200)), 200
    rows, used = np.array([[0, 60, 60, 100], [100, 150, 150, 200]]), random.random(n) < 0.7
    guess, weight = np.array([[0.5, 0.9], [400.0, -0.4]]), np.array([[0.2, 0.5], [1.0, 0.1]])
    measured, states = np.repeat([0.1, 400.3], 100) + random.normal(0.0, 0.05, n), np.empty((2, 2))
    output, rate, still = np.empty(n), np.empty(n), np.zeros(n)
    driven.replay_windows(
        rows,
        np.ones(2, dtype=bool),
        used,
        guess,
        weight,
        measured,
        t,
        still,
        still,
        model.kernel_vector(),
        output,
        rate,
        states,
    )
    for (first, lead, scored, end), found, near, share in zip(rows, states, guess, weight, strict=True):
        moved = np.column_stack([np.ones(end - first), -np.expm1(-b / m * (t[first:end] - t[first])) * m / b])
        seen = np.flatnonzero(used[first:lead])
        system = np.vstack([moved[seen], np.diag(np.sqrt(share))])
        expected = np.linalg.lstsq(system, np.append(measured[first + seen], np.sqrt(share) * near))[0]
        np.testing.assert_allclose(found, expected, rtol=1e-6)
        np.testing.assert_allclose(output[scored:end], (moved @ expected)[scored - first :], rtol=1e-6)
