"""Bounded least squares: its minima in closed form."""

import numpy as np
import pytest

from mmt_drake.numeric.least_squares import minimise

ONE = np.ones(1)


def test_a_linear_problem_ends_at_the_solution_of_its_normal_equations() -> None:
    rng = np.random.default_rng(3)
    a, b = rng.standard_normal((40, 3)), rng.standard_normal(40)
    found = minimise(lambda x: a @ x - b, np.zeros(3), -9.0 * np.ones(3), 9.0 * np.ones(3), np.ones(3))
    assert found.x == pytest.approx(np.linalg.solve(a.T @ a, a.T @ b), abs=1e-6) and found.converged


def test_a_minimum_beyond_a_bound_is_sought_at_the_bound() -> None:
    found = minimise(lambda x: x - 5.0, np.zeros(1), -ONE, 2.0 * ONE, ONE)
    assert found.x == pytest.approx(2.0)


def test_a_time_constant_is_not_thrown_to_nothing_by_one_step() -> None:
    """At next to nothing what decays is gone before the first sample, and no slope leads back."""
    at = np.arange(0.1, 10.0, 0.1)
    start = np.array([3.0])
    found = minimise(
        lambda tau: np.exp(-at / tau) - np.exp(-at / 0.1), start, 1e-6 * ONE, np.inf * ONE, start, converged_at=1e-12
    )
    assert found.x == pytest.approx(0.1, rel=1e-6)
