"""Causes of the thesis's mismatch do what they say, and are found in the blocks that they are put into."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mmt_drake.diagnosis.decide.blocks import replay_block
from mmt_drake.diagrams.proof.experiments.changes import Cause, unchanged
from mmt_drake.diagrams.proof.experiments.own_mismatch import (
    CAUSES,
    LATE_S,
    NO_BLOCK,
    believed,
    estimated_object,
    try_causes,
)
from mmt_drake.diagrams.stations.blocks import station_blocks
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA
from mmt_drake.recording import Recording

BY_NAME = {cause.name: cause for cause in CAUSES}
TRUTH = {"m": 1.0, "k1": 20.0, "k2": 500.0, "b1": 60.0, "b2": 40.0, "Fc": 0.0, "normal_k": 500.0, "normal_b": 60.0}
TRUTH |= {"Fs": 0.0, "v_d": 0.0}
STROKE, HERTZ, DEPTH = 0.01, 2.0, 0.004


def strokes() -> Recording:
    """A hand that presses and strokes along y from time 0 on, beside an estimate that is right from the start."""
    time = 1e-3 * np.arange(2000)
    omega = 2.0 * np.pi * HERTZ
    columns = {f"{what}_{axis}": np.zeros(2000) for what in ("master_position", "master_velocity") for axis in "xyz"}
    columns |= {"master_position_y": STROKE * (1.0 - np.cos(omega * time)), "master_position_z": np.full(2000, -DEPTH)}
    columns |= {"master_velocity_y": STROKE * omega * np.sin(omega * time)}
    columns |= {f"theta_{name}": np.full(2000, TRUTH[name]) for name in THETA}
    columns |= {"theta_stable": np.ones(2000), "detected_contact": np.ones(2000)}
    return Recording(time, columns)


def rendered_with(name: str) -> np.ndarray:
    return replay_block(strokes(), station_blocks(BY_NAME[name].change(believed()))[-1])["rendered_force"]


def test_a_body_moved_by_position_only_damps_like_one_that_stands_still():
    recording = strokes()

    def rate(t: float, state: np.ndarray) -> list[float]:
        body, velocity = state
        stretch = STROKE * (1.0 - np.cos(2.0 * np.pi * HERTZ * t)) - body
        still = TRUTH["b2"] * (0.0 - velocity)
        force = TRUTH["k2"] * stretch + still - TRUTH["k1"] * body - TRUTH["b1"] * velocity
        return [velocity, force / TRUTH["m"]]

    solved = solve_ivp(rate, (0.0, 2.0), [0.0, 0.0], t_eval=recording.time, rtol=1e-9, atol=1e-12)
    stretch = recording["master_position_y"] - solved.y[0]
    expected = -(TRUTH["k2"] * stretch + TRUTH["b2"] * (0.0 - solved.y[1]))
    rendered = rendered_with("renderer's input without velocity")
    # It is put at the end of each step for all of it, half a step early.
    assert np.max(np.abs(rendered[1:, 1] - expected[1:])) < 1e-2 * np.max(np.abs(expected))
    assert rendered[:, 2] == pytest.approx(TRUTH["normal_k"] * DEPTH)


def test_a_late_input_gives_the_force_of_that_much_earlier_and_a_held_one_half_of_that():
    healthy = rendered_with("none")
    steps = round(1e3 * LATE_S)
    late = rendered_with("renderer's input 20 ms late")
    assert late[steps:, 1] == pytest.approx(healthy[:-steps, 1], abs=1e-9)
    held = rendered_with("renderer's input held for 20 ms")[:, 1]
    settled = held[1000:] - held[1000:].mean()  # whole periods
    lags = range(1, steps)
    likeness = [float(settled @ (healthy[1000 - k : 2000 - k, 1])) for k in lags]
    assert lags[int(np.argmax(likeness))] == pytest.approx(steps / 2, abs=1.5)


def test_the_estimated_object_is_the_latest_stable_estimate_without_what_pushes():
    recording = strokes()
    m, stable = np.linspace(1.0, 3.0, 2000), recording["theta_stable"].copy()
    stable[1500:] = 0.0
    columns = {"theta_m": m, "theta_stable": stable, "theta_k1": np.full(2000, -3.0), "theta_Fc": np.full(2000, 0.2)}
    recording = replace(recording, columns={**recording.columns, **columns})
    late, early = estimated_object(recording), estimated_object(recording, 0.5, absent=["Fc"])
    assert (late.parameters.m, early.parameters.m) == (m[1499], m[500])
    assert (late.parameters.k1, late.parameters.Fc, early.parameters.Fc) == (0.0, 0.2, 0.0)
    assert (late.normal.k, late.normal.b) == (500.0, 60.0)
    with pytest.raises(BadInput, match="no stable estimate"):
        estimated_object(recording, -1.0)


def test_runs_that_share_a_scenario_share_a_recording(tmp_path: Path):
    twice = (Cause("once", NO_BLOCK, unchanged), Cause("again", NO_BLOCK, unchanged))
    made = try_causes(tmp_path, twice, scenario=believed(7.0))
    assert len(list(tmp_path.iterdir())) == 1
    assert made[0].recording is made[1].recording
