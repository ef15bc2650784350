"""The compiled object against independent integration, closed forms and its own sign table."""

import numpy as np
import pytest

from mmt_drake.diagrams.proof.bench.accuracy import independent
from mmt_drake.model import body as one_body
from mmt_drake.model import flexible_box as box
from mmt_drake.model.flexible_box_replay import replay_axis as replay_one
from mmt_drake.model.laws import ActiveLaw, Slot, law
from mmt_drake.model.linear import transfer_function
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction

STEP = 1e-3
TERMS = ((0.03, 3.6, 0.0), (0.02, 0.7, 0.4), (0.005, 10.0, 1.1))


def probe(t):
    return sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in TERMS)


def probe_rate(t):
    return sum(a * 2 * np.pi * f * np.cos(2 * np.pi * f * t + p) for a, f, p in TERMS)


def slow(t):
    return 0.04 * np.sin(2 * np.pi * 0.25 * t) ** 3


def slow_rate(t):
    return 0.12 * np.sin(2 * np.pi * 0.25 * t) ** 2 * 2 * np.pi * 0.25 * np.cos(2 * np.pi * 0.25 * t)


def replay(model, times, position, velocity):
    force, body = np.empty((len(times), 3)), np.empty((len(times), 4))
    contact = np.full(len(times), box.CONTACT_BY_GEOMETRY)
    box.replay(times, position, velocity, contact, model.kernel_vector(), force, body)
    return force, body


def replay_axis(model, x, v, times, axis=1):
    position, velocity = np.zeros((2, len(times), 3))
    position[:, axis], velocity[:, axis] = x(times), v(times)
    position[:, 2] = -0.005
    return replay(model, times, position, velocity)


def rms(a):
    return np.sqrt(np.mean(np.square(a)))


OBJECTS = [
    BoxParameters(),
    BoxParameters(m=0.2, k1=300, k2=2000, b1=80, b2=80),
    BoxParameters(m=0.2, k1=300, k2=2000, b1=2, b2=2),
    BoxParameters(m=3, k1=0, k2=150, b1=2, b2=2),
]


@pytest.mark.parametrize("parameters", OBJECTS, ids=str)
def test_smooth_motion_agrees_with_adaptive_integration_to_1e_6(parameters):
    times = np.arange(0, 4, STEP)
    expected, _ = independent(probe(times), probe_rate(times), times, parameters, Friction())
    force, _ = replay_axis(FlexibleBoxModel(parameters), probe, probe_rate, times)
    assert rms(force[:, 1] - expected) < 1e-6 * rms(expected)


@pytest.mark.parametrize("motion", [(probe, probe_rate), (slow, slow_rate)], ids=["fast", "slow"])
def test_karnopp_friction_of_the_thesis_agrees_within_0_1_percent(motion):
    times = np.arange(0, 4, STEP)
    friction = Friction(Fs=0.1, Fd=0.05, v_d=0.005)
    expected, rate = independent(*(f(times) for f in motion), times, BoxParameters(), friction)
    stuck = rate == 0.0
    force, body = replay_axis(FlexibleBoxModel(friction=friction), *motion, times)
    assert rms(force[:, 1] - expected) < 1e-3 * rms(expected)
    if motion[0] is slow:
        assert stuck.mean() > 0.01  # the law is really exercised
        assert np.mean((body[:, 3] == 0.0) != stuck) < 0.005


@pytest.mark.parametrize("motion", [(probe, probe_rate), (slow, slow_rate)], ids=["fast", "slow"])
def test_two_newton_of_coulomb_friction_agrees_and_sticks_when_the_reference_sticks(motion):
    times = np.arange(0, 4, STEP)
    expected, rate = independent(*(f(times) for f in motion), times, BoxParameters(), Friction.coulomb(2.0))
    stuck = rate == 0.0
    force, body = replay_axis(FlexibleBoxModel(BoxParameters(Fc=2.0)), *motion, times)
    assert rms(force[:, 1] - expected) < 0.01 * 2.0
    changes = np.flatnonzero(np.diff(stuck.astype(int)))
    ours = np.flatnonzero(np.diff((body[:, 3] == 0.0).astype(int)))
    assert len(changes) == len(ours) >= 3
    assert np.abs(changes - ours).max() <= 1


def test_a_body_held_by_friction_does_not_creep():
    # 1 N of drive against 2 N of friction: a regularised sign function would creep here.
    times = np.arange(0, 60, STEP)
    model = FlexibleBoxModel(BoxParameters(Fc=2.0))
    force, body = replay_axis(model, lambda t: np.minimum(t, 1.0) * 0.002, lambda t: (t < 1.0) * 0.002, times)
    assert np.all(body[:, 1] == 0.0) and np.all(body[:, 3] == 0.0)
    np.testing.assert_allclose(force[2000:, 1], -500 * 0.002, rtol=1e-12)


def test_a_released_body_stops_after_the_distance_that_coulomb_friction_allows():
    # Off contact with b1 = 0: x = v0^2 m / (2 Fc), reached at v0 m / Fc.
    p = FlexibleBoxModel(BoxParameters(m=0.5, k1=0, b1=0, Fc=0.8)).kernel_vector()
    state = np.empty(box.STATE_SIZE)
    above = np.array([0.0, 0.0, 0.01, 0.0, 0.0, 0.0])
    box.begin(state, 0.0, above, box.CONTACT_BY_GEOMETRY, p)
    body = state[box.BODY : box.BODY + one_body.AXIS_SIZE]
    body[one_body.VELOCITY], body[one_body.MODE] = 0.4, 1.0
    for k in range(1, 1001):
        box.advance(state, k * STEP, above, box.CONTACT_BY_GEOMETRY, p)
        if k == 249:
            assert body[one_body.VELOCITY] > 0
        if k == 251:
            assert body[one_body.VELOCITY] == 0.0
    assert body[one_body.POSITION] == pytest.approx(0.4**2 * 0.5 / (2 * 0.8), rel=1e-9)


@pytest.mark.parametrize("frequency", [0.1, 1.0, 3.6, 10.0])
def test_steady_sine_follows_the_transfer_function(frequency):
    p = BoxParameters(k1=40.0)
    w = 2 * np.pi * frequency
    times = np.arange(0, 5 + 4 / frequency, STEP)
    force, _ = replay_axis(
        FlexibleBoxModel(p), lambda t: 0.01 * np.sin(w * t), lambda t: 0.01 * w * np.cos(w * t), times
    )
    last = times > times[-1] - 2 / frequency
    basis = np.column_stack([np.sin(w * times[last]), np.cos(w * times[last])])
    in_phase, quadrature = np.linalg.lstsq(basis, force[last, 1], rcond=None)[0]
    assert in_phase + 1j * quadrature == pytest.approx(-0.01 * transfer_function(p, 1j * w), rel=2e-6)


def test_signs_of_the_table_in_conventions():
    model = FlexibleBoxModel()
    times = np.arange(0, 0.5, STEP)
    for axis in (0, 1):
        force, _ = replay_axis(model, lambda t: 0.1 * t, lambda t: 0.1 + 0 * t, times, axis)
        assert force[-1, axis] < 0
        assert np.all(force[:, 1 - axis] == 0)
    assert force[-1, 2] == pytest.approx(500 * 0.005)


def test_normal_force_is_eq_8_and_zero_off_contact_and_may_pull_while_below():
    z = np.array([0.01, 0.001, -0.002, -0.004, -0.001, 0.003])
    vz = np.array([-9.0, -3.0, -2.0, 0.0, 3.0, 4.0])
    position, velocity = np.zeros((2, len(z), 3))
    position[:, 2], velocity[:, 2] = z, vz
    model = FlexibleBoxModel(normal=NormalContact(k=300, b=20))
    force, _ = replay(model, np.arange(len(z)) * STEP, position, velocity)
    np.testing.assert_allclose(force[:, 2], np.where(z < 0, -300 * z - 20 * vz, 0.0), rtol=1e-14)
    assert force[4, 2] < 0


def test_touch_starts_the_spring_unstretched_and_keeps_the_bodys_velocity():
    # The probe slides at 0.2 m/s through the surface halfway between two samples.
    p = FlexibleBoxModel().kernel_vector()
    state = np.empty(box.STATE_SIZE)
    velocity = [0.2, 0.0, -1.0]
    box.begin(state, 0.0, np.array([0.3, 0.0, 0.0005, *velocity]), box.CONTACT_BY_GEOMETRY, p)
    body = state[box.BODY : box.BODY + one_body.AXIS_SIZE]
    body[one_body.VELOCITY], body[one_body.MODE] = 0.2, 1.0
    box.advance(state, STEP, np.array([0.3002, 0.0, -0.0005, *velocity]), box.CONTACT_BY_GEOMETRY, p)
    force = np.empty(3)
    box.force_on_probe(state, p, force)
    # Half a step of braking by b1 alone, then half a step of v' = b2 (0.2 - v) - b1 v: the spring has hardly moved.
    at_touch = 0.2 * np.exp(-60 * 0.0005)
    assert body[one_body.VELOCITY] == pytest.approx(0.1 + (at_touch - 0.1) * np.exp(-120 * 0.0005), rel=1e-4)
    assert force[0] == pytest.approx(-60 * (0.2 - body[one_body.VELOCITY]), abs=500 * 0.2 * 0.0005 * 0.1)
    assert body[one_body.ANCHOR] == pytest.approx(0.3001 - 0.2 * (1 - np.exp(-60 * 0.0005)) / 60, rel=1e-6)


def test_result_does_not_depend_on_where_the_samples_fall():
    # The same motion, touch and release sampled at 1 kHz and at 10 kHz.
    def motion(t):
        position = np.column_stack([0.05 * np.sin(9 * t), 0.03 * np.cos(7 * t), 0.004 * np.cos(5 * t) + 0.0003])
        velocity = np.column_stack([0.45 * np.cos(9 * t), -0.21 * np.sin(7 * t), -0.02 * np.sin(5 * t)])
        return position, velocity

    results = []
    for step in (1e-3, 1e-4):
        t = np.arange(round(5 / step) + 1) * step
        _, body = replay(FlexibleBoxModel(friction=Friction(0.1, 0.05, 0.005)), t, *motion(t))
        results.append(body[:: round(1e-3 / step)])
    assert np.abs(results[0] - results[1])[:, :2].max() < 2e-7


@pytest.mark.parametrize("speed", [1e-10, 1e-8, 1e-6])
def test_a_body_under_a_creeping_probe_creeps_with_it_at_the_break_away_level(speed):
    """Karnopp's body slips by less than an atom's width at a time there, thousands of times a step."""
    friction = Friction(Fs=0.1, Fd=0.05, v_d=0.005)
    model = FlexibleBoxModel(friction=friction)
    p, state, force = model.kernel_vector(), np.zeros(box.STATE_SIZE), np.zeros(3)
    motion = np.array([0.0, 0.0, -0.005, 0.0, speed, 0.0])
    box.begin(state, 0.0, motion, 1.0, p)
    body = box.BODY + one_body.AXIS_SIZE
    held = friction.Fs - model.parameters.b2 * speed  # the rest is the damper's
    state[body + one_body.ANCHOR] = -held / model.parameters.k2 * (1 - 1e-12)
    for k in range(1, 2000):
        motion[1] = speed * k * STEP
        box.advance(state, k * STEP, motion, 1.0, p)
        box.force_on_probe(state, p, force)
        assert force[1] == pytest.approx(-friction.Fs, rel=5e-3)
    assert state[body + one_body.POSITION] == pytest.approx(speed * 2.0, rel=0.01, abs=1e-15)


@law(Slot.CONTACT)
def presses(at, q, p):
    return p[0] * at.load, 0.0, 0.0, 0.0


@law(Slot.SENSOR, remembers=True)
def reads_time(at, q, p):
    return at.force + p[0] * at.h + p[1] * q[0] + p[2] * at.t, q[0] + at.h, 0.0, 0.0


def test_laws_know_the_load_and_the_time_since_the_first_sample_and_the_last():
    laws = ActiveLaw(presses, (0.7,)), ActiveLaw(reads_time, (3.0, 5.0, 7.0))
    model = FlexibleBoxModel(BoxParameters(k1=0.0, Fc=1e3)).with_additions(laws=laws)  # Fc holds the body
    t = 2.0 + np.cumsum(np.random.default_rng(5).uniform(5e-4, 2e-3, 50))
    x, v, z, vz = 0.02 * np.sin(9 * t), 0.18 * np.cos(9 * t), -0.005 + 0.002 * np.cos(11 * t), -0.022 * np.sin(11 * t)
    force, _ = replay(model, t, np.column_stack([0 * x, x, z]), np.column_stack([0 * v, v, vz]))
    at_once, body = np.empty((1, 50)), np.empty((2, 1, 50))
    replay_one(t, x[None], v[None], z, vz, True, np.empty(0), model.kernel_vector(), at_once, *body)
    true = 500.0 * (x - x[0]) + 60.0 * v + 0.7 * np.maximum(-500.0 * z - 60.0 * vz, 0.0)
    past = np.append(0.0, (t - t[0])[:-1])
    expected = -true + 3.0 * np.diff(t, prepend=t[0]) + 5.0 * past + 7.0 * (t - t[0])
    np.testing.assert_allclose([force[:, 1], at_once[0]], [expected] * 2, rtol=1e-9)
