"""A first guess of an object by its looks and by like objects."""

import math

import numpy as np
import pytest

from mmt_drake.estimation.first_guess import DENSITY, FRICTION, NARROWEST, WIDEST, guess
from mmt_drake.model.parameters import THETA
from mmt_drake.model.theta import NO_FLAW, flaw_of_theta
from mmt_drake.numeric.arrays import Array

M, K2, FC = (THETA.index(symbol) for symbol in ("m", "k2", "Fc"))
NO_COLOUR = (math.nan,) * 3
CUBE = np.array([0.05, 0.1, 0.1, *NO_COLOUR])
YELLOW, RED = (82.0, -5.0, 64.0), (39.0, 36.0, 26.0)


def guessed(looks: Array, others: Array, thetas: Array) -> tuple[Array, float]:
    theta = np.empty(len(THETA))
    return theta, guess(np.asarray(looks, float), others, thetas, len(others), theta)


def test_without_any_other_it_is_what_is_believed_beforehand_with_the_widest_deviation() -> None:
    theta, deviation = guessed(CUBE, np.zeros((0, 6)), np.zeros((0, 10)))
    assert theta[M] == pytest.approx(DENSITY * 5e-4)
    assert theta[FC] == pytest.approx(FRICTION * 9.81 * theta[M])
    assert deviation == WIDEST


def test_the_mass_of_a_like_object_comes_by_volume_and_many_of_them_outweigh_the_belief() -> None:
    known = np.array([0.2, 0.0, 800.0, 0.0, 10.0, 0.4, 800.0, 10.0, 0.4, 0.0])  # of 400 kg/m^3
    others, thetas = np.tile(CUBE, (9, 1)), np.tile(known, (9, 1))
    theta, deviation = guessed(CUBE * [1.0, 1.1, 1.0, 1.0, 1.0, 1.0], others, thetas)
    weight = 9.0 * math.exp(-0.5 * (math.log(1.1) / 0.5) ** 2)
    density = math.exp((math.log(DENSITY) + weight * math.log(400.0)) / (1.0 + weight))
    assert theta[M] == pytest.approx(density * 5.5e-4, rel=1e-9)
    assert deviation == NARROWEST


def test_an_object_that_is_not_alike_says_nothing() -> None:
    known = np.array([20.0, 0.0, 9000.0, 0.0, 100.0, 15.0, 9000.0, 100.0, 15.0, 0.0])
    alone, _ = guessed(CUBE, np.zeros((0, 6)), np.zeros((0, 10)))
    beside, deviation = guessed(CUBE, np.array([[0.4, 0.5, 0.5, *NO_COLOUR]]), known[None])
    np.testing.assert_allclose(beside, alone, rtol=1e-2)
    assert deviation == pytest.approx(WIDEST, rel=1e-2)


def test_of_two_of_one_size_the_one_of_like_colour_is_believed() -> None:
    light = np.array([0.2, 0.0, 300.0, 0.0, 10.0, 0.4, 300.0, 10.0, 0.4, 0.0])
    heavy = np.array([2.0, 0.0, 3000.0, 0.0, 30.0, 8.0, 3000.0, 30.0, 8.0, 0.0])
    others = np.array([[*CUBE[:3], *YELLOW], [*CUBE[:3], *RED]])
    thetas = np.array([light, heavy])
    guesses = [guessed([*CUBE[:3], *colour], others, thetas)[0] for colour in (YELLOW, NO_COLOUR, RED)]
    believed = DENSITY * 5e-4
    for theta, (to_light, to_heavy) in zip(guesses, ((1.0, 0.3), (1.0, 1.0), (0.3, 1.0)), strict=True):
        weights = 1.0, to_light, to_heavy
        mass = math.exp(np.average(np.log([believed, 0.2, 2.0]), weights=weights))
        assert theta[M] == pytest.approx(mass, rel=0.01)
    assert guesses[0][FC] < guesses[1][FC] < guesses[2][FC]


def test_no_guess_is_unstable_or_cannot_be_integrated_whatever_is_remembered() -> None:
    random = np.random.default_rng(3)
    for _ in range(500):
        count = int(random.integers(0, 5))
        others = random.uniform(-100.0, 100.0, (count, 6))
        others[:, :3] = 10.0 ** random.uniform(-3.0, 0.5, (count, 3))
        thetas = 10.0 ** random.uniform(-4.0, 6.0, (count, 10)) * random.choice([0.0, 1.0], (count, 10))
        theta, deviation = guessed([*10.0 ** random.uniform(-4.0, 0.5, 3), *YELLOW], others, thetas)
        assert np.isfinite(theta).all() and (theta >= 0.0).all()
        assert flaw_of_theta(theta, 1e-5) == NO_FLAW
        m, k1, k2, b1, b2 = theta[:5]
        assert np.linalg.eigvals([[0.0, 1.0], [-(k1 + k2) / m, -(b1 + b2) / m]]).real.max() < 0.0
        assert NARROWEST <= deviation <= WIDEST
