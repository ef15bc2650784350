"""Roots, weights, normals and swept spheres, against closed forms and searches over all points."""

import math

import numpy as np
import pytest

from mmt_drake.cloud.grid import build_grid
from mmt_drake.cloud.spheres import distance_roots, neighbourhood, way_ahead, way_out, wendland

R1, R2, R3 = 3e-3, 5e-3, 10e-3


def test_wendland_has_the_values_of_eq_15():
    assert wendland(0.0, R1, R3) == 1.0
    assert wendland(R1, R1, R3) == 1.0
    assert wendland(0.5 * (R1 + R3), R1, R3) == pytest.approx(0.5**4 * 3.0)
    assert wendland(R1 + 0.25 * (R3 - R1), R1, R3) == pytest.approx(0.75**4 * 2.0)
    assert wendland(R3, R1, R3) == 0.0


def test_wendland_is_smooth_at_both_ends():
    for r in (R1, R3):
        assert abs(wendland(r + 1e-7, R1, R3) - wendland(r - 1e-7, R1, R3)) / 2e-7 < 1e-1 / R3


def test_roots_put_the_point_at_the_wanted_distance():
    random = np.random.default_rng(4)
    met = 0
    for _ in range(1000):
        b, c, a = random.normal(size=3), random.normal(size=3), random.uniform(0.1, 2.0)
        roots = distance_roots(a, tuple(b), tuple(c))
        closest = np.linalg.norm(b - (b @ c) / (c @ c) * c)
        assert math.isnan(roots[0]) == (closest > a)
        if closest < a:
            met += 1
            assert roots[0] <= roots[1]
            np.testing.assert_allclose([np.linalg.norm(b - d * c) for d in roots], a, rtol=1e-12)
    assert 200 < met < 900


def test_eq_29_as_printed_misses_the_point_right_ahead():
    # A point 10 mm ahead is touched by a sphere of 4 mm after 6 mm: the quadratic's own formula says so.
    a, b, c = 4.0, np.array([0.0, 0.0, 10.0]), np.array([0.0, 0.0, 1.0])
    assert distance_roots(a, tuple(b), tuple(c)) == (6.0, 14.0)
    as_printed = (b @ c) ** 2 - 4.0 * (b @ b - a**2) * (c @ c)
    assert as_printed < 0.0  # no real root: the sphere would run through


def rough_sheet():
    random = np.random.default_rng(5)
    return np.column_stack([random.uniform(-0.05, 0.05, (6000, 2)), random.normal(0.0, 3e-4, 6000)])


def test_the_normal_is_the_sum_of_eq_14_over_all_points():
    points = rough_sheet()
    grid = build_grid(points)
    for at in np.random.default_rng(6).uniform(-0.03, 0.03, (20, 3)) * [1, 1, 0.2]:
        r = np.linalg.norm(at - points, axis=1)
        t = np.clip((r - R1) / (R3 - R1), 0.0, 1.0)
        weight = (1.0 - t) ** 4 * (4.0 * t + 1.0)
        nearest, normal, total, mean = neighbourhood(grid, tuple(at), R1, R3)
        assert nearest == pytest.approx(r.min())
        np.testing.assert_allclose(normal, (weight / r) @ (at - points), atol=1e-11)
        np.testing.assert_allclose(total, weight.sum())
        np.testing.assert_allclose(mean, weight @ points / weight.sum(), atol=1e-12)


def test_the_weight_of_eq_14_takes_the_distance():
    """Turning points and proxy together turns the normal; weights of the vector's components would not."""
    points = rough_sheet()
    at = np.array([0.002, -0.001, 0.004])
    turn, _ = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))
    _, normal, _, _ = neighbourhood(build_grid(points), tuple(at), R1, R3)
    _, turned, _, _ = neighbourhood(build_grid(np.ascontiguousarray(points @ turn.T)), tuple(turn @ at), R1, R3)
    np.testing.assert_allclose(turn @ normal, turned, atol=1e-9)

    def by_component(at, points):
        away = at - points
        near = np.linalg.norm(away, axis=1) < R3
        weight = np.vectorize(lambda r: wendland(abs(r), R1, R3))(away[near])
        return (away[near] / np.linalg.norm(away[near], axis=1)[:, None] * weight).sum(axis=0)

    printed, printed_turned = by_component(at, points), by_component(turn @ at, points @ turn.T)
    assert np.linalg.norm(turn @ printed - printed_turned) > 0.05 * np.linalg.norm(printed)


def test_the_way_ahead_ends_where_a_search_over_all_points_says():
    points = rough_sheet()
    grid = build_grid(points)
    random = np.random.default_rng(8)
    met = 0
    for _ in range(400):
        scale = 10.0 ** random.uniform(-4, 0)
        at = random.uniform(-0.06, 0.06, 3) + np.array([0.0, 0.0, 0.03])
        way = scale * random.normal(size=3) - [0.0, 0.0, 0.3 * scale]
        r = np.linalg.norm(points - at, axis=1)
        if r.min() < 4e-3:
            continue
        along = way / np.linalg.norm(way)
        aside = np.linalg.norm(np.cross(points - at, along), axis=1)
        ahead = (points - at) @ along
        hit = (aside < 4e-3) & (ahead > 0.0)
        first = (ahead - np.sqrt(np.maximum(16e-6 - aside**2, 0.0)))[hit].min(initial=np.inf)
        expected = min(first / np.linalg.norm(way), 1.0)
        met += expected < 1.0
        assert way_ahead(grid, tuple(at), tuple(way), 4e-3) == pytest.approx(expected, abs=1e-9)
    assert met > 40


def test_a_jump_of_kilometres_stops_at_the_surface():
    grid = build_grid(np.array([[0.0, 0.0, 0.0]]))
    assert way_ahead(grid, (0.0, 0.0, 5e3), (0.0, 0.0, -1e4), 0.004) == pytest.approx(0.5 - 0.004e-4, abs=1e-12)
    assert way_ahead(grid, (0.0, 1.0, 5e3), (0.0, 0.0, -1e4), 0.004) == 1.0


def test_a_point_inside_the_sphere_stops_only_what_moves_towards_it():
    grid = build_grid(np.array([[0.0, 0.0, 0.0]]))
    assert way_ahead(grid, (0.0, 0.0, 2e-3), (0.0, 0.0, -1.0), 4e-3) == 0.0
    assert way_ahead(grid, (0.0, 0.0, 2e-3), (0.0, 0.0, 1.0), 4e-3) == 1.0
    assert way_ahead(grid, (0.0, 0.0, 2e-3), (0.0, 0.0, 0.0), 4e-3) == 1.0


def test_the_way_out_is_just_enough():
    points = rough_sheet()
    grid = build_grid(points)
    for height in (-1e-3, 0.0, 2e-3, 3.9e-3):
        at = np.array([1e-3, 2e-3, height])
        d = way_out(grid, tuple(at), (0.0, 0.0, 1.0), 4e-3)
        inside = points[np.linalg.norm(points - at, axis=1) < 4e-3]
        after = np.linalg.norm(inside - at - [0.0, 0.0, d], axis=1)
        assert after.min() == pytest.approx(4e-3, rel=1e-9)


def test_the_way_out_of_a_groove_does_not_pass_its_far_wall():
    at_wall, far_wall = [0.0, 0.0, 0.0], [9e-3, 0.0, 0.0]
    grid = build_grid(np.array([at_wall, far_wall]))
    assert way_out(grid, (1e-3, 0.0, 0.0), (1.0, 0.0, 0.0), 4e-3) == pytest.approx(3e-3)
