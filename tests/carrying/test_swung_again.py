"""The operator's copy of a carried object swings as the object does, also where its centre is told late."""

import numpy as np
import pytest
from test_grasped_objects import C, M, P, path

from mmt_drake.estimation.carried import CARRIED, FREE, ON_TABLE
from mmt_drake.rendering import carried
from mmt_drake.rendering.updates import EnergyPermitting, renderer_rule

THETA = np.array([M, 0.0, P[1], 0.0, P[2], 0.2, P[3], P[4], 0.2, 0.005])
RULE = renderer_rule(EnergyPermitting(), 1e-3, 1)


def felt(told_at: float, believed: float, wrong: float = 0.0, top: float = 0.0, closed_at: float = 0.7):
    """(n, 3) force along `path`; the centre is told from a time on, and before that a wrong one, unless that is 0.

    That the object stands in the grip is told from 0.9 s on.
    """
    t = np.arange(0.0, 4.0, 1e-3)
    at, force = path(t), np.zeros((len(t), 3))
    out = np.zeros(carried.MEMORY + carried.MEMORY_SIZE)
    for k, now in enumerate(t):
        table = np.array([0.0, 0.0, -P[3] * at[k, 2]]) if at[k, 2] < 0.01 else np.zeros(3)
        centre = C if now >= told_at else wrong
        state = CARRIED if now > 1.2 else ON_TABLE if now > 0.9 else FREE
        load = np.array([state, M, centre, 0.05, 8.0 if now > min(closed_at + 0.4, 0.9) else 0.0])
        motion, grip = np.append(at[k] + [0.0, 0.0, top], np.zeros(3)), 8.0 if now > closed_at else 0.0
        given = motion, table, grip, 1.0, THETA, load, top, 0.0, believed
        carried.carried_force(out[carried.MEMORY :].copy(), now, 1e-3, *given, RULE, out)
        force[k] = out[:3]
    return t, force


def off(other, true, span):
    return np.linalg.norm((other - true)[span, :2]) / np.linalg.norm(true[span, :2])


def test_a_centre_that_is_told_late_is_made_up_for_and_one_believed_rightly_is_felt_at_once():
    t, known = felt(0.0, C)
    assert np.abs(known[t > 2.0, 0]).max() > 0.1  # it swings
    late = felt(2.8, carried.NO_SWING)[1]
    before, after = (t > 2.2) & (t < 2.8), t > 2.8 + 3.0 * carried.TAKE_UP_S
    assert off(late, known, before) > 0.3
    assert off(late, known, after) < 0.05
    assert off(felt(2.8, C)[1], known, t > 1.9) < 0.02
    assert off(felt(2.8, 0.9 * C)[1], known, before) < 0.5 * off(late, known, before)


def test_the_step_of_the_force_when_the_centre_is_told_fades_and_is_no_jump():
    t, late = felt(2.8, carried.NO_SWING)
    steps = np.abs(np.diff(late[t > 2.0, 0]))
    assert steps.max() < 0.1 * np.abs(late[t > 2.0, 0]).max()


def test_it_does_not_matter_how_high_its_top_stands():
    low, high = felt(2.0, 0.04)[1], felt(2.0, 0.04, top=-0.02)[1]
    np.testing.assert_allclose(low, high, atol=1e-9)


@pytest.mark.parametrize("wrong", [0.02, 0.2])
def test_a_wrong_centre_that_was_told_leaves_nothing_behind(wrong):
    t, known = felt(0.0, C)
    assert off(felt(2.8, C, wrong=wrong)[1], known, t > 3.5) < 0.05


def test_a_grip_that_was_closed_before_it_came_down_feels_what_it_lifts():
    t, usual = felt(0.0, C)
    early = felt(0.0, C, closed_at=-1.0)[1]
    assert usual[t > 2.0, 2].max() < -0.5 * M * 9.81
    np.testing.assert_allclose(early[t > 2.0], usual[t > 2.0], atol=1e-9)


def test_of_what_the_telerobot_carries_and_the_hand_never_took_hold_of_no_force_is_made():
    memory, out = np.zeros(carried.MEMORY_SIZE), np.zeros(carried.MEMORY + carried.MEMORY_SIZE)
    load, force = np.array([CARRIED, M, C, 0.05, 8.0]), np.array([0.0, 0.0, 5.0])
    for state, felt_at_all in ((CARRIED, False), (FREE, True)):
        given = np.zeros(6), force, 8.0, 1.0, THETA, np.append(state, load[1:]), 0.0, 1.0, C
        carried.carried_force(memory, 0.0, 1e-3, *given, RULE, out)
        assert (out[2] > 0.0) == felt_at_all and out[carried.CARRIES] == 0.0
