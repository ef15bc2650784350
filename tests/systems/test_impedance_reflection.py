"""The renderer: the plant's own physics, contact by the flag, parameters swapped in, nothing before the first theta."""

from dataclasses import replace

import numpy as np
import pytest
from driven import STEP, driven
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from scipy.integrate import solve_ivp

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.rendering.updates import EnergyPermitting
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.impedance_reflection import ImpedanceRenderer
from mmt_drake.systems.scripted_operator import ScriptedOperator

MODEL = FlexibleBoxModel(BoxParameters(Fc=0.4))
TIME = np.arange(4001) * STEP


def motion(height):
    position = np.column_stack([0.03 * np.sin(9 * TIME), 0.02 * np.sin(20 * TIME), height(TIME)])
    velocity = np.column_stack([0.27 * np.cos(9 * TIME), 0.4 * np.cos(20 * TIME), np.gradient(height(TIME), STEP)])
    return position, velocity


PRESSED = motion(lambda t: -0.004 + 0 * t)


def held(values):
    """A signal that jumps to values[i] at TIME[i]."""
    values = np.atleast_2d(np.asarray(values, dtype=float).T)
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(TIME, values))


def render(position, velocity, theta, stable, contact, *, model_status=None, **settings):
    """Rendered force (n, 3) at every tick."""
    told = {"theta": theta, "stable": stable, "in_contact": contact}
    told |= {} if model_status is None else {"model_status": model_status}
    sources = {name: held(values) for name, values in told.items()}
    return force_of(ImpedanceRenderer(**settings), position, velocity, **sources)


def force_of(system, position, velocity, **sources):
    motion = ScriptedOperator(SampledMotion(TIME, position, velocity))
    return driven(system, ["force"], TIME[-1], motion=motion, **sources)[0]["force"]


def constant(value):
    return np.tile(value, (len(TIME), 1))


@pytest.mark.parametrize("in_plane", ["per_axis", "vector"])
def test_with_the_plants_own_parameters_and_contact_it_renders_the_plants_force(in_plane):
    position, velocity = PRESSED
    plant = FlexibleBox(replace(MODEL, in_plane=in_plane))
    force = render(position, velocity, constant(MODEL.theta()), constant(1), constant(1), in_plane=in_plane)
    expected = force_of(plant, position, velocity)
    assert expected[:, 0].std() > 1
    np.testing.assert_allclose(force, expected, atol=1e-10)


def test_the_force_belongs_to_the_motion_of_the_same_tick():
    # A pure damper along z answers a velocity at once.
    position, velocity = motion(lambda t: -0.004 + 0.002 * np.sin(12 * t))
    theta = constant([1, 0, 1, 0, 0, 0, 0, 30, 0, 0])
    force = render(position, velocity, theta, constant(1), constant(1))
    np.testing.assert_allclose(force[:, 2], -30 * velocity[:, 2], atol=1e-12)


def test_nothing_is_rendered_before_the_first_stable_theta():
    position, velocity = PRESSED
    theta = constant(MODEL.theta())
    theta[:500] = np.nan
    stable = constant(1.0)
    stable[:1500] = 0
    force = render(position, velocity, theta, stable, constant(1))
    assert np.all(force[:1500] == 0)
    assert np.all(force[1510:, 2] == pytest.approx(2.0))


def test_an_unstable_or_unknown_theta_is_passed_over_and_the_last_good_one_kept():
    position, velocity = PRESSED
    theta = constant(MODEL.theta())
    expected = render(position, velocity, theta, constant(1), constant(1))
    spoilt, stable = theta.copy(), constant(1.0)
    spoilt[1000:2000] = [-1, 5, -400, 1, 1, 0, 100, 1, 0, 0]
    stable[1000:2000] = 0
    spoilt[2000:] = np.nan
    np.testing.assert_array_equal(render(position, velocity, spoilt, stable, constant(1)), expected)


def test_new_parameters_act_at_once_and_the_bodys_motion_carries_over():
    position, velocity = PRESSED
    theta = constant(MODEL.theta())
    theta[2000:, 6] = 700
    force = render(position, velocity, theta, constant(1), constant(1))
    before = render(position, velocity, constant(MODEL.theta()), constant(1), constant(1))
    np.testing.assert_array_equal(force[:, :2], before[:, :2])
    np.testing.assert_allclose(force[1999:2001, 2], [2.0, 2.8])


def test_off_contact_the_force_is_zero_and_the_next_touch_is_unstretched():
    position, velocity = PRESSED
    contact = constant(1.0)
    contact[1000:2000] = 0
    force = render(position, velocity, constant(MODEL.theta()), constant(1), contact)
    assert np.all(force[1000:2000] == 0)
    # The spring is unstretched; the damper feels the difference of two bounded velocities.
    assert np.abs(force[2000, :2]).max() <= 60 * 0.5
    assert np.abs(force[2000:, :2]).max() > 1


def test_more_substeps_change_a_smooth_force_by_less_than_a_millionth():
    position, velocity = PRESSED
    theta = constant(FlexibleBoxModel().theta())
    one, eight = (render(position, velocity, theta, constant(1), constant(1), substeps=n) for n in (1, 8))
    difference = np.sqrt(np.mean((one - eight) ** 2))
    assert 0 < difference < 1e-6 * np.sqrt(np.mean(eight**2))


def test_a_probe_that_is_placed_damps_like_one_that_stands_still():
    # The contact damper then acts between the body and the world; what is left of it on the probe is b2 v_m.
    p = BoxParameters(k1=30.0, b2=40.0)
    position, velocity = PRESSED
    force = render(position, velocity, constant(FlexibleBoxModel(p).theta()), constant(1), constant(1), probe="placed")

    def rate(t, state):
        x, v = state
        stretch = 0.02 * np.sin(20 * t) - x
        return [v, (p.k2 * stretch - (p.b1 + p.b2) * v - p.k1 * x) / p.m]

    body = solve_ivp(rate, (0.0, TIME[-1]), [0.0, 0.0], t_eval=TIME, rtol=1e-9, atol=1e-12).y
    expected = -(p.k2 * (position[:, 1] - body[0]) - p.b2 * body[1])
    assert np.abs(force[:, 1] - expected).max() < 0.02 * np.abs(expected).max()  # a step of 1 ms at 20 rad/s
    np.testing.assert_allclose(force[1:, 2], 500 * 0.004)


@pytest.mark.parametrize("arguments", [{"period": 0.0}, {"substeps": 0}, {"substeps": 1.5}, {"probe": "thrown"}])
def test_meaningless_settings_are_refused(arguments):
    with pytest.raises(BadInput, match="renderer"):
        ImpedanceRenderer(**arguments)


def test_a_theta_too_stiff_to_integrate_is_passed_over():
    # An early estimate can be admissible and still have a mass of 1e-7 kg.
    position, velocity = PRESSED
    theta = constant(MODEL.theta())
    expected = render(position, velocity, theta, constant(1), constant(1))
    stiff = theta.copy()
    stiff[1000:2000, 0] = 1e-7
    np.testing.assert_array_equal(render(position, velocity, stiff, constant(1), constant(1)), expected)


def test_numbers_that_the_estimator_is_not_sure_of_change_the_force_more_slowly():
    position, velocity = motion(lambda t: 0.008 * np.clip(0.1 - t, -0.5, 0.1))
    position[:, :2] = velocity[:, :2] = 0.0  # it presses for half a second, and holds
    theta, status = constant(MODEL.theta()), constant(0)
    theta[TIME >= 1.0, 6] *= 0.5  # of 500 N/m along the normal: 1 N less
    status[(TIME >= 1.1) & (TIME < 1.3)] = 3
    policy = EnergyPermitting(rate=4.0, unsure_rate=1.0)
    contact = position[:, 2] < 0.0
    force = render(position, velocity, theta, constant(1), contact, model_status=status, updates=policy)
    rate = -np.diff(force[:, 2]) / STEP
    assert rate[(TIME[1:] > 1.01) & (TIME[1:] < 1.09)] == pytest.approx(4.0, rel=1e-6)
    assert rate[(TIME[1:] > 1.11) & (TIME[1:] < 1.29)] == pytest.approx(1.0, rel=1e-6)
