"""The proxy spring renders k times the depth below the surface, now, and nothing above it."""

import numpy as np
import pytest
from hand_and_cloud import HandAndCloud
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from mmt_drake.cloud import Cloud, ProxySettings, plane
from mmt_drake.errors import BadInput
from mmt_drake.systems.proxy_spring import ProxySpringRenderer

K = 500.0


def rendered(positions, cloud, settings=None):
    """(ticks, 3) forces at the same times as the positions (ticks, 3)."""
    builder = DiagramBuilder()
    motions = np.hstack([positions, np.zeros_like(positions)])
    signals = builder.AddSystem(HandAndCloud("motion", motions, cloud))
    spring = builder.AddSystem(ProxySpringRenderer(K, settings))
    for port in ("motion", "point_cloud"):
        builder.Connect(signals.GetOutputPort(port), spring.GetInputPort(port))
    sink = LogVectorOutput(spring.GetOutputPort("force"), builder, 1e-3)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((len(positions) - 1) * 1e-3)
    return sink.FindLog(simulator.get_context()).data().T


def pressing_slide():
    t = np.arange(3000) * 1e-3
    z = 1e-3 - 4e-3 * (1.0 - np.cos(5.0 * t))
    return np.column_stack([0.03 * np.sin(2.0 * t), 0.02 * np.cos(3.0 * t), z])


@pytest.mark.parametrize(
    ("layout", "noise", "newton"), [("regular", 0.0, 0.01), ("jittered", 0.0, 0.03), ("regular", 3e-4, 0.15)]
)
def test_force_is_stiffness_times_depth_whatever_the_radii(layout, noise, newton):
    cloud = plane(30_000, layout=layout, noise=noise, seed=4)
    path = pressing_slide()
    expected = K * np.maximum(-path[:, 2], 0.0)
    for settings in (None, ProxySettings(r1=2e-3, r2=6e-3, r3=12e-3)):
        force = rendered(path, lambda k: cloud, settings)
        np.testing.assert_allclose(force[:, 2], expected, atol=newton)
        assert np.all(force[path[:, 2] > 1e-3] == 0.0)
        assert np.sqrt(np.mean(force[:, :2] ** 2)) < 0.05 * expected.max()


def test_the_force_belongs_to_the_position_of_the_same_tick():
    cloud = plane(30_000)
    path = np.zeros((4, 3))
    path[:, 2] = [0.02, -0.004, -0.006, 0.01]
    np.testing.assert_allclose(rendered(path, lambda k: cloud)[:, 2], [0.0, 2.0, 3.0, 0.0], atol=5e-3)


def test_the_force_on_a_slope_is_along_its_normal():
    flat = plane(40_000, (0.2, 0.2)).points()
    slope = np.radians(20.0)
    turn = np.array([[np.cos(slope), 0, np.sin(slope)], [0, 1, 0], [-np.sin(slope), 0, np.cos(slope)]])
    cloud = Cloud(flat @ turn.T)
    normal = turn @ [0.0, 0.0, 1.0]
    path = np.outer(np.append(np.linspace(0.02, -0.005, 300), np.full(200, -0.005)), normal)
    force = rendered(path, lambda k: cloud)
    np.testing.assert_allclose(force[-1], K * 0.005 * normal, atol=0.05)


def test_no_cloud_no_force():
    path = np.tile([0.0, 0.0, -0.01], (5, 1))
    np.testing.assert_array_equal(rendered(path, lambda k: Cloud.empty()), np.zeros((5, 3)))
    assert rendered(path, lambda k: None).max() == 0.0


@pytest.mark.parametrize("k", [0.0, -5.0, np.nan, np.inf])
def test_a_stiffness_that_cannot_be_is_refused(k):
    with pytest.raises(BadInput):
        ProxySpringRenderer(k)
