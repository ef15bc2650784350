"""The recursion of eq. 4-5 is batch least squares, and with forgetting the exponentially weighted one."""

import numpy as np
import pytest

from mmt_drake.estimation.thesis import rls_update


def data(rows: int, n: int = 7) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(rows)
    psi = rng.standard_normal((rows, n)) * 10.0 ** np.linspace(-2, 3, n)  # as far apart as x and its third derivative
    return psi, psi @ rng.standard_normal(n) + 0.1 * rng.standard_normal(rows)


def recursion(psi: np.ndarray, y: np.ndarray, P0: float, forgetting: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    n = psi.shape[1]
    theta, P, gain = np.zeros(n), P0 * np.eye(n), np.zeros(n)
    for row, value, factor in zip(psi, y, forgetting, strict=True):
        rls_update(theta, P, row, value, factor, gain)
    return theta, P


def batch(psi: np.ndarray, y: np.ndarray, P0: float, weight: np.ndarray, prior: float) -> tuple[np.ndarray, np.ndarray]:
    """Minimum of sum weight (y - psi theta)^2 + prior theta^2/P0, by a QR decomposition, and its inverse Hessian."""
    n = psi.shape[1]
    stacked = np.vstack([np.sqrt(weight)[:, None] * psi, np.sqrt(prior / P0) * np.eye(n)])
    q, r = np.linalg.qr(stacked)
    inverse = np.linalg.inv(r)
    return inverse @ (q.T @ np.append(np.sqrt(weight) * y, np.zeros(n))), inverse @ inverse.T


@pytest.mark.parametrize("P0", [1.0, 1e6])
def test_without_forgetting_it_is_least_squares_with_a_prior(P0: float) -> None:
    psi, y = data(3000)
    theta, P = recursion(psi, y, P0, np.ones(3000))
    expected, covariance = batch(psi, y, P0, np.ones(3000), 1.0)
    np.testing.assert_allclose(theta, expected, rtol=1e-6)
    np.testing.assert_allclose(
        P, covariance, rtol=1e-5, atol=1e-5 * np.sqrt(np.outer(*[np.diag(covariance)] * 2)).min()
    )


def test_one_step_is_eq_4_and_5_as_printed() -> None:
    rng = np.random.default_rng(1)
    theta, psi, y = rng.standard_normal(3), rng.standard_normal(3), 0.7
    root = rng.standard_normal((3, 3))
    P = root @ root.T
    expected_theta = theta - P @ psi / (1 + psi @ P @ psi) * (psi @ theta - y)
    expected_P = P - np.outer(P @ psi, psi @ P) / (1 + psi @ P @ psi)
    rls_update(theta, P, psi, y, 1.0, np.zeros(3))
    np.testing.assert_allclose(theta, expected_theta, rtol=1e-13)
    np.testing.assert_allclose(P, expected_P, atol=1e-13)


def test_forgetting_weighs_the_past_exponentially() -> None:
    psi, y = data(400)
    factor = 0.99
    theta, P = recursion(psi, y, 10.0, np.full(400, factor))
    weight = factor ** np.arange(399, -1, -1)
    expected, covariance = batch(psi, y, 10.0, weight, factor**400)
    np.testing.assert_allclose(theta, expected, rtol=1e-7)
    np.testing.assert_allclose(np.diag(P), np.diag(covariance), rtol=1e-7)


def test_two_rows_of_one_instant_are_forgotten_once() -> None:
    psi, y = data(400)
    theta, _ = recursion(psi, y, 10.0, np.tile([0.98, 1.0], 200))
    weight = 0.98 ** np.repeat(np.arange(199, -1, -1), 2)
    np.testing.assert_allclose(theta, batch(psi, y, 10.0, weight, 0.98**200)[0], rtol=1e-7)


def test_psi_of_zero_changes_nothing() -> None:
    psi, y = data(50)
    theta, P = recursion(psi, y, 1e3, np.ones(50))
    before = theta.copy(), P.copy()
    rls_update(theta, P, np.zeros(7), 5.0, 1.0, np.zeros(7))
    assert np.array_equal(theta, before[0]) and np.array_equal(P, before[1])


def test_the_covariance_stays_symmetric_to_the_last_bit_and_positive() -> None:
    psi, y = data(20000)
    _, P = recursion(psi, y, 1e6, np.ones(20000))
    assert np.array_equal(P, P.T)
    scale = 1.0 / np.sqrt(np.diag(P))
    assert np.linalg.eigvalsh(P * np.outer(scale, scale)).min() > 0
