"""Laws with a memory of their own: held against scipy's integration of the same equations, and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mmt_drake.model import flexible_box as box
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MEMORY, POSITION
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.laws import ActiveLaw, Slot, law
from mmt_drake.model.memory import after_step, between, both, moved
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model_files import with_effects

STEP, DEPTH = 1e-3, 0.005
M, K1, K2, B1, B2 = 0.7, 50.0, 400.0, 10.0, 15.0
MAXWELL = {"k_maxwell": 200.0, "tau": 0.15}
NUMBERS = {
    "viscoelastic_relaxation": MAXWELL,
    "second_mode": {"m2": 0.2, "k": 60.0, "b": 0.4},
    "hysteresis": {"alpha": 150.0, "beta": 120.0, "gamma": 60.0, "n": 1.5},
    "dahl_friction": {"Fc": 0.6, "sigma": 300.0},
    "presliding_friction": {"sigma0": 400.0, "sigma1": 2.0, "Fs": 1.2, "v_s": 0.05},
}


def with_laws(model, *names):
    return with_effects(model, [{"name": name, "parameters": NUMBERS[name]} for name in names], "here")


def replayed(model, t, way, rate):
    """Force (n, 2) and body (n, 4) under a probe at way (2, n), pressed into the surface."""
    position, velocity = np.full((len(t), 3), -DEPTH), np.zeros((len(t), 3))
    position[:, :2], velocity[:, :2] = way.T, rate.T
    force, body = np.empty((len(t), 3)), np.empty((len(t), 4))
    box.replay(t, position, velocity, np.ones(len(t)), model.kernel_vector(), force, body)
    return force[:, :2], body


def acting(name, q, v, d, d_rate, Fc):
    """Pull on the body, push of the contact, and the rates of q."""
    p = NUMBERS[name]
    if name == "viscoelastic_relaxation":
        return 0.0, p["k_maxwell"] * (d - q[0]), ((d - q[0]) / p["tau"], 0.0)
    if name == "second_mode":  # q is the way of the mass beyond the body's, and its velocity
        pull = p["k"] * q[0] + p["b"] * (q[1] - v)
        return pull, 0.0, (q[1] - v, -pull / p["m2"])
    if name == "hysteresis":
        size = abs(q[0]) ** p["n"]
        z_rate = d_rate - p["beta"] * abs(d_rate) * size * np.sign(q[0]) - p["gamma"] * d_rate * size
        return 0.0, p["alpha"] * q[0], (z_rate, 0.0)
    if name == "dahl_friction":  # q is the force itself
        return -q[0], 0.0, (p["sigma"] * (v - abs(v) * q[0] / p["Fc"]), 0.0)
    level = Fc + (p["Fs"] - Fc) * np.exp(-((v / p["v_s"]) ** 2))
    z_rate = v - p["sigma0"] * abs(v) / level * q[0]
    return -(p["sigma0"] * q[0] + p["sigma1"] * z_rate), 0.0, (z_rate, 0.0)


def expected(names, t, probe, Fc):
    """Force (n, 2): the equation of motion in the plane, a body (x, v, q, q) an axis, by scipy."""

    def forces(s, state):
        bodies, (way, rate), slides = state.reshape(2, 6), probe(s), "presliding_friction" not in names
        speed, pushes, rates = np.hypot(*bodies[:, 1]), [], []
        for i, (x, v, *q) in enumerate(bodies):
            d, d_rate = way[i] - probe(0.0)[0][i] - x, rate[i] - v
            found = [acting(name, q[2 * j : 2 * j + 2], v, d, d_rate, Fc) for j, name in enumerate(names)]
            push = K2 * d + B2 * d_rate + sum(law[1] for law in found)
            brake = Fc * v / speed if slides and speed > 0.0 else 0.0
            drive = push - K1 * x - B1 * v + sum(law[0] for law in found) - brake
            pushes.append(push)
            rates += [v, drive / M, *found[0][2], *found[1][2]]
        return np.array(pushes), np.array(rates)

    settings = {"t_eval": t, "rtol": 1e-9, "atol": 1e-11, "max_step": 5e-3}
    states = solve_ivp(lambda s, state: forces(s, state)[1], (0.0, t[-1]), np.zeros(12), **settings).y
    return -np.array([forces(s, state)[0] for s, state in zip(t, states.T, strict=True)])


def circle(t):
    """A probe that never stands still, nor does what it pulls along."""
    way, rate = (0.05 * np.cos(9 * t), 0.04 * np.sin(9 * t)), (-0.45 * np.sin(9 * t), 0.36 * np.cos(9 * t))
    return np.array(way), np.array(rate)


@pytest.mark.parametrize(
    ("names", "Fc", "in_plane"),
    [
        (("viscoelastic_relaxation", "second_mode"), 0.0, "per_axis"),
        (("presliding_friction", "hysteresis"), 0.8, "per_axis"),
        (("viscoelastic_relaxation", "second_mode"), 0.3, "vector"),
        (("hysteresis", "dahl_friction"), 0.3, "vector"),
    ],
)
def test_laws_with_a_memory_follow_an_independent_integration(names, Fc, in_plane):
    t = STEP * np.arange(800)
    model = FlexibleBoxModel(BoxParameters(m=M, k1=K1, k2=K2, b1=B1, b2=B2, Fc=Fc), in_plane=in_plane)
    force, _ = replayed(with_laws(model, *names), t, *circle(t))
    wanted = expected(names, t, circle, Fc)
    np.testing.assert_allclose(force[1:], wanted[1:], atol=1e-5 * np.abs(wanted).max())


def maxwell_push(t, speed):
    """Push of a Maxwell branch whose one end moves at a speed since 0 [N]."""
    return MAXWELL["k_maxwell"] * speed * MAXWELL["tau"] * -np.expm1(-t / MAXWELL["tau"])


@pytest.mark.parametrize(("in_plane", "angle"), [("per_axis", np.pi / 2), ("vector", 0.0), ("vector", 0.9)])
def test_a_held_body_breaks_away_when_spring_damper_and_maxwell_branch_pull_by_the_level(in_plane, angle):
    t, speed, Fc, along = STEP * np.arange(600), 0.02, 3.0, np.array([[np.cos(angle)], [np.sin(angle)]])
    model = FlexibleBoxModel(BoxParameters(m=M, k1=K1, k2=K2, b1=B1, b2=B2, Fc=Fc), in_plane=in_plane)
    model = with_laws(model, "viscoelastic_relaxation")
    force, body = replayed(model, t, speed * t * along, np.full_like(t, speed) * along)
    held = K2 * speed * t + B2 * speed + maxwell_push(t, speed)
    end = brentq(lambda s: K2 * speed * s + B2 * speed + maxwell_push(s, speed) - Fc, 0.0, 1.0)
    stuck = t <= end
    assert 0.2 < end < 0.5 and not body[stuck].any() and body[~stuck, :2].any(axis=1).all()
    np.testing.assert_allclose(force[stuck], (-held * along).T[stuck], atol=1e-10)

    def slides(s, state):
        x, v, q = state
        stretch = speed * s - x
        pull = K2 * stretch + B2 * (speed - v) + MAXWELL["k_maxwell"] * (stretch - q)
        return v, (pull - K1 * x - B1 * v - Fc) / M, (stretch - q) / MAXWELL["tau"]

    start = 0.0, 0.0, speed * end - maxwell_push(end, speed) / MAXWELL["k_maxwell"]
    way = solve_ivp(slides, (end, t[-1]), start, t_eval=t[~stuck], rtol=1e-10, atol=1e-13).y[0]
    np.testing.assert_allclose(body[~stuck, :2], (way * along).T, atol=1e-7)


def test_a_maxwell_branch_beside_a_prescribed_contact_relaxes_as_its_exponential():
    t, speed, k, b = 0.3 + STEP * np.arange(500), 0.1, 300.0, 20.0
    contact, force = with_laws(KelvinVoigt(k=k, b=b), "viscoelastic_relaxation"), np.empty_like(t)
    way, rate = speed * (t - t[0]), np.full_like(t, speed)
    kelvin_voigt.replay(t, way, rate, np.zeros_like(t), contact.kernel_vector(), force)
    np.testing.assert_allclose(force, -(k * way + b * speed + maxwell_push(t - t[0], speed)), rtol=1e-9)


@law(Slot.CONTACT, remembers=True)
def in_contact(at, q, p):
    return 0.0, 0.0, 0.0, 0.0


@law(Slot.BODY, remembers=True)
def on_body(at, q, p):
    return 0.0, 0.0, 0.0, 0.0


@pytest.mark.parametrize(("laws", "left"), [((on_body, in_contact), [1, 2, 0, 0]), ((in_contact, in_contact), [0] * 4)])
def test_a_touch_empties_the_memory_of_the_contact_and_no_other(laws, left):
    model = FlexibleBoxModel(BoxParameters(k1=0.0)).with_additions(laws=tuple(ActiveLaw(one, ()) for one in laws))
    p, state, motion = model.kernel_vector(), np.empty(box.STATE_SIZE), np.array([0.3, -0.2, 0.01, 0.0, 0.0, 0.0])
    box.begin(state, 0.0, motion, 0.0, p)
    bodies = state[box.BODY :].reshape(2, AXIS_SIZE)
    bodies[:, MEMORY : MEMORY + 4], bodies[:, POSITION] = [1.0, 2.0, 3.0, 4.0], [0.04, 0.05]
    box.advance(state, STEP, motion, 1.0, p)
    assert bodies[:, MEMORY : MEMORY + 4].tolist() == [left, left]
    assert bodies[:, ANCHOR] == pytest.approx([0.26, -0.25]) and state[box.CONTACT] == 1.0


def test_the_arithmetic_of_a_memory_is_that_of_vectors():
    q, *rates = np.random.default_rng(0).normal(size=(5, 4))
    a, b, c, d = (tuple(rate) for rate in rates)
    np.testing.assert_allclose(both(a, b), rates[0] + rates[1], rtol=1e-14)
    np.testing.assert_allclose(moved(tuple(q), 0.3, a), q + 0.3 * rates[0], rtol=1e-14)
    np.testing.assert_allclose(between(a, b, 0.3), 0.7 * rates[0] + 0.3 * rates[1], rtol=1e-13)
    runge_kutta = q + 0.3 / 6.0 * (np.array([1.0, 2.0, 2.0, 1.0]) @ rates)
    np.testing.assert_allclose(after_step(tuple(q), 0.3, a, b, c, d), runge_kutta, rtol=1e-13)
