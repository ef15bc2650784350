"""Recorded motions on the table."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hand_recording import hand_motion

from mmt_drake.errors import BadInput
from mmt_drake.motion.placement import AS_RECORDED, HAND, PALPATION, Placement, automatic_placement, place
from mmt_drake.recording import Recording, load

RECORDINGS = Path(os.environ.get("MMT_RECORDINGS", Path(__file__).parents[2] / ".." / "shared" / "recordings"))
PANDA = [f"panda_comanipulation/symbol17_rec{i}" for i in (0, 3, 4)]
DVRK = [
    "dvrk_palpation/ContPalpRAL18T1",
    "dvrk_palpation/Hamlyn_Zone2_T1",
    "dvrk_palpation/zone1_wrist_fixed",
    "dvrk_palpation/zone3_adp_wrist_cdp",
]


def real(name):
    path = RECORDINGS / f"{name}.npz"
    if not path.exists():
        pytest.skip(f"no recordings in {RECORDINGS}")
    return load(path)


def recording(time, position, *, source="made up", **vectors):
    columns = {
        f"{name}_{axis}": value[:, i]
        for name, value in {"position": position, **vectors}.items()
        for i, axis in enumerate("xyz")
    }
    return Recording(np.asarray(time), columns, source)


def guided(n=3000):
    """A hand over a flat support at an odd place of an odd size, 12 s."""
    t = np.linspace(5.0, 17.0, n)
    return recording(t, np.column_stack([0.5 + 0.15 * np.sin(t), 0.05 * np.cos(1.3 * t), 0.3 + 5e-4 * np.sin(0.7 * t)]))


def touches(z):
    return int(np.sum((z[1:] < 0.0) & (z[:-1] >= 0.0)))


@pytest.mark.parametrize("name", PANDA + DVRK)
def test_real_hands_come_to_slide_press_and_lift_on_the_table(name):
    source = real(name)
    motion, placement = place(source), automatic_placement(source)
    assert placement.press_from == ("force" if name in DVRK else "position")
    z = motion.position[:, 2]
    assert motion.time[0] == 0.0
    assert motion.duration == pytest.approx(source.time[-1] - source.time[0], abs=0.005)
    assert -0.0101 <= z.min() <= -0.009
    assert z[0] == pytest.approx(0.01) and z[-1] == pytest.approx(0.01, abs=1e-4)
    assert touches(z) == placement.lifts + 1 >= 2
    assert np.mean(z < 0.0) > 0.7
    np.testing.assert_allclose(motion.position[:, :2].min(axis=0), -motion.position[:, :2].max(axis=0), atol=1e-12)
    assert np.abs(motion.position[:, :2]).max() < 0.1
    assert np.abs(motion.velocity).max() < 0.2
    assert np.abs(np.diff(motion.velocity, axis=0)).max() * placement.rate < 3.0  # m/s^2: no jerks from the seams


@pytest.mark.parametrize("name", PANDA)
def test_guided_hand_keeps_its_path(name):
    source = real(name)
    motion = place(source)
    time = source.time - source.time[0]
    for axis in (0, 1):
        raw = np.interp(motion.time, time, source.vector("position")[:, axis])
        np.testing.assert_allclose(np.ptp(motion.position[:, axis]), np.ptp(raw), rtol=1e-3)
        shifted = motion.position[:, axis] - raw
        assert np.std(shifted) < 5e-5  # smoothing moves it by less than 0.05 mm


@pytest.mark.parametrize("name", DVRK)
def test_probe_presses_deeper_where_it_felt_more_force(name):
    source = real(name)
    motion = place(source, replace(automatic_placement(source), lifts=None))
    force = np.interp(motion.time, source.time - source.time[0], source["force_z"])
    assert np.corrcoef(-motion.position[:, 2], force)[0, 1] > 0.85
    assert motion.position[:, 2].max() == pytest.approx(-0.001)


def test_highest_and_lowest_sample_become_the_ends_of_the_press():
    source = guided()
    motion = place(source, Placement(press=(0.002, 0.008), bandwidth=20.0))
    z = source["position_z"]
    expected = -0.002 - 0.006 * (z.max() - z) / np.ptp(z)
    inner = (motion.time > 1.0) & (motion.time < 11.0)
    np.testing.assert_allclose(
        motion.position[inner, 2], np.interp(motion.time, source.time - 5.0, expected)[inner], atol=1e-5
    )


def test_automatic_placement_shrinks_what_does_not_fit():
    motion = place(guided())
    assert np.ptp(motion.position[:, 0]) == pytest.approx(0.2, rel=0.01)
    assert np.ptp(motion.position[:, 1]) == pytest.approx(0.1 * 0.2 / 0.3, rel=0.02)


def test_lifts_come_at_even_intervals_and_to_their_height():
    motion = place(guided(), Placement(press=(0.001, 0.009), lifts=3, clearance=0.02, lift_time=1.0))
    z = motion.position[:, 2]
    for moment in (0.0, 3.0, 6.0, 9.0, 12.0):
        assert z[np.argmin(np.abs(motion.time - moment))] == pytest.approx(0.02)
    assert touches(z) == 4


def test_motion_on_the_table_is_taken_as_it_is():
    hand = hand_motion()
    source = recording(hand.time + 3.0, hand.position, velocity=hand.velocity)
    assert automatic_placement(source) == AS_RECORDED
    motion = place(source)
    np.testing.assert_allclose(motion.time, hand.time, atol=1e-12)
    np.testing.assert_array_equal(motion.position, hand.position)
    np.testing.assert_array_equal(motion.velocity, hand.velocity)


def test_probe_that_never_leaves_a_surface_of_unknown_height_is_not_on_the_table():
    t = np.linspace(0.0, 12.0, 600)
    z = 0.005 * np.sin(t) - 0.005
    z -= z.max()
    force = np.column_stack([0 * t, 0 * t, 1.0 + 0.5 * np.sin(3.0 * t)])
    source = recording(t, np.column_stack([0.01 * t, 0 * t, z]), force=force)
    touching = Recording(t, {**source.columns, "in_contact": np.ones(len(t))})
    assert automatic_placement(touching).press_from == "force"
    by_height = Recording(t, {**source.columns, "in_contact": (z < 0.0).astype(float)})
    assert automatic_placement(by_height) == AS_RECORDED


def test_missing_velocity_is_the_splines():
    hand = hand_motion()
    motion = place(recording(hand.time, hand.position))
    np.testing.assert_allclose(motion.velocity, hand.velocity, atol=1e-6)


def test_what_was_done_is_told():
    assert "press=(0.001, 0.01)" in place(guided()).notes[0]


@pytest.mark.parametrize(
    "change",
    [
        {"scale": 0.0},
        {"scale": float("nan")},
        {"centre": (0.0, float("inf"))},
        {"press": (0.01, 0.001)},
        {"press": (-0.001, 0.01)},
        {"press_from": "height"},
        {"lifts": -1},
        {"lift_time": 0.0},
        {"clearance": -0.01},
        {"bandwidth": 200.0},
        {"rate": 0.0},
    ],
)
def test_impossible_placements_are_bad_input(change):
    with pytest.raises(BadInput, match=next(iter(change))):
        Placement(**change)


def test_recordings_that_cannot_be_placed_are_bad_input():
    source = guided()
    with pytest.raises(BadInput, match=r"made up.*8 lifts"):
        place(source, replace(HAND, lifts=8))
    with pytest.raises(BadInput, match="force_z"):
        place(source, PALPATION)
    flat = Recording(source.time, {**source.columns, "position_z": np.full(len(source), 0.3)}, "flat")
    with pytest.raises(BadInput, match=r"flat.*does not vary"):
        place(flat, HAND)
    with pytest.raises(BadInput, match="position_x"):
        place(Recording(source.time, {}, "empty"))
    with pytest.raises(BadInput, match="1 samples"):
        place(recording(np.zeros(1), np.zeros((1, 3))))
    with pytest.raises(BadInput, match=r"0.02 s.*smooth"):
        place(recording(np.linspace(0.0, 0.02, 50), np.ones((50, 3))), HAND)
