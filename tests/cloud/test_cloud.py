"""A cloud is immutable, shares its neighbour structure when it moves, and goes to and from Drake and Open3D."""

import copy
import math
import pickle

import numpy as np
import pytest
from pydrake.common.value import AbstractValue

from mmt_drake.cloud import Cloud, contact_offset, plane
from mmt_drake.cloud.cloud import SERIAL
from mmt_drake.errors import BadInput

POINTS = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3))


def test_points_are_where_the_translation_took_them():
    cloud = Cloud(POINTS).moved((0.01, -0.02, 0.03), 1.5)
    np.testing.assert_array_equal(cloud.points(), POINTS + np.array([0.01, -0.02, 0.03]))
    assert cloud.stamp == 1.5
    assert len(cloud) == 500


def test_moved_shares_everything_but_place_and_time():
    cloud = Cloud(POINTS).moved((1.0, 0.0, 0.0), 0.0)
    moved = cloud.moved((0.0, 0.5, 0.0), 2.0)
    assert moved.base is cloud.base
    assert all(a is b for a, b in zip(moved.kernel_arrays[:3], cloud.kernel_arrays[:3], strict=True))
    np.testing.assert_array_equal(moved.points(), POINTS + np.array([0.0, 0.5, 0.0]))
    np.testing.assert_array_equal(cloud.points(), POINTS + np.array([1.0, 0.0, 0.0]))


def test_nothing_of_it_can_be_changed():
    mine = POINTS.copy()
    cloud = Cloud(mine)
    mine[0] = 7.0
    np.testing.assert_array_equal(cloud.base[0], POINTS[0])
    for array in (cloud.base, cloud.translation):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    with pytest.raises(AttributeError):
        cloud.stamp = 3.0


def test_copies_in_drake_values_are_the_same_object():
    cloud = Cloud(POINTS)
    assert copy.deepcopy(cloud) is cloud
    assert AbstractValue.Make(cloud).Clone().get_value() is cloud


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (np.zeros((3, 2)), "shape (3, 2)"),
        (np.zeros(3), "shape (3,)"),
        ([[0.0, 0.0, 0.0], [0.0, math.nan, 0.0]], "point 1"),
        ([[math.inf, 0.0, 0.0]], "point 0"),
        ([[math.inf, 0.0, 0.0], [-math.inf, 0.0, 0.0]], "point 0"),
    ],
)
def test_bad_points_are_refused(points, said):
    with pytest.raises(BadInput) as error:
        Cloud(points)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("colours", "said"),
    [(np.zeros((2, 3)), "shape (2, 3)"), ([*[[0.5] * 3] * (len(POINTS) - 1), [0.0, 255.0, 0.0]], "sRGB from 0 to 1")],
)
def test_bad_colours_are_refused_and_unknown_ones_are_not(colours, said):
    with pytest.raises(BadInput) as error:
        Cloud(POINTS, colours=colours)
    assert said in str(error.value)
    assert np.isnan(Cloud(POINTS, colours=np.full(POINTS.shape, np.nan)).colours).all()


@pytest.mark.parametrize("far", [-1.7e308, 1e100, 1e12, -100.5])
def test_a_point_that_no_camera_sees_is_refused(far):
    points = POINTS.copy()
    points[3, 0], points[4, 2] = far, 1.7e308
    with pytest.raises(BadInput, match=r"point 3: found .* expected coordinates within 100 m"):
        Cloud(points)


@pytest.mark.parametrize(("place", "time"), [((0, 0), 0.0), ((0, 0, math.nan), 0.0), ((0, 0, 0), math.inf)])
def test_bad_places_and_times_are_refused(place, time):
    with pytest.raises(BadInput):
        Cloud(POINTS).moved(place, time)


def test_a_cloud_may_be_empty():
    cloud = Cloud.empty(stamp=4.0)
    assert len(cloud) == 0
    assert cloud.points().shape == (0, 3)
    assert cloud.spacing == 0.0
    assert len(cloud.moved((1.0, 0.0, 0.0), 5.0)) == 0


def test_open3d_has_the_points_where_they_are_now():
    cloud = Cloud(POINTS).moved((0.0, 0.0, 0.1), 0.0)
    np.testing.assert_array_equal(np.asarray(cloud.to_open3d().points), cloud.points())


@pytest.mark.parametrize("layout", ["regular", "jittered", "random"])
@pytest.mark.parametrize("n", [400, 5000, 30_000])
def test_spacing_is_the_root_of_area_per_point(layout, n):
    cloud = plane(n, (0.3, 0.2), layout=layout, noise=1e-4, seed=3)
    assert cloud.spacing == pytest.approx(math.sqrt(0.06 / n), rel=0.12)


@pytest.mark.parametrize("n", [1, 2, 7, 1000, 30_000])
@pytest.mark.parametrize("layout", ["regular", "jittered", "random"])
def test_a_plane_has_as_many_points_as_asked_for_on_its_rectangle(n, layout):
    points = plane(n, (0.3, 0.1), centre=(1.0, 2.0, 3.0), layout=layout).points()
    assert points.shape == (n, 3)
    assert np.all(np.abs(points - [1.0, 2.0, 3.0]) <= [0.15, 0.05, 0.0])


def test_a_regular_plane_has_equal_gaps_both_ways():
    points = plane(1200, (0.4, 0.3)).points()
    for axis, side, count in ((0, 0.4, 40), (1, 0.3, 30)):
        gaps = np.diff(np.unique(points[:, axis].round(9)))
        assert len(gaps) == count - 1
        np.testing.assert_allclose(gaps, side / count, atol=2e-9)


def test_the_seed_alone_decides_jitter_and_noise():
    make = {"layout": "jittered", "noise": 1e-3}
    np.testing.assert_array_equal(plane(500, seed=1, **make).base, plane(500, seed=1, **make).base)
    assert not np.array_equal(plane(500, seed=1, **make).base, plane(500, seed=2, **make).base)
    assert plane(20_000, noise=1e-3, seed=1).base[:, 2].std() == pytest.approx(1e-3, rel=0.02)


@pytest.mark.parametrize("bad", [{"n": -1}, {"size": (0.1, 0.0)}, {"noise": -1e-3}, {"layout": "hexagonal"}])
def test_planes_that_cannot_be_are_refused(bad):
    with pytest.raises(BadInput):
        plane(**({"n": 10} | bad))


def dropped_from_above(points, at, r):
    """Height at which a sphere's centre stops."""
    aside = ((points[:, :2] - at) ** 2).sum(axis=1)
    under = aside < r**2
    return (points[under, 2] + np.sqrt(r**2 - aside[under])).max()


@pytest.mark.parametrize(
    ("layout", "noise", "within"), [("regular", 0.0, 4e-6), ("random", 3e-4, 5e-5), ("random", 1e-3, 5e-5)]
)
def test_contact_offset_is_the_mean_height_at_which_a_dropped_sphere_stops(layout, noise, within):
    cloud = plane(30_000, layout=layout, noise=noise, seed=8)
    spots = np.random.default_rng(9).uniform(-0.1, 0.1, (600, 2))
    mean = np.mean([dropped_from_above(cloud.base, spot, 5e-3) for spot in spots])
    assert contact_offset(5e-3, math.sqrt(0.09 / 30_000), noise) == pytest.approx(mean, abs=within)


def test_another_process_has_the_same_cloud_by_a_number_of_its_own():
    normals, colours = np.tile([0.0, 0.0, 1.0], (len(POINTS), 1)), np.linspace(0.0, 1.0, 3 * len(POINTS)).reshape(-1, 3)
    cloud = Cloud(POINTS, stamp=1.0, normals=normals, colours=colours).moved((0.01, 0.0, 0.0), 2.0)
    there = pickle.loads(pickle.dumps(cloud))
    np.testing.assert_array_equal(there.points(), cloud.points())
    np.testing.assert_array_equal(there.normals, normals)
    np.testing.assert_array_equal(there.colours, colours)
    assert (there.stamp, there.spacing) == (2.0, cloud.spacing)
    assert there.kernel_arrays[3][SERIAL] != cloud.kernel_arrays[3][SERIAL]
    with pytest.raises(ValueError, match="read-only"):
        there.base[0] = 1.0


def test_a_cloud_from_another_process_has_its_neighbours_once_it_is_asked_and_shares_them() -> None:
    cloud = Cloud(np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3)), normals=np.tile([0.0, 0.0, 1.0], (500, 1)))
    told = pickle.loads(pickle.dumps(cloud))
    moved = told.moved([0.0, 0.0, 0.1], 1.0)
    for mine, theirs in zip(cloud.kernel_arrays[:3], moved.kernel_arrays[:3], strict=True):
        np.testing.assert_array_equal(mine, theirs)
    assert moved.kernel_arrays[0] is told.kernel_arrays[0]
    np.testing.assert_array_equal(told.lowered(0.01)[1], cloud.lowered(0.01)[1])
