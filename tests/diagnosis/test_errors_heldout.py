"""Held-out errors are the contract's, and the noise floor is what a right model leaves."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import FORCE_NOISE, MODEL, contact_recording, driven_recording
from scipy.ndimage import minimum_filter1d
from trial_samples import changed

from mmt_drake.diagnosis.fit.errors import HeldOutPart, intervals_of, noise_through, within
from mmt_drake.diagnosis.signals.smoother import smooth
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.model_files import with_effects
from mmt_drake.recording import Recording
from mmt_drake.recording.derive import rate_of
from mmt_drake.replay import replayed

BLOCKS = ((3.0, 5.0), (9.5, 13.0))


def heldout(recording: Recording, axes: str = "", blocks=BLOCKS) -> HeldOutPart:
    return HeldOutPart(recording, blocks, smooth(recording), tuple(axes))


def off_by(offset: float) -> tuple[Recording, np.ndarray]:
    """A recording whose forces are the model's own but for an offset; and which samples count."""
    recording = contact_recording(noise=0.0)
    forces = replayed(MODEL, recording)
    columns = {name: values + offset for name, values in forces.items()}
    inside = within(recording.time, BLOCKS) & (recording["in_contact"] > 0.0)
    return changed(recording, **columns), inside


def test_an_offset_counts_in_full() -> None:
    recording, inside = off_by(0.1)
    expected = 0.1 / np.std(recording["force_y"][inside])
    assert heldout(recording, "y").nrmse(MODEL) == pytest.approx(expected, rel=1e-9)


def test_axes_count_together() -> None:
    recording, inside = off_by(0.1)
    recording = changed(recording, force_x=recording["force_y"] - 0.3)
    both = np.stack([recording["force_x"][inside], recording["force_y"][inside]])
    model = np.stack([replayed(MODEL, recording)[f"force_{axis}"][inside] for axis in "xy"])
    expected = np.sqrt(np.mean((both - model) ** 2)) / np.std(both)
    assert heldout(recording, "xy").nrmse(MODEL) == pytest.approx(expected, rel=1e-9)


def test_what_is_off_contact_or_not_held_out_does_not_count() -> None:
    recording, inside = off_by(0.1)
    spoilt = np.where(inside, recording["force_y"], 1e3)
    off = heldout(changed(recording, force_y=spoilt), "y").nrmse(MODEL)
    assert off == pytest.approx(heldout(recording, "y").nrmse(MODEL), rel=1e-12)


def test_a_spring_and_a_driven_body_count_off_contact_too() -> None:
    box, _ = off_by(0.0)
    time, x = box.time, box["position_y"]
    spring = KelvinVoigt(k=300.0)
    force = -300.0 * x + 0.2
    columns = {"position": x, "velocity": box["velocity_y"], "force": force, "in_contact": np.zeros(len(time))}
    expected = 0.2 / np.std(force[within(time, BLOCKS)])
    assert heldout(Recording(time, columns)).nrmse(spring) == pytest.approx(expected, rel=1e-9)
    body = driven_recording(noise=0.0)
    inside = within(body.time, BLOCKS[:1])
    later = changed(body, output=body["output"] + 0.01 * inside)
    expected = 0.01 / np.std(later["output"][inside])
    assert heldout(later, blocks=BLOCKS[:1]).nrmse(DrivenBodyModel(m=2.0)) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("velocity", [True, False])
def test_a_right_model_leaves_the_noise_floor(velocity: bool) -> None:
    recording = contact_recording(velocity=velocity)
    floor = heldout(recording, "y").floor(MODEL)
    assert heldout(recording, "y").nrmse(MODEL) == pytest.approx(floor, rel=0.05)


def slow_loop(noise: float) -> Recording:
    """A spring of 500 N/m and a loop (Bouc and Wen), pressed 1 mm to and fro at 0.4 Hz: noise goes a longer way."""
    rate, fine, w, beta = 500.0, 40, 2.0 * np.pi * 0.4, 1000.0
    grid = np.arange(round(14.0 * rate) * fine) / (rate * fine)
    x, v, loop = 1e-3 * np.sin(w * grid), 1e-3 * w * np.cos(w * grid), np.zeros(len(grid))
    for k in range(1, len(grid)):
        dx = x[k] - x[k - 1]
        loop[k] = (
            loop[k - 1] + dx - beta * (abs(dx) + dx * np.sign(loop[k - 1])) * abs(loop[k - 1]) * np.sign(loop[k - 1])
        )
    random = np.random.default_rng(3)
    columns = {}
    for name, values, std in (("position", x, 1e-5), ("velocity", v, 5e-4), ("force", -500.0 * x - 300.0 * loop, 5e-3)):
        columns[name] = values[::fine] + noise * std * random.standard_normal(len(grid) // fine)
    return Recording(grid[::fine], columns)


def test_of_a_loop_the_floor_has_what_it_loses_by_noise_that_counts_as_a_way() -> None:
    effect = {"name": "hysteresis", "parameters": {"alpha": 300.0, "beta": 1000.0}}
    right = with_effects(KelvinVoigt(k=500.0, b=0.0), [effect], "here")
    assert heldout(slow_loop(0.0)).nrmse(right) < 0.01, "without noise it is the law"
    noisy = heldout(slow_loop(1.0))
    assert noisy.nrmse(right) > 0.1
    assert noisy.floor(right) == pytest.approx(noisy.nrmse(right), rel=0.1)


def test_an_encoder_that_stands_on_one_count_has_no_noise_there() -> None:
    time = 1e-3 * np.arange(14_000)
    position = 1e-3 * np.round(np.clip(20.0 * np.sin(0.8 * time), -10.0, 10.0))
    columns = {"position": position, "velocity": rate_of(time, position), "force": -50.0 * position}
    recording = Recording(time, columns, derived=frozenset({"velocity"}))
    stands = columns["velocity"] == 0.0
    through = noise_through(KelvinVoigt(k=50.0), recording, smooth(recording))["force"]
    deep = minimum_filter1d(stands, 61)
    assert deep.mean() > 0.3
    np.testing.assert_array_equal(through[deep], 0.0)
    assert np.mean(through[~stands] != 0.0) > 0.9


def test_the_floor_of_a_noiseless_motion_is_that_of_the_sensor() -> None:
    clean = contact_recording(noise=0.0)
    rng = np.random.default_rng(3)
    noisy = changed(clean, force_y=clean["force_y"] + FORCE_NOISE * rng.standard_normal(len(clean)))
    inside = within(noisy.time, BLOCKS) & (noisy["in_contact"] > 0.0)
    expected = FORCE_NOISE / np.std(noisy["force_y"][inside])
    assert heldout(noisy, "y").floor(MODEL) == pytest.approx(expected, rel=0.05)


def test_no_sample_or_no_axis_to_count_is_bad_input() -> None:
    recording, _ = off_by(0.0)
    with pytest.raises(BadInput, match="no sample that counts"):
        heldout(recording, "y", ((100.0, 101.0),)).nrmse(MODEL)
    with pytest.raises(BadInput, match="x, y, z or several"):
        heldout(recording).nrmse(MODEL)
    still = changed(recording, force_y=np.zeros(len(recording)))
    with pytest.raises(BadInput, match="constant output"):
        heldout(still, "y").nrmse(MODEL)


def test_a_single_axis_box_is_in_contact_unless_it_says_otherwise() -> None:
    box = contact_recording(seconds=8.0, noise=0.0)
    model = FlexibleBoxModel(BoxParameters(m=0.5, k2=400.0, b1=18.0, b2=17.0))
    columns = {"position": box["position_y"], "velocity": box["velocity_y"]}
    force = replayed(model, Recording(box.time, {**columns, "force": np.zeros(len(box))}))["force"]
    whole = Recording(box.time, {**columns, "force": force + 0.1})
    inside = within(box.time, BLOCKS[:1])
    assert heldout(whole, blocks=BLOCKS[:1]).nrmse(model) == pytest.approx(0.1 / np.std(force[inside]), rel=1e-9)
    told = replace(whole, columns={**whole.columns, "in_contact": np.zeros(len(box))})
    with pytest.raises(BadInput, match="no sample that counts"):
        heldout(told, blocks=BLOCKS[:1]).nrmse(model)


def test_intervals_are_the_runs_of_a_flag() -> None:
    time = np.arange(10) / 10.0
    flags = np.array([1, 1, 0, 0, 1, 0, 1, 1, 1, 1], dtype=bool)
    found = intervals_of(time, flags)
    assert found == ((0.0, 0.1), (0.4, 0.4), (0.6, 0.9))
    np.testing.assert_array_equal(within(time, found), flags)
    assert intervals_of(time, ~flags | flags) == ((0.0, 0.9),)
