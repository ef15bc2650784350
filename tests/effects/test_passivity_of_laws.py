"""Passivity as a function of the values: each law by itself under random motion, and motions that draw energy."""

from functools import partial

import numpy as np
import pytest
from responses import MODELS, SOME

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.laws import At, Slot

STEP = 1e-3
FINE = 4  # Runge-Kutta steps within one
BOX = MODELS["flexible_box"]
FELT = (Slot.BODY, Slot.CONTACT, Slot.FRICTION)
LAWS = [n for n, e in LIBRARY.items() if e.law is not None and e.passive and e.law.slot in FELT]


def random_motion(seed, seconds=1.5):
    """Of up to 0.04 m and 8 Hz, from rest: time -> position, velocity."""
    random = np.random.default_rng(seed)
    w = 2.0 * np.pi * random.uniform(0.3, 8.0, 5)
    a, phase = random.uniform(0.2, 1.0, 5) * 0.04 / 5, random.uniform(0.0, 2.0 * np.pi, 5)
    before = np.sum(a * np.sin(phase))

    def motion(t):
        soft, soft_rate = (1.0, 0.0) if t > 0.1 else (t * t * (0.3 - 2.0 * t) * 1e3, 6e3 * t * (0.1 - t))
        x = np.sum(a * np.sin(w * t + phase)) - before
        return soft * x, soft_rate * x + soft * np.sum(a * w * np.cos(w * t + phase))

    return motion, seconds


def drawn(name, seed):
    """Values within a factor of five of some, or None where they do not go together."""
    random, effect = np.random.default_rng((seed, 7)), LIBRARY[name]
    values = {
        symbol: value if symbol in ("side", "p") else value * float(np.exp(random.uniform(-1.6, 1.6)))
        for symbol, value in SOME[name].items()
    }
    try:
        return effect.checked(values, BOX, "test")
    except BadInput:
        return None


def work_on(name, values, motion, seconds, model=BOX):
    """(n,) energy put into a law by a motion of what it acts on [J], and (n,) what it says that it holds."""
    effect = LIBRARY[name]
    law = effect.law
    p = tuple(values.values()) + tuple(model.value(symbol) for symbol in effect.uses)
    p += (0.0,) * (6 - len(p))

    def at(t):
        x, v = motion(t)
        return At(t, x, v, x, v, 3.0, float(np.sign(v)), 0.0, 0.0, 0.0)

    def rates(t, q):
        here = at(t)
        force, second, third, _ = law(here, (q[0], q[1], 0.0, 0.0), p)
        if law.slot == Slot.FRICTION:
            return np.array([0.0, 0.0, force * abs(here.v)])
        return np.array([second, third, (force if law.slot == Slot.CONTACT else -force) * here.v])

    state, h = np.zeros(3), STEP / FINE
    work, held = [0.0], [0.0]
    for k in range(round(seconds / STEP)):
        for i in range(FINE):
            t = k * STEP + i * h
            a = rates(t, state)
            b = rates(t + 0.5 * h, state + 0.5 * h * a)
            c = rates(t + 0.5 * h, state + 0.5 * h * b)
            d = rates(t + h, state + h * c)
            state = state + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        work.append(state[2])
        held.append(0.0 if law.stored is None else law.stored(at((k + 1) * STEP), (state[0], state[1], 0.0, 0.0), p)[0])
    return np.array(work), np.array(held)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", LAWS)
def test_a_law_that_says_so_gives_no_more_than_it_holds_and_holds_no_more_than_was_put_in(name, seed):
    values = drawn(name, seed)
    if values is None or not LIBRARY[name].passive.holds(BOX, values):
        return
    work, held = work_on(name, values, *random_motion(seed))
    least = 1e-6 + 1e-5 * np.abs(work).max()
    assert held.min() >= 0.0
    assert (work - held).min() > -least  # nothing came from nowhere
    assert np.diff(work - held).min() > -least  # and what was burnt stays so


def slow(size, period):
    """To a size and back, again and again."""
    w = 2.0 * np.pi / period
    return lambda t: (0.5 * size * (1.0 - np.cos(w * t)), 0.5 * size * w * np.sin(w * t))


def creep_and_dash(t):
    """Slowly for 0.5 s, which winds bristles up to what holds them, then at 1 m/s."""
    return (0.01 * t, 0.01) if t < 0.5 else (0.005 + (t - 0.5), 1.0)


@pytest.mark.parametrize(
    ("name", "values", "motion", "seconds"),
    [
        ("nonlinear_stiffness", {"k3": -1e5}, slow(0.04, 1.0), 0.5),
        ("presliding_friction", {"sigma0": 2000.0, "sigma1": 150.0, "Fs": 2.0, "v_s": 0.05}, creep_and_dash, 0.501),
        ("stiffness_drift", {"rate": 0.5}, slow(0.04, 1.0), 1.0),
        ("constant_force", {"F": 1.0}, slow(0.04, 1.0), 0.5),
        ("torque_ripple", {"amplitude": 1.0, "period": 0.02, "phase": 0.5}, slow(0.04, 1.0), 0.5),
    ],
)
def test_of_values_that_are_not_passive_some_motion_draws_energy(name, values, motion, seconds):
    effect = LIBRARY[name]
    checked = effect.checked(values, BOX, "test")
    assert effect.passive is None or not effect.passive.holds(BOX, checked)
    work, _ = work_on(name, checked, motion, seconds)
    assert work.min() < -1e-3


def test_a_body_that_gains_mass_at_speed_gains_energy_and_one_that_loses_it_none():
    holds = partial(LIBRARY["mass_change"].passive.holds, BOX)
    assert holds({"time": 1.0, "dm": -0.2}) and not holds({"time": 1.0, "dm": 0.2})


def test_the_condition_of_bristles_is_what_the_damper_to_the_world_takes():
    holds = partial(LIBRARY["presliding_friction"].passive.holds, BOX)  # b1 = 5, Fc = 0.3
    assert holds({"sigma1": 5.0, "Fs": 0.6}) and not holds({"sigma1": 5.1, "Fs": 0.6})
    assert holds({"sigma1": 5.0, "Fs": 0.15}) and not holds({"sigma1": 5.1, "Fs": 0.15})
    assert holds({"sigma1": 1e3, "Fs": 0.3})


def test_everything_within_its_bounds_is_passive_where_nothing_more_is_asked():
    assert {name for name, effect in LIBRARY.items() if effect.passive and effect.passive.where} == {
        *("nonlinear_stiffness", "normal_nonlinear_stiffness", "hysteresis", "normal_hysteresis"),
        *("presliding_friction", "mass_change"),
    }
