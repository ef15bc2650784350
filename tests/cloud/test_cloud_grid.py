"""The grid finds exactly the points that a search over all of them finds."""

import numpy as np
import pytest

from mmt_drake.cloud.grid import COUNT, build_grid, count_within


def sheet(random):
    return np.column_stack([random.uniform(-0.15, 0.15, (4000, 2)), random.normal(0.0, 3e-4, 4000)])


def lattice(random):
    # On the cells' very borders, where rounding decides which side a point is on.
    return np.stack(np.meshgrid(*[np.arange(15) * 2.5e-3] * 3), axis=-1).reshape(-1, 3)


SETS = {
    "sheet": sheet,
    "lattice": lattice,
    "block": lambda random: random.uniform(0.0, 0.03, (5000, 3)),
    "line": lambda random: np.outer(random.uniform(0, 1, 500), [0.1, -0.2, 0.3]),
    "one place": lambda random: np.full((300, 3), 0.1),
    "one point": lambda random: np.array([[1.0, -2.0, 3.0]]),
    "with a stray 100 m away": lambda random: np.vstack([sheet(random), [[100.0, -100.0, 50.0]]]),
}


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("radius", [1e-3, 2.5e-3, 1e-2, 0.2])
def test_counts_equal_those_over_all_points(name, radius):
    random = np.random.default_rng(1)
    points = SETS[name](random)
    grid = build_grid(points)
    near = points[random.integers(0, len(points), 100)] + random.normal(0.0, radius, (100, 3))
    for at in np.vstack([near, points[:50], random.uniform(-1.0, 1.0, (20, 3))]):
        expected = np.count_nonzero(((points - at) ** 2).sum(axis=1) < radius**2)
        assert count_within(grid, tuple(at), radius, len(points) + 1) == expected


@pytest.mark.parametrize("name", SETS)
def test_every_point_is_stored_once_in_its_own_cell(name):
    points = SETS[name](np.random.default_rng(2))
    grid = build_grid(points)
    assert sorted(map(tuple, grid.points.T)) == sorted(map(tuple, points))
    assert grid.starts[0] == 0
    assert grid.starts[-1] == len(points)
    sizes = np.diff(grid.starts)
    assert np.all(sizes >= 0)
    corner, edge, cells = grid.frame[:3, None], grid.frame[3], grid.frame[COUNT:].astype(int)
    cell = np.repeat(np.arange(len(sizes)), sizes)
    number = np.array([cell % cells[0], cell // cells[0] % cells[1], cell // (cells[0] * cells[1])])
    inside = (grid.points - corner) / edge - number
    assert np.all(inside > -1e-9)
    assert np.all(inside < 1 + 1e-9)


def test_counting_stops_at_what_is_enough():
    grid = build_grid(np.zeros((100, 3)))
    assert count_within(grid, (0.0, 0.0, 0.0), 1e-3, 7) == 7


def test_a_wide_cloud_gets_larger_cells_not_more_memory():
    grid = build_grid(np.array([[0.0, 0.0, 0.0], [1e3, 1e3, 1e3]]))
    assert len(grid.starts) <= (1 << 16) + 1
    assert count_within(grid, (1e3, 1e3, 1e3), 1e-3, 5) == 1
