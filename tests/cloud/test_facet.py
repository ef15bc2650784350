"""Proxy and touching plane on clouds with normals: where slopes begin, and how round surfaces are met."""

import math

import numpy as np
import pytest

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.cloud.facet import FACET_SIZE, touching_plane
from mmt_drake.cloud.proxy import TOUCHING, new_memory, step_proxy
from mmt_drake.errors import BadInput
from mmt_drake.surfaces import Cylinder, HeightField, Plane, Saddle, Sphere, Step, locate

FREE = (0.0, 0.0, 0.0)
SETTINGS = ProxySettings()


def followed(cloud, path):
    """Contact by the proxy, and the touching plane, at every position (n, 3)."""
    memory, facet, packed = new_memory(), np.zeros(FACET_SIZE), SETTINGS.packed()
    contact, facets = np.zeros(len(path)), np.zeros((len(path), FACET_SIZE))
    for k, hand in enumerate(path):
        step_proxy(memory, hand, cloud, packed)
        touching_plane(memory, hand, cloud, packed, facet)
        contact[k], facets[k] = memory[TOUCHING], facet
    return contact, facets


def strokes_over(surface, seconds=4.0):
    """A hand that glides over a surface at up to 0.15 m/s and comes and goes along its normal."""
    time = np.arange(0.0, seconds, 1e-3)
    foot = surface.points(np.column_stack([0.03 * np.sin(4.0 * time), 0.03 * np.sin(3.1 * time)]))
    packed = surface.packed()
    normals = np.array([locate(packed, tuple(x), FREE)[1] for x in foot])
    depth = 0.004 * np.sin(5.0 * time - 1.0)
    return foot - depth[:, None] * normals, depth, normals


@pytest.mark.parametrize("tilt", [0.0, 30.0, 60.0])
def test_a_proxy_on_a_slope_touches_where_the_surface_is(tilt):
    """Lowered along z the cloud gave 5 % false contact at 30 degrees and 16 % at 60."""
    surface = Plane(tilt=tilt, turned=25.0)
    path, depth, _ = strokes_over(surface)
    cloud = surface.cloud(30_000, (0.2, 0.2))
    contact, _ = followed(cloud, path)
    assert np.mean((contact > 0.0) != (depth > 0.0)) < 0.005
    if tilt == 60.0:
        along_z, _ = followed(Cloud(cloud.points()), path)
        assert np.mean((along_z > 0.0) != (depth > 0.0)) > 0.05


ROUND = [Sphere(), Cylinder(turned=20.0), Saddle(), HeightField(), Plane(tilt=45.0)]


@pytest.mark.parametrize("surface", ROUND, ids=lambda s: type(s).__name__)
def test_the_touching_plane_is_where_the_surface_is_and_turns_as_it_does(surface):
    path, depth, normals = strokes_over(surface)
    contact, facets = followed(surface.cloud(30_000, (0.2, 0.2)), path)
    seen = (contact > 0.0) & (depth > 0.0)
    assert np.mean((contact > 0.0) != (depth > 0.0)) < 0.01
    height = np.einsum("ij,ij->i", facets[seen, :3], path[seen]) - facets[seen, 3]
    assert np.abs(height + depth[seen]).max() < 5e-5  # of 4 mm
    assert np.abs(facets[seen, :3] - normals[seen]).max() < 0.02
    again = np.flatnonzero(seen[1:] & seen[:-1]) + 1
    kept = np.cumsum(seen)[again] > 0
    turns = np.linalg.norm(np.diff(facets[seen, :3], axis=0), axis=1)
    assert kept.all() and np.median(turns) < 0.005


def test_leaving_over_an_edge_is_leaving():
    x = np.arange(-0.03, 0.03, 5e-5)
    path = np.vstack([np.column_stack([0 * x[:50] - 0.03, 0 * x[:50], np.linspace(0.005, -0.003, 50)]),
                      np.column_stack([x, 0 * x, 0 * x - 0.003])])  # fmt: skip
    contact, _ = followed(Step().cloud(30_000, (0.2, 0.2)), path)
    gone = path[50:, 0][np.flatnonzero(contact[50:] == 0.0)[0]]
    assert 0.0 < gone < 0.004
    assert not contact[50:][path[50:, 0] > 0.005].any()


def test_without_normals_the_plane_is_that_of_the_proxy():
    contact, facets = followed(plane(30_000), np.tile([0.0, 0.0, -0.002], (20, 1)))
    assert contact[-1] == 1.0
    assert facets[-1] == pytest.approx([0.0, 0.0, 1.0, 0.0], abs=1e-3)


def test_a_cloud_that_moved_has_its_normals_and_its_lowered_grid():
    cloud = Plane(tilt=20.0).cloud(2000)
    moved = cloud.moved((0.1, 0.0, 0.0), 1.0)
    assert moved.normals is cloud.normals
    assert moved.lowered(0.004) is cloud.lowered(0.004)


def test_normals_by_open3d_are_those_of_the_surface_and_point_up():
    surface = Sphere()
    cloud = surface.cloud(20_000, (0.12, 0.12))
    out = cloud.points() + np.array([0.0, 0.0, surface.radius])
    inside = np.hypot(*cloud.points()[:, :2].T) < 0.04
    assert np.abs(cloud.normals - out / surface.radius)[inside].max() < 0.01
    assert (cloud.normals[:, 2] >= 0.0).all()


@pytest.mark.parametrize(
    ("normals", "expected"),
    [
        ([[0.0, 0.0, -1.0]] * 3, "point down"),
        ([[0.0, 0.0, 1.0]] * 2, "shape"),
        ([[0.0, 0.0, 1.0], [0.0, 0.0, 0.5], [0.0, 0.0, 1.0]], "normal 1"),
        ([[0.0, 0.0, 1.0], [0.0, math.nan, 1.0], [0.0, 0.0, 1.0]], "normal 1"),
    ],
)
def test_normals_that_are_none_are_refused_in_one_line(normals, expected):
    with pytest.raises(BadInput, match=expected) as error:
        Cloud([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0]], normals=normals)
    assert "\n" not in str(error.value)
