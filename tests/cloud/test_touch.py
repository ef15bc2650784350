"""The height of a surface by one touch: closed-form contacts, force that is late, noise that is told, what is none."""

import math

import numpy as np
import pytest

from mmt_drake.cloud import Cloud, plane
from mmt_drake.cloud.touch import TouchSettings, height_of_touch, plane_below
from mmt_drake.errors import BadInput

STEP, BEFORE, AFTER = 1e-3, 80, 48
LEVEL = plane(10_000, (0.1, 0.1))
UP = np.array([0.0, 0.0, 1.0])


def coming_down(height, k, b, *, speed=0.05, delay=0.0, lag=0.0, noise=0.0, seed=0, normal=UP):
    """Samples about the onset of a force that begins where the tip passes a surface `height` above the cloud's.

    It does so between two samples.
    """
    fine = 20
    time = STEP / fine * np.arange(-400 * fine, 400 * fine)
    under = np.clip(speed * (time - delay) + 1e-12, 0.0, None)  # depth, of a tip that is at the surface at time 0
    force = np.where(under > 0.0, k * under + b * speed, 0.0)
    if lag > 0.0:
        share, low = 1.0 - math.exp(-STEP / fine / lag), 0.0
        for i, now in enumerate(force):
            low += share * (now - low)
            force[i] = low
    time, force = time[8::fine], force[8::fine]
    n = normal / np.linalg.norm(normal)
    above = height * n[2] - speed * time
    drawn = np.random.default_rng(seed)
    samples = np.column_stack([above[:, None] * n, np.broadcast_to(-speed * n, (len(time), 3)), force[:, None] * n])
    samples[:, 6:] += noise * drawn.normal(size=(len(time), 3))
    shown = np.flatnonzero(force > max(6.0 * noise, 1e-3))
    onset = int(shown[0])
    return samples[onset - BEFORE + 1 : onset + AFTER + 1]


def told(samples, cloud=LEVEL, noise=0.0, lateness=(0.0, 0.0)):
    seen = plane_below(cloud, samples[BEFORE - 1], 0.01)
    return None if seen is None else height_of_touch(samples, np.full(3, noise), BEFORE - 1, seen, STEP, lateness)


@pytest.mark.parametrize(("k", "b"), [(500.0, 0.0), (0.0, 60.0), (500.0, 60.0), (5000.0, 5.0)])
@pytest.mark.parametrize("height", [-0.001, 0.0, 0.0003])
def test_a_force_begins_where_the_surface_is(k, b, height):
    touch = told(coming_down(height, k, b))
    assert touch.height == pytest.approx(height, abs=1e-3 * 0.05)  # within the way of a tick
    assert abs(touch.height - height) < 2.5 * touch.deviation


@pytest.mark.parametrize(("delay", "lag"), [(0.004, 0.0), (0.0, 0.004), (0.002, 0.002)])
def test_what_the_force_is_late_by_is_no_height(delay, lag):
    samples = coming_down(0.0002, 500.0, 60.0, delay=delay, lag=lag)
    assert told(samples, lateness=(delay + lag, 1e-5)).height == pytest.approx(0.0002, abs=5e-5)
    if lag == 0.0:
        assert told(samples).height == pytest.approx(0.0, abs=5e-5)  # taken for punctual, it is 0.05 m/s x 4 ms lower
    unsure = told(samples, lateness=(0.0, 0.005))
    assert abs(unsure.height - 0.0002) < 2.0 * unsure.deviation


def test_its_deviation_covers_under_noise():
    within, heights = 0, np.random.default_rng(5).normal(0.0, 5e-4, 100)
    for seed, height in enumerate(heights):
        speed = 0.01 + 0.002 * (seed % 20)
        touch = told(coming_down(height, 500.0, 10.0, speed=speed, noise=0.02, seed=seed), noise=0.02)
        within += abs(touch.height - height) < 2.0 * touch.deviation
    assert within >= 90


def test_on_a_slope_the_height_is_along_z():
    normal = np.array([math.sin(0.5), 0.0, math.cos(0.5)])
    points = plane(10_000, (0.1, 0.1)).points()
    points[:, 2] = -points[:, 0] * math.tan(0.5)
    sloping = Cloud(points, normals=np.broadcast_to(normal, points.shape))
    touch = told(coming_down(0.0004, 500.0, 60.0, normal=normal), sloping)
    assert touch.height == pytest.approx(0.0004, abs=5e-5)


@pytest.mark.parametrize("what", ["a step along the way up", "a slow pull", "no surface", "a wall"])
def test_what_is_no_touch_tells_nothing(what):
    samples, cloud = coming_down(0.0, 500.0, 60.0), LEVEL
    if what == "a step along the way up":
        samples[:, 3:6] *= -1.0
        samples[:, :3] = samples[::-1, :3]
    if what == "a slow pull":
        samples[:, 8] = -np.linspace(0.0, 1.0, len(samples))
    if what == "no surface":
        cloud = LEVEL.moved((1.0, 0.0, 0.0), 0.0)
    if what == "a wall":
        points = plane(10_000, (0.02, 0.02)).points()[:, [2, 1, 0]]
        cloud = Cloud(points, normals=np.broadcast_to((1.0, 0.0, 0.0), points.shape))
    assert told(samples, cloud) is None


def test_the_plane_below_is_the_mean_of_what_is_near():
    points = plane(10_000, (0.1, 0.1)).points()
    points[:, 2] = 0.002 + 0.001 * np.random.default_rng(1).normal(size=len(points))
    seen = plane_below(Cloud(points).moved((0.0, 0.0, 0.003), 0.0), np.array([0.01, 0.0, 0.0]), 0.01)
    assert seen.normal == (0.0, 0.0, 1.0)
    assert seen.deviation == pytest.approx(0.001 / math.sqrt(314), rel=0.1)
    assert abs(seen.along - 0.005) < 3.0 * seen.deviation
    assert seen.below(np.array([1.0, 2.0, 3.0])) == seen.along


def test_at_an_edge_the_plane_below_is_not_certain():
    points = plane(10_000, (0.1, 0.1)).points()
    normals = np.broadcast_to(UP, points.shape)
    assert plane_below(Cloud(points, normals=normals), np.zeros(3), 0.01).deviation < 1e-9
    points[points[:, 0] > 0.003, 2] = -0.003
    assert plane_below(Cloud(points, normals=normals), np.zeros(3), 0.01).deviation > 1e-4


def test_beside_a_touch_less_is_known_but_never_less_than_of_the_cloud():
    settings = TouchSettings(deviation=1e-3, slope=0.01, wander=0.0)
    assert settings.beside(0.0, 0.05) == pytest.approx(5e-4)
    assert settings.beside(0.0, 10.0) == 1e-3
    with pytest.raises(BadInput, match="touch: deviation: found 0"):
        TouchSettings(deviation=0.0)
