"""What is told of a carried object: mass, centre, swing, and that nothing tells them."""

import numpy as np
import pytest
from test_grasped_objects import BOX, MU, M, P, path

from mmt_drake.estimation import carried as told
from mmt_drake.model import flexible_box as box
from mmt_drake.model import grasped_box as own

THETA = np.array([0.31, 0.0, 510.0, 0.0, 29.0, 0.2, 2000.0, 60.0, 0.2, 0.005])


def followed(p=P, sway=0.01, theta=THETA, mu=MU, noise=1.0):
    """Outputs of the estimator along the motion of `path`, with noise of the sensors: (n, readout)."""
    random = np.random.default_rng(1)
    t = np.arange(0.0, 6.0, 1e-3)
    at, rate = path(t, sway), (path(t + 1e-6, sway) - path(t - 1e-6, sway)) / 2e-6
    state, grasp, numbers = np.zeros(box.STATE_SIZE), np.zeros(own.GRASP_SIZE), np.append(p, mu)
    memory, rods = np.zeros(told.MEMORY_SIZE), told.bank()
    out = np.zeros((len(t), sum(told.PORT_SIZES.values()) + told.MEMORY_SIZE))
    force, body, held = np.zeros(3), np.zeros(4), np.zeros((len(t), 4))
    box_p = BOX.copy()
    box_p[0] = p[0]
    for k, now in enumerate(t):
        motion = np.concatenate([at[k], rate[k]])
        grip = 8.0 if 0.7 <= now < 5.5 else 0.0
        if k == 0:
            box.begin(state, now, motion, 0.0, box_p)
        own.advance_grasped(state, grasp, now, motion, grip, motion[2] < 0.0, np.zeros(2), box_p, numbers)
        touches = own.read_grasped(state, grasp, box_p, numbers, force, body, held[k])
        sigma = noise * np.repeat([1e-5, 5e-4, 0.02], 3)
        measured = np.concatenate([motion, force]) + sigma * random.standard_normal(9)
        told.estimate_load(memory, measured, held[k], grip, touches, theta, 1e-3, rods, out[k])
        memory = out[k, -told.MEMORY_SIZE :].copy()
    return t, held, out


@pytest.mark.parametrize(("mass", "centre", "zeta"), [(0.3, 0.05, 0.05), (0.15, 0.03, 0.1), (0.5, 0.09, 0.02)])
def test_mass_centre_and_swing_are_found(mass, centre, zeta):
    p = P.copy()
    p[[0, 5, 6]] = mass, centre, zeta
    _t, held, out = followed(p, mu=2.0)
    lifted = int(np.argmax(held[:, 3] > 0.0))
    after = out[lifted + 2500]
    assert after[told.STATUS] == told.TELLS
    assert after[told.LOAD + 1] == pytest.approx(mass, rel=0.01)
    assert after[told.LOAD + 2] == pytest.approx(centre, rel=0.06)
    assert after[told.LOAD + 3] == pytest.approx(zeta, rel=0.5)
    assert 0.0 < after[told.DEVIATION] < 0.03 * mass  # the prior is wrong by up to a factor of two


@pytest.mark.parametrize("stiffness", [0.9, 1.0, 1.1])
def test_lift_and_landing_are_seen_within_30_ms_also_where_the_stiffness_of_the_grasp_is_told_wrong(stiffness):
    theta = THETA.copy()
    theta[6] *= stiffness
    _t, held, out = followed(theta=theta)
    truth, seen = held[:, 3] > 0.0, out[:, told.LOAD] == told.CARRIED
    assert np.abs(np.flatnonzero(np.diff(truth)) - np.flatnonzero(np.diff(seen))).max() <= 30
    assert np.all(out[seen, told.CONTACT] == 0.0)


def test_the_mass_begins_with_what_pushing_has_told():
    _t, _held, out = followed()
    lifted = int(np.argmax(out[:, told.LOAD] == told.CARRIED))
    assert out[lifted, told.LOAD + 1] == THETA[0]
    assert np.all(out[: lifted + 200, told.STATUS] == told.LEARNING)
    assert np.all(followed(theta=np.full(10, np.nan))[2][:, told.LOAD + 1] == 0.0)


def test_a_motion_that_does_not_swing_it_does_not_tell_its_centre():
    _, held, out = followed(sway=0.0)
    still = out[int(np.argmax(held[:, 3] > 0.0)) + 700]
    assert still[told.STATUS] == told.UNEXCITED
    assert still[told.LOAD + 2] == 0.0
    assert still[told.LOAD + 1] == pytest.approx(M, rel=0.01)


def test_a_slip_is_told_while_it_lasts_and_a_loss_after_it():
    _, held, out = followed(mu=0.36)
    slips = np.flatnonzero(np.diff(held[:, 2]) > 0.0) + 1
    assert len(slips) > 0
    carried = held[slips, 3] > 1e-3
    assert np.isin(out[slips[carried], told.LOAD], [told.SLIPS, told.GONE]).mean() > 0.95
    gone = held[:, 0] == own.LOST
    assert gone.any()
    assert np.all(out[gone, told.LOAD] == told.GONE)
