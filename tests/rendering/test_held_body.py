"""A body that friction holds is brought to where it is reported to be, as the policy allows, and only where it may."""

import numpy as np
import pytest
from test_updates import STEP, Rendered, moving, wandering

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MODE, POSITION
from mmt_drake.model.held_body import HELD_SIZE, NEAR, report
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.rendering.updates import AtOnce, Blended, EnergyPermitting, RateLimited

STICKY = FlexibleBoxModel(BoxParameters(m=2.0, k1=80.0, k2=400.0, b1=30.0, b2=60.0, Fc=4.0)).theta()
SLIPPERY = STICKY.copy()
SLIPPERY[[5, 8]] = 0.1
N, BETTER = 4000, 2000  # ticks; of these without the right friction
K2 = STICKY[2]


LEFT = NEAR * K2 * (1.0 + 1e-9)
"""Force of the distance [N] that is left alone."""


def strokes(n: int = N) -> np.ndarray:
    """(n, 6) in contact throughout: friction of 4 N lets go in the first stroke and never again, 0.1 N always does."""
    t, w, tau = np.arange(n) * STEP, 5.0, 0.3
    size, fading = 0.004 + 0.03 * np.exp(-t / tau), -0.03 / tau * np.exp(-t / tau)
    motion = np.zeros((n, 6))
    motion[:, 1], motion[:, 4] = size * np.sin(w * t), fading * np.sin(w * t) + size * w * np.cos(w * t)
    motion[:, 2] = -0.004
    return motion


def learned(n: int = N) -> np.ndarray:
    """(n, 10) too little friction at first."""
    theta = np.tile(STICKY, (n, 1))
    theta[:BETTER] = SLIPPERY
    return theta


def reports(rendered: Rendered, n: int = N, age: int = 30) -> np.ndarray:
    """(n, 6) where the body of another rendering is held, reported so many ticks later, every 50 ticks."""
    held = np.zeros((n, HELD_SIZE))
    for k in range(n):
        if k % 50 == 0 and k >= age:
            state = rendered.state[k - age]
            bodies = state[box.BODY : box.BODY + 2 * AXIS_SIZE].reshape(2, -1)
            held[k] = report(held[k - 1], bodies, (k - age) * STEP)
        elif k > 0:
            held[k] = held[k - 1]
    return held


@pytest.fixture(scope="module")
def right() -> Rendered:
    return Rendered(AtOnce(), strokes(), STICKY)


@pytest.fixture(scope="module")
def astray() -> Rendered:
    return Rendered(AtOnce(), strokes(), learned())


def test_where_nothing_is_reported_it_is_the_object_itself_bit_for_bit(astray):
    motion, p, found = strokes(), FlexibleBoxModel(BoxParameters()).kernel_vector(), np.empty((N, 3))
    theta = learned()
    state = np.zeros(box.STATE_SIZE)
    for k in range(N):
        model = FlexibleBoxModel(BoxParameters(*theta[k, :6]))
        p = model.kernel_vector(STEP * (1 + 1e-9)) if k in (0, BETTER + 1) else p
        (box.advance if k else box.begin)(state, k * STEP, motion[k], 1.0, p)
        if k == BETTER:  # what lies before an update is integrated with the model as it was
            p = model.kernel_vector(STEP * (1 + 1e-9))
        box.force_on_probe(state, p, found[k])
    np.testing.assert_array_equal(astray.force[:, :2], found[:, :2])


def test_friction_keeps_what_early_parameters_have_done_and_a_report_takes_it_off(right, astray):
    late = slice(BETTER + 600, None)
    assert abs(right.state[-1, box.BODY + AXIS_SIZE + POSITION]) > 1e-3
    off = astray.force[late, 1] - right.force[late, 1]
    assert np.abs(off).min() > 0.1 and np.ptp(off) < 1e-9
    brought = Rendered(AtOnce(), strokes(), learned(), held=reports(right))
    np.testing.assert_allclose(brought.force[late], right.force[late], atol=1e-12)


def test_the_jump_that_this_makes_is_put_out_and_the_body_stays_held(right, astray):
    brought = Rendered(AtOnce(), strokes(), learned(), held=reports(right))
    k = BETTER + int(np.argmax(np.abs(brought.jump[BETTER + 1 :, 1]))) + 1
    at = box.BODY + AXIS_SIZE
    moved = brought.state[k, at + POSITION] - astray.state[k, at + POSITION]
    moved += brought.state[k, at + ANCHOR] - astray.state[k, at + ANCHOR]
    assert abs(moved) > 1e-4
    assert brought.jump[k, 1] == pytest.approx(K2 * moved, rel=1e-9)
    assert brought.state[k, at + MODE] == 0.0


@pytest.mark.parametrize("spoilt", ["moved since", "touched since", "sliding", "not finite"])
def test_a_report_that_need_not_be_true_any_more_is_not_taken(astray, spoilt):
    sent = np.array([0.001, 0.002, 0.0, 0.003, 0.004, 0.0, 0.0])
    held, theta, contact = np.tile(sent, (N, 1)), learned(), np.ones(N)
    held[:3001] = 0.0
    if spoilt == "moved since":
        held[3001:, 5] = 1.9  # along y; with little friction, until 2 s, it moved in every stroke
    elif spoilt == "touched since":
        contact[3000] = 0.0
        held[3001:, [2, 5]] = 3.0
    elif spoilt == "not finite":
        held[3001:, [2, 5]], held[3001:, 0], held[3001:, 4] = 3.0, np.nan, np.inf
    else:
        theta, held[3001:, [2, 5]] = np.tile(SLIPPERY, (N, 1)), 9.0
    plain = Rendered(AtOnce(), strokes(), theta, contact=contact)
    brought = Rendered(AtOnce(), strokes(), theta, contact=contact, held=held)
    if spoilt == "sliding":
        sliding = brought.state[:, box.BODY + AXIS_SIZE + MODE] != 0.0
        assert sliding.any() and np.all(brought.jump[sliding, 1] == 0.0) and np.any(brought.jump[1:, 1] != 0.0)
    else:
        np.testing.assert_array_equal(brought.force, plain.force)


def test_rate_limited_parameters_and_reports_together_change_the_force_no_faster(right):
    rate, n = 20.0, 6000
    random = np.random.default_rng(1)
    held = np.repeat(random.normal(0.0, 0.005, (n // 50, HELD_SIZE)), 50, axis=0)
    held[:, [2, 5]] = np.arange(n)[:, np.newaxis] * STEP
    motion = moving(n)
    motion[:, [0, 1, 3, 4]] *= 0.1  # so little that friction holds the body at times
    found = Rendered(RateLimited(rate), motion, wandering(n), held=held)
    free = Rendered(RateLimited(rate), motion, wandering(n))
    assert np.linalg.norm(found.jump, axis=1).max() <= rate * STEP * (1 + 1e-9)
    assert np.abs(found.force - free.force).max() > 0.1
    brought = Rendered(RateLimited(rate), strokes(), learned(), held=reports(right))
    np.testing.assert_allclose(brought.force[-800:], right.force[-800:], atol=LEFT)


def test_blended_the_distance_fades_exponentially(right, astray):
    # One report, once both are held for good; the friction is taken up at once by then.
    held = reports(right)
    first = BETTER + 1000
    held[:first] = 0.0
    found = Rendered(Blended(0.02), strokes(), learned(), held=held)
    off = np.abs(found.force[first - 1 :, 1] - right.force[first - 1 :, 1])
    assert off[0] > 0.05
    fading = off[0] * np.exp(-np.arange(400) * STEP / 0.02)
    far = fading > LEFT
    np.testing.assert_allclose(off[:400][far], fading[far], rtol=1e-6)
    assert 0.9 * LEFT < off[399] <= LEFT and 50 < far.sum() < 200


@pytest.mark.parametrize("seed", range(3))
def test_as_energy_permits_no_report_gives_back_what_was_not_put_in(seed):
    n = 8000
    random = np.random.default_rng(seed)
    motion, theta = moving(n, seed), wandering(n, seed)
    theta[:, [5, 8]] *= 10.0  # friction that holds
    held = np.repeat(random.normal(0.0, 0.01, (n // 50, HELD_SIZE)), 50, axis=0)
    held[:, [2, 5]] = np.arange(n)[:, np.newaxis] * STEP
    contact = (motion[:, 2] < 0.0).astype(float)
    kept, free = (
        Rendered(way, motion, theta, contact=contact, held=held) for way in (EnergyPermitting(0.02), AtOnce())
    )
    plain = Rendered(EnergyPermitting(0.02), motion, theta, contact=contact)
    assert kept.balance().min() > -1e-7
    assert free.balance().min() < -1e-3
    assert np.abs(kept.force - plain.force).max() > 0.1  # reports were taken


def test_as_energy_permits_the_reported_position_is_reached_once_the_model_has_burnt_enough(right):
    found = Rendered(EnergyPermitting(rate=1e6), strokes(), learned(), held=reports(right))
    np.testing.assert_allclose(found.force[-800:], right.force[-800:], atol=1e-9)
