"""Bounded least squares against closed forms: lines, active bounds, derivatives that are already known."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from mmt_drake.errors import MmtError
from mmt_drake.numeric.least_squares import minimise, stay

FREE = np.full(4, -np.inf), np.full(4, np.inf)
ONES = np.ones(4)


def linear(seed=0, n=60, k=4):
    """A and b of the residual A x - b, no column far from unit length."""
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, k)) / np.sqrt(n), rng.standard_normal(n)


class Counted:
    """A residual that knows where it was evaluated."""

    def __init__(self, residual):
        self.residual, self.at = residual, []

    def __call__(self, x):
        self.at.append(x.copy())
        return self.residual(x)


def test_a_linear_problem_ends_at_the_normal_equations_answer():
    A, b = linear()
    found = minimise(lambda x: A @ x - b, np.zeros(4), *FREE, ONES)
    expected = np.linalg.lstsq(A, b, rcond=None)[0]
    np.testing.assert_allclose(found.x, expected, atol=1e-6)
    np.testing.assert_allclose(found.jacobian, A, atol=1e-9)
    np.testing.assert_allclose(found.residual, A @ found.x - b, atol=1e-14)
    assert found.converged and found.cost == pytest.approx(found.residual @ found.residual)
    # Columns that differ by orders of magnitude are made equal by their scales.
    scale = np.array([1e-4, 1.0, 50.0, 1e5])
    found = minimise(lambda x: A @ (x / scale) - b, np.zeros(4), *FREE, scale)
    np.testing.assert_allclose(found.x / scale, expected, atol=1e-6)
    np.testing.assert_allclose(found.jacobian, A / scale, rtol=1e-6, atol=1e-9 / scale.min())


@pytest.mark.parametrize("seed", range(12))
def test_active_bounds_are_where_the_conditions_of_karush_kuhn_and_tucker_have_them(seed):
    A, b = linear(seed)
    low, high = np.full(4, -0.4), np.full(4, 0.4)
    found = minimise(lambda x: A @ x - b, np.zeros(4), low, high, ONES)
    expected = lsq_linear(A, b, (low, high), method="bvls", tol=1e-14).x
    assert np.any(np.abs(expected) > 0.399)  # or there would be nothing to see
    np.testing.assert_allclose(found.x, expected, atol=0.02)  # a fiftieth of the standard error, which is 1 here
    assert np.all(low <= found.x) and np.all(found.x <= high) and found.converged
    exact = np.sum((A @ expected - b) ** 2)
    assert found.cost <= exact * (1 + 1e-5)


def test_nothing_outside_the_bounds_is_ever_evaluated_not_even_for_a_difference():
    A, b = linear(3)
    low, high = np.array([-0.2, -0.2, 0.0, -1.0]), np.array([0.2, 0.0, 0.3, 1.0])
    residual = Counted(lambda x: A @ x - b)
    found = minimise(residual, np.array([5.0, 0.0, 0.3, -7.0]), low, high, ONES)
    assert all(np.all(low <= x) and np.all(x <= high) for x in residual.at)
    np.testing.assert_allclose(found.jacobian, A, atol=1e-9)  # at an upper bound the difference is taken backwards
    assert found.simulations == len(residual.at)


def test_a_parameter_between_equal_bounds_stays_and_the_rest_is_fitted():
    A, b = linear(5)
    low, high = np.array([-9.0, 0.7, -9.0, -9.0]), np.array([9.0, 0.7, 9.0, 9.0])
    found = minimise(lambda x: A @ x - b, np.full(4, 0.7), low, high, ONES)
    rest = [0, 2, 3]
    expected = np.linalg.lstsq(A[:, rest], b - 0.7 * A[:, 1], rcond=None)[0]
    np.testing.assert_allclose(found.x[rest], expected, atol=1e-6)
    assert found.x[1] == 0.7


def test_a_parameter_that_changes_next_to_nothing_stays_where_it_is_and_does_not_hold_up_the_others():
    A, b = linear(1)
    rng = np.random.default_rng(1)
    idle = 1e-9 * rng.standard_normal(len(b))
    found = minimise(
        lambda x: A @ x[:4] + idle * x[4] - b, np.full(5, 3.0), np.full(5, -99), np.full(5, 99), np.ones(5)
    )
    np.testing.assert_allclose(found.x[:4], np.linalg.lstsq(A, b, rcond=None)[0], atol=1e-6)
    assert found.x[4] == 3.0 and found.converged
    np.testing.assert_allclose(found.jacobian[:, 4], idle, atol=1e-12)  # what it does is told all the same


def test_known_derivatives_are_used_and_not_simulated_again():
    A, b = linear(7)
    known = np.full(A.shape, np.nan)
    known[:, :3] = A[:, :3]
    residual, all_of_them = Counted(lambda x: A @ x - b), Counted(lambda x: A @ x - b)
    found = minimise(residual, np.zeros(4), *FREE, ONES, known=known)
    minimise(all_of_them, np.zeros(4), *FREE, ONES)
    np.testing.assert_allclose(found.x, np.linalg.lstsq(A, b, rcond=None)[0], atol=1e-6)
    jacobians = len(all_of_them.at) - len(residual.at)
    assert jacobians > 0 and jacobians % 3 == 0  # three simulations less for each
    # What is said to change nothing is not moved.
    known[:, :3] = 0.0
    found = minimise(lambda x: A @ x - b, np.zeros(4), *FREE, ONES, known=known)
    np.testing.assert_array_equal(found.x[:3], 0.0)
    assert found.x[3] == pytest.approx(A[:, 3] @ b / (A[:, 3] @ A[:, 3]), rel=1e-5)


def test_a_decay_is_found_from_far_off():
    t = np.linspace(0.0, 2.0, 200)
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(t))
    measured = 3.0 * np.exp(-t / 0.4) + 0.5 + noise

    def residual(x):
        return x[0] * np.exp(-t / x[1]) + x[2] - measured

    start, scale = np.array([1.0, 2.0, 0.0]), np.array([1.0, 0.5, 1.0])
    low, high = np.array([0.0, 0.01, -10.0]), np.array([100.0, 10.0, 10.0])
    found = minimise(residual, start, low, high, scale)
    np.testing.assert_allclose(found.x, [3.0, 0.4, 0.5], atol=3e-3)
    assert found.converged and found.cost == pytest.approx(noise @ noise, rel=0.05)
    short = minimise(residual, start, low, high, scale, steps=2)
    assert not short.converged and found.cost < short.cost < np.sum(residual(start) ** 2)


@pytest.mark.parametrize("failure", [lambda: np.full(3, np.nan), lambda: np.full(3, np.inf), None])
def test_where_a_simulation_fails_is_a_step_too_far(failure):
    """The minimum of (ln x - ln 2)^2 lies beside a region that cannot be simulated, which a full step would enter."""

    def residual(x):
        if x[0] <= 0.5:
            if failure is None:
                raise MmtError("diverged")
            return failure()
        return np.array([np.log(x[0] / 2.0), 1e-6, 0.0])

    found = minimise(residual, np.array([9.0]), np.array([-1e9]), np.array([1e9]), np.array([1.0]))
    assert found.x[0] == pytest.approx(2.0, rel=1e-4)
    at_once = residual if failure is None else Counted(residual)
    with pytest.raises(MmtError, match="diverges at the start"):
        minimise(at_once, np.array([0.1]), np.array([-1e9]), np.array([1e9]), np.array([1.0]))
    with pytest.raises(MmtError, match="diverges at the start"):
        stay(at_once, np.array([0.1]), np.array([-1e9]), np.array([1e9]), np.array([1.0]))


def test_a_jacobian_that_is_carried_on_leads_to_the_same_minimum_for_fewer_simulations():
    rng = np.random.default_rng(0)
    A, truth = rng.standard_normal((300, 12)) / 3.0, rng.uniform(-1.0, 1.0, 12)
    measured = np.tanh(A @ truth) + 0.01 * rng.standard_normal(300)
    start, bound, ones = truth + rng.uniform(-0.5, 0.5, 12), np.full(12, 9.0), np.ones(12)
    simulated, carried = (
        minimise(lambda x: np.tanh(A @ x) - measured, start, -bound, bound, ones, converged_at=1e-6, secant=secant)
        for secant in (False, True)
    )
    np.testing.assert_allclose(carried.x, simulated.x, atol=1e-3)
    assert carried.converged and carried.cost == pytest.approx(simulated.cost, rel=1e-5)
    assert carried.simulations < simulated.simulations
    # Where a fit ends, derivatives were simulated last: they are good enough for intervals.
    size = np.linalg.norm(simulated.jacobian, axis=0)
    assert np.all(np.linalg.norm(carried.jacobian - simulated.jacobian, axis=0) < 0.01 * size)


@pytest.mark.parametrize("secant", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_no_fit_ends_worse_than_it_began(seed, secant):
    rng = np.random.default_rng(seed)
    A, B, b = rng.standard_normal((30, 3)), rng.standard_normal((30, 3)), rng.standard_normal(30)

    def rough(x):  # with a staircase as friction makes it
        return np.sin(A @ x) + 0.3 * np.floor(5.0 * (B @ x)) / 5.0 - b

    start = rng.uniform(-2.0, 2.0, 3)
    found = minimise(rough, start, np.full(3, -2.0), np.full(3, 2.0), np.ones(3), secant=secant)
    assert found.cost <= np.sum(rough(start) ** 2)
    np.testing.assert_array_equal(found.residual, rough(found.x))


def test_staying_gives_residual_and_derivatives_and_moves_nothing():
    A, b = linear(9)
    x, scale = np.array([0.3, -0.2, 0.0, 2.0]), np.array([1.0, 10.0, 0.1, 1.0])
    found = stay(lambda x: A @ x - b, x, *FREE, scale)
    np.testing.assert_array_equal(found.x, x)
    np.testing.assert_allclose(found.residual, A @ x - b, atol=1e-15)
    np.testing.assert_allclose(found.jacobian, A, atol=1e-8)
    assert found.simulations == 5


def test_a_time_constant_is_not_thrown_to_nothing_by_one_step() -> None:
    """At next to nothing what decays is gone before the first sample, and no slope leads back."""
    at = np.arange(0.1, 10.0, 0.1)
    low, high, start = np.array([1e-6]), np.array([np.inf]), np.array([3.0])
    found = minimise(lambda tau: np.exp(-at / tau) - np.exp(-at / 0.1), start, low, high, start, converged_at=1e-12)
    assert found.x == pytest.approx(0.1, rel=1e-6)


@pytest.mark.parametrize("start", [0.4, 1.7])
def test_a_valley_whose_sides_are_rough_is_gone_down_to_its_floor(start: float) -> None:
    """A parabola with a wave on it whose slope turns thrice within a hundredth of the parameter."""

    def residual(x: np.ndarray) -> np.ndarray:
        return np.array([x[0] - 1.0 + 0.01 * np.sin(1e3 * x[0]), 0.1 * x[1]])

    wide = np.full(2, np.inf)
    rough = np.array([True, False])
    found = minimise(residual, np.array([start, 1.0]), -wide, wide, np.ones(2), rough=rough)
    stuck = minimise(residual, np.array([start, 1.0]), -wide, wide, np.ones(2))
    assert abs(found.x[0] - 1.0) < 0.02 < abs(stuck.x[0] - 1.0)
