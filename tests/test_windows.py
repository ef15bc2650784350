"""Windows of a driven body: how long they are, which samples set a state, and what hidden effects still show."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.diagnosis.checks.preflight import preflight
from mmt_drake.diagnosis.fit import tracks
from mmt_drake.diagnosis.fit.tracks import DrivenTrack
from mmt_drake.diagnosis.fit.window_length import window_length
from mmt_drake.diagnosis.signals.smoother import smooth
from mmt_drake.model import driven_body
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording
from mmt_drake.replay import in_windows, replayed
from mmt_drake.simulation import simulate
from mmt_drake.windows import EVERY, LEAD, Windows, blocks_of, held_blocks, in_blocks, sets_out

BODY = DrivenBodyModel(m=2.0, b=4.0)
SETTING_IN = parse_model(
    {
        "structure": "driven_body",
        "parameters": {"m": 2.0, "b": 4.0},
        "effects": [{"name": "dahl_friction", "parameters": {"Fc": 0.8, "sigma": 8.0}}],
    },
    "friction that sets in over 0.1 m",
)
TIME = np.arange(0.0, 30.0, 2e-3)
NOISE = 1e-4
PENDULUM = {"structure": "driven_body", "gravity": {"kind": "pendulum", "value": 9.0}}
INPUT = 3.0 * np.sin(2.0 * np.pi * 0.7 * TIME) + 2.0 * np.sin(2.0 * np.pi * 0.31 * TIME + 1.0)


def recorded(body, *, drive=INPUT, noise=NOISE, position=0.0, rate=0.0):
    """What a body does under an input, and the noise that its encoder adds."""
    state, output, rates = np.empty(driven_body.STATE_SIZE), np.empty(len(TIME)), np.empty(len(TIME))
    driven_body.set_out(state, 0.0, 0.0, drive[0], 0.0, position, rate)
    driven_body.replay_part(0, len(TIME), TIME, drive, np.zeros(len(TIME)), body.kernel_vector(), state, output, rates)
    noisy = output + noise * np.random.default_rng(0).standard_normal(len(TIME))
    return Recording(TIME, {"input": INPUT, "output": noisy}, "carriage"), np.column_stack([output, rates])


def test_a_body_that_its_drive_sets_in_motion_at_once_begins_at_rest_and_one_that_moves_does_not():
    body, growing = DrivenBodyModel(m=2.0, b=1.5, Fc=0.9), 4.0 * np.sin(1.3 * TIME) + 3.0 * np.sin(3.1 * TIME + 0.4)
    recording, _ = recorded(body, drive=growing)
    position, rate = Windows.of(TIME, recording["output"], 5.0).guess[0]
    assert rate == 0.0 and position == pytest.approx(0.0, abs=NOISE)
    moving, _ = recorded(body, drive=growing, rate=0.5)
    assert Windows.of(TIME, moving["output"], 5.0).guess[0, 1] > 0.3


@pytest.mark.parametrize("body", [BODY, SETTING_IN], ids=["friction of now", "friction that remembers"])
@pytest.mark.parametrize("length", [1.0, 2.5, 5.0])
def test_no_held_out_sample_sets_a_state_that_is_scored(body, length):
    recording, _ = recorded(body)
    windows = Windows.of(TIME, recording["output"], length)
    out = in_blocks(TIME, held_blocks(blocks_of(TIME, length)))
    scored = np.zeros(len(TIME), dtype=int)
    for first, lead, begin, end in windows.rows:
        assert not out[first:lead].any()
        assert out[begin:end].all() or not out[begin:end].any()
        assert lead - first == pytest.approx(LEAD * windows.length / 2e-3, abs=2.0)
        scored[begin:end] += 1
    assert scored[out].min() == scored.max() == 1
    spoilt = recording["output"] + 1.0 * out
    told = Recording(TIME, {"input": INPUT, "output": spoilt}, "spoilt")
    one, other = (in_windows(body, r, Windows.of(TIME, r["output"], length))[0]["output"] for r in (recording, told))
    np.testing.assert_array_equal(one[windows.scored], other[windows.scored])


@pytest.mark.parametrize(
    ("truth", "drift"),
    [(replace(BODY, Fc=0.8), 0.0), (replace(BODY, offset=0.3), 0.0), (BODY, 0.02)],
    ids=["friction", "bias", "drift"],
)
def test_what_a_model_leaves_out_shows_as_much_as_from_known_states(truth, drift):
    recording, motion = recorded(truth, drive=INPUT + drift * TIME)
    windows = Windows.of(TIME, recording["output"], 2.5)
    fitted = in_windows(BODY, recording, windows)[0]["output"]
    known = Windows(
        np.column_stack([windows.rows[:, 2]] * 3 + [windows.rows[:, 3]]),
        windows.kept,
        windows.used,
        motion[windows.rows[:, 2]],
        windows.weight,
        windows.length,
    )
    exact = in_windows(BODY, recording, known)[0]["output"]
    scored = windows.scored
    left, there = (np.sqrt(np.mean((motion[:, 0] - one)[scored] ** 2)) for one in (fitted, exact))
    assert left > 0.95 * there > 20.0 * NOISE
    recording, motion = recorded(truth)
    right = in_windows(truth, recording, Windows.of(TIME, recording["output"], 2.5))[0]["output"]
    assert np.sqrt(np.mean((right - motion[:, 0])[scored] ** 2)) < 3.0 * NOISE


def test_a_window_begins_with_what_friction_remembers_of_the_motion_before_it():
    recording, motion = recorded(SETTING_IN)
    windows = Windows.of(TIME, recording["output"], 2.5)
    right = in_windows(SETTING_IN, recording, windows)[0]["output"]
    off = np.sqrt(np.mean((right - motion[:, 0])[windows.scored] ** 2))
    assert off < 3.0 * NOISE
    forgotten = motion[:, 0].copy()
    for i in range(len(windows.rows)):
        alone = replace(windows, rows=windows.rows[i : i + 1], kept=windows.kept[i : i + 1])
        alone = replace(alone, guess=windows.guess[i : i + 1], weight=windows.weight[i : i + 1])
        forgotten[alone.scored] = in_windows(SETTING_IN, recording, alone)[0]["output"][alone.scored]
    assert np.sqrt(np.mean((forgotten - motion[:, 0])[windows.scored] ** 2)) > 10.0 * off


def test_of_windows_that_nobody_wants_nothing_is_simulated():
    recording, _ = recorded(SETTING_IN)
    none = Windows.of(TIME, recording["output"], 2.5).scoring(np.zeros(len(TIME), dtype=bool))
    assert none.count == 0
    assert np.isnan(in_windows(SETTING_IN, recording, none)[0]["output"]).all()


def driven_track(length):
    smoothed = smooth(recorded(replace(BODY, Fc=0.8))[0])
    held = in_blocks(smoothed.time, held_blocks(blocks_of(smoothed.time, length or smoothed.time[-1] / 12.0)))
    return DrivenTrack(smoothed, 0, held, NOISE, window_s=length)


@pytest.mark.parametrize("heldout", [False, True])
def test_a_part_is_simulated_as_in_the_whole_bit_for_bit_and_nothing_else_is(heldout):
    track = driven_track(2.5)
    part = track.part(heldout)
    chosen = (track.heldout == heldout) & (track.weight > 0.0)
    np.testing.assert_array_equal(part.residual(BODY)[chosen], track.residual(BODY)[chosen])
    assert not part.residual(BODY)[~chosen & (track.weight > 0.0)].any()
    assert np.abs(track.residual(BODY)[chosen]).max() > 10.0 * NOISE


@pytest.mark.parametrize("length", [None, 2.5])
def test_of_a_long_recording_windows_spread_over_all_of_it_are_easier_to_fit(length, monkeypatch):
    monkeypatch.setattr(tracks, "LONG", 3000)
    track = driven_track(length)
    eased = track.eased()
    times = track.time[eased.weight > 0.0]
    assert 0 < len(times) < 0.5 * len(track.time) and not track.heldout[eased.weight > 0.0].all()
    assert times[0] < 0.2 * track.time[-1] and times[-1] > 0.6 * track.time[-1]
    assert eased.weight @ eased.residual(replace(BODY, Fc=0.8)) ** 2 < 0.1 * (eased.weight @ eased.residual(BODY) ** 2)


def test_a_body_that_sets_out_in_motion_is_simulated_in_motion_and_one_at_rest_at_rest():
    moving, motion = recorded(BODY, rate=0.4, position=0.2)
    still, _ = recorded(BODY)
    assert sets_out(TIME, moving["output"]) and not sets_out(TIME, still["output"])
    fitting = replace(BODY, initial="fitted")
    found = replayed(fitting, moving)
    assert found["output_rate"][0] == pytest.approx(0.4, abs=2e-3)
    np.testing.assert_allclose(found["output"], motion[:, 0], atol=1e-3)
    again = simulate(fitting, moving)
    np.testing.assert_allclose(again["output"], found["output"], rtol=0.0, atol=1e-9)
    assert replayed(BODY, still)["output"][0] == still["output"][0]
    assert replayed(BODY, still)["output_rate"][0] == 0.0


@pytest.mark.parametrize("period", range(2, 13))
def test_no_part_of_a_motion_that_repeats_is_always_held_out(period):
    held = held_blocks(72)
    assert held.reshape(-1, EVERY).sum(axis=1).tolist() == [1] * 24 and not (held[1:] & held[:-1]).any()
    assert not any(held[phase::period].all() for phase in range(period))


@pytest.mark.parametrize("band", [4.0, np.inf])
def test_what_is_held_out_is_not_filtered_into_a_state(band):
    recording, _ = recorded(replace(BODY, Fc=0.5))
    out = in_blocks(TIME, held_blocks(blocks_of(TIME, 2.5)))
    spoilt = replace(recording, columns=recording.columns | {"output": recording["output"] + 1.0 * out})
    simulated = []
    for one in (recording, spoilt):
        smoothed = smooth(one, band_hz=band)
        heldout = in_blocks(smoothed.time, held_blocks(blocks_of(TIME, 2.5)))
        track = DrivenTrack(smoothed, 0, heldout, window_s=2.5)
        simulated.append(track.simulated(BODY)[track.windows.scored])
    np.testing.assert_array_equal(*simulated)


@pytest.mark.parametrize(
    ("body", "length"),
    [
        # of an inverted pendulum (m q'' = u + G q) an error grows by e in sqrt(m / G)
        (parse_model({**PENDULUM, "parameters": {"m": 8.0}}), math.sqrt(8.0 / 9.0)),
        # of a body that is damped alone, the longest in which noise of the input adds little, or 3 m / b
        (replace(BODY, b=8.0), 3.0 * 2.0 / 8.0),
        (replace(BODY, k=500.0), None),
    ],
    ids=["inverted", "free", "held"],
)
def test_windows_end_before_an_error_has_grown_and_a_body_that_is_held_needs_none(body, length):
    time = np.arange(0.0, 60.0, 5e-3)
    motion = math.pi + 0.1 * np.sin(3.0 * time)
    noise = np.random.default_rng(0).standard_normal(len(time))
    recording = Recording(time, {"input": np.sin(3.0 * time) + 0.3 * noise, "output": motion + 1e-7 * noise}, "joint")
    found = window_length([preflight(recording, body)], body)
    assert found == (None if length is None else pytest.approx(length, rel=0.01))


def test_of_a_body_that_drifts_windows_are_short_although_its_input_is_exact_where_they_hold_samples_enough():
    free = replace(BODY, b=8.0)
    time = np.arange(0.0, 60.0, 5e-3)
    recording = Recording(time, {"input": np.sin(3.0 * time), "output": 0.1 * np.sin(3.0 * time)}, "joint")
    assert window_length([preflight(recording, free)], free) == pytest.approx(3.0 * 2.0 / 8.0)
    few = Recording(time[:470], {name: column[:470] for name, column in recording.columns.items()}, "joint")
    assert window_length([preflight(few, free)], free) is None


def test_the_length_of_windows_stands_in_a_model_file():
    data = {"structure": "driven_body", "parameters": {"m": 2.0}, "window_s": 2.5}
    assert parse_model(data).window_s == 2.5


def test_whoever_cannot_say_that_a_ball_is_at_rest_fits_its_first_velocity():
    time = np.arange(45) / 15.0
    noise = 0.04 * np.random.default_rng(0).standard_normal(45)
    ball = parse_model(
        {"structure": "driven_body", "parameters": {"m": 1.0}, "gravity": {"kind": "constant", "value": 9.81}}
    )
    assert sets_out(time, 47.0 + 0.6 * time - 0.5 * 9.81 * time**2 + noise)
    height = 47.0 + 0.6 * time - 0.5 * 9.81 * time**2
    recording = Recording(time, {"input": np.zeros(45), "output": height + noise}, "ball")
    out = in_blocks(time, np.arange(12) % 3 == 2)
    error = (replayed(replace(ball, initial="fitted"), recording)["output"] - height)[out]
    assert np.sqrt(np.mean(error**2)) < 0.03
