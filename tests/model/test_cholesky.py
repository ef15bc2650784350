"""The allocation-free Cholesky solver agrees with numpy and notices matrices that have no factor."""

import numpy as np
import pytest

from mmt_drake.model.cholesky import cholesky_factor, cholesky_solve


@pytest.mark.parametrize("n", [1, 2, 5, 7])
def test_it_solves_what_numpy_solves(n: int) -> None:
    rng = np.random.default_rng(n)
    root = rng.standard_normal((n, n)) + 3 * np.eye(n)
    A, y = root @ root.T, rng.standard_normal(n)
    factor, x = A.copy(), y.copy()
    assert cholesky_factor(factor)
    np.testing.assert_allclose(np.tril(factor), np.linalg.cholesky(A), rtol=1e-10, atol=1e-12)
    cholesky_solve(factor, x)
    np.testing.assert_allclose(x, np.linalg.solve(A, y), rtol=1e-8)


def test_an_indefinite_matrix_has_no_factor() -> None:
    assert not cholesky_factor(np.array([[1.0, 2.0], [2.0, 1.0]]))
