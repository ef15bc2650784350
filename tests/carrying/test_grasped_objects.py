"""An object that is gripped, lifted and put down, by both simulations."""

import numpy as np
import pytest

from mmt_drake.foreign import grasped as foreign
from mmt_drake.model import flexible_box as box
from mmt_drake.model import grasped_box as own
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.structure import Friction

M, C, MU = 0.3, 0.05, 0.6
P = np.array([M, 500.0, 30.0, 2000.0, 60.0, C, 0.05])
BOX = FlexibleBoxModel(
    parameters=BoxParameters(m=M, k1=0.0, k2=500.0, b1=0.0, b2=30.0),
    normal=NormalContact(k=2000.0, b=60.0),
    friction=Friction(Fs=0.2, Fd=0.2, v_d=0.005),
).kernel_vector()
FOREIGN = np.array([*P, 0.2, MU])


def smooth(t, start, end):
    s = np.clip((t - start) / (end - start), 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def path(t, sway=0.02):
    """Touch, lift by 60 mm, sway along x and y in the air, put down at another place, let go."""
    z = 0.01 - 0.013 * smooth(t, 0.2, 0.5) + 0.063 * smooth(t, 1.0, 1.8) - 0.063 * smooth(t, 4.0, 5.0)
    air = smooth(t, 1.8, 2.2) * (1.0 - smooth(t, 3.6, 4.0))
    x = sway * air * np.sin(8.0 * t) + 0.05 * smooth(t, 2.0, 3.6)
    y = 0.5 * sway * air * np.sin(5.0 * t)
    return np.stack([x, y, z + 0.02 * smooth(t, 5.6, 6.0)], axis=-1)


def run(plant, grip=8.0, opens=5.5, mu=MU, sway=0.02):
    t = np.arange(0.0, 6.0, 1e-3)
    at = path(t, sway)
    rate = (path(t + 1e-6, sway) - path(t - 1e-6, sway)) / 2e-6
    force, body, held, contact = np.zeros((len(t), 3)), np.zeros((len(t), 4)), np.zeros((len(t), 4)), np.zeros(len(t))
    state = np.zeros(box.STATE_SIZE if plant == "own" else foreign.ROD_SIZE)
    grasp, numbers = np.zeros(own.GRASP_SIZE), np.append(P, mu)
    foreign_p = FOREIGN.copy()
    foreign_p[8] = mu
    for k, now in enumerate(t):
        motion = np.concatenate([at[k], rate[k]])
        closed = grip if 0.7 <= now < opens else 0.0
        if plant == "own":
            if k == 0:
                box.begin(state, now, motion, 0.0, BOX)
            own.advance_grasped(state, grasp, now, motion, closed, motion[2] < 0.0, np.zeros(2), BOX, numbers)
            contact[k] = own.read_grasped(state, grasp, BOX, numbers, force[k], body[k], held[k])
        else:
            if k == 0:
                foreign.stand(state, now, motion, foreign_p)
            foreign.move(state, now, motion, closed, foreign_p)
            contact[k] = foreign.look(state, foreign_p, force[k], body[k], held[k])
    return t, force, body, held, contact


@pytest.mark.parametrize("plant", ["own", "foreign"])
def test_it_is_carried_by_its_weight_and_put_down_elsewhere(plant):
    t, force, body, held, contact = run(plant)
    high = (t > 1.9) & (t < 2.0)
    assert force[high].mean(0)[2] == pytest.approx(-M * 9.81, rel=0.02)
    assert held[(t > 2.0) & (t < 3.9), 3].min() > 0.05
    assert np.all(held[t > 5.2, 3] == 0.0)
    assert body[-1, 0] == pytest.approx(0.05, abs=0.01)
    assert abs(body[-1, 2]) < 1e-3
    assert contact[-1] == 0.0
    assert np.all(held[t > 5.51, 0] == own.NOTHING)


def test_two_simulations_that_share_nothing_agree():
    """Up to what is of the second order in the angle, which one of them leaves out: here 5 degrees."""
    _t, first, body1, held1, _ = run("own", sway=0.005)
    _, second, body2, held2, _ = run("foreign", sway=0.005)
    air = (held1[:, 3] > 1e-3) & (held2[:, 3] > 1e-3)
    apart = np.sqrt(np.mean((first[air] - second[air]) ** 2) / np.mean(second[air] ** 2))
    assert apart < 0.02
    assert abs(np.argmax(held1[:, 3] > 0.0) - np.argmax(held2[:, 3] > 0.0)) <= 5
    assert np.abs(body1[air, :2] - body2[air, :2]).max() < 2e-3


def test_place_and_velocity_carry_over_when_it_is_lifted_and_put_down():
    _, force, body, held, _ = run("own")
    up, down = np.flatnonzero(np.diff(held[:, 3] > 0.0))
    assert np.abs(force[up + 1] - force[up]).max() < 0.15  # as the tip stretches the grasp; at the end its damper stops
    for when in (up, down):
        assert np.abs(body[when + 1, :2] - body[when, :2] - 1e-3 * body[when, 2:]).max() < 2e-5
        assert np.abs(body[when + 1, 2:] - body[when, 2:]).max() < 0.02


@pytest.mark.parametrize("plant", ["own", "foreign"])
def test_a_grip_too_weak_slips_and_loses_it(plant):
    _, force, _, held, _ = run(plant, grip=4.0)
    assert held[:, 0].max() == own.LOST
    lost = int(np.argmax(held[:, 0] == own.LOST))
    assert held[lost - 20, 2] > 0.0
    assert np.all(force[lost + 200 : 3900] == 0.0)
    assert held[lost + 400, 3] == 0.0


@pytest.mark.parametrize("plant", ["own", "foreign"])
def test_an_open_grip_lifts_nothing(plant):
    _, force, _, held, _ = run(plant, grip=0.0)
    assert np.all(held == 0.0)
    assert np.all(force[2000:3900] == 0.0)
