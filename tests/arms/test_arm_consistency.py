"""Numbers that no body can have become the nearest that one can have."""

import numpy as np
import pytest

from mmt_drake.arms.consistency import is_consistent, nearest_consistent, pseudo_inertia


def body(rng: np.random.Generator) -> np.ndarray:
    """Ten numbers of eight random points."""
    points, masses = rng.uniform(-0.3, 0.3, (8, 3)), rng.uniform(0.1, 0.6, 8)
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return np.array([masses.sum(), *(masses @ points), *(inertia[i, j] for i, j in order)])


def numbers_of(pseudo: np.ndarray) -> np.ndarray:
    """The ten numbers of a pseudo-inertia: Ixx is what the second moments of y and z add up to."""
    xx, yy, zz = np.diag(pseudo)[:3]
    off = (-pseudo[0, 1], -pseudo[0, 2], -pseudo[1, 2])
    return np.array([pseudo[3, 3], *pseudo[:3, 3], yy + zz, xx + zz, xx + yy, *off])


def clipped(numbers: np.ndarray, least: float) -> np.ndarray:
    """The naive way: eigenvalues of the pseudo-inertia that are too small are set to the least."""
    values, vectors = np.linalg.eigh(pseudo_inertia(numbers))
    return numbers_of(vectors @ np.diag(np.maximum(values, least)) @ vectors.T)


def cost(step: np.ndarray, weight: np.ndarray) -> float:
    return float(step.ravel() @ weight @ step.ravel())


def test_the_pseudo_inertia_of_points_is_the_sum_of_their_squares() -> None:
    rng = np.random.default_rng(0)
    points, masses = rng.standard_normal((5, 3)), rng.uniform(0.1, 1.0, 5)
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    order = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    numbers = np.array([masses.sum(), *(masses @ points), *(inertia[i, j] for i, j in order)])
    longer = np.column_stack([points, np.ones(5)])
    np.testing.assert_allclose(pseudo_inertia(numbers), longer.T @ np.diag(masses) @ longer, atol=1e-12)
    np.testing.assert_allclose(numbers_of(pseudo_inertia(numbers)), numbers, atol=1e-12)
    assert is_consistent(numbers)


def test_numbers_that_bodies_can_have_stay_as_they_are() -> None:
    rng = np.random.default_rng(1)
    found = np.stack([body(rng), body(rng)])
    np.testing.assert_array_equal(nearest_consistent(found, np.eye(20), found), found)


@pytest.mark.parametrize("seed", range(6))
def test_others_become_consistent_and_nearer_than_by_clipping(seed: int) -> None:
    rng = np.random.default_rng(10 + seed)
    believed = np.stack([body(rng), body(rng)])
    wrong = believed.copy()
    wrong[0, 4 + seed % 3] *= -0.5  # no body turns more easily than not at all
    wrong[1, 1:4] *= 3.0
    assert not all(map(is_consistent, wrong))
    root = rng.standard_normal((20, 20))
    weight = root @ root.T + 0.1 * np.eye(20)
    found = nearest_consistent(wrong, weight, believed)
    assert all(map(is_consistent, found))
    naive = np.stack(
        [clipped(w, 1e-6 * float(np.trace(pseudo_inertia(b)))) for w, b in zip(wrong, believed, strict=True)]
    )
    assert all(map(is_consistent, naive))
    assert cost(found - wrong, weight) < cost(naive - wrong, weight)
    for part in (0.3, 0.1):  # no point on the way back to what was believed is nearer
        between = found + part * (believed - found)
        assert cost(found - wrong, weight) <= cost(between - wrong, weight)


def test_a_body_whose_moments_are_small_beside_its_mass_is_made_possible_at_little_cost() -> None:
    # As a fit found a payload in a hand: moments of a thousandth of its mass, and two of them negative.
    found = np.array([[1.436, 0.0529, 0.0801, -0.0185, 0.0035, 0.0022, 0.0064, -0.0030, 0.0002, 0.0009]])
    assert not is_consistent(found[0])
    weight = np.diag([1e6, 1e8, 1e8, 1e8, *[1e9] * 6])
    moved = nearest_consistent(found, weight, found)
    assert is_consistent(moved[0])
    assert 0.0 < cost(moved - found, weight) < cost(clipped(found[0], 1e-9) - found[0], weight)
