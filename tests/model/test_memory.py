"""Laws with a memory of their own: their equations integrated by scipy, and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mmt_drake.model import flexible_box as box
from mmt_drake.model import kelvin_voigt
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MEMORY, POSITION
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.laws import ActiveLaw, At, Slot, law
from mmt_drake.model.memory import between
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model_files import with_effects

STEP, DEPTH = 1e-3, 0.005
M, K1, K2, B1, B2 = 0.7, 50.0, 400.0, 10.0, 15.0
NUMBERS = {
    "viscoelastic_relaxation": {"k_maxwell": 200.0, "tau": 0.15},
    "second_mode": {"m2": 0.2, "k": 60.0, "b": 0.4},
    "hysteresis": {"alpha": 150.0, "beta": 120.0, "gamma": 60.0, "n": 1.5},
    "dahl_friction": {"Fc": 0.6, "sigma": 300.0},
    "presliding_friction": {"sigma0": 400.0, "sigma1": 2.0, "Fs": 1.2, "v_s": 0.05},
}


def box_with(names, Fc, in_plane):
    model = FlexibleBoxModel(BoxParameters(m=M, k1=K1, k2=K2, b1=B1, b2=B2, Fc=Fc), in_plane=in_plane)
    return with_effects(model, [{"name": name, "parameters": NUMBERS[name]} for name in names], "here")


def replayed(model, t, way, rate):
    """Force (n, 2) and body (n, 4) under a probe at way (2, n), pressed into the surface."""
    position, velocity = np.full((len(t), 3), -DEPTH), np.zeros((len(t), 3))
    position[:, :2], velocity[:, :2] = way.T, rate.T
    force, body = np.empty((len(t), 3)), np.empty((len(t), 4))
    box.replay(t, position, velocity, np.ones(len(t)), model.kernel_vector(), force, body)
    return force[:, :2], body


def circle(t):
    """A probe that never stands still, nor does what it pulls along."""
    way, rate = (0.05 * np.cos(9 * t), 0.04 * np.sin(9 * t)), (-0.45 * np.sin(9 * t), 0.36 * np.cos(9 * t))
    return np.array(way), np.array(rate)


def by_scipy(model, t):
    """Force (n, 2): of the equation of motion in the plane, a body (x, v, and two numbers a law) an axis."""

    def acting(s, state):
        bodies, (way, rate), pushes, rates = state.reshape(2, 6), circle(s), [], []
        speed = max(np.hypot(*bodies[:, 1]), 1e-300)
        known = np.column_stack([bodies[:, 1], way - circle(0.0)[0] - bodies[:, 0], rate - bodies[:, 1], bodies[:, 2:]])
        for i, (x, v, *_) in enumerate(bodies):
            (_, d, d_rate, *q), beside = known[i], known[1 - i] * (model.in_plane == "vector")
            at, force = At(s, x, v, d, d_rate, 0.0, np.sign(v), 0.0, 0.0, 0.0, *beside[:3]), dict.fromkeys(Slot, 0.0)
            rates += [v, 0.0]
            for j, one in enumerate(model.additions.laws):
                memory = (*q[2 * j : 2 * j + 2], *beside[3 + 2 * j : 5 + 2 * j])
                value, *own, _ = one.law(at, memory, one.values)
                force[one.law.slot] += value
                rates += own
            pushes.append(K2 * d + B2 * d_rate + force[Slot.CONTACT])
            drive = pushes[-1] - K1 * x - B1 * v + force[Slot.BODY]
            rates[6 * i + 1] = (drive - model.value("Fc") * v / speed) / M
        return np.array(pushes), np.array(rates)

    settings = {"t_eval": t, "rtol": 1e-9, "atol": 1e-11, "max_step": 5e-3}
    states = solve_ivp(lambda s, state: acting(s, state)[1], (0.0, t[-1]), np.zeros(12), **settings).y
    return -np.array([acting(s, state)[0] for s, state in zip(t, states.T, strict=True)])


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
    t, model = STEP * np.arange(800), box_with(names, Fc, in_plane)
    force, expected = replayed(model, t, *circle(t))[0], by_scipy(model, t)
    np.testing.assert_allclose(force, expected, atol=1e-5 * np.abs(expected).max())


def maxwell_push(t, speed):
    """Push of a Maxwell branch whose one end moves at a speed since 0 [N]."""
    return 200.0 * speed * 0.15 * -np.expm1(-t / 0.15)


@pytest.mark.parametrize(("in_plane", "angle"), [("per_axis", np.pi / 2), ("vector", 0.0), ("vector", 0.9)])
def test_a_held_body_lets_go_when_spring_damper_and_maxwell_branch_pull_by_the_level(in_plane, angle):
    t, speed, Fc, along = STEP * np.arange(600), 0.02, 3.0, np.array([[np.cos(angle)], [np.sin(angle)]])
    model = box_with(("viscoelastic_relaxation",), Fc, in_plane)
    force, body = replayed(model, t, speed * t * along, np.full_like(t, speed) * along)
    end = brentq(lambda s: K2 * speed * s + B2 * speed + maxwell_push(s, speed) - Fc, 0.0, 1.0)
    held = t <= end
    assert 100 < held.sum() < 500 and not body[held].any() and body[~held, :2].any(axis=1).all()
    pull = K2 * speed * t + B2 * speed + maxwell_push(t, speed)
    np.testing.assert_allclose(force[held], -(pull * along).T[held], atol=1e-10)


def test_a_maxwell_branch_beside_a_prescribed_contact_relaxes_as_its_exponential():
    t, speed, force = 0.3 + STEP * np.arange(500), 0.1, np.empty(500)
    entry = {"name": "viscoelastic_relaxation", "parameters": NUMBERS["viscoelastic_relaxation"]}
    p = with_effects(KelvinVoigt(k=300.0, b=20.0), [entry], "here").kernel_vector()
    way = speed * (t - t[0])
    kelvin_voigt.replay(t, way, np.full(500, speed), np.zeros(500), p, force)
    np.testing.assert_allclose(force, -(300.0 * way + 20.0 * speed + maxwell_push(t - t[0], speed)), rtol=1e-9)


def remembered(at, q, p):
    return 0.0, 0.0, 0.0, 0.0


IN_CONTACT, ON_BODY = (law(slot, remembers=True)(remembered) for slot in (Slot.CONTACT, Slot.BODY))


@pytest.mark.parametrize(("laws", "left"), [((ON_BODY, IN_CONTACT), [1, 2, 0, 0]), ((IN_CONTACT, IN_CONTACT), [0] * 4)])
def test_a_touch_empties_the_memory_of_the_contact_and_no_other(laws, left):
    model = FlexibleBoxModel(BoxParameters(k1=0.0)).with_additions(laws=tuple(ActiveLaw(one, ()) for one in laws))
    p, state, motion = model.kernel_vector(), np.empty(box.STATE_SIZE), np.array([0.3, -0.2, 0.01, 0.0, 0.0, 0.0])
    box.begin(state, 0.0, motion, 0.0, p)
    bodies = state[box.BODY : box.NORMAL].reshape(2, AXIS_SIZE)
    bodies[:, MEMORY : MEMORY + 4], bodies[:, POSITION] = [1.0, 2.0, 3.0, 4.0], [0.04, 0.05]
    box.advance(state, STEP, motion, 1.0, p)
    assert bodies[:, MEMORY : MEMORY + 4].tolist() == [left, left]
    assert bodies[:, ANCHOR] == pytest.approx([0.26, -0.25]) and state[box.CONTACT] == 1.0


def test_a_memory_between_two_is_their_weighted_mean():
    assert between((1.0, 2.0, 3.0, 4.0), (2.0, 4.0, 1.0, 9.0), 0.4) == pytest.approx((1.4, 2.8, 2.2, 6.0))
