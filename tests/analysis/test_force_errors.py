"""Errors by band, against sines whose errors are known."""

import json
from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.analysis import metrics
from mmt_drake.analysis.metrics import measure
from mmt_drake.errors import BadInput

STEP = 1e-3
FREQUENCIES = np.array([0.1, 1.0, 5.0])  # one in each band
AMPLITUDES = np.array([3.0, 2.0, 0.5])
BANDS = ("below_0.3_hz", "0.3_to_3_hz", "3_to_10_hz")


def clock(seconds: float, step: float = STEP) -> np.ndarray:
    return np.arange(round(seconds / step)) * step


def sines(time: np.ndarray, gains: np.ndarray | float = 1.0) -> np.ndarray:
    """(n, 3): the sum of sines along y, half of it along x, a third along z; `gains` scale each sine."""
    y = np.sin(2 * np.pi * FREQUENCIES * time[:, None]) @ (AMPLITUDES * gains)
    return np.column_stack([0.5 * y, y, y / 3.0])


def band_gains(low: float, high: float) -> np.ndarray:
    """Zero-phase gain 1 / (1 + w^8) of order 4 at FREQUENCIES, w the frequency mapped to the low-pass prototype's."""
    band_pass = (FREQUENCIES**2 - low * high) / (FREQUENCIES * (high - low))
    prototype = band_pass if low > 0.0 else FREQUENCIES / high
    return 1.0 / (1.0 + prototype**8)


def test_each_band_gets_the_error_of_its_own_sine(recording_of):
    time = clock(100.0)
    wrong = np.array([0.02, 0.3, 0.9])
    run = recording_of(time, force=sines(time), rendered_force=sines(time, 1.0 + wrong), in_contact=np.ones_like(time))
    error = measure(run).rendered_error
    for band, edges in zip(BANDS, ((0.0, 0.3), (0.3, 3.0), (3.0, 10.0)), strict=True):
        through = band_gains(*edges) * AMPLITUDES
        expected = np.linalg.norm(wrong * through) / np.linalg.norm(through)
        assert error.tangential[band] == pytest.approx(expected, rel=5e-3)
        assert error.normal[band] == pytest.approx(expected, rel=5e-3)
    expected = np.linalg.norm(wrong * AMPLITUDES) / np.linalg.norm(AMPLITUDES)
    assert error.tangential["all"] == pytest.approx(expected, rel=1e-3)


def test_x_and_y_are_one_signal_and_z_is_apart(recording_of):
    time = clock(20.0)
    force = np.column_stack([np.full_like(time, 3.0), np.full_like(time, 4.0), np.full_like(time, 10.0)])
    rendered = force + np.array([1.0, 0.0, 2.0])
    error = measure(recording_of(time, force=force, rendered_force=rendered, in_contact=np.ones_like(time)))
    assert error.rendered_error.tangential["all"] == pytest.approx(1.0 / 5.0, rel=1e-12)
    assert error.rendered_error.normal["all"] == pytest.approx(2.0 / 10.0, rel=1e-12)
    assert error.rendered_error.reference_rms["all"] == pytest.approx(5.0, rel=1e-12)


def test_a_delay_of_whole_steps_is_exact_and_any_other_interpolates(recording_of):
    time = clock(30.0)
    for delay, bound in ((0.4, 1e-12), (0.4004, 1e-4)):
        run = recording_of(time, force=sines(time), rendered_force=sines(time + delay), in_contact=np.ones_like(time))
        assert measure(run, delay_s=delay).rendered_error.tangential["all"] < bound


def test_an_uncompensated_delay_costs_twice_the_sine_of_half_its_phase(recording_of):
    time = clock(30.0)
    delay, frequency = 0.05, 1.0
    run = recording_of(
        time,
        force=np.sin(2 * np.pi * frequency * time)[:, None] * np.ones(3),
        rendered_force=np.sin(2 * np.pi * frequency * (time + delay))[:, None] * np.ones(3),
        in_contact=np.ones_like(time),
    )
    expected = 2.0 * np.sin(np.pi * frequency * delay)
    found = measure(run).rendered_error.tangential
    assert found["all"] == pytest.approx(expected, rel=1e-3)
    assert found["0.3_to_3_hz"] == pytest.approx(expected, rel=1e-2)  # the filter rings at the ends


def in_contact_at(time: np.ndarray, *spans: tuple[float, float]) -> np.ndarray:
    return np.any([(time >= a - STEP / 4) & (time < b - STEP / 4) for a, b in spans], axis=0).astype(float)


def test_errors_count_only_in_contact_and_after_five_seconds_of_it_in_all(recording_of):
    time = clock(30.0)
    contact = in_contact_at(time, (0.0, 3.0), (10.0, 12.0), (20.0, 25.0))
    force = np.ones((len(time), 3))
    rendered = force * np.where((time < 20.0) | (time >= 25.0), 2.0, 1.1)[:, None]
    run = recording_of(time, force=force, rendered_force=rendered, in_contact=contact)
    found = measure(run).rendered_error
    assert found.samples == 5000
    assert found.tangential["all"] == pytest.approx(0.1, rel=1e-12)
    earlier = measure(run, after_s=4.5).rendered_error
    assert earlier.samples == 5500
    assert earlier.tangential["all"] == pytest.approx(np.sqrt((500 * 1.0 + 5000 * 0.01) / 5500), rel=1e-12)


def test_the_estimate_is_held_against_the_filtered_force_and_the_render_against_the_true_one_or_as_asked(recording_of):
    time = clock(20.0)
    force = sines(time)
    run = recording_of(
        time,
        force=force,
        true_force=2.0 * force,
        rendered_force=1.5 * force,
        filtered_force=4.0 * force,
        estimated_force=4.4 * force,
        in_contact=np.ones_like(time),
    )
    found = measure(run)
    assert found.rendered_error.tangential["all"] == pytest.approx(0.5)
    assert found.rendered_error_true.tangential["all"] == pytest.approx(0.25)
    assert found.estimated_error.tangential["all"] == pytest.approx(0.1)
    assert found.estimated_error_raw.tangential["all"] == pytest.approx(3.4)
    found = measure(run, measured="filtered_force")
    assert found.rendered_error.tangential["all"] == pytest.approx(0.625)
    assert found.estimated_error_raw.tangential["all"] == pytest.approx(0.1)


def test_error_around_switches_is_told_apart_from_the_error_between_them(recording_of):
    time = clock(40.0)
    contact = in_contact_at(time, (0.0, 12.0), (15.0, 27.0), (30.0, 40.0))
    force = contact[:, None] * np.array([0.0, 2.0, 5.0])
    answer_s = 0.1  # the rendered force answers each event that much later
    rendered = np.roll(force, round(answer_s / STEP), axis=0)
    rendered[: round(answer_s / STEP)] = 0.0
    found = measure(recording_of(time, force=force, rendered_force=rendered, in_contact=contact))
    # each window of 501 samples holds 100 wrong ones; 251 of it are in contact at a touch, 250 at a release
    wrong, pressed = 4 * 100, 2 * 251 + 2 * 250
    assert found.switch_error.tangential["all"] == pytest.approx(np.sqrt(wrong / pressed), rel=1e-9)
    assert found.between_switches_error.tangential["all"] == 0.0
    assert found.touch.median_s == pytest.approx(answer_s)


def test_the_whole_run_is_told_in_stages_first_contact_the_rest_and_touches(recording_of):
    time = clock(12.0)
    contact = in_contact_at(time, (1.0, 1.3), (2.0, 4.0), (5.0, 12.0))
    force = contact[:, None] * np.array([3.0, 4.0, 10.0])
    wrong = np.select([time < 2.2, (time >= 5.0) & (time < 5.05)], [0.5, 0.25], 0.1)  # 0.5 s of contact end at 2.2
    run = recording_of(
        time, force=force, true_force=2 * force, in_contact=contact, rendered_force=(1 + wrong)[:, None] * force
    )
    found = measure(run).to_json()
    assert found["error_first_0.5s"]["all"] == pytest.approx(0.5) and found["error_first_0.5s"]["z"][
        "all"
    ] == pytest.approx(0.5)
    assert found["error_rest"]["all"] == pytest.approx(np.sqrt((8750 * 0.1**2 + 50 * 0.25**2) / 8800))
    assert found["error_touches"]["all"] == pytest.approx(np.sqrt((2 * 0.5**2 + 0.25**2) / 3))
    assert found["error_first_0.5s_true"]["all"] == pytest.approx(0.25)
    assert found["touch_errors"] == pytest.approx([0.25, 0.25, 0.375]) and found["median_touch_error"] == 0.25


def test_time_to_stable_is_contact_time_until_stable_for_good(recording_of):
    time = clock(20.0)
    contact = in_contact_at(time, (1.0, 4.0), (6.0, 20.0))
    stable = in_contact_at(time, (2.0, 3.0), (7.0, 20.0))
    stable[time < 0.5] = np.nan  # no estimate yet
    run = recording_of(time, in_contact=contact, theta_stable=stable)
    assert metrics.time_to_stable(run) == pytest.approx(3.0 + 1.0)
    never = recording_of(time, in_contact=contact, theta_stable=np.where(time > 19.9, 0.0, stable))
    assert metrics.time_to_stable(never) is None


def test_parameters_are_the_last_estimate_and_nothing_where_there_was_none(recording_of):
    time = clock(0.01)
    run = recording_of(time, theta_m=np.linspace(0.0, 0.9, len(time)), theta_Fc=np.full_like(time, np.nan))
    assert metrics.final_parameters(run) == {"m": 0.9, "Fc": None}


def test_an_uneven_clock_gives_the_figures_of_an_even_one(recording_of):
    rng = np.random.default_rng(3)
    even = clock(60.0, 2e-3)
    uneven = even + rng.uniform(-0.8e-3, 0.8e-3, len(even))
    wrong = np.array([0.02, 0.3, 0.9])
    found = [
        measure(
            recording_of(t, force=sines(t), rendered_force=sines(t + 0.1, 1.0 + wrong), in_contact=np.ones_like(t)),
            delay_s=0.1,
        ).rendered_error.tangential
        for t in (even, uneven)
    ]
    for band in BANDS:
        assert found[1][band] == pytest.approx(found[0][band], rel=1e-2)


@pytest.mark.parametrize("sideways", [0.0, 1e-9])
def test_a_reference_of_no_more_than_rounding_gives_no_ratio_and_the_document_stays_json(recording_of, sideways):
    time = clock(20.0)
    force = np.column_stack([sideways * np.sin(3.0 * time), 0 * time, np.ones_like(time)])
    rendered = 1.2 * force + [0.1, 0.0, 0.0]
    run = recording_of(time, force=force, rendered_force=rendered, in_contact=np.ones_like(time))
    document = json.loads(json.dumps(measure(run).to_json(), allow_nan=False))
    assert document["rendered_error"]["all"] is None and document["touch_errors"] == [None]
    assert document["rendered_error"]["z"]["all"] == pytest.approx(0.2)
    assert document["estimated_error"] is None


def test_the_delay_is_that_which_the_recording_tells(stroke_run):
    told = replace(stroke_run, made_by={"to_telerobot_delay_s": "0.4"})
    assert measure(told) == measure(stroke_run, delay_s=0.4) != measure(stroke_run)
    with pytest.raises(BadInput, match="to_telerobot_delay_s"):
        measure(replace(stroke_run, made_by={"to_telerobot_delay_s": "soon"}))


def test_the_document_has_the_keys_of_the_contract(stroke_run):
    document = json.loads(json.dumps(measure(stroke_run, delay_s=0.4).to_json(), allow_nan=False))
    assert set(document) >= {
        "rendered_error",
        "rendered_error_true",
        "estimated_error",
        "time_to_stable_s",
        "touch_lag_s",
        "release_lag_s",
        "parameters",
        "delay_s",
    }
    assert set(document["rendered_error"]) == {"all", *BANDS, "z"}
    assert document["estimated_error"]["all"] == pytest.approx(0.02)
    assert document["time_to_stable_s"] == pytest.approx(2.8, abs=1.1e-3)
    assert document["parameters"]["k2"] == pytest.approx(500.0, rel=1e-6)


def good_signals(time: np.ndarray) -> dict[str, np.ndarray]:
    return {"force": sines(time), "rendered_force": sines(time), "in_contact": np.ones_like(time)}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda s: s.pop("force"), "'force_x'"),
        (lambda s: s.pop("rendered_force"), "'rendered_force_x'"),
        (lambda s: s.pop("in_contact"), "'in_contact'"),
        (lambda s: s.update(estimated_force=s["force"]), "'filtered_force_x'"),
        (lambda s: s["in_contact"].fill(0.0), "0 s of contact"),
        (lambda s: s["in_contact"][4000:].fill(0.0), "4 s of contact"),
        (lambda s: s["in_contact"][7:8].fill(0.5), "in_contact, sample 7: found 0.5"),
        (lambda s: s["force"][70:71, 1].fill(np.nan), "force_y, sample 70: found nan"),
        (lambda s: s.update(theta_stable=np.full(10_000, 2.0)), "theta_stable, sample 0: found 2.0"),
    ],
)
def test_a_recording_that_lacks_what_is_needed_is_refused(recording_of, change, said):
    time = clock(10.0)
    signals = good_signals(time)
    change(signals)
    with pytest.raises(BadInput, match=said) as caught:
        measure(recording_of(time, **signals))
    assert "test.csv" in str(caught.value)


@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf"), "400 ms"])
def test_a_delay_that_is_no_time_is_refused(stroke_run, value):
    with pytest.raises(BadInput, match="delay_s"):
        measure(stroke_run, delay_s=value)


def test_a_clock_that_stands_still_or_pauses_or_is_too_slow_is_refused(recording_of):
    time = clock(10.0)
    signals = good_signals(time)
    standing = time.copy()
    standing[5] = standing[4]
    with pytest.raises(BadInput, match=r"time, sample 5: found 0\.004, expected more than 0\.004"):
        measure(recording_of(standing, **signals))
    pausing = time + 2.0 * (time >= 5.0)
    with pytest.raises(BadInput, match="a gap of 2 s"):
        measure(recording_of(pausing, **signals))
    slow = clock(100.0, 0.06)
    with pytest.raises(BadInput, match=r"16\.6667 samples/s, expected more than 20"):
        measure(recording_of(slow, **good_signals(slow)))
