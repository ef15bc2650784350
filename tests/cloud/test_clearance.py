"""Height above a cloud: of the highest point about the hand, whatever else is near."""

import math

import numpy as np
import pytest

from mmt_drake.cloud import Cloud, plane
from mmt_drake.cloud.clearance import clearance

RADIUS = 0.01


@pytest.mark.parametrize("z", [0.05, 0.003, 0.0, -0.012, -0.2])
def test_above_and_below_a_flat_surface_it_is_the_height(z: float) -> None:
    top = plane(2500, (0.1, 0.1)).moved((0.0, 0.0, 0.001), 0.0)
    assert clearance(top, np.array([0.01, -0.02, z]), RADIUS) == pytest.approx(z - 0.001, abs=1e-12)


def test_it_is_that_above_the_highest_point_of_the_column_about_the_hand() -> None:
    random = np.random.default_rng(5)
    points = random.uniform((-0.05, -0.05, -0.02), (0.05, 0.05, 0.02), (400, 3))
    cloud = Cloud(points).moved((0.004, -0.003, 0.002), 0.0)
    for hand in random.uniform((-0.04, -0.04, -0.03), (0.04, 0.04, 0.03), (200, 3)):
        near = np.linalg.norm(cloud.points()[:, :2] - hand[:2], axis=1) < RADIUS
        assert near.any()
        assert clearance(cloud, hand, RADIUS) == pytest.approx(hand[2] - cloud.points()[near, 2].max(), abs=1e-12)


def test_over_a_hole_and_beyond_the_rim_only_what_is_above_everything_is_above_the_surface() -> None:
    steps = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, -0.01], [0.0, 0.05, 0.004]])
    cloud = Cloud(steps)
    for hand in ((0.025, 0.025, 0.02), (3.0, -1.0, 0.02)):
        assert 0.016 - 0.0025 <= clearance(cloud, np.array(hand), RADIUS) <= 0.016  # less than a cell too little
        assert clearance(cloud, np.array([*hand[:2], 0.003]), RADIUS) < 0.0


def test_without_a_surface_nothing_is_above_it() -> None:
    for unseen in (None, Cloud.empty()):
        assert clearance(unseen, np.ones(3), RADIUS) == -math.inf
