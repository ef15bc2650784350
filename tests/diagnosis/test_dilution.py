"""Noise of the input draws a damper towards less: what is delivered is free of that, and of nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from trial_samples import BASE, beside, model, problem_of, recorded

from mmt_drake.diagnosis.diagnose import diagnose
from mmt_drake.diagnosis.fit.dilution import undiluted
from mmt_drake.diagnosis.fit.floors import noisier
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.recording import Recording
from mmt_drake.recording.check import completed

POSITION_NOISE = 2e-5


def noisy(recording: Recording, size: float, seed: int = 0) -> Recording:
    """The recording, its positions as a worse sensor reads them, and no velocity but theirs."""
    generator = np.random.default_rng(seed)
    columns = {name: values for name, values in recording.columns.items() if not name.startswith("velocity")}
    for name in (f"position_{axis}" for axis in "xyz"):
        columns[name] = columns[name] + size * generator.standard_normal(len(recording.time))
    return completed(recording.time, columns, "noisy")


def fitted_to(recording: Recording) -> tuple[Problem, Fitted]:
    problem, hypothesis = problem_of(recording, model()), beside()
    return problem, problem.fit(hypothesis, hypothesis.base())


def test_a_damper_that_noise_has_weakened_is_as_strong_as_with_a_fifth_of_the_noise() -> None:
    """Against the same recordings with the noise that they have anyhow: over many draws the mean difference goes."""
    moved = []
    for seed in range(6):
        recording = recorded(seed=seed, seconds=12.0)
        found = [fitted_to(noisy(recording, size, seed)) for size in (0.0, POSITION_NOISE)]
        quiet, loud = ((fitted, undiluted(problem, fitted)) for problem, fitted in found)
        pairs = zip(quiet, loud, strict=True)
        moved.append([b.structure_values["b2"] / a.structure_values["b2"] - 1.0 for a, b in pairs])
    before, after = np.mean(moved, axis=0)
    assert before < -0.008 and abs(after) < 0.3 * abs(before)


@pytest.mark.parametrize("has_velocity", [True, False])
def test_noise_that_is_added_is_that_of_the_smoother(has_velocity: bool) -> None:
    """Its rate is made as large as the smoother says; its position comes out as large as the smoother's taps say."""
    recording = recorded(seed=2, seconds=20.0)
    problem, _ = fitted_to(recording if has_velocity else noisy(recording, 0.0))
    track = problem.tracks[0]
    own, more = track.smoothed, noisier(track, np.random.default_rng(7)).smoothed
    assert own.uses_velocity is has_velocity
    for axis in range(3):
        moving = own.input_rate[:, axis] != 0.0  # a standstill has no noise left
        x, u = (more.input - own.input)[:, axis], (more.input_rate - own.input_rate)[:, axis]
        assert np.std(u[moving]) == pytest.approx(own.input_rate_noise[axis], rel=0.02)
        assert np.std(x[moving]) == pytest.approx(own.input_noise[axis], rel=0.1)
        # Below the crossover the position is the better source: a steady speed has next to no noise.
        density = np.abs(np.fft.rfft(u))
        assert density[1:11].mean() < 0.2 * density[100:300].mean()


def test_a_fit_of_an_input_without_noise_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    problem, fitted = fitted_to(recorded(seed=3, seconds=10.0))
    smoothed = [replace(t.smoothed, input_rate_noise=0.0 * t.smoothed.input_rate_noise) for t in problem.tracks]
    tracks = tuple(replace(t, smoothed=s) for t, s in zip(problem.tracks, smoothed, strict=True))
    assert undiluted(replace(problem, tracks=tracks), fitted) is fitted


def test_where_noise_decides_what_sticks_nothing_is_taken_out() -> None:
    recording = recorded(("static_friction", (("Fd", 0.3), ("Fs", 2.0), ("v_d", 0.01))), seed=4)
    problem, hypothesis = problem_of(recording, model()), beside("static_friction")
    start = hypothesis.vector({}, {"static_friction": {"Fd": 0.3, "Fs": 2.0, "v_d": 0.01}})
    fitted = problem.fit(hypothesis, start)
    assert undiluted(problem, fitted) is fitted


def test_what_noise_did_to_a_damper_is_no_wrong_parameter_and_numbers_handed_in_stay() -> None:
    outcome = diagnose([noisy(recorded(seed=1, seconds=12.0), POSITION_NOISE)], model(), library=[])
    assert outcome.diagnosis.verdict == "no_mismatch" and not outcome.diagnosis.parameters
    assert outcome.best is not None and outcome.best.structure_values["b2"] == BASE["b2"]


def test_a_damper_that_is_wrong_is_told_as_strong_as_it_is() -> None:
    said = diagnose([noisy(recorded(seed=1, seconds=12.0), 5e-6)], model(b2=23.0), library=[]).diagnosis
    assert said.verdict == "parameters" and set(said.parameters) == {"b2"}
    low, high = said.parameters["b2"].ci95
    assert low <= BASE["b2"] <= high
