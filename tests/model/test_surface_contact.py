"""A tip on a surface: against closed forms, and against the contact of an object that cannot move."""

import math

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.model import surface_contact
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.place_table import FIRST, PlaceTable, nodes_under, under
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording
from mmt_drake.replay import replayed
from mmt_drake.simulation import replay

TIME = np.arange(0.0, 2.0, 1e-3)


def sloped(angle, about="x"):
    """A plane that rises along x or y, as a map."""
    rise, at = math.tan(angle), (-0.2, -0.1, 0.0, 0.1, 0.2)
    x, y = np.meshgrid(at, at)
    return PlaceTable(at, at, tuple((rise * (x if about == "x" else y)).ravel().tolist()))


def force_on(model, position):
    """(n, 3) on a tip with these positions (n, 3)."""
    found = np.empty((len(position), 6))
    velocity = np.gradient(position, TIME[: len(position)], axis=0)
    surface_contact.replay(TIME[: len(position)], position, velocity, model.kernel_vector(), found)
    return found[:, :3]


def path(x=0.0, y=0.0, z=0.0):
    return np.column_stack([np.broadcast_to(values, TIME.shape) for values in (x, y, z)]).copy()


def test_on_a_level_surface_it_is_a_spring_and_a_damper_along_z():
    press = path(z=-0.003 + 0.002 * np.sin(9.0 * TIME), x=0.01 * TIME)
    force = force_on(SurfaceContact(k=400.0, b=7.0, height=0.001), press)
    expected = -400.0 * (press[:, 2] - 0.001) - 7.0 * np.gradient(press[:, 2], TIME)
    np.testing.assert_allclose(force[:, 2], expected, atol=1e-12)
    np.testing.assert_allclose(force[:, :2], 0.0, atol=1e-12)


def test_above_the_surface_there_is_no_force():
    assert not force_on(SurfaceContact(k=400.0, b=7.0, mu=0.3), path(z=1e-6 + 0.001 * TIME)).any()


@pytest.mark.parametrize("angle", [0.2, -0.5])
def test_a_slope_turns_the_force_by_its_angle(angle):
    model = SurfaceContact(k=400.0, surface=sloped(angle))
    force = force_on(model, path(x=0.02, z=0.02 * math.tan(angle) - 0.004))
    load = 400.0 * 0.004 * math.cos(angle)
    np.testing.assert_allclose(force[-1], load * np.array([-math.sin(angle), 0.0, math.cos(angle)]), rtol=1e-9)


@pytest.mark.parametrize("mu", [0.1, 0.4])
def test_a_tip_that_slips_is_held_back_by_mu_times_its_load(mu):
    force = force_on(SurfaceContact(k=400.0, b=1.0, mu=mu), path(x=0.02 * TIME, y=0.03 * TIME, z=-0.004))
    back = -mu * 1.6 / math.hypot(2.0, 3.0)
    np.testing.assert_allclose(force[-1], [2.0 * back, 3.0 * back, 1.6], rtol=1e-3)


def test_below_that_it_sticks_as_stiffly_as_it_presses():
    to_and_fro = path(x=2e-4 * np.sin(4.0 * TIME), z=-0.004)  # 0.08 N of mu N = 0.48 N
    force = force_on(SurfaceContact(k=400.0, mu=0.3), to_and_fro)
    np.testing.assert_allclose(force[:, 0], -400.0 * to_and_fro[:, 0], atol=1e-6)


def test_friction_on_a_slope_is_across_its_normal():
    model = SurfaceContact(k=400.0, mu=0.2, surface=sloped(0.3))
    x = 0.03 * TIME
    force = force_on(model, path(x=x, z=x * math.tan(0.3) - 0.005))[-1]
    n, along = np.array([-math.sin(0.3), 0.0, math.cos(0.3)]), np.array([math.cos(0.3), 0.0, math.sin(0.3)])
    assert force @ along == pytest.approx(-0.2 * force @ n, rel=1e-3)


def test_where_k_is_told_over_places_it_is_that_of_the_place_along_the_normal_and_across():
    at = (-0.1, -0.05, 0.0, 0.05, 0.1)
    k = PlaceTable(at, at, tuple(400.0 + 2000.0 * x for _ in at for x in at))
    to_and_fro = path(x=0.02 + 1e-4 * np.sin(4.0 * TIME), z=-0.004)
    force = force_on(SurfaceContact(k=50.0, mu=0.3, stiffness=k), to_and_fro)
    here = 400.0 + 2000.0 * to_and_fro[:, 0]
    np.testing.assert_allclose(force[:, 2], 0.004 * here, rtol=1e-12)
    np.testing.assert_allclose(force[:, 0], -here * (to_and_fro[:, 0] - 0.02), atol=1e-9)


def test_no_cycle_gives_energy_back():
    turn = 2.0 * np.pi * TIME
    model = SurfaceContact(k=400.0, mu=0.3, surface=sloped(0.2, "y"))
    circle = path(x=0.01 * np.cos(turn), y=0.01 * np.sin(turn), z=-0.006 + 0.001 * np.sin(2.0 * turn))
    work = -np.sum(force_on(model, circle)[1000:] * np.gradient(circle, axis=0)[1000:])
    assert work > 0.0


def test_along_the_normal_it_has_the_laws_of_a_kelvin_voigt_contact():
    effects = [{"name": "viscoelastic_relaxation", "parameters": {"k_maxwell": 200.0, "tau": 0.1}}]
    numbers = {"k": 400.0, "b": 7.0}
    press = -0.003 + 0.002 * np.sin(9.0 * TIME)
    model = parse_model({"structure": "surface_contact", "parameters": numbers, "effects": effects})
    spring = parse_model({"structure": "kelvin_voigt", "parameters": numbers, "effects": effects})
    assert isinstance(spring, KelvinVoigt)
    rate = np.gradient(press, TIME)
    one = replayed(spring, Recording(TIME, {"position": press, "velocity": rate}, "test"))["force"]
    np.testing.assert_allclose(force_on(model, path(z=press))[:, 2], one, rtol=1e-9)


def test_drake_and_the_compiled_loop_give_the_same_force():
    at = {"position_x": 0.01 * np.sin(5.0 * TIME), "position_y": 0.004 * TIME, "position_z": 0.002 * np.sin(7.0 * TIME)}
    rates = {name.replace("position", "velocity"): np.gradient(values, TIME) for name, values in at.items()}
    recording = Recording(TIME, {**at, **rates}, "test")
    model = SurfaceContact(k=400.0, b=5.0, mu=0.3, surface=sloped(0.2))
    one, other = replay(model, recording), replayed(model, recording)
    assert one.keys() == other.keys() == {"force_x", "force_y", "force_z"}
    for name, values in one.items():
        np.testing.assert_allclose(values, other[name], atol=1e-12)


def test_a_map_is_smooth_through_its_heights_and_level_beyond():
    x, y = (0.0, 0.01, 0.02, 0.03), (-0.01, 0.0, 0.01)
    heights = tuple(np.random.default_rng(0).normal(0.0, 1e-3, 12).tolist())
    packed = PlaceTable(x, y, heights).packed()
    assert under(packed, 0.02, 0.0).h == pytest.approx(heights[6], abs=1e-15)
    assert under(packed, 0.5, -0.01) == (pytest.approx(heights[3]), 0.0, 0.0) or under(packed, 0.5, -0.01).hx == 0.0
    a, b = under(packed, 0.0137, 0.0041), under(packed, 0.0137 + 1e-7, 0.0041)
    assert (b.h - a.h) / 1e-7 == pytest.approx(a.hx, rel=1e-4)


def test_what_each_height_does_is_the_derivative_of_the_map():
    x, y = (0.0, 0.01, 0.02, 0.03), (-0.01, 0.0, 0.01)
    heights = np.random.default_rng(1).normal(0.0, 1e-3, 12)
    packed = PlaceTable(x, y, tuple(heights.tolist())).packed()
    places = np.random.default_rng(2).uniform(-0.012, 0.035, (20, 2))
    node, value, slope_x, slope_y = (np.empty((20, 16)) for _ in range(4))
    nodes_under(packed, places[:, 0].copy(), places[:, 1].copy(), node, value, slope_x, slope_y)
    own = packed[FIRST:][node.astype(int)]
    for k, place in enumerate(places):
        expected = under(packed, *place)
        assert (value[k] @ own[k], slope_x[k] @ own[k], slope_y[k] @ own[k]) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("values", "line"),
    [
        (
            {"x": [0, 1, 3], "y": [0, 1], "height": [0] * 6},
            "surface_shape.x: found 3 places, expected two places or more",
        ),
        ({"x": [0], "y": [0, 1], "height": [0] * 2}, "surface_shape.x: found 1 places"),
        ({"x": [0, 1], "y": [0, 1], "height": [0] * 3}, "surface_shape.height: found 3 values, expected 4, a row of 2"),
        ({"x": [0, 1], "y": [0, 1], "height": [0] * 4, "deviation": [-1] * 4}, "deviation: found 4 deviations from -1"),
    ],
)
def test_a_surface_that_is_none_is_refused_in_one_line(values, line):
    values = {"deviation": [0.0] * len(values["height"]), **values}
    effect = {"name": "surface_shape", "parameters": values}
    with pytest.raises(BadInput) as error:
        parse_model({"structure": "surface_contact", "parameters": {"k": 1.0}, "effects": [effect]}, "m.yaml")
    assert line in str(error.value) and "\n" not in str(error.value)


def test_friction_of_a_sliding_body_has_no_place_in_it():
    effect = {"name": "dahl_friction", "parameters": {"Fc": 1.0, "sigma": 1.0}}
    with pytest.raises(BadInput, match="dahl_friction in a surface_contact, expected one of probe_slip"):
        parse_model({"structure": "surface_contact", "parameters": {"k": 1.0}, "effects": [effect]}, "m.yaml")
