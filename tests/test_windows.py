"""Windows of a driven body: which samples set a state, what hidden effects still show, and what they cost."""

import time as clock
from dataclasses import replace

import numpy as np
import pytest

from mmt_drake.model import driven_body
from mmt_drake.model.parameters import DrivenBodyModel
from mmt_drake.model_files import parse_model
from mmt_drake.recording import Recording
from mmt_drake.replay import in_windows, replayed
from mmt_drake.simulate import simulate
from mmt_drake.windows import LEAD, Windows, blocks_of, heldout, sets_out

BODY = DrivenBodyModel(m=2.0, b=4.0)
TIME = np.arange(0.0, 30.0, 2e-3)
NOISE = 1e-4
INPUT = 3.0 * np.sin(2.0 * np.pi * 0.7 * TIME) + 2.0 * np.sin(2.0 * np.pi * 0.31 * TIME + 1.0)


def recorded(body, *, drive=INPUT, noise=NOISE, position=0.0, rate=0.0):
    """What a body does under an input, and the noise that its encoder adds."""
    state, output, rates = np.empty(driven_body.STATE_SIZE), np.empty(len(TIME)), np.empty(len(TIME))
    driven_body.set_out(state, 0.0, 0.0, drive[0], 0.0, position, rate)
    driven_body.replay_part(0, len(TIME), TIME, drive, np.zeros(len(TIME)), body.kernel_vector(), state, output, rates)
    noisy = output + noise * np.random.default_rng(0).standard_normal(len(TIME))
    return Recording(TIME, {"input": INPUT, "output": noisy}, "carriage"), np.column_stack([output, rates])


@pytest.mark.parametrize("length", [1.0, 2.5, 5.0])
def test_no_held_out_sample_sets_a_state_that_is_scored(length):
    recording, _ = recorded(BODY)
    windows = Windows.of(TIME, recording["output"], length)
    out = heldout(TIME, blocks_of(TIME, length))
    scored = np.zeros(len(TIME), dtype=int)
    for first, lead, begin, end in windows.rows:
        assert not out[first:lead].any()
        assert out[begin:end].all() or not out[begin:end].any()
        assert lead - first == pytest.approx(LEAD * windows.length / 2e-3, abs=2.0)
        scored[begin:end] += 1
    assert scored[out].min() == scored.max() == 1
    spoilt = recording["output"] + 1.0 * out
    told = Recording(TIME, {"input": INPUT, "output": spoilt}, "spoilt")
    one, other = (in_windows(BODY, r, Windows.of(TIME, r["output"], length))[0]["output"] for r in (recording, told))
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


def test_windows_cost_little_more_than_the_whole():
    recording, _ = recorded(replace(BODY, Fc=0.5))
    model = replace(BODY, Fc=0.4)
    whole, windows = (Windows.of(TIME, recording["output"], length) for length in (None, 2.5))

    def seconds(some):
        took = []
        for _ in range(7):
            begun = clock.perf_counter()
            in_windows(model, recording, some)
            took.append(clock.perf_counter() - begun)
        return min(took)

    assert seconds(windows) < 4.0 * seconds(whole)


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
    out = heldout(time, 12)
    error = (replayed(replace(ball, initial="fitted"), recording)["output"] - height)[out]
    assert np.sqrt(np.mean(error**2)) < 0.03
