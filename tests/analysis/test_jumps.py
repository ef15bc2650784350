"""Jumps of a force, and what a hand does, on recordings whose figures are known."""

import numpy as np
import pytest

from mmt_drake.analysis.hand import settling, tracking_error
from mmt_drake.analysis.jumps import jumps_beside, update_jumps
from mmt_drake.analysis.passivity import returnable
from mmt_drake.errors import BadInput

TIME = np.arange(5000) * 1e-3


def forces(recording_of, jump, **more):
    force = np.tile([0.0, 3.0, 4.0], (len(TIME), 1))
    return recording_of(TIME, force=force, update_jump=jump, in_contact=np.ones(len(TIME)), **more)


def along_z(values):
    return np.column_stack([0.0 * values, 0.0 * values, values])


def test_the_largest_update_is_found_and_large_ones_are_counted(recording_of):
    jump = np.zeros((len(TIME), 3))
    jump[1000], jump[2000], jump[3000] = [0.3, 0.0, 0.4], [0.0, 3.0, 0.0], [0.0, 0.0, 0.1]
    found = update_jumps(forces(recording_of, jump))
    assert (found.largest, found.largest_at, found.large) == (3.0, 2.0, 2)
    assert found.ratio == pytest.approx(0.6) and found.reference_rms == pytest.approx(5.0)


def test_a_jump_beside_another_run_is_what_that_run_does_not_have(recording_of):
    smooth = np.column_stack([np.sin(TIME), 5.0 + np.cos(TIME), 0.0 * TIME])
    jumping = smooth + 0.2 * (TIME >= 2.0)[:, None] * [0.0, 1.0, 0.0]
    reference, found = (
        recording_of(TIME, rendered_force=force, in_contact=np.ones(len(TIME))) for force in (smooth, jumping)
    )
    jumps = jumps_beside(found, reference, "rendered_force")
    assert jumps.largest == pytest.approx(0.2) and jumps.largest_at == 2.0
    assert jumps.reference_rms == pytest.approx(np.sqrt(np.mean(np.sum(smooth**2, axis=1))))
    assert jumps_beside(reference, reference, "rendered_force").largest == 0.0
    with pytest.raises(BadInput, match="another clock"):
        jumps_beside(recording_of(TIME + 1.0, rendered_force=smooth), reference, "rendered_force")


def test_energy_that_a_stiffer_spring_adds_is_missed_in_the_balance(recording_of):
    z = -0.01 * np.sin(np.pi * TIME / TIME[-1]) ** 2
    k = np.where(TIME < 2.5, 400.0, 600.0)
    columns = {"rendered_force": along_z(-k * z), "master_position": along_z(z)}
    made = returnable(recording_of(TIME, stored_energy=0.5 * k * z**2, **columns))
    # The spring, sampled, gives back a little too much as well.
    assert not made.holds and made.least == pytest.approx(-0.5 * 200.0 * 1e-4, rel=0.02)
    assert made.least_at >= 2.5
    columns["rendered_force"] = along_z(-400.0 * z - 5.0 * np.gradient(z, TIME))
    assert returnable(recording_of(TIME, stored_energy=200.0 * z**2, **columns)).holds


def test_a_hand_settles_where_its_motion_dies_out(recording_of):
    for decay, stable in ((2.0, True), (0.0, False)):
        size = np.where(TIME < 1.0, 1.0, np.exp(-decay * (TIME - 1.0)))
        velocity = np.column_stack([size * np.cos(50 * TIME), 0 * TIME, 0 * TIME])
        found = settling(recording_of(TIME, master_velocity=velocity, master_position=velocity / 50), 1.0, 4.99)
        assert found.stable is stable
        assert found.moving == pytest.approx(np.sqrt(0.5), rel=0.05)


def test_a_rest_outside_the_recording_is_refused(recording_of):
    still = np.zeros((len(TIME), 3))
    with pytest.raises(BadInput, match="within it"):
        settling(recording_of(TIME, master_velocity=still, master_position=still), 1.0, 9.0)


def test_the_telerobot_is_held_against_where_the_hand_was(recording_of):
    hand = np.column_stack([np.sin(TIME), 0 * TIME, 0 * TIME])
    late = np.vstack([np.repeat(hand[:1], 100, axis=0), hand[:-100]])
    recording = recording_of(TIME, master_position=hand, position=late + np.array([0.0, 0.003, 0.004]))
    assert tracking_error(recording, 0.1) == pytest.approx(0.005)
