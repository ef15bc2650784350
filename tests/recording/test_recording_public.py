"""The public data sets, read directly: the right kind, clock, sign and unit, checked against what is known of them."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from mmt_drake.cli.convert import convert
from mmt_drake.errors import BadInput
from mmt_drake.recording import load, load_all, save

#: Kind of recording, files at least, recordings in each.
EXPECTED = {
    "bam_servo": ("driven_body", 8, 1),
    "emps": ("driven_body", 2, 1),
    "silverbox": ("driven_body", 2, 1),
    "falling_balls": ("driven_body", 7, 2),
    "mr_damper": ("single_axis", 6, 1),
    "silicone_tensile": ("single_axis", 1, 3),
    "davinci_tool": ("single_axis", 2, 1),
    "haptic_force_field": ("single_axis", 6, 90),
    "dvrk_palpation": ("contact", 4, 1),
    "panda_comanipulation": ("contact", 3, 1),
}


@pytest.mark.parametrize("folder", EXPECTED)
def test_every_file_of_a_data_set_is_recognised(folder: str, recordings: Path) -> None:
    kind, files, each = EXPECTED[folder]
    paths = [path for path in sorted((recordings / folder).glob("*.npz")) if not path.name.startswith("probing")]
    read = [recording for path in paths for recording in load_all(path)]
    assert len(paths) >= files and Counter(recording.kind for recording in read) == {kind: each * len(paths)}
    assert all(recording.notes for recording in read)


def test_emps_gives_the_published_parameters_by_least_squares(recordings: Path) -> None:
    train = load(recordings / "emps" / "train.npz")
    rate = train["output_rate"]
    signals = [np.gradient(rate, train.time), rate, np.sign(rate), np.ones(len(train)), train["input"]]
    filtered = np.column_stack([np.convolve(signal, np.ones(41) / 41, "same") for signal in signals])
    moving = np.abs(filtered[:, 2]) > 0.999  # one direction over the whole filter
    moving[:100] = moving[-100:] = False
    mass, viscous, coulomb, offset = np.linalg.lstsq(filtered[moving, :4], filtered[moving, 4], rcond=None)[0]
    # Janot, Gautier and Brunot: M 95.11 kg, Fv 203.5 N s/m, Fc 20.39 N, offset -3.16 N
    assert mass == pytest.approx(95.11, rel=0.03)
    assert viscous == pytest.approx(203.5, rel=0.06)
    assert coulomb == pytest.approx(20.39, rel=0.08)
    assert offset == pytest.approx(-3.16, abs=0.5)


def test_the_servo_s_input_is_a_voltage_below_its_supply_with_the_sign_of_the_error(recordings: Path) -> None:
    path = recordings / "bam_servo" / "xl330_kp100_sin_sin.npz"
    servo = load(path)
    with np.load(path) as data:
        error = data["qgoal_rad"] - data["q_rad"]
        assert (np.abs(servo["input"]) < data["vin_V"]).all()
    assert np.corrcoef(servo["input"], error)[0, 1] > 0.99
    assert servo.constants["mass_kg"] == 0.49


def test_balls_fall_with_gravity_at_first(recordings: Path) -> None:
    for drop in load_all(recordings / "falling_balls" / "golf_ball.npz"):
        early = drop.time < 1.2
        acceleration = 2.0 * np.polyfit(drop.time[early], drop["output"][early], 2)[0]
        assert acceleration == pytest.approx(-9.81, rel=0.06)
        assert (drop["input"] == 0.0).all() and drop.time[0] == 0.0


@pytest.mark.parametrize("folder", ["mr_damper", "davinci_tool", "silicone_tensile", "brfd_friction_damper"])
def test_what_is_moved_resists(folder: str, recordings: Path) -> None:
    for path in (recordings / folder).glob("*.npz"):
        for moved in load_all(path):
            assert np.mean(moved["force"] * moved["velocity"]) < 0.0


@pytest.mark.parametrize(("person", "late"), [("ND_person01", 0), ("D70_person01", 14)])
def test_the_field_on_a_reaching_hand_is_6_newton_seconds_a_metre_at_once_or_70_ms_late(
    person: str, late: int, recordings: Path
) -> None:
    reach = load_all(recordings / "haptic_force_field" / f"{person}.npz")[20]
    assert reach.source.endswith("trial 20 device")
    velocity, force = reach["velocity"][: len(reach) - late], reach["force"][late:]
    assert -(velocity @ force) / (velocity @ velocity) == pytest.approx(6.0, abs=0.05)


def test_palpation_presses_down_with_positive_force_and_friction_against_the_motion(recordings: Path) -> None:
    for path in (recordings / "dvrk_palpation").glob("[!p]*.npz"):
        probe = load(path)
        assert (probe["force_z"] > 0.0).all() and (probe["in_contact"] == 1.0).all()
        assert probe["position_z"].max() == 0.0
        assert sum(np.mean(probe[f"force_{a}"] * probe[f"velocity_{a}"]) for a in "xy") < 0.0


def test_the_hand_s_clock_is_inferred_from_position_and_velocity(recordings: Path) -> None:
    for path in (recordings / "panda_comanipulation").glob("*.npz"):
        hand = load(path)
        steps = np.diff(hand.time)
        assert np.ptp(steps) < 1e-12 and steps[0] == pytest.approx(1.49e-3, rel=0.02)
        rates = np.gradient(hand.vector("position"), hand.time, axis=0)
        assert np.corrcoef(rates.ravel(), hand.vector("velocity").ravel())[0, 1] > 0.9


def test_depth_probing_is_told_to_be_no_recording(recordings: Path) -> None:
    with pytest.raises(BadInput, match="728 sites by depth steps, without times"):
        load(recordings / "dvrk_palpation" / "probing_probingRAL2018_T1.npz")


def test_several_drops_become_several_files(recordings: Path, tmp_path: Path) -> None:
    source = recordings / "falling_balls" / "baseball.npz"
    with pytest.raises(BadInput, match=r"2 recordings .*drop 1.*drop 2.*expected one"):
        load(source)
    convert(str(source), str(tmp_path / "ball.csv"), {})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball_1.csv", "ball_2.csv"]
    np.testing.assert_array_equal(load(tmp_path / "ball_2.csv")["output"], load_all(source)[1]["output"])


@pytest.mark.parametrize("array", ["q_m", "force_N", "t_s"])
def test_a_public_file_that_is_damaged_is_refused(array: str, recordings: Path, tmp_path: Path) -> None:
    with np.load(recordings / "emps" / "train.npz") as data:
        arrays = {name: data[name] for name in data.files}
    arrays[array] = arrays[array].copy()
    arrays[array][17] = np.nan
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(BadInput, match=f"row 18, array '{array}'"):
        load(tmp_path / "a.npz")
    arrays[array] = arrays[array][:-5]
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(BadInput, match=rf"{array}: found shape \(24836,\)"):
        load(tmp_path / "a.npz")


def test_constants_stay_with_the_recording(recordings: Path, tmp_path: Path) -> None:
    damper = load(recordings / "mr_damper" / "10mm1Hz1A.npz")
    save(damper, tmp_path / "a.mcap")
    assert load(tmp_path / "a.mcap").constants == {"current_A": 1.0}
