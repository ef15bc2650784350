"""Laws on the body against closed forms, on a driven body."""

import numpy as np
import pytest
from responses import applied
from scipy.special import ellipj, ellipk

from mmt_drake.effects import LIBRARY
from mmt_drake.model import driven_body
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity

T = np.arange(3000) * 1e-3


def motion(model, u, load=0.0, start=0.0, time=T, **effects):
    """(n,) position and rate."""
    for name, values in effects.items():
        model = applied(model, name, values)
    n = len(time)
    output, rate, state = np.empty(n), np.empty(n), np.empty(driven_body.STATE_SIZE)
    u, load = u + np.zeros(n), load + np.zeros(n)
    driven_body.begin(state, time[0], u[0], load[0], start)
    driven_body.replay_part(0, n, time, u, load, model.kernel_vector(), state, output, rate)
    return output, rate


def test_a_further_mass_gives_the_two_mass_transfer_function():
    m, b, k, m2, k2, b2 = 0.8, 4.0, 90.0, 0.3, 150.0, 1.2
    for omega in (6.0, 14.0, 25.0):  # below, near and above the second resonance
        time = np.arange(14000) * 1e-3
        hung = {"m2": m2, "k": k2, "b": b2}
        x, _ = motion(DrivenBodyModel(m=m, b=b, k=k), np.cos(omega * time), time=time, second_mode=hung)
        s = 1j * omega
        branch = (k2 + b2 * s) * m2 * s**2 / (m2 * s**2 + b2 * s + k2)
        h = 1 / (m * s**2 + b * s + k + branch)
        settled = time > 10.0
        expected = (h * np.exp(s * time)).real[settled]
        np.testing.assert_allclose(x[settled], expected, atol=1e-4 * abs(h))  # the input is linear between samples


def test_a_wall_that_is_never_left_is_a_constant_force_beside_a_stiffer_spring():
    push, wall = np.sin(7.0 * T), {"position": -0.05, "stiffness": 20.0}
    pressed, _ = motion(DrivenBodyModel(m=0.5, b=1.0, k=100.0), push, end_stop=wall)
    pulled, _ = motion(DrivenBodyModel(m=0.5, b=1.0, k=120.0), push, constant_force={"F": -1.0})
    assert pressed.min() > wall["position"]
    np.testing.assert_allclose(pressed, pulled, atol=1e-9)
    assert all(LIBRARY[name].is_simpler_than(LIBRARY["end_stop"]) for name in ("constant_force", "ground_spring"))


def test_a_wall_is_pressed_in_by_the_work_done_on_the_way_to_it():
    push, stiffness, position = 2.0, 500.0, 0.05
    depth = (push + np.sqrt(push**2 + 2 * stiffness * push * position)) / stiffness
    for side in (1.0, -1.0):
        wall = {"position": side * position, "stiffness": stiffness, "side": side}
        x, _ = motion(DrivenBodyModel(m=0.5), side * push, end_stop=wall)
        assert np.max(side * x) == pytest.approx(position + depth, rel=1e-4)
        away, _ = motion(DrivenBodyModel(m=0.5), -side * push, end_stop=wall)
        np.testing.assert_allclose(away, -side * 0.5 * push / 0.5 * T**2, atol=1e-9)


def test_a_payload_changes_the_acceleration_and_leaves_the_velocity():
    _, v = motion(DrivenBodyModel(m=0.5), 3.0, mass_change={"time": 1.2, "dm": 0.7})
    np.testing.assert_allclose(v[:1199], 6.0 * T[:1199], atol=1e-9)
    np.testing.assert_allclose(v[1202:], 6.0 * 1.2 + 2.5 * (T[1202:] - 1.2), atol=1e-3 * 3.5)
    assert v[-1] - v[1500] == pytest.approx(2.5 * (T[-1] - T[1500]), rel=1e-9)


def test_a_payload_that_falls_along_changes_nothing():
    ball = DrivenBodyModel(m=0.5, gravity=Gravity("constant", 9.81))
    x, _ = motion(ball, 0.0, start=40.0, mass_change={"time": 1.2, "dm": -0.3})
    np.testing.assert_allclose(x, 40.0 - 0.5 * 9.81 * T**2, atol=1e-8)


def test_a_ball_falls_against_drag_as_a_hyperbolic_tangent():
    m, c, g = 0.2, 0.05, 9.81
    time = np.arange(0, 3, 1 / 15)  # as a camera samples it
    ball = DrivenBodyModel(m=m, gravity=Gravity("constant", g))
    _, v = motion(ball, 0.0, time=time, quadratic_drag={"c": c})
    np.testing.assert_allclose(v, -np.sqrt(m * g / c) * np.tanh(np.sqrt(c * g / m) * time), rtol=1e-5)


def test_a_hardening_spring_swings_as_jacobis_cosine():
    m, k, k3, a = 0.5, 40.0, 6e3, 0.1
    x, _ = motion(DrivenBodyModel(m=m, k=k), 0.0, start=a, nonlinear_stiffness={"k3": k3})
    omega = np.sqrt((k + k3 * a * a) / m)
    modulus = k3 * a * a / (2 * (k + k3 * a * a))
    assert T[-1] > 4 * 4 * ellipk(modulus) / omega  # several periods
    np.testing.assert_allclose(x, a * ellipj(omega * T, modulus)[1], atol=1e-5 * a)


@pytest.mark.parametrize(
    ("name", "values", "holds", "slides"),
    [
        ("coulomb_friction", {"Fc": 2.0}, (2.0, 2.0), (2.0, 2.0)),
        ("asymmetric_friction", {"Fc_plus": 2.0, "Fc_minus": 1.2}, (2.0, 1.2), (2.0, 1.2)),
        ("static_friction", {"Fs": 2.0, "Fd": 1.5, "v_d": 1e-3}, (2.0, 2.0), (1.5, 1.5)),
        ("load_dependent_friction", {"mu": 0.5}, (2.0, 2.0), (2.0, 2.0)),
    ],
)
def test_friction_holds_below_its_level_and_subtracts_above(name, values, holds, slides):
    body = DrivenBodyModel(m=0.5)
    for sign, hold, slide in zip((1.0, -1.0), holds, slides, strict=True):
        rest, _ = motion(body, sign * 0.999 * hold, load=4.0, **{name: values})
        assert not rest.any()
        x, _ = motion(body, sign * 3.0, load=4.0, **{name: values})
        np.testing.assert_allclose(x, sign * 0.5 * (3.0 - slide) / 0.5 * T**2, rtol=1e-6, atol=1e-9)


def test_stribeck_friction_holds_below_its_break_away_level_and_settles_where_forces_balance():
    body = DrivenBodyModel(m=0.5, b=3.0, Fc=1.0)
    values = {"Fs": 2.0, "v_s": 0.3}
    assert not motion(body, 1.999, stribeck_friction=values)[0].any()
    _, v = motion(body, 2.6, stribeck_friction=values, time=np.arange(12000) * 1e-3)
    assert 3.0 * v[-1] + 1.0 + np.exp(-((v[-1] / 0.3) ** 2)) == pytest.approx(2.6, abs=1e-6) and v[-1] > 0.1


def test_bristles_hold_as_a_spring_below_the_level():
    body = DrivenBodyModel(m=0.5, b=8.0, Fc=2.0)
    x, _ = motion(body, 0.01, presliding_friction={"sigma0": 500.0})  # 0.5 % of the level
    assert x[-1] == pytest.approx(0.01 / 500.0, rel=2e-2)


def test_dampers_and_forces_of_the_body_are_their_formulas():
    body = DrivenBodyModel(m=0.1, b=3.0, gain=2.0)
    for u, b in ((1.5, 5.0), (-1.5, 2.0)):
        _, v = motion(body, u, asymmetric_viscous_friction={"b_plus": 5.0, "b_minus": 2.0})
        np.testing.assert_allclose(v, 2.0 * u / b * (1 - np.exp(-b * T / 0.1)), atol=1e-7)
    x, _ = motion(DrivenBodyModel(m=0.5, gain=2.0), 0.0, constant_force={"F": 1.5})
    np.testing.assert_allclose(x, 0.5 * 2.0 * 1.5 / 0.5 * T**2, atol=1e-9)
    x, _ = motion(DrivenBodyModel(m=0.5, k=10.0), 0.0, start=0.1, ground_spring={"k": 30.0})
    np.testing.assert_allclose(x, 0.1 * np.cos(np.sqrt(80.0) * T), atol=1e-5 * 0.1)


def test_a_linear_table_over_position_is_a_spring_and_over_velocity_a_damper():
    body = DrivenBodyModel(m=0.5, b=1.0, k=10.0)
    u = np.sin(7 * T)
    spring = motion(body, u, ground_spring={"k": 30.0})[0]
    table = {"of": "position", "at": [-1, 0.1, 1], "value": [-30, 3, 30]}
    np.testing.assert_allclose(motion(body, u, tabulated_force=table)[0], spring, atol=1e-9)
    damper = motion(body, u, viscous_friction={"b": 4.0})[0]
    table = {"of": "sliding_velocity", "at": [-2, 2], "value": [-8, 8]}
    np.testing.assert_allclose(motion(body, u, tabulated_force=table)[0], damper, atol=1e-9)
