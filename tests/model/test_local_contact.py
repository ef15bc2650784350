"""The contact on any surface: on a level one that of `flexible_box`, on others closed forms and another integrator."""

import itertools
import math

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import AXIS_SIZE, POSITION, VELOCITY
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.local_contact import Facet
from mmt_drake.model.on_surface import advance_on, begin_on, predicted
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.surfaces import Cylinder, Plane, Saddle, Shape, Sphere, locate
from mmt_drake.surfaces.layout import WORLD

THESIS = FlexibleBoxModel(friction=Friction(Fs=0.1, Fd=0.05, v_d=0.005))
NEVER = 1e12  # friction of the tip so high that it never slips, and no level surface either: no short cut is taken
BODY_X, BODY_Y = box.BODY, box.BODY + AXIS_SIZE


@njit
def run(surface, mu, time, position, velocity, p, force, body, energy):
    state, motion, felt = np.zeros(box.STATE_SIZE), np.empty(6), np.empty(3)
    world, held = surface[WORLD], (0.0, 0.0, 0.0)
    for k in range(len(time)):
        motion[:3], motion[3:] = position[k], velocity[k]
        at = (motion[0], motion[1], motion[2])
        if k > 0:
            at = predicted(state, time[k], motion, world)
        depth, n = locate(surface, at, held)
        facet = Facet(n, depth + n[0] * at[0] + n[1] * at[1] + n[2] * at[2], world, mu)
        if k == 0:
            begin_on(state, time[k], motion, box.CONTACT_BY_GEOMETRY, facet, p)
        else:
            advance_on(state, time[k], motion, box.CONTACT_BY_GEOMETRY, facet, p)
        held = n if state[box.CONTACT] != 0.0 else (0.0, 0.0, 0.0)
        box.force_on_probe(state, p, felt)
        force[k] = felt
        energy[k] = stored_energy(state, p)
        body[k, 0], body[k, 1] = state[BODY_X + POSITION], state[BODY_Y + POSITION]
        body[k, 2], body[k, 3] = state[BODY_X + VELOCITY], state[BODY_Y + VELOCITY]


def simulated(surface: Shape, model, time, position, velocity, mu=NEVER):
    force, body, energy = np.empty((len(time), 3)), np.empty((len(time), 4)), np.empty(len(time))
    run(surface.packed(), mu, time, position, velocity, model.kernel_vector(), force, body, energy)
    return force, body, energy


def strokes(seconds=8.0, step=1e-3):
    time = np.arange(0.0, seconds, step)
    return (time, *scripted_motion("strokes").sample(time))


@pytest.mark.parametrize("in_plane", ["per_axis", "vector"])
@pytest.mark.parametrize("fixed_to", ["world", "body"])
def test_on_a_level_surface_without_slip_it_is_the_flexible_box_to_1e_9(in_plane, fixed_to):
    time, position, velocity = strokes()
    model = FlexibleBoxModel(
        BoxParameters(m=0.8, k1=20.0, k2=450.0, b1=40.0, b2=30.0),
        NormalContact(600.0, 40.0),
        Friction(Fs=0.3, Fd=0.2, v_d=0.002),
        in_plane=in_plane,
    )
    level, moved = np.empty((len(time), 3)), np.empty((len(time), 4))
    contact = np.full(len(time), box.CONTACT_BY_GEOMETRY)
    box.replay(time, position, velocity, contact, model.kernel_vector(), level, moved)
    force, body, _ = simulated(Plane(fixed_to=fixed_to), model, time, position, velocity)
    assert np.abs(level).max() > 1.0
    assert np.abs(moved).max() > 0.01
    np.testing.assert_allclose(force, level, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(body, moved, rtol=0.0, atol=1e-9)
    short_cut, body, _ = simulated(Plane(fixed_to=fixed_to), model, time, position, velocity, mu=math.inf)
    np.testing.assert_array_equal(short_cut, level)


def rotation(surface: Plane):
    """The columns are the axes of the plane, level ones turned the shortest way."""
    _, (nx, ny, nz) = locate(surface.packed(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return np.array(
        [
            [1.0 - nx * nx / (1.0 + nz), -nx * ny / (1.0 + nz), nx],
            [-nx * ny / (1.0 + nz), 1.0 - ny * ny / (1.0 + nz), ny],
            [-nx, -ny, nz],
        ]
    )


@pytest.mark.parametrize(("tilt", "in_plane"), [(20.0, "vector"), (60.0, "per_axis"), (60.0, "vector")])
def test_a_slope_that_is_fixed_to_the_world_is_the_level_surface_turned(tilt, in_plane):
    time, position, velocity = strokes()
    model = FlexibleBoxModel(friction=THESIS.friction, in_plane=in_plane)
    slope = Plane(tilt=tilt, turned=30.0)
    turn = rotation(slope)
    level, expected, _ = simulated(Plane(), model, time, position, velocity)
    force, body, _ = simulated(slope, model, time, position @ turn.T, velocity @ turn.T)
    np.testing.assert_allclose(force, level @ turn.T, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(body, expected, rtol=0.0, atol=1e-9)


def gliding(time):
    """A tip that presses on a slope and draws circles, in contact all the time."""
    w = 2.0 * math.pi * 0.8
    position = np.column_stack(
        [0.02 * np.sin(w * time), 0.015 * np.sin(0.7 * w * time), -0.01 + 0.002 * np.sin(w * time)]
    )
    velocity = np.column_stack(
        [0.02 * w * np.cos(w * time), 0.7 * w * 0.015 * np.cos(0.7 * w * time), 0.002 * w * np.cos(w * time)]
    )
    return position, velocity


def test_the_body_under_a_slope_moves_as_another_integrator_says():
    """All of -F acts along the table: the part along the normal too."""
    model = FlexibleBoxModel(BoxParameters(m=0.9, k1=30.0, k2=400.0, b1=12.0, b2=9.0), NormalContact(700.0, 25.0))
    slope, p = Plane(tilt=35.0, turned=50.0, fixed_to="body"), model.parameters
    n = np.array(locate(slope.packed(), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))[1])
    start, _ = gliding(np.zeros(1))

    def forces(t, y):
        position, velocity = gliding(np.array([t]))
        r, rate = position[0] - [*y[:2], 0.0], velocity[0] - [*y[2:], 0.0]
        d, u = (r - start[0]) - n * (n @ (r - start[0])), rate - n * (n @ rate)
        return n * (-700.0 * (n @ r) - 25.0 * (n @ rate)) - 400.0 * d - 9.0 * u

    def slopes(t, y):
        return [*y[2:], *((-forces(t, y)[:2] - 30.0 * y[:2] - 12.0 * y[2:]) / p.m)]

    errors = []
    for step in (2e-3, 1e-3):
        time = np.arange(0.0, 2.0, step)
        exact = solve_ivp(slopes, (0.0, 2.0), [0.0] * 4, t_eval=time, rtol=1e-10, atol=1e-12)
        force, body, _ = simulated(slope, model, time, *gliding(time))
        truth = np.array([forces(t, y) for t, y in zip(time, exact.y.T, strict=True)])
        assert np.ptp(body[:, 0]) > 0.01
        errors.append(np.abs(force - truth).max() / np.abs(truth).max())
    assert errors[1] < 2e-5
    assert errors[0] / errors[1] > 3.0


@pytest.mark.parametrize("in_plane", ["per_axis", "vector"])
def test_friction_of_the_table_holds_the_body_under_a_slope_until_the_push_beats_it(in_plane):
    """Pressed straight down without a tangential spring, the slope pushes the body by N sin(tilt)."""
    model = FlexibleBoxModel(
        BoxParameters(m=1.0, k1=0.0, k2=0.0, b1=20.0, b2=0.0),
        NormalContact(500.0, 0.0),
        Friction(Fs=1.0, Fd=1.0, v_d=0.0),
        in_plane=in_plane,
    )
    time = np.arange(0.0, 1.0, 1e-3)
    position = np.column_stack([0 * time, 0 * time, -0.02 * time])
    velocity = np.tile([0.0, 0.0, -0.02], (len(time), 1))
    _, body, _ = simulated(Plane(tilt=30.0, fixed_to="body"), model, time, position, velocity)
    lets_go = 1.0 / (500.0 * 0.02 * math.sin(math.radians(30.0)) * math.cos(math.radians(30.0)))
    assert np.all(body[time < lets_go - 2e-3] == 0.0)
    assert np.all(body[time > lets_go + 5e-3, 0] < 0.0)  # away from the hand: the slope falls along +x


HELD = FlexibleBoxModel(BoxParameters(m=1.0, k1=1e5, k2=400.0, b1=1000.0, b2=10.0), NormalContact(500.0, 0.0))


@pytest.mark.parametrize("surface", [Plane(), Plane(tilt=40.0, turned=70.0), Plane(fixed_to="body")])
def test_a_tip_that_slips_meets_mu_times_the_load_against_its_motion(surface):
    turn = rotation(surface)
    time = np.arange(0.0, 2.0, 1e-3)
    way = np.array([0.6, 0.8, 0.0])
    flat = np.outer(0.05 * time, way) + np.array([0.0, 0.0, -0.01])
    position, velocity = flat @ turn.T, np.tile(0.05 * way, (len(time), 1)) @ turn.T
    force, _, _ = simulated(surface, HELD, time, position, velocity, mu=0.3)
    felt = force @ turn
    np.testing.assert_allclose(felt[:, 2], 5.0, rtol=1e-9)
    np.testing.assert_allclose(felt[-100:, :2], np.tile(-1.5 * way[:2], (100, 1)), atol=1e-3)
    stuck = time < 0.9 * (1.5 - 10.0 * 0.05) / 400.0 / 0.05  # k2 d + b2 u reaches the limit
    np.testing.assert_allclose(felt[stuck, :2], -np.outer(400.0 * 0.05 * time[stuck] + 0.5, way[:2]), rtol=2e-2)


def test_a_tip_that_has_slipped_and_stops_keeps_its_anchor_where_it_was_carried():
    time = np.arange(0.0, 4.0, 1e-3)
    x = 0.03 * np.minimum(time, 1.0) - 0.03 * np.clip(time - 2.0, 0.0, 0.1)
    position = np.column_stack([x, 0 * x, np.full_like(x, -0.01)])
    rate = np.where(time < 1.0, 0.03, np.where((time > 2.0) & (time < 2.1), -0.03, 0.0))
    force, _, _ = simulated(Plane(), HELD, time, position, np.column_stack([rate, 0 * x, 0 * x]), mu=0.2)
    at_stop, back = force[1900, 0], force[3900, 0]
    assert at_stop == pytest.approx(-1.0, abs=0.15)  # the damper lets the spring go a little beyond it
    assert back - at_stop == pytest.approx(400.0 * 0.003, rel=0.02)  # and back the spring gives way, without slip


def test_what_slips_is_limited_as_a_vector_and_not_axis_by_axis():
    time, position, velocity = strokes(4.0)
    force, _, _ = simulated(Plane(), HELD, time, position, velocity, mu=0.1)
    tangential, limit = np.hypot(force[:, 0], force[:, 1]), 0.1 * np.maximum(force[:, 2], 0.0)
    assert np.all(tangential <= limit + 1e-12)
    assert np.mean(np.isclose(tangential, limit, atol=1e-9) & (limit > 0.0)) > 0.1


@pytest.mark.parametrize(
    ("surface", "mu"),
    list(
        itertools.product(
            [Sphere(), Cylinder(turned=30.0), Saddle(fixed_to="body"), Sphere(fixed_to="body"), Plane(tilt=45.0)],
            [NEVER, 0.2],
        )
    ),
    ids=lambda value: value if isinstance(value, float) else f"{type(value).__name__}-{value.fixed_to}",
)
def test_nobody_gets_more_out_of_a_contact_than_was_put_in(surface, mu):
    """Springs alone, and friction: over any way the hand's work is at least what is in store."""
    time = np.arange(0.0, 6.0, 1e-3)
    model = FlexibleBoxModel(
        BoxParameters(m=0.5, k1=50.0, k2=300.0, b1=1.0, b2=0.5), NormalContact(600.0, 0.5), Friction.coulomb(0.05)
    )
    uv = np.column_stack([0.02 * np.sin(3.0 * time), 0.02 * np.sin(2.3 * time + 1.0)])
    on = surface.points(uv)
    n = np.array([locate(surface.packed(), tuple(x), (0.0, 0.0, 0.0))[1] for x in on])
    position = on - n * (0.004 + 0.003 * np.sin(5.0 * time))[:, None]
    velocity = np.gradient(position, time, axis=0)
    force, _, energy = simulated(surface, model, time, position, velocity, mu)
    work = np.concatenate([[0.0], np.cumsum(-0.5 * ((force[1:] + force[:-1]) * np.diff(position, axis=0)).sum(axis=1))])
    assert np.ptp(work) > 1e-3
    burnt = work - (energy - energy[0])
    assert np.diff(burnt).min() > -2e-6
    assert burnt.min() > -1e-5


def test_turning_with_a_round_surface_keeps_the_force_from_jumping():
    """A tip that glides over a ball: its force turns with the normal, its size along the normal stays."""
    time = np.arange(0.0, 3.0, 1e-3)
    uv = np.column_stack([0.05 * np.sin(2.0 * time), 0.0 * time])
    ball = Sphere()
    on = ball.points(uv)
    n = (on + np.array([0.0, 0.0, 0.06])) / 0.06
    position = on - 0.005 * n
    force, _, _ = simulated(ball, FlexibleBoxModel(), time, position, np.gradient(position, time, axis=0))
    np.testing.assert_allclose((force * n).sum(axis=1)[2:-2], 2.5, rtol=1e-3)
    own, turns = np.linalg.norm(np.diff(force[300:], axis=0), axis=1), 0.1 / 0.06 * 1e-3
    assert own.max() < 3.0 * turns * np.linalg.norm(force[300:], axis=1).max()
