"""Friction as a vector in the plane: closed forms, an independent object, and what may not depend on the axes."""

from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.foreign import plant
from mmt_drake.foreign.numbers import Numbers
from mmt_drake.model import flexible_box
from mmt_drake.model.body import AXIS_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.model.flexible_box_replay import replay_plane
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.model_files import with_effects

STEP, DEPTH = 1e-3, 0.005
MODEL = FlexibleBoxModel(
    BoxParameters(m=0.7, k1=50.0, k2=400.0, b1=10.0, b2=15.0, Fc=0.5), NormalContact(400.0, 8.0), in_plane="vector"
)
BREAKING_AWAY = replace(MODEL, friction=Friction(Fs=0.8, Fd=0.4, v_d=0.004))


def simulated(model, x, y, rate_x, rate_y):
    """Tangential force (n, 2) [N] and body (n, 4) under a probe that presses at a depth, sampled at 1 kHz."""
    n = len(x)
    position, velocity = np.full((n, 3), -DEPTH), np.zeros((n, 3))
    position[:, 0], position[:, 1], velocity[:, 0], velocity[:, 1] = x, y, rate_x, rate_y
    force, body = np.empty((n, 3)), np.empty((n, 4))
    contact = np.ones(n)
    flexible_box.replay(STEP * np.arange(n), position, velocity, contact, model.kernel_vector(), force, body)
    return force[:, :2], body


def strokes(n=6000):
    t = STEP * np.arange(n)
    x, rate_x = 0.03 * np.sin(3.1 * t) + 0.01 * np.sin(9.7 * t), 0.093 * np.cos(3.1 * t) + 0.097 * np.cos(9.7 * t)
    y, rate_y = 0.02 * np.sin(5.3 * t), 0.106 * np.cos(5.3 * t)
    return x, y, rate_x, rate_y


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.8, 2.4])
def test_sliding_evenly_it_pulls_back_by_its_level_whatever_the_direction(angle):
    t, speed = STEP * np.arange(4000), 0.05
    model = replace(MODEL, parameters=replace(MODEL.parameters, k1=0.0))
    along = np.array([np.cos(angle), np.sin(angle)])
    force, _ = simulated(model, *(speed * t * c for c in along), *(np.full_like(t, speed * c) for c in along))
    assert force[-1] == pytest.approx(-(10.0 * speed + 0.5) * along, abs=1e-6)


@pytest.mark.parametrize(("part", "holds"), [(0.70, True), (0.72, False)])
def test_it_holds_by_the_norm_of_the_pull(part, holds):
    t, most = STEP * np.arange(3000), part * 0.5 / 400.0  # the contact spring pulls by `part` of the level on each axis
    way = most * np.minimum(t / 2.0, 1.0)
    rate = np.where(t < 2.0, most / 2.0, 0.0)
    _, body = simulated(replace(MODEL, parameters=replace(MODEL.parameters, b2=0.0)), way, way, rate, rate)
    assert (not body[-1, :2].any()) == holds


@pytest.mark.parametrize("model", [MODEL, BREAKING_AWAY])
def test_turned_motions_give_turned_forces(model):
    assert_alike_in_all_directions(model)


def assert_alike_in_all_directions(model):
    x, y, rate_x, rate_y = strokes()
    c, s = np.cos(0.7), np.sin(0.7)
    force, _ = simulated(model, x, y, rate_x, rate_y)
    turned, _ = simulated(model, c * x - s * y, s * x + c * y, c * rate_x - s * rate_y, s * rate_x + c * rate_y)
    assert np.abs(turned - force @ [[c, s], [-s, c]]).max() < 2e-3 * np.abs(force).max()


def test_a_table_over_the_velocity_draws_a_drag_in_all_directions():
    """And what is the same forth and back pushes each axis, as a constant force does."""
    speeds, c = np.linspace(-0.5, 0.5, 401), 20.0
    drag, push = (
        {"name": "quadratic_drag", "parameters": {"c": c}},
        {"name": "constant_force", "parameters": {"F": 0.2}},
    )
    drawn = {"of": "sliding_velocity", "at": list(speeds), "value": list(c * speeds * np.abs(speeds) - 0.2)}
    table = with_effects(MODEL, [{"name": "tabulated_force", "parameters": drawn}], "table")
    laws = with_effects(MODEL, [drag, push], "laws")
    force, _ = simulated(laws, *strokes())
    same, _ = simulated(table, *strokes())
    assert np.abs(same - force).max() < 1e-3 * np.abs(force).max()
    assert_alike_in_all_directions(with_effects(MODEL, [drag], "drag"))


def test_along_one_axis_it_is_friction_of_that_axis():
    x, _, rate_x, _ = strokes()
    still = np.zeros_like(x)
    force, _ = simulated(MODEL, x, still, rate_x, still)
    alone, _ = simulated(replace(MODEL, in_plane="per_axis"), x, still, rate_x, still)
    assert np.abs(force - alone).max() < 3e-5
    assert not force[:, 1].any()


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.8, 2.4])
def test_drag_with_the_square_of_the_speed_opposes_an_even_motion_alike_in_all_directions(angle):
    t, speed = STEP * np.arange(4000), 0.3
    bare = replace(MODEL, parameters=replace(MODEL.parameters, k1=0.0, Fc=0.0))
    model = with_effects(bare, [{"name": "quadratic_drag", "parameters": {"c": 6.0}}], "here")
    along = np.array([np.cos(angle), np.sin(angle)])
    force, _ = simulated(model, *(speed * t * c for c in along), *(np.full_like(t, speed * c) for c in along))
    assert force[-1] == pytest.approx(-(10.0 * speed + 6.0 * speed**2) * along, abs=1e-6)


OTHER = {"m": 0.7, "k1": 50.0, "k2": 400.0, "b1": 10.0, "b2": 15.0, "normal_k": 400.0, "normal_b": 8.0}
OTHER |= {"Fs": 0.5, "Fd": 0.5}
FREE = replace(MODEL, parameters=replace(MODEL.parameters, Fc=0.0))
IN_PLANE = {
    "nonlinear_stiffness": {"k3": 4e5},
    "hunt_crossley_damping": {"lambda": 60.0},
    "hysteresis": {"alpha": 150.0, "beta": 120.0, "gamma": 40.0},
    "contact_gap": {"gap": 0.004},
    "quadratic_drag": {"c": 20.0},
    "presliding_friction": {"sigma0": 900.0, "sigma1": 3.0, "Fs": 0.8, "v_s": 0.05},
    "dahl_friction": {"Fc": 0.5, "sigma": 900.0},
    "smooth_coulomb_friction": {"Fc": 0.5, "v_s": 0.02},
    "hardening_relaxation": {"k3_maxwell": 4e5, "tau": 0.1},
}


def having(name, model=MODEL, **values):
    return with_effects(model, [{"name": name, "parameters": values or IN_PLANE[name]}], "here")


@pytest.mark.parametrize(
    ("model", "given", "lifts"),
    [
        (MODEL, {}, False),
        (MODEL, {}, True),
        (having("viscoelastic_relaxation", k_maxwell=200.0, tau=0.15), {"k_maxwell": 200.0, "tau": 0.15}, False),
        (having("stribeck_friction", Fs=0.9, v_s=0.02), {"Fs": 0.9, "v_s": 0.02}, False),
        (having("nonlinear_stiffness"), IN_PLANE["nonlinear_stiffness"], False),
        (having("hunt_crossley_damping"), {"hunt_crossley": 60.0}, False),
        (having("hysteresis"), IN_PLANE["hysteresis"], False),
        (having("hysteresis"), IN_PLANE["hysteresis"], True),
        (having("hysteresis", FREE), IN_PLANE["hysteresis"] | {"Fs": 0.0, "Fd": 0.0}, False),
        (having("contact_gap"), IN_PLANE["contact_gap"], False),
        (having("contact_gap", FREE), IN_PLANE["contact_gap"] | {"Fs": 0.0, "Fd": 0.0}, False),
        (having("quadratic_drag"), IN_PLANE["quadratic_drag"], False),
        (having("presliding_friction"), IN_PLANE["presliding_friction"], False),
        (having("dahl_friction", FREE), {"sigma0": 900.0}, False),
    ],
    ids=[
        *("slides", "touches and lifts", "relaxes", "Stribeck", "hardens", "Hunt and Crossley", "Bouc and Wen"),
        *("Bouc and Wen lifts", "Bouc and Wen alone", "play", "play alone", "drag", "LuGre", "Dahl"),
    ],
)
def test_it_agrees_with_another_integrator_and_another_stick_rule(model, given, lifts):
    x, y, rate_x, rate_y = strokes()
    t, n = STEP * np.arange(len(x)), len(x)
    height, rise = (DEPTH * np.sin(4.0 * t), 4.0 * DEPTH * np.cos(4.0 * t)) if lifts else (x * 0.0 - DEPTH, x * 0.0)
    motion = np.column_stack([x, y, height, rate_x, rate_y, rise])
    force, body = np.empty((n, 3)), np.empty((n, 4))
    touches = np.full(n, flexible_box.CONTACT_BY_GEOMETRY)
    position, velocity = np.ascontiguousarray(motion[:, :3]), np.ascontiguousarray(motion[:, 3:])
    flexible_box.replay(t, position, velocity, touches, model.kernel_vector(), force, body)
    substeps = round(STEP / plant.STEP_S)
    other, body = np.empty(((n - 1) * substeps + 1, 3)), np.empty((n, 4))
    plant.run(t, motion, Numbers(**OTHER | given).checked(plant.STEP_S), substeps, other, body)
    difference = force[:, :2] - other[::substeps, :2]
    assert np.sqrt(np.mean(difference**2) / np.mean(force[:, :2] ** 2)) < (0.02 if lifts else 2e-3)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("name", IN_PLANE)
def test_laws_in_the_plane_are_alike_in_all_directions(name, friction):
    model = FREE if name in ("dahl_friction", "smooth_coulomb_friction") else MODEL
    assert_alike_in_all_directions(having(name, replace(model, parameters=replace(model.parameters, Fc=friction))))


@pytest.mark.parametrize("name", IN_PLANE)
def test_laws_in_the_plane_are_those_of_an_axis_where_the_other_is_still(name):
    x, _, rate_x, _ = strokes()
    still, model = np.zeros_like(x), having(name, FREE)
    force, _ = simulated(model, x, still, rate_x, still)
    alone, _ = simulated(replace(model, in_plane="per_axis"), x, still, rate_x, still)
    assert np.abs(force - alone).max() < 3e-5
    assert not force[:, 1].any()


@pytest.mark.parametrize("model", [MODEL, BREAKING_AWAY])
def test_a_finer_step_changes_nothing_that_counts(model):
    motion = strokes()
    force, _ = simulated(model, *motion)
    p = model.kernel_vector(max_step=5e-5)
    n = len(force)
    position, velocity = np.full((n, 3), -DEPTH), np.zeros((n, 3))
    position[:, 0], position[:, 1], velocity[:, 0], velocity[:, 1] = motion
    finer, body = np.empty((n, 3)), np.empty((n, 4))
    flexible_box.replay(STEP * np.arange(n), position, velocity, np.ones(n), p, finer, body)
    assert np.sqrt(np.mean((finer[:, :2] - force) ** 2)) < 1e-3


def test_a_probe_that_creeps_at_the_break_away_level_takes_no_more_steps_than_others():
    model = replace(BREAKING_AWAY, parameters=BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=0.0, b2=0.0))
    t = STEP * np.arange(40)
    way, still = 0.8 / 500.0 + 1e-10 * t, np.zeros_like(t)  # it slips by less than an atom's width
    model = replace(model, friction=Friction(Fs=0.8, Fd=0.4, v_d=0.004))
    n = len(t)
    position, velocity = np.full((n, 3), -DEPTH), np.zeros((n, 3))
    position[:, 0], position[0, 0], position[:, 1], velocity[:, 0] = way, 0.0, still, 1e-10
    force, body = np.empty((n, 3)), np.empty((n, 4))
    flexible_box.replay(t, position, velocity, np.ones(n), model.kernel_vector(), force, body)
    assert np.isfinite(force).all()


def test_both_axes_replayed_together_are_those_of_the_object_stepped_sample_by_sample():
    x, y, rate_x, rate_y = strokes()
    force, body = simulated(MODEL, x, y, rate_x, rate_y)
    n = len(x)
    height, still = np.full(n, -DEPTH), np.zeros(n)
    found, way, rate = np.empty((2, n)), np.empty((2, n)), np.empty((2, n))
    probe, probe_rate = np.vstack([x, y]), np.vstack([rate_x, rate_y])
    p = MODEL.kernel_vector()
    replay_plane(STEP * np.arange(n), probe, probe_rate, height, still, True, np.empty(0), p, found, way, rate)
    np.testing.assert_allclose(found.T, force, atol=1e-12)
    np.testing.assert_allclose(np.vstack([way, rate]).T, body, atol=1e-12)


def test_what_cannot_be_followed_is_an_error_here_too():
    t = np.array([0.0, 1e7])
    still, force, body = np.zeros((2, 3)), np.empty((2, 3)), np.empty((2, 4))
    model = replace(MODEL, parameters=BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=60.0, b2=60.0, Fc=0.1))
    with pytest.raises(RuntimeError, match="ten million"):
        flexible_box.replay(t, still - DEPTH, still, np.ones(2), model.kernel_vector(), force, body)


@pytest.mark.parametrize("names", [(), ("dahl_friction",), ("viscoelastic_relaxation", "dahl_friction")])
@pytest.mark.parametrize(("model", "part"), [(MODEL, 0.0), (BREAKING_AWAY, 0.3)])
def test_what_happens_along_x_happens_along_y(model, part, names):
    numbers = {
        "dahl_friction": {"Fc": 0.05, "sigma": 800.0},
        "viscoelastic_relaxation": {"k_maxwell": 200.0, "tau": 0.15},
    }
    model = with_effects(model, [{"name": name, "parameters": numbers[name]} for name in names], "here")
    x, y, rate_x, rate_y = strokes(3000)
    force, body = simulated(model, x, part * y, rate_x, part * rate_y)
    swapped, body_swapped = simulated(model, part * y, x, part * rate_y, rate_x)
    np.testing.assert_allclose(swapped, force[:, ::-1], atol=1e-9)
    np.testing.assert_allclose(body_swapped, body[:, [1, 0, 3, 2]], atol=1e-9)


@pytest.mark.parametrize("step", [0.01, 0.4, 4.0])
def test_a_body_let_go_in_the_plane_slides_as_far_as_friction_allows_whatever_the_samples(step):
    model = BoxParameters(m=2.0, k1=0.0, k2=0.0, b1=0.0, b2=0.0, Fc=0.2)  # from 1 m/s: v^2 / (2 a) = 5 m in 10 s
    p, along = FlexibleBoxModel(model, in_plane="vector").kernel_vector(), np.array([0.6, -0.8])
    state, motion = np.empty(flexible_box.STATE_SIZE), np.zeros(6)
    flexible_box.begin(state, 0.0, motion, 0.0, p)
    bodies = state[flexible_box.BODY : flexible_box.NORMAL].reshape(2, AXIS_SIZE)
    bodies[:, VELOCITY], bodies[:, MODE] = along, np.sign(along)
    for k in range(1, round(12.0 / step) + 1):
        flexible_box.advance(state, k * step, motion, 0.0, p)
        if k * step < 9.9:
            np.testing.assert_allclose(bodies[:, POSITION], (k * step - 0.05 * (k * step) ** 2) * along, rtol=1e-9)
    np.testing.assert_allclose(bodies[:, POSITION], 5.0 * along, rtol=1e-3)
    assert not bodies[:, [VELOCITY, MODE]].any()


@pytest.mark.parametrize("touches", [0.0, 1.0])
def test_a_body_so_slow_that_squares_of_its_speed_are_0_has_a_direction_still(touches):
    table = {"of": "friction_over_position", "at": [-0.2, -0.1, 0.1, 0.2], "value": [0.0, 0.0, 0.0, 0.5]}
    frictionless = replace(MODEL, parameters=replace(MODEL.parameters, k1=0.0, Fc=0.0))
    p = with_effects(frictionless, [{"name": "tabulated_force", "parameters": table}], "test").kernel_vector()
    state, probe = np.empty(flexible_box.STATE_SIZE), np.zeros(6)
    flexible_box.begin(state, 0.0, probe, touches, p)
    x, y = (flexible_box.BODY + AXIS_SIZE * axis for axis in range(2))
    state[x + VELOCITY], state[x + MODE], state[y + MODE] = 1e-170, 1.0, 1.0  # a damper alone has brought it there
    state[y + POSITION] = 0.2  # where there is friction
    for i in range(1, 20):
        flexible_box.advance(state, STEP * i, probe, touches, p)
    assert np.isfinite(state[flexible_box.BODY :]).all()
