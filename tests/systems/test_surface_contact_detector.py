"""The detector beside the operator: in the very tick, wherever between the points, on a cloud that is old."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue

from mmt_drake.cloud import ProxySettings, plane
from mmt_drake.diagrams.stations.surfaces import SeenSurface
from mmt_drake.systems.surface_contact_detector import SurfaceContactDetector

STEP = 1e-3


def looking_ahead(cloud, noise):
    return SeenSurface(cloud, None, cloud.spacing, noise).looking_ahead(ProxySettings())


def detected(path, cloud, settings=None):
    """(n,) in contact, for every position (n, 3); `cloud` is a function of the tick."""
    detector = SurfaceContactDetector(settings or looking_ahead(cloud(0), 0.0))
    context = detector.CreateDefaultContext()
    found = np.zeros(len(path))
    for k, position in enumerate(path):
        context.SetTime(k * STEP)
        detector.GetInputPort("position").FixValue(context, position)
        detector.GetInputPort("point_cloud").FixValue(context, AbstractValue.Make(cloud(k)))
        found[k] = detector.GetOutputPort("in_contact").Eval(context)[0]
        detector.ExecuteForcedEvents(context)
    return found


def strokes(speed, seed):
    """A path down, along the surface and up at a speed [m/s], at a place between the points."""
    random = np.random.default_rng(seed)
    step = speed * STEP
    z = np.arange(0.004 + step * random.uniform(), -0.004, -step)
    z = np.concatenate([z, np.full(50, z[-1]), z[::-1]])
    x = random.uniform(-0.1, 0.1) + 0.02 * np.sin(10.0 * STEP * np.arange(len(z)))
    return np.column_stack([x, np.full(len(z), random.uniform(-0.1, 0.1)), z])


@pytest.mark.parametrize("speed", [0.003, 0.1, 0.5])
@pytest.mark.parametrize("points", [3_000, 30_000])
def test_contact_is_told_in_the_tick_in_which_the_hand_crosses_the_surface(speed, points):
    cloud = plane(points)
    for seed in range(3):
        path = strokes(speed, seed)
        wrong = detected(path, lambda k: cloud) != (path[:, 2] < 0.0)
        assert np.abs(path[wrong, 2]).max(initial=0.0) < 4e-6  # a coarse lattice lets the normal tilt a little
        assert not wrong.any() or speed * STEP < 4e-6


def test_a_surface_that_moves_along_itself_may_be_seen_late():
    cloud = plane(30_000)
    path = strokes(0.1, 4)

    def late(k):
        frame = max(k - 400, 0) // 33
        return cloud.moved((0.05 * np.sin(0.5 * frame), 0.0, 0.0), frame * 0.033)

    np.testing.assert_array_equal(detected(path, late), path[:, 2] < 0.0)


def test_noise_is_averaged_over_the_points_around_the_proxy():
    cloud = plane(30_000, noise=2e-4, seed=2)
    settings = looking_ahead(cloud, 2e-4)
    heights = []
    for seed in range(12):
        path = strokes(0.02, seed)
        heights.append(path[np.flatnonzero(detected(path, lambda k: cloud, settings))[0], 2])
    assert np.std(heights) < 0.06e-3 and abs(np.mean(heights)) < 0.05e-3


def test_without_a_cloud_there_is_no_contact():
    assert not detected(strokes(0.1, 0), lambda k: plane(0), ProxySettings()).any()
