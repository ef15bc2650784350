"""The law of a carried object: closed forms, energy, slip."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.model import carried as law

P = np.array([0.3, 500.0, 30.0, 2000.0, 60.0, 0.05, 0.05])


def held(p=P):
    """At rest in the air, the grasp stretched by the weight; the tip is where it then is."""
    state = np.zeros(law.CARRIED_SIZE)
    state[law.HEIGHT] = 0.05
    return state, np.array([0.0, 0.0, 0.05 + p[law.MASS] * law.GRAVITY / p[law.NORMAL_K]])


def test_at_rest_the_probe_carries_the_weight_and_nothing_moves():
    state, tip = held()
    for _ in range(500):
        law.carry(state, tip, tip, 1e-3, P)
    assert state[law.PULL : law.PULL + 3] == pytest.approx([0.0, 0.0, 0.3 * 9.81], abs=1e-9)
    assert state[law.HEIGHT] == pytest.approx(0.05, abs=1e-12)


def test_it_swings_at_the_frequency_of_a_rod_held_at_its_end():
    p = P.copy()
    p[[law.K, law.B, law.ZETA]] = 1e7, 1e3, 0.0  # a pivot that does not give
    state, tip = held(p)
    state[law.LATERAL + law.ANGLE] = 0.1
    state[law.LATERAL + law.RADIUS] = 0.05 * 0.1
    angles = []
    for _ in range(4000):
        law.carry(state, tip, tip, 1e-4, p)
        angles.append(state[law.LATERAL + law.ANGLE])
    falls = [k for k in range(1, 4000) if angles[k - 1] > 0.0 >= angles[k]]
    assert falls[0] * 1e-4 == pytest.approx(0.25 * 2.0 * math.pi / math.sqrt(3.0 * 9.81 / (4.0 * 0.05)), rel=2e-3)


def test_a_step_is_that_of_an_independent_integrator():
    """Lagrange's equations of the rod in p and theta, not in r and theta, by scipy."""
    m, k, b, _, _, c, zeta = P
    inertia = 4.0 / 3.0 * m * c * c
    beta = 2.0 * zeta * math.sqrt(0.75 * 9.81 / c) * inertia
    mass = np.array([[m, m * c], [m * c, inertia]])

    def rates(t, y):
        place, rate, angle, turning = y
        x, v = 0.02 * math.sin(9.0 * t), 0.18 * math.cos(9.0 * t)
        f = k * (x - place) + b * (v - rate)
        a, alpha = np.linalg.solve(mass, [f, -m * 9.81 * c * angle - beta * turning])
        return [rate, a, turning, alpha]

    truth = solve_ivp(rates, (0.0, 2.0), [0.0, 0.0, 0.0, 0.0], rtol=1e-9, atol=1e-12, t_eval=[2.0]).y[:, -1]
    state, tip = held()
    h = 2.5e-4
    for n in range(8000):
        x0, x1 = (0.02 * math.sin(9.0 * t) for t in (n * h, (n + 1) * h))
        law.carry(state, np.array([x0, 0.0, tip[2]]), np.array([x1, 0.0, tip[2]]), h, P)
    place, rate = law.gripped_at(state, 0, c)
    angle, turning = state[law.LATERAL + law.ANGLE], state[law.LATERAL + law.TURNING]
    assert [place, angle] == pytest.approx(truth[[0, 2]], abs=2e-5)
    assert [rate, turning] == pytest.approx(truth[[1, 3]], abs=2e-3)


@pytest.mark.parametrize("seed", range(20))
def test_no_numbers_and_no_step_make_energy(seed):
    random = np.random.default_rng(seed)
    p = np.exp(
        random.uniform(np.log([0.02, 5.0, 0.01, 10.0, 0.01, 0.005, 1e-3]), np.log([5, 5e3, 200, 5e3, 200, 0.2, 1]))
    )
    state, tip = held(p)
    energy, given = law.stored(state, tip, p), 0.0
    for _ in range(2000):
        after = tip + random.normal(0.0, 2e-4, 3)
        law.carry(state, tip, after, 1e-3, p)
        given += float(state[law.PULL : law.PULL + 3] @ (after - tip))
        tip = after
        assert law.stored(state, tip, p) - energy <= given + 1e-9


def test_a_grip_holds_at_most_its_friction_and_says_how_far_it_slips():
    state, tip = held()
    motion = np.concatenate([tip + np.array([0.004, 0.0, 0.002]), np.zeros(3)])
    before = math.sqrt(sum(law.pull_of(state, i, motion, P) ** 2 for i in range(3)))
    slipped = law.slip(state, motion, 4.0, P)
    after = math.sqrt(sum(law.pull_of(state, i, motion, P) ** 2 for i in range(3)))
    assert before > 4.0
    assert after == pytest.approx(4.0)
    assert slipped > 0.0
    assert law.slip(state, motion, 4.0 + 1e-9, P) == 0.0
