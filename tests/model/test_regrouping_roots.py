"""Real roots of the polynomials of eq. 30, against numpy's."""

import numpy as np
import pytest

from mmt_drake.model.regrouping_roots import cubic_roots, quadratic_roots


def test_cubic_roots_are_the_real_ones_of_numpy() -> None:
    rng = np.random.default_rng(3)
    out = np.empty(3)
    for _ in range(300):
        c = rng.standard_normal(4) * 10.0 ** rng.uniform(-3, 3, 4)
        n = cubic_roots(*c, out)
        expected = np.roots(c)
        real = np.sort(expected[abs(expected.imag) < 1e-9 * abs(expected)].real)
        np.testing.assert_allclose(np.sort(out[:n]), real, rtol=1e-9)


@pytest.mark.parametrize("roots", [(2.0, 2.0, -5.0), (-1.0, 3.0, 3.0), (1e-4, 1e-4, 3e5), (0.0, 0.0, 7.0)])
def test_cubic_roots_keep_a_multiple_root(roots: tuple[float, ...]) -> None:
    out = np.empty(3)
    n = cubic_roots(*(0.7 * np.poly(roots)), out)
    assert n == 3
    np.testing.assert_allclose(np.sort(out), np.sort(roots), rtol=1e-6)


@pytest.mark.parametrize("roots", [(2.0, -3.0, 5.0), (2.0, 1.0 + 3.0j, 1.0 - 3.0j), (4.0, 4.0, 4.0), (0.0, 0.0, 0.0)])
def test_cubic_roots_leave_alone_what_lies_behind_them(roots: tuple[complex, ...]) -> None:
    out, behind = np.full(7, 1e-9), roots[0] * 1.0001
    out[3:] = behind  # near enough to a root to be taken for one
    n = cubic_roots(*(1.7 * np.poly(roots)).real, out[:3])
    np.testing.assert_allclose(np.sort(out[:n]), np.sort([x.real for x in roots if x.imag == 0.0]), rtol=1e-4)
    np.testing.assert_array_equal(out[3:], behind)


def test_quadratic_roots_do_not_cancel_and_join_complex_pairs_only_when_asked() -> None:
    out = np.empty(2)
    assert quadratic_roots(1.0, -1e8, 1.0, False, out) == 2
    np.testing.assert_allclose(np.sort(out), [1e-8, 1e8], rtol=1e-14)
    assert quadratic_roots(1.0, -2.0, 5.0, False, out) == 0
    assert quadratic_roots(1.0, -2.0, 5.0, True, out) == 1 and out[0] == 1.0
    assert quadratic_roots(0.0, 2.0, -6.0, False, out) == 1 and out[0] == 3.0
