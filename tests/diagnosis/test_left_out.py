"""What fits leave of blocks left out, and whether chance puts one before another there."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from trial_samples import COULOMB, beside, model, problem_of, recorded

from mmt_drake.diagnosis.fit.left_out import by_chance, left_out


def test_a_block_left_out_is_what_a_fit_without_it_leaves_of_it() -> None:
    """Against fits that never saw the block, its residual taken out by a weight of nothing."""
    problem = problem_of(recorded(COULOMB, seed=3, seconds=10.0), model())
    hypothesis = beside("coulomb_friction")
    fitted, numbers = (
        problem.fit(hypothesis, hypothesis.vector({}, {"coulomb_friction": {"Fc": 0.3}})),
        problem.blocks(),
    )
    found = left_out(problem, fitted)
    J, r = fitted.minimum.jacobian, fitted.minimum.residual
    for number in (2, 5):
        own = np.append(numbers == number, False)
        x = fitted.x - np.linalg.lstsq(J[~own], r[~own], rcond=None)[0]
        there = problem.unchanged(fitted.hypothesis, x).minimum.residual
        assert np.linalg.norm(found[own[:-1]] - there[own]) < 0.05 * np.linalg.norm(there[own])
    assert found @ found > r[:-1] @ r[:-1]  # the fit has followed every block a little


def blocks_of(counts: Sequence[int]) -> np.ndarray:
    return np.repeat(np.arange(len(counts)), counts)


def test_what_shows_in_two_blocks_only_rules_out_and_what_chance_does_does_not() -> None:
    rng, numbers = np.random.default_rng(1), blocks_of([200] * 16)
    better = rng.standard_normal(len(numbers))
    met = np.isin(numbers, (3, 11)) * np.sin(0.1 * np.arange(len(numbers)))
    assert by_chance(numbers, better + 3.0 * met, better) < 0.01
    assert by_chance(numbers, better, better) == 1.0
    assert by_chance(numbers, better, better + 3.0 * met) == 1.0


def alike_but(rng: np.random.Generator, numbers: np.ndarray, alike: np.ndarray, size: float) -> tuple[Any, Any]:
    """Residuals of a worse and a better one: as large by chance where they are alike, ten times as large elsewhere."""
    own, better = rng.standard_normal((2, len(numbers))) * np.where(alike, size, 1e-2)
    own *= 1.001 * np.linalg.norm(better[alike]) / np.linalg.norm(own[alike])
    return np.where(alike, own, 10.0 * better), better


def test_a_transient_does_not_hide_a_gain_in_every_other_block() -> None:
    numbers = blocks_of([200] * 16)
    worse, better = alike_but(np.random.default_rng(4), numbers, numbers == 6, 1e3)
    assert by_chance(numbers, worse, better, 1e-6) < 0.01


@pytest.mark.parametrize(("noise", "ruled_out"), [(1e-6, True), (1.0, False)])
def test_a_block_in_which_both_leave_less_than_noise_speaks_for_neither(noise: float, ruled_out: bool) -> None:
    numbers = blocks_of([200] * 16)
    worse, better = alike_but(np.random.default_rng(4), numbers, numbers % 2 == 0, 3.0)
    assert (by_chance(numbers, worse, better, noise) < 0.01) is ruled_out


@pytest.mark.parametrize("uneven", [0.0, 2.0])
@pytest.mark.parametrize("colour", [0.0, 0.98])
def test_of_two_that_are_as_good_one_is_hardly_ever_ruled_out(colour: float, uneven: float) -> None:
    """Both wrong by as much in their own way, beside a remainder that remembers for a tenth of a block.

    In uneven recordings some blocks leave many times as much as others.
    """
    rng, numbers = np.random.default_rng(2), blocks_of([500] * 16)
    ruled_out = 0
    for _ in range(400):
        size = np.exp(uneven * rng.standard_normal(16))[numbers] if uneven else 1.0
        remainder, one, other = rng.standard_normal((3, len(numbers)))
        for series in (remainder, one, other):
            for i in range(1, len(numbers) if colour else 0):
                series[i] = colour * series[i - 1] + series[i] * np.sqrt(1.0 - colour**2)
        some, others = size * (remainder + 0.5 * one), size * (remainder + 0.5 * other)
        ruled_out += by_chance(numbers, some, others, 1e-3) < 0.01
    assert ruled_out <= 8  # 1 % of them are 4
