"""What a short log may leave out of a joint, and what it may not."""

import numpy as np
import pytest

from mmt_drake.arms.folds import Folds
from mmt_drake.arms.problem import JointRows, Term
from mmt_drake.arms.search import JointSearch, JointSet

BLOCKS, EACH = 16, 40


def best(v: np.ndarray, torque: np.ndarray, without: frozenset[str] = frozenset()) -> JointSet:
    """Of a joint that only has friction, at velocities and torques (BLOCKS, EACH)."""
    every = np.stack([v, np.sign(v), np.ones_like(v)], axis=-1).reshape(-1, 3)
    names = ("viscous_friction", "coulomb_friction", "constant_force")
    terms = tuple(Term(name, "turn", (), (at,)) for at, name in enumerate(names))
    moving, block = np.ones(len(every), dtype=bool), np.repeat(np.arange(BLOCKS), EACH)
    turns = np.zeros(len(every), dtype=bool)
    rows = JointRows(0, torque.ravel(), torque.ravel(), every, moving, turns, block, BLOCKS, terms)
    return JointSearch(rows, Folds(rows.sums, range(BLOCKS), None)).best(without)


def velocities(seed: int, slowest: float, fastest: float) -> np.ndarray:
    """There and back at speeds drawn."""
    speeds = np.random.default_rng(seed).uniform(slowest, fastest, (BLOCKS, EACH))
    return np.where(np.arange(EACH) < EACH // 2, speeds, -speeds)


@pytest.mark.parametrize("seed", range(5))
def test_where_speeds_are_alike_dry_friction_stands_for_what_may_be_viscous(seed: int) -> None:
    # Levels that wander hide what a speed a tenth higher adds. Taken for viscous, it would double at twice the speed.
    v, levels = velocities(seed, 0.95, 1.05), np.random.default_rng(seed + 50).normal(1.0, 0.3, (BLOCKS, 1))
    assert best(v, levels * np.sign(v)).names == {"coulomb_friction"}


@pytest.mark.parametrize("seed", range(5))
def test_dry_friction_does_not_stand_for_what_is_viscous(seed: int) -> None:
    v = velocities(seed, 0.2, 2.0)
    torque = v + np.random.default_rng(seed + 50).normal(0.0, 0.05, v.shape)
    assert best(v, torque).names == {"viscous_friction"}


def test_an_offset_that_takes_most_of_the_error_stays_although_a_few_blocks_say_it_may_be_chance() -> None:
    v = velocities(0, 0.5, 1.5)
    offset = np.where(np.arange(BLOCKS) % 16 < 11, 1.0, 0.2)[:, None]
    assert "constant_force" in best(v, np.sign(v) + offset).names


def test_a_rival_without_dry_friction_has_none() -> None:
    v, levels = velocities(0, 0.95, 1.05), np.random.default_rng(50).normal(1.0, 0.3, (BLOCKS, 1))
    assert best(v, levels * np.sign(v), frozenset({"coulomb_friction"})).names == {"viscous_friction"}
