"""Measurements in the frame of a surface: a slope is a table that was turned, and what is told comes back."""

import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from mmt_drake.systems.local_frame import LocalFrame

STEP = 1e-3


def followed(measurements, facets):
    """(n, 9) what the estimator reads, tick by tick."""
    system = LocalFrame(period=STEP)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    found = []
    for k, (measurement, facet) in enumerate(zip(measurements, facets, strict=True)):
        system.GetInputPort("raw_measurement").FixValue(context, measurement)
        system.GetInputPort("facet").FixValue(context, facet)
        found.append(np.array(system.GetOutputPort("measurement").Eval(context)))
        simulator.AdvanceTo((k + 1) * STEP)
    return np.array(found), system, context


def slope(degrees):
    a = math.radians(degrees)
    n = np.array([math.sin(a), 0.0, math.cos(a)])
    return n, np.array([[math.cos(a), 0.0, n[0]], [0.0, 1.0, 0.0], [-n[0], 0.0, n[2]]])


def flat(seed=0):
    drawn = np.random.default_rng(seed)
    return np.cumsum(drawn.normal(0.0, 1e-4, (300, 3)), axis=0), drawn.normal(size=(300, 6))


def test_on_a_level_surface_a_measurement_stays_as_it_is():
    position, rest = flat()
    measured = np.hstack([position, rest])
    found, *_ = followed(measured, np.tile([0.0, 0.0, 1.0, 0.0], (300, 1)))
    np.testing.assert_allclose(found, measured, atol=1e-15)


def test_on_a_slope_it_is_turned_back_and_z_counts_from_the_slope():
    position, rest = flat()
    n, turn = slope(50.0)
    origin = 0.02 * n
    turned = np.hstack([position @ turn.T + origin, rest[:, :3] @ turn.T, rest[:, 3:] @ turn.T])
    found, *_ = followed(turned, np.tile([*n, 0.02], (300, 1)))
    np.testing.assert_allclose(found[:, :3] - found[0, :3], position - position[0], atol=1e-15)
    np.testing.assert_allclose(found[:, 2], position[:, 2], atol=1e-15)
    np.testing.assert_allclose(found[:, 3:], rest, atol=1e-14)


def test_the_last_plane_counts_where_none_is_told():
    position, rest = flat()
    n, _ = slope(30.0)
    facets = np.tile([*n, 0.0], (300, 1))
    known, *_ = followed(np.hstack([position, rest]), facets)
    facets[150:] = 0.0
    facets[200:] = np.nan
    found, *_ = followed(np.hstack([position, rest]), facets)
    np.testing.assert_array_equal(found, known)


def test_a_force_that_an_estimator_tells_in_the_frame_comes_back_to_the_table():
    position, rest = flat()
    n, _ = slope(40.0)
    found, system, context = followed(np.hstack([position, rest]), np.tile([*n, 0.0], (300, 1)))
    system.GetInputPort("estimated_force").FixValue(context, found[-1, 6:])
    assert system.GetOutputPort("estimated").Eval(context) == pytest.approx(rest[-1, 3:], abs=1e-14)
