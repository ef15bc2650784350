"""A hand that yields: its impedance, and the limit of the device."""

import numpy as np
import pytest
from scipy.signal import lsim

from mmt_drake.errors import BadInput
from mmt_drake.motion.yielding import HandImpedance, step_deviation

STEP = 1e-3


def deviations(hand, force):
    """(n, 6) before each tick's force (n, 3) acts."""
    own, forced = hand.matrices(STEP)
    found, deviation = [], np.zeros(6)
    for row in force:
        found.append(deviation.copy())
        step_deviation(deviation, row, hand.force_limit, own, forced)
    return np.array(found)


def test_it_answers_a_held_force_as_its_transfer_function_says():
    hand = HandImpedance(mass=1.5, damping=12.0, stiffness=250.0)
    force = np.random.default_rng(0).normal(0.0, 1.0, (2000, 3))
    found = deviations(hand, force)
    # lsim takes inputs as linear between samples; ten samples a tick hold them.
    time = np.arange(20_000) * STEP / 10
    held = np.repeat(force[:, 1], 10)
    _, expected, _ = lsim(([1.0], [1.5, 12.0, 250.0]), held, time, interp=False)
    np.testing.assert_allclose(found[:, 1], expected[::10], atol=1e-9)


def test_it_rests_where_spring_and_force_are_equal_and_stays_without_force():
    force = np.tile([0.0, 2.0, -3.0], (8000, 1))
    assert deviations(HandImpedance(stiffness=200.0), force)[-1, :3] == pytest.approx([0.0, 0.01, -0.015], abs=1e-6)
    assert np.all(deviations(HandImpedance(), 0.0 * force) == 0.0)


def test_no_force_above_the_devices_acts_whatever_its_direction():
    hand, direction = HandImpedance(force_limit=5.0), np.tile([0.6, 0.0, 0.8], (100, 1))
    strong, most = (deviations(hand, size * direction) for size in (50.0, 5.0))
    np.testing.assert_allclose(strong, most, rtol=1e-12)


@pytest.mark.parametrize("name", ["mass", "stiffness", "force_limit"])
def test_a_hand_without_meaning_is_refused(name):
    with pytest.raises(BadInput, match=f"hand: {name}"):
        HandImpedance(**{name: 0.0})
