"""What the check before a diagnosis says of clean recordings, of spoilt ones, and of real ones."""

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_samples import FORCE_NOISE, MODEL, NORMAL_B, NORMAL_K, Strokes, contact_recording, driven_recording
from trial_samples import changed, cut, late

from mmt_drake.diagnosis.checks.alignment import normal_fit
from mmt_drake.diagnosis.checks.preflight import preflight
from mmt_drake.diagnosis.checks.sensors import clipping, coarseness, freezing, spikes
from mmt_drake.diagnosis.signals.smoother import smooth
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel, Gravity
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import load_model
from mmt_drake.recording import Recording, load, load_all

FORCES = ("force_x", "force_y", "force_z")


@pytest.fixture(scope="module")
def examples() -> Path:
    folder = Path(os.environ.get("MMT_EXAMPLES", Path(__file__).resolve().parents[3] / "shared" / "examples"))
    if not folder.is_dir():
        pytest.skip(f"no example recordings at {folder} (MMT_EXAMPLES names the folder)")
    return folder


def codes(result, *severities):
    return {finding.code for finding in result.findings if finding.severity in severities}


def finding(result, code):
    return next(found for found in result.findings if found.code == code)


def test_a_clean_recording_has_nothing_against_it(strokes):
    result = preflight(strokes, MODEL)
    assert result.reason is None and not codes(result, "warn", "refuse")
    assert result.outputs == (1,)
    assert {"clock", "contact", "excitation", "bias", "noise", "offset"} == codes(result, "note")
    contact = finding(result, "contact").figures
    assert contact["seconds"] == pytest.approx(16.0, abs=0.1) and contact["touches"] == 2
    moved = finding(result, "excitation").figures
    t = strokes.time[strokes["in_contact"] > 0]
    rate = Strokes().y(t, 1)
    assert moved["speed"] == pytest.approx(np.sqrt(np.mean(rate**2)), rel=0.02)
    assert moved["amplitude"] == pytest.approx(0.5 * np.ptp(Strokes().y(t)), rel=0.02)
    assert moved["reversals"] == pytest.approx(np.count_nonzero(np.diff(np.sign(rate))), abs=6)


HIDDEN = {
    "bias": lambda clean: changed(clean, force_y=clean["force_y"] + 0.3),
    "drift": lambda clean: changed(clean, force_y=clean["force_y"] + 0.02 * clean.time),
    "hum": lambda clean: changed(clean, force_y=clean["force_y"] + 0.3 * np.sin(2 * np.pi * 7 * clean.time)),
    "clipped": lambda clean: changed(clean, force_y=np.clip(clean["force_y"], -2.0, 2.0)),
    "no velocity": lambda clean: contact_recording(velocity=False, flag=False),
    "no noise": lambda clean: contact_recording(noise=0.0),
    "500 Hz": lambda clean: contact_recording(rate=500.0),
    "uneven": lambda clean: contact_recording(time=np.cumsum(np.random.default_rng(1).uniform(0.7e-3, 1.3e-3, 20_000))),
    "short": lambda clean: contact_recording(seconds=7.0),
}


@pytest.mark.parametrize("which", HIDDEN)
def test_what_a_diagnosis_is_for_is_not_refused(strokes, which):
    result = preflight(HIDDEN[which](strokes), MODEL)
    assert result.reason is None and result.outputs == (1,)


def test_both_axes_count_where_both_move(strokes):
    crossed = changed(
        strokes,
        position_x=strokes["position_y"] / 3,
        velocity_x=strokes["velocity_y"] / 3,
        force_x=strokes["force_y"] / 3,
    )
    assert preflight(crossed, MODEL).outputs == (0, 1)


def test_an_axis_whose_force_is_noise_is_left_out_and_the_other_counts(strokes):
    noise = FORCE_NOISE * np.random.default_rng(1).standard_normal(len(strokes))
    moved = {f"{what}_x": strokes[f"{what}_y"] / 3 for what in ("position", "velocity")}
    result = preflight(changed(strokes, force_x=noise, **moved), MODEL)
    assert result.reason is None and result.outputs == (1,)
    said = finding(result, "noisy")
    assert said.severity == "warn" and said.text.startswith("force_x varies") and "left out" in said.text


def above(clean):
    return changed(clean, position_z=clean["position_z"] + 0.05, in_contact=0 * clean.time)


def limited(clean):
    contact = clean["in_contact"] > 0
    limit = 0.3 * np.std(clean["force_y"][contact])
    return changed(clean, force_y=np.where(contact, np.clip(clean["force_y"], -limit, limit), clean["force_y"]))


def noise_alone(clean):
    return changed(clean, force_y=FORCE_NOISE * np.random.default_rng(0).standard_normal(len(clean)))


def held(recording, *names):
    """Some columns held at one value, and velocities at 0."""
    return changed(recording, **{n: np.full(len(recording), 0.01 if "position" in n else 0.0) for n in names})


def dashed(recording):
    """A contact of 40 ms in every half second."""
    touching = np.arange(len(recording)) % 500 < 40
    forces = {name: np.where(touching, recording[name], 0.0) for name in FORCES}
    z = np.where(touching, -0.005, 0.005)
    return changed(recording, in_contact=touching * 1.0, position_z=z, velocity_z=0.0 * z, **forces)


TANGENTIAL = ("position_x", "position_y", "velocity_x", "velocity_y")


def one_sided(clean):
    return contact_recording(motion=lambda t: (0.01 * t - 0.002 * np.cos(4 * t), 0.01 + 0.008 * np.sin(4 * t)))


# Recordings from which nothing can be told, what is to be said about it, and how; more in test_conventions.
BAD = {
    "too short": (lambda clean: cut(clean, (clean.time > 1.0) & (clean.time < 2.0)), "too_short", ""),
    "motionless": (lambda clean: contact_recording(motion=lambda t: (0.01 + 0 * t, 0 * t)), "motionless", ""),
    "held still to the last bit": (lambda clean: held(clean, *TANGENTIAL), "motionless", ""),
    "held still, in a velocity of noise": (lambda clean: held(clean, *TANGENTIAL[:3]), "motionless", ""),
    "contacts of 40 ms": (dashed, "too_short", ""),
    "one-sided": (one_sided, "one_sided", r"y moves toward \+ alone"),
    "saturated": (limited, "saturation", ""),
    "tangential force late": (late(0.7, "force_y"), "misaligned", ""),
    "never touches": (above, "no_contact", r"lowest point is z = 3\d\.\d\d mm"),
    "mostly gaps": (lambda clean: cut(clean, (clean.time % 1.0) < 0.3), "gaps", ""),
    "dead sensor": (lambda clean: changed(clean, force_y=0 * clean.time), "stuck", ""),
    "nothing but noise": (noise_alone, "noisy", ""),
}


@pytest.mark.parametrize("which", BAD)
def test_a_recording_that_cannot_say_anything_is_refused_with_the_reason(strokes, which):
    spoil, code, said = BAD[which]
    result = preflight(spoil(strokes), MODEL)
    assert code in codes(result, "refuse"), result.findings
    assert result.reason and finding(result, code).text in result.reason and "\n" not in result.reason
    assert result.findings[0].severity == "refuse" and re.search(said, result.reason)


@pytest.mark.parametrize("lag", [0.0, 0.003, 0.0125, 0.06, -0.008])
def test_the_offset_of_the_clocks_is_read_off_the_touches(strokes, lag):
    fit = normal_fit(smooth(late(lag, "force_z")(strokes)))
    assert fit.offset == pytest.approx(lag, abs=4e-4)
    k, b = fit.coefficients
    assert k == pytest.approx(NORMAL_K, rel=0.01) and b == pytest.approx(NORMAL_B, rel=0.1)
    assert fit.explained > 0.999 and fit.standard_error < 4e-4


def test_a_small_offset_is_a_warning_with_its_size(strokes):
    result = preflight(late(0.02, "force")(strokes), MODEL)
    found = finding(result, "offset")
    assert found.severity == "warn" and found.figures["offset_s"] == pytest.approx(0.02, abs=4e-4)
    assert "later" in found.text and result.reason is None


def test_bias_is_told_with_its_standard_error(strokes):
    result = preflight(changed(strokes, force_y=strokes["force_y"] + 0.25), MODEL)
    found = finding(result, "bias")
    assert found.severity == "warn" and "force_y 0.25" in found.text and "force_z" not in found.text
    assert found.figures["force_y"] == pytest.approx(0.25, abs=5 * found.figures["force_y_se"])


def test_a_limit_is_found_and_its_share_is_right(strokes):
    limit = 1.5
    clipped = np.clip(strokes["force_y"], -limit, limit)
    found = finding(preflight(changed(strokes, force_y=clipped), MODEL), "saturation")
    contact = strokes["in_contact"] > 0
    assert found.severity == "warn" and found.figures["limit"] == pytest.approx(limit)
    assert found.figures["share"] == pytest.approx(np.mean(np.abs(clipped[contact]) == limit), abs=1e-9)


def test_a_normal_force_that_is_clipped_is_borne(strokes):
    clipped = changed(strokes, force_z=np.minimum(strokes["force_z"], 0.3))
    result = preflight(clipped, MODEL)
    assert finding(result, "saturation").severity == "warn" and result.reason is None
    assert "offset" not in codes(result, "note", "warn", "refuse")


def test_neither_a_sine_nor_a_coarse_sine_is_taken_for_clipped():
    wave = np.sin(0.01 * np.arange(20_000))
    assert clipping("force", wave, 1e-3) is None
    for step in (0.003, 0.02, 0.1):
        assert clipping("force", step * np.round(wave / step), 1e-3) is None
        assert clipping("force", np.clip(step * np.round(wave / step), -0.7, 0.7), 1e-3) is not None
    assert coarseness("force", wave, 1e-3) is None
    coarse = coarseness("force", 0.1 * np.round(wave / 0.1), 1e-3)
    assert coarse.severity == "warn" and coarse.figures["step"] == pytest.approx(0.1)


def test_spikes_are_told_and_neither_noise_nor_touches_nor_a_coarse_sensor_are_taken_for_them():
    noisy = 0.02 * np.random.default_rng(3).standard_normal(20_000)
    steps = noisy + 2.0 * (np.arange(20_000) // 500 % 2)  # a touch is a step: the samples beside it are not alike
    for plain in (noisy, steps, 0.05 * np.round(noisy / 0.05), np.zeros(100)):
        assert spikes("force", plain, 1e-3) is None
    struck = steps.copy()
    struck[100:20_000:250] += 1.0
    found = spikes("force", struck, 1e-3)
    assert found.severity == "warn" and found.figures["count"] == 80
    assert found.figures["largest"] == pytest.approx(1.0, abs=0.1)


def test_a_sensor_that_drops_out_is_noticed():
    noisy = np.random.default_rng(0).standard_normal(20_000)
    assert freezing("force", noisy, 1e-3) is None
    noisy[5000:6000] = noisy[5000]
    found = freezing("force", noisy, 1e-3)
    assert found.severity == "warn" and found.figures["seconds"] == pytest.approx(1.0, abs=0.01)
    noisy[5000:17_000] = noisy[5000]
    assert freezing("force", noisy, 1e-3).severity == "refuse"


def test_gaps_are_told_with_their_place(strokes):
    result = preflight(cut(strokes, (strokes.time < 6.0) | (strokes.time > 6.25)), MODEL)
    found = finding(result, "gaps")
    assert found.severity == "warn" and "from 5.999 to 6.251 s" in found.text and result.reason is None


def test_filtered_force_noise_is_called_coloured(strokes):
    rng, a = np.random.default_rng(8), 0.95
    coloured = np.zeros(len(strokes))
    for i, w in enumerate(rng.standard_normal(len(strokes) - 1)):
        coloured[i + 1] = a * coloured[i] + 0.03 * w
    quiet = changed(strokes, force_y=strokes["force_y"] + coloured)
    assert "coloured_noise" in codes(preflight(quiet, MODEL), "warn")


def test_a_driven_body_that_rests_is_refused():
    recording = driven_recording()
    noise = 1e-6 * np.random.default_rng(0).standard_normal(len(recording))
    still = changed(recording, output=noise, output_rate=np.gradient(noise, recording.time))
    assert "motionless" in codes(preflight(still, DrivenBodyModel(m=2.0)), "refuse")


@pytest.mark.parametrize(("times", "off"), [(0.0, "100 %"), (-1.0, "200 %"), (1e-3, "99.9 %")])
def test_velocities_of_something_else_are_derived_instead_and_that_is_said(strokes, times, off):
    foreign = {f"velocity_{axis}": times * strokes[f"velocity_{axis}"] for axis in "xyz"}
    result = preflight(changed(strokes, **foreign), MODEL)
    assert result.reason is None and not result.smoothed.uses_velocity
    assert f"velocity_y is not the rate of what moves: it is off by {off}" in finding(result, "foreign_rate").text
    true = strokes["velocity_y"]
    assert np.std(result.recording["velocity_y"] - true) < 0.02 * np.std(true)
    again = preflight(result.recording, MODEL)
    assert again.recording is result.recording and "foreign_rate" not in codes(again, "warn")


@pytest.mark.parametrize(
    ("steps", "found"),
    [
        (np.where(np.arange(7999) == 4000, 1e5, 1e-3), "found 100000 s after 4 s, where the median step is 0.001 s"),
        (np.where(np.arange(7999) % 2 == 0, 1e-6, 0.02), "found 0.02 s after .* s, where the median step is 1e-06 s"),
    ],
    ids=["a jump of a day", "a microsecond and 20 ms in turn"],
)
def test_a_clock_that_is_none_is_refused_before_memory_is_taken_for_it(strokes, steps, found):
    columns = {name: values[:8000] for name, values in strokes.columns.items()}
    jumps = Recording(np.concatenate([[0.0], np.cumsum(steps)]), columns, "made.csv")
    with pytest.raises(BadInput, match=rf"made\.csv: time: {found}, expected steps of like size"):
        preflight(jumps, MODEL)


def test_a_model_of_another_structure_is_bad_input(strokes):
    for model in (KelvinVoigt(k=1.0), DrivenBodyModel(m=1.0)):
        with pytest.raises(BadInput, match=r"made\.csv: columns: found position_x"):
            preflight(strokes, model)
    with pytest.raises(BadInput, match="for this structure of model"):
        preflight(driven_recording(), MODEL)


def test_a_recording_of_a_handful_of_samples_is_refused_in_one_line(strokes):
    with pytest.raises(BadInput, match="5 samples"):
        preflight(cut(strokes, slice(0, 5)), MODEL)
    assert preflight(cut(strokes, slice(0, 60)), MODEL).reason


@pytest.mark.parametrize("name", ["clean", "coulomb_hidden"])
def test_the_example_recordings_pass(examples, name):
    result = preflight(load(examples / f"{name}.csv"), load_model(examples / f"{name}.yaml"))
    assert result.reason is None and not codes(result, "warn") and result.outputs == (1,)
    told = {"clean": 0.012, "coulomb_hidden": 0.021}[name]
    assert result.smoothed.noise["force_y"].std == pytest.approx(told, rel=0.05)
    assert result.smoothed.noise["position_y"].std == pytest.approx(1e-5, rel=0.05)
    assert result.smoothed.noise["velocity_y"].std == pytest.approx(5e-4, rel=0.05)


REAL = {
    "emps": DrivenBodyModel(m=95.0, b=200.0),
    "silverbox": DrivenBodyModel(m=5e-6, b=2e-4, k=0.93),
    "bam_servo": DrivenBodyModel(m=0.01, b=0.1, gain=0.2, gravity=Gravity("pendulum", 0.48)),
    "falling_balls": DrivenBodyModel(m=1.0, gravity=Gravity("constant", 9.81)),
    "mr_damper": KelvinVoigt(k=20_000.0, b=10_000.0),
    "dvrk_palpation": FlexibleBoxModel(replace(MODEL.parameters, m=0.1, k1=50.0, k2=100.0, b1=1.0, b2=1.0)),
}


@pytest.mark.parametrize("folder", REAL)
def test_real_recordings_pass(recordings, folder):
    for path in sorted((recordings / folder).glob("*.npz")):
        for recording in load_all(path) if not path.name.startswith("probing") else ():
            result = preflight(recording, REAL[folder])
            assert result.reason is None, f"{recording.source}: {result.reason}"


def test_a_hand_guiding_a_robot_touches_nothing(recordings):
    path = recordings / "panda_comanipulation" / "symbol17_rec0.npz"
    assert "never touches" in preflight(load(path), MODEL).reason
