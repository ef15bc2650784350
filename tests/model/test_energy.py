"""The energy that the object holds in store: closed form, and the balance of a motion."""

import numpy as np
import pytest

from mmt_drake.model import flexible_box as box
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION, VELOCITY
from mmt_drake.model.energy import stored_energy
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model_files import with_effects

STEP = 1e-3


def test_it_is_that_of_two_springs_a_mass_and_the_normal_contact():
    model = FlexibleBoxModel(BoxParameters(m=2.0, k1=30.0, k2=400.0), NormalContact(k=700.0))
    state = np.zeros(box.STATE_SIZE)
    state[box.PROBE : box.PROBE + 3] = 0.02, -0.01, -0.004
    for i, (x, v, anchor) in enumerate([(0.01, 0.3, 0.002), (-0.02, 0.0, 0.0)]):
        body = box.BODY + AXIS_SIZE * i
        state[body + POSITION], state[body + VELOCITY], state[body + ANCHOR] = x, v, anchor
    alone = 0.5 * 2.0 * 0.3**2 + 0.5 * 30.0 * (0.01**2 + 0.02**2)
    assert stored_energy(state, model.kernel_vector()) == pytest.approx(alone, rel=1e-12)
    state[box.CONTACT] = 1.0
    contact = 0.5 * 400.0 * (0.008**2 + 0.01**2) + 0.5 * 700.0 * 0.004**2
    assert stored_energy(state, model.kernel_vector()) == pytest.approx(alone + contact, rel=1e-12)


def test_laws_beside_the_springs_hold_what_they_say_and_those_of_the_contact_nothing_off_it():
    effects = [
        {"name": "nonlinear_stiffness", "parameters": {"k3": 3e6}},
        {"name": "end_stop", "parameters": {"position": 0.004, "stiffness": 900.0}},
    ]
    bare = FlexibleBoxModel(BoxParameters(m=2.0, k1=30.0, k2=400.0), NormalContact(k=700.0))
    p, without = with_effects(bare, effects, "test").kernel_vector(), bare.kernel_vector()
    state = np.zeros(box.STATE_SIZE)
    state[box.PROBE : box.PROBE + 3] = 0.02, -0.01, -0.004
    state[box.BODY + POSITION] = 0.01
    wall = 0.5 * 900.0 * 0.006**2
    assert stored_energy(state, p) - stored_energy(state, without) == pytest.approx(wall, rel=1e-12)
    state[box.CONTACT] = 1.0
    cubic = 0.25 * 3e6 * (0.01**2 + 0.01**2) ** 2
    assert stored_energy(state, p) - stored_energy(state, without) == pytest.approx(wall + cubic, rel=1e-9)


@pytest.mark.parametrize("in_plane", ["vector", "per_axis"])
def test_behind_a_clearance_the_spring_holds_what_is_stretched_beyond_it(in_plane):
    spring = BoxParameters(m=2.0, k2=400.0)
    model = FlexibleBoxModel(spring, NormalContact(k=0.0), in_plane=in_plane).with_additions(gap=0.004)
    state = np.zeros(box.STATE_SIZE)
    state[box.CONTACT], state[box.PROBE : box.PROBE + 2] = 1.0, (0.006, -0.008)
    beyond = (0.010 - 0.002) ** 2 if in_plane == "vector" else 0.004**2 + 0.006**2
    assert stored_energy(state, model.kernel_vector()) == pytest.approx(0.5 * 400.0 * beyond, rel=1e-12)
    state[box.PROBE : box.PROBE + 2] = 0.0012, -0.0016
    assert stored_energy(state, model.kernel_vector()) == 0.0


@pytest.mark.parametrize("gap", [0.0, 0.004])
@pytest.mark.parametrize(("b1", "b2", "normal_b"), [(0.0, 0.0, 0.0), (5.0, 20.0, 30.0)])
def test_what_the_probe_puts_in_is_stored_or_burnt(b1, b2, normal_b, gap):
    springs = BoxParameters(m=0.5, k1=50.0, k2=800.0, b1=b1, b2=b2)
    model = FlexibleBoxModel(springs, NormalContact(500.0, normal_b)).with_additions(gap=gap)
    p, state, force = model.kernel_vector(), np.zeros(box.STATE_SIZE), np.zeros(3)
    given, stored, highest = [0.0], [], 0.0
    before = None
    for k in range(3000):
        t = k * STEP
        motion = np.array([0.01 * np.sin(9 * t), 0.0, -0.005 + 0.002 * np.sin(4 * t), 0.09 * np.cos(9 * t), 0.0, 0.0])
        motion[5] = 0.008 * np.cos(4 * t)
        if k == 0:
            box.begin(state, t, motion, 1.0, p)
        else:
            box.advance(state, t, motion, 1.0, p)
        box.force_on_probe(state, p, force)
        if before is not None:
            given.append(given[-1] - 0.5 * (force + before[1]) @ (motion[:3] - before[0]))
        before = motion[:3].copy(), force.copy()
        stored.append(stored_energy(state, p))
        highest = max(highest, stored[-1])
    burnt = np.array(given) - (np.array(stored) - stored[0])
    if b1 == b2 == normal_b == 0.0:
        assert np.abs(burnt).max() < 1e-4 * highest
    else:
        assert np.diff(burnt).min() > -1e-6 * highest and burnt[-1] > highest
