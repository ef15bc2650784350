"""Transfer function and stability against independent forms."""

import numpy as np
import pytest

from mmt_drake.model.linear import is_stable, state_space, transfer_function
from mmt_drake.model.parameters import BoxParameters

P = BoxParameters(m=1.3, k1=40, k2=700, b1=25, b2=12)


def test_transfer_function_is_the_impedance_of_the_springs_and_mass_in_series():
    s = np.array([0.3 + 2j, 5j, -1 + 30j])
    contact = P.k2 + P.b2 * s
    body = P.m * s**2 + P.b1 * s + P.k1
    np.testing.assert_allclose(transfer_function(P, s), 1 / (1 / contact + 1 / body), rtol=1e-13)


def test_static_stiffness_is_two_springs_in_series():
    assert transfer_function(P, 0j) == pytest.approx(40 * 700 / 740)


def test_stability_is_the_sign_of_the_eigenvalues():
    random = np.random.default_rng(3)
    seen = set()
    for m, k1, k2, b1, b2 in random.normal(size=(500, 5)):
        expected = bool(np.all(np.roots([m, b1 + b2, k1 + k2]).real < 0))
        assert is_stable(m, k1, k2, b1, b2) == expected
        seen.add(expected)
    assert seen == {True, False}


def test_the_state_space_has_the_transfer_function():
    A, B, C, D = state_space(P)
    for s in (0j, 0.3 + 2j, 5j, -1 + 30j):
        answer = C @ np.linalg.solve(s * np.eye(2) - A, B) + D
        assert (answer @ [1.0, s]).item() == pytest.approx(transfer_function(P, s), rel=1e-12)
