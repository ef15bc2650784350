"""The table's plane is found among what stands on it, and is the same in every look at a cloud."""

import numpy as np
import pytest

from mmt_drake.cloud.segment import above_table
from mmt_drake.numeric.arrays import Array

SLOPE = 0.05


def table_with_a_box(noise: float) -> Array:
    """(n, 3) a table at -0.05 m that rises along x, and a box of 12 mm on it, near enough to be of the table."""
    random = np.random.default_rng(3)
    points = random.uniform(-0.2, 0.2, (9000, 3))
    on_box = (np.abs(points[:, :2]) < 0.06).all(axis=1)
    points[:, 2] = -0.05 + SLOPE * points[:, 0] + 0.012 * on_box + noise * random.standard_normal(len(points))
    return points


def test_the_table_is_where_most_points_are_level_and_what_is_above_it_is_kept() -> None:
    points = table_with_a_box(0.0)
    above, height = above_table(points, -0.045)
    on_table = points[:, 2] < -0.049 + SLOPE * points[:, 0]
    near = points[np.abs(points[:, 2] + 0.045) < 0.02]
    assert height == pytest.approx(-0.05 + SLOPE * near[:: len(near) // 2000, 0].mean(), abs=1e-9)
    np.testing.assert_array_equal(above, points[~on_table])


def test_every_look_at_a_cloud_finds_the_same_table() -> None:
    """A search that shares its rounds among processors gives one of many answers."""
    points = table_with_a_box(1e-3)
    found = {above_table(points, -0.05)[1] for _ in range(20)}
    assert len(found) == 1
    assert found.pop() == pytest.approx(-0.05, abs=1e-3)
