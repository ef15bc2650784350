"""The contact detector sees the surface where it is: at z = 0, for every speed of a hand."""

import math

import numpy as np
import pytest
from hand_and_cloud import HandAndCloud
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from mmt_drake.cloud import Cloud, ProxySettings, contact_offset, plane
from mmt_drake.errors import BadInput
from mmt_drake.systems.contact_detector import ContactDetector


def wired(position, cloud, settings=None):
    """(diagram, detector, log sinks by port); positions (ticks, 3)."""
    builder = DiagramBuilder()
    signals = builder.AddSystem(HandAndCloud("position", np.asarray(position, float), cloud))
    detector = builder.AddSystem(ContactDetector(settings))
    for port in ("position", "point_cloud"):
        builder.Connect(signals.GetOutputPort(port), detector.GetInputPort(port))
    sinks = {
        port: LogVectorOutput(detector.GetOutputPort(port), builder, 1e-3)
        for port in ("in_contact", "proxy", "proxy_state")
    }
    return builder.Build(), detector, sinks


def detected(position, cloud, settings=None):
    """{port: (ticks, size)}: row k is what the ports show because of the inputs at tick k."""
    diagram, _, sinks = wired(position, cloud, settings)
    simulator = Simulator(diagram)
    simulator.AdvanceTo(len(position) * 1e-3)
    return {port: sink.FindLog(simulator.get_context()).data().T[1:] for port, sink in sinks.items()}


def straight_down_and_up(speed, start, xy):
    down = start - speed * 1e-3 * np.arange(int(2 * start / (speed * 1e-3)))
    z = np.append(down, down[::-1])
    return np.column_stack([np.tile(xy, (len(z), 1)), z])


@pytest.mark.parametrize("speed", [0.01, 0.1, 0.5, 1.0])
@pytest.mark.parametrize(("n", "within"), [(30_000, 0.16e-3), (300_000, 0.02e-3)])
def test_contact_is_seen_at_the_surface_at_every_speed(speed, n, within):
    """`within` is the unevenness of the sampled surface, spacing²/(4 r2), which at 1 cm/s is many ticks' travel."""
    cloud = plane(n)
    random = np.random.default_rng(1)
    for _ in range(5):
        path = straight_down_and_up(speed, 0.006 + speed * 1e-3 * random.uniform(), random.uniform(-0.1, 0.1, 2))
        contact = detected(path, lambda k: cloud)["in_contact"][:, 0]
        z = path[:, 2]
        first, last = np.flatnonzero(contact)[[0, -1]]
        assert -within - speed * 1e-3 < z[first] < within
        assert -within < z[last + 1] < within + 2 * speed * 1e-3
        assert np.all(contact[first : last + 1] == 1.0)
        assert np.flatnonzero(z < 0.0)[0] - math.ceil(within / (speed * 1e-3)) <= first
        assert first <= np.flatnonzero(z < 0.0)[0] + math.ceil(within / (speed * 1e-3))


def test_the_noise_of_a_cloud_is_told_to_the_offset():
    """The highest of the noisy points is met first: 0.2 mm early on average, unless the offset knows."""
    cloud = plane(30_000, noise=3e-4, seed=2)
    offset = contact_offset(5e-3, cloud.spacing, 3e-4)
    random = np.random.default_rng(3)
    heights = {None: [], offset: []}
    for _ in range(30):
        path = straight_down_and_up(0.02, 0.002, random.uniform(-0.1, 0.1, 2))[:150]
        for given, found in heights.items():
            contact = detected(path, lambda k: cloud, ProxySettings(surface_offset=given))["in_contact"][:, 0]
            found.append(path[np.flatnonzero(contact)[0], 2])
    assert np.mean(heights[None]) > 0.12e-3
    assert abs(np.mean(heights[offset])) < 0.1e-3


def test_outputs_are_states_one_period_younger_than_the_input():
    cloud = plane(30_000)
    diagram, detector, _ = wired([[0, 0, 0.01], [0, 0, -0.01], [0, 0, 0.01]], lambda k: cloud)
    simulator = Simulator(diagram)
    context = detector.GetMyContextFromRoot(simulator.get_context())
    shown = []
    for k in range(5):
        simulator.AdvanceTo(k * 1e-3)
        shown.append(detector.GetOutputPort("in_contact").Eval(context)[0])
    # The input of tick 1 (below the surface) shows when the clock stands at tick 2.
    assert shown == [0.0, 0.0, 1.0, 0.0, 0.0]


def test_sliding_and_a_cloud_that_moves_along_do_not_break_contact():
    cloud = plane(30_000, (0.5, 0.3))
    t = np.arange(2000) * 1e-3
    path = np.column_stack([0.05 * np.sin(12 * t), 0.03 * np.sin(7 * t), -2e-3 - 1e-3 * np.sin(40 * t)])
    path[0, 2] = 0.02
    shift = 0.06 * np.sin(5 * t)
    seen = detected(path, lambda k: cloud.moved((shift[k // 33 * 33] if k < 2000 else 0.0, 0.0, 0.0), 0.0))
    assert np.all(seen["in_contact"][1:] == 1.0)
    assert np.abs(seen["proxy"][1:, :2] - path[1:, :2]).max() < 2e-3
    assert np.all(seen["proxy"][1:, 2] < 0.1e-3)
    assert np.all(seen["proxy"][1:, 2] > -2.1e-3)


def test_before_the_first_cloud_there_is_no_contact():
    cloud = plane(30_000)
    path = np.tile([0.0, 0.0, -0.003], (20, 1))
    for nothing in (None, Cloud.empty()):
        contact = detected(path, lambda k, nothing=nothing: nothing if k < 10 else cloud)["in_contact"][:, 0]
        np.testing.assert_array_equal(contact, np.arange(20) >= 10)


def test_a_surface_that_rises_into_the_hand_is_contact_and_entrenches():
    base = plane(8100, (0.09, 0.09))
    heights = -0.02 + 1e-3 * np.arange(40)

    def rising(k):
        return Cloud(base.points() + np.array([0.0, 0.0, heights[min(k, 39)]]))

    seen = detected(np.zeros((40, 3)), rising)
    np.testing.assert_array_equal(seen["in_contact"][heights > 0.5e-3, 0], 1.0)
    np.testing.assert_array_equal(seen["in_contact"][heights < -0.5e-3, 0], 0.0)
    assert {0.0, 1.0, 2.0} == set(seen["proxy_state"][:, 0])


def test_a_position_that_is_not_finite_stops_the_run_with_one_line():
    diagram, _, _ = wired([[0.0, 0.0, math.nan]], lambda k: None)
    with pytest.raises(BadInput, match="finite"):
        Simulator(diagram).AdvanceTo(2e-3)


def test_something_else_than_a_cloud_stops_the_run_with_one_line():
    diagram, _, _ = wired([[0.0, 0.0, 0.0]], lambda k: np.zeros((3, 3)))
    with pytest.raises(BadInput, match="ndarray"):
        Simulator(diagram).AdvanceTo(2e-3)
