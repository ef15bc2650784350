"""Time-domain passivity control: it tames a delayed loop that is unstable without, and leaves a passive one alone."""

import numpy as np
import pytest

from mmt_drake.errors import BadInput
from mmt_drake.motion.yielding import HandImpedance, step_deviation
from mmt_drake.rendering.finite import HOLD_S, LET_GO_S
from mmt_drake.rendering.passivity import (
    FORCE_MEMORY_SIZE,
    IN,
    MOTION_MEMORY_SIZE,
    PassivityControl,
    control_force,
    control_motion,
    drifted,
)

STEP = 1e-3
SPRING, DAMPER = 600.0, 20.0


class Loop:
    """A hand pushed 1 N for 0.1 s against a spring and damper at the end of a delayed network, along z.

    Attributes:
        hand, probe: (n,) positions [m].
        felt, pressed: (n,) forces on the hand and on the probe [N].
    """

    def __init__(self, delay, control, n=8000, hand=HandImpedance(mass=0.5, damping=5.0, stiffness=100.0)):  # noqa: B008
        own, forced = hand.matrices(STEP)
        deviation, motion = np.zeros(6), np.zeros(6)
        near, far = np.zeros(FORCE_MEMORY_SIZE), np.zeros(MOTION_MEMORY_SIZE)
        sent, back = [(np.zeros(6), np.zeros(3))] * (delay + 1), [(np.zeros(3), np.zeros(3))] * (delay + 1)
        share = -np.expm1(-STEP / control.yielding_lag) if control else 0.0
        self.hand, self.probe, self.felt, self.pressed = np.zeros((4, n))
        for k in range(n):
            commanded, near_energy = sent.pop(0)
            remote, far_energy = back.pop(0)
            motion[:] = commanded
            if control:
                drifted(far, commanded, motion)
            pressed = -SPRING * motion[:3] - DAMPER * motion[3:]
            felt = remote.copy()
            if control:
                control_force(near, deviation, remote, far_energy, STEP, control.most_damping, felt)
                back_rate = 0.0 if control.return_time is None else 1.0 / control.return_time
                control_motion(far, commanded, pressed, near_energy, STEP, control.most_yielding, share, back_rate)
            sent.append((deviation.copy(), near[IN : IN + 3].copy()))
            back.append((pressed.copy(), far[IN : IN + 3].copy()))
            self.hand[k], self.probe[k], self.felt[k], self.pressed[k] = deviation[2], motion[2], felt[2], pressed[2]
            push = felt + np.array([0.0, 0.0, -1.0 if k < 100 else 0.0])
            step_deviation(deviation, push, 100.0, own, forced)

    def made(self):
        """(n,) energy [J] that came out of the network at both ends less what went in."""
        into_hand = np.append(0.0, np.cumsum(self.felt[:-1] * np.diff(self.hand)))
        mean = 0.5 * (self.pressed[1:] + self.pressed[:-1])
        return into_hand + np.append(0.0, np.cumsum(-mean * np.diff(self.probe)))


@pytest.mark.parametrize("delay", [50, 400])
def test_a_delayed_loop_is_unstable_without_it_and_comes_to_rest_with_it(delay):
    n = 20 * delay + 4000
    free, tamed = Loop(delay, None, n), Loop(delay, PassivityControl(), n)
    assert np.abs(free.hand[-1000:]).max() > 0.5  # up to what the device gives
    assert np.abs(tamed.hand[-1000:]).max() < 0.02 * np.abs(tamed.hand).max()
    assert np.abs(tamed.hand).max() < 0.05


def test_the_network_makes_next_to_no_energy():
    free, tamed = Loop(200, None), Loop(200, PassivityControl())
    assert free.made().max() > 1.0
    # What comes out before the telerobot has taken up the motion that yields can only be burnt afterwards.
    assert tamed.made().max() < 0.003


def test_without_delay_it_is_hardly_felt():
    plain, controlled = Loop(0, None), Loop(0, PassivityControl())
    assert np.abs(controlled.hand - plain.hand).max() < 0.15 * np.abs(plain.hand).max()


@pytest.mark.parametrize(("return_rate", "left"), [(0.0, 1.0), (5.0, np.exp(-5.0))])
def test_a_drifted_telerobot_is_led_back_only_where_asked(return_rate, left):
    memory, commanded, motion = np.zeros(MOTION_MEMORY_SIZE), np.zeros(6), np.zeros(6)
    drift = []
    for k in range(1500):
        force = np.array([0.0, 0.0, 1.0 if k < 300 else 0.0])
        commanded[2] = -1e-4 * min(k, 300)  # pushed against the force, and nothing was put in at the other end
        control_motion(memory, commanded, force, np.zeros(3), STEP, 0.1, 0.1, return_rate)
        drifted(memory, commanded, motion)
        drift.append(motion[2] - commanded[2])
    assert drift[300] == pytest.approx(0.03, rel=0.1)  # as much as was commanded
    assert drift[1400] / drift[400] == pytest.approx(left, abs=0.003)


@pytest.mark.parametrize("name", ["most_damping", "most_yielding", "yielding_lag", "return_time"])
def test_strengths_without_meaning_are_refused(name):
    with pytest.raises(BadInput, match=f"passivity control: {name}"):
        PassivityControl(**{name: 0.0})


def test_what_comes_out_while_a_force_is_let_go_is_counted_as_it_is_felt():
    memory, force = np.zeros(FORCE_MEMORY_SIZE), np.zeros(3)
    z, felt = 0.0, [0.0]
    out = into = 0.0
    for k in range(200):
        lapse = 1 <= k < 140
        step = (-1e-4 if k < 40 else 1e-4) * lapse  # with the force while that is held, then against it
        z += step
        out, into = out + max(felt[-1] * step, 0.0), into + max(-felt[-1] * step, 0.0)
        remote = np.array([0.0, 0.0, np.nan if lapse else -1.0])
        control_force(memory, np.array([0.0, 0.0, z, 0.0, 0.0, 0.0]), remote, np.ones(3), STEP, 50.0, force)
        felt.append(force[2])
    assert memory[3 + 2] == pytest.approx(out, rel=1e-12) and out > 3e-3
    assert memory[IN + 2] == pytest.approx(into, rel=1e-12) and into > 1e-3


def test_a_tick_that_is_not_finite_holds_the_force_and_leaves_the_controller_at_work():
    memory, force = np.zeros(FORCE_MEMORY_SIZE), np.zeros(3)

    def tick(z, remote_z, energy=0.0):
        motion = np.array([0.0, 0.0, z, 0.0, 0.0, -0.1])
        control_force(memory, motion, np.array([0.0, 0.0, remote_z]), np.full(3, energy), STEP, 50.0, force)
        return force[2]

    tick(0.0, -1.0)
    held = tick(-1e-4, -1.0)
    for spoilt in ((np.nan, -1.0), (-2e-4, np.nan), (-2e-4, -1.0, np.inf)):
        assert tick(*spoilt) == held
        assert np.isfinite(memory).all()
    # It pulls the hand along with energy that nobody has put in: that is still seen, and burnt.
    assert tick(-4e-4, -1.0) > -1.0
    assert memory[3 + 2] == pytest.approx(4e-4)  # came out, over the ticks held as well


def test_a_force_that_nobody_measures_any_more_is_let_go_and_comes_back_with_the_next_that_is():
    memory, force = np.zeros(FORCE_MEMORY_SIZE), np.zeros(3)

    def tick(remote):
        control_force(memory, np.zeros(6), np.array([0.0, 0.0, remote]), np.ones(3), STEP, 50.0, force)
        return force[2]

    for _ in range(2):
        assert tick(-2.0) == -2.0
        forces = [tick(np.nan) for _ in range(round((HOLD_S + LET_GO_S) / STEP) + 5)]
        assert forces[: round(HOLD_S / STEP)] == pytest.approx([-2.0] * round(HOLD_S / STEP))
        assert np.all(np.diff(forces) >= 0.0) and np.diff(forces).max() < 1.05 * 2.0 * STEP / LET_GO_S
        assert forces[-1] == 0.0 and tick(-1.0) == -1.0


def test_a_telerobot_forgets_a_force_that_is_not_finite():
    memory = np.zeros(MOTION_MEMORY_SIZE)
    for k in range(300):
        force = np.array([0.0, 0.0, np.nan if k == 50 else 1.0])
        commanded = np.array([0.0, 0.0, np.nan if k == 100 else -1e-4 * k, 0.0, 0.0, -0.1])
        control_motion(memory, commanded, force, np.zeros(3), STEP, 0.1, 0.1, 0.0)
        assert np.isfinite(memory).all()
    assert abs(memory[15 + 2]) > 1e-3  # it yields all the same


@pytest.mark.parametrize("size", [FORCE_MEMORY_SIZE, MOTION_MEMORY_SIZE])
def test_both_ends_write_into_their_own_memory_alone(size):
    beyond = np.full(size + 64, np.nan)
    memory = beyond[:size]
    memory[:] = 0.0
    for k in range(40):
        motion, force = np.array([0.0, 0.0, -1e-4 * k, 0.0, 0.0, -0.1]), np.full(3, np.nan if k > 20 else 1.0)
        if size == FORCE_MEMORY_SIZE:
            control_force(memory, motion, force, np.zeros(3), STEP, 50.0, np.zeros(3))
        else:
            control_motion(memory, motion, force, np.zeros(3), STEP, 0.1, 0.1, 1.0)
    assert np.isfinite(memory).all() and np.isnan(beyond[size:]).all()


def test_a_lapse_is_counted_in_a_place_of_its_own():
    memory, force = np.zeros(FORCE_MEMORY_SIZE), np.zeros(3)
    for k in range(10):  # within the time for which a force is held
        control_force(memory, np.zeros(6), np.full(3, np.nan if k else 1.0), np.ones(3), STEP, 50.0, force)
        np.testing.assert_array_equal(force, 1.0)
    assert memory[-1] == pytest.approx(9 * STEP) and np.count_nonzero(memory) == 4


def test_what_the_telerobots_end_does_along_one_axis_it_does_along_any_other():
    ticks, drifts = np.random.default_rng(7).normal(size=(300, 3)) * [1e-3, 2.0, 1e-4], []
    for at in range(3):
        memory, commanded, energy, beyond = np.zeros(MOTION_MEMORY_SIZE), np.zeros(6), np.zeros(3), np.full(4, 9.0)
        drift = np.zeros((300, 3))
        for k, (x, f, e) in enumerate(ticks):
            commanded[at], beyond[:3], beyond[at], energy[at] = x, 0.0, f, energy[at] + abs(e)
            control_motion(memory, commanded, beyond[:3], energy, STEP, 0.1, 0.1, 2.0)
            motion = np.empty(6)
            drifted(memory, commanded, motion)
            drift[k] = motion[:3] - commanded[:3]
        drifts.append(np.roll(drift, -at, axis=1))
    np.testing.assert_array_equal(drifts[1:], [drifts[0]] * 2)
    assert np.abs(drifts[0][:, 0]).max() > 1e-5 and not drifts[0][:, 1:].any()
