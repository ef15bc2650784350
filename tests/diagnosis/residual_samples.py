"""Problems whose residual is known: recordings in the place of which a model's own output stands, and a shape."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from diagnosis_samples import MODEL, contact_recording

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.model.structure import Structure

PLAIN = Hypothesis(MODEL)
NOISE = 0.01

Shape = Callable[[Track], np.ndarray]


def strokes(seconds: float = 20.0, **how) -> Problem:
    """The box of `MODEL` under strokes along y, one track."""
    found = prepare([contact_recording(seconds, **how)], MODEL).problem
    assert found is not None and [track.axis for track in found.tracks] == ["y", "z"]
    return replace(found, tracks=found.tracks[:1])


def leaving(
    problem: Problem, shape: Shape | None = None, model: Structure = MODEL, noise: float = NOISE, seed: int = 1
) -> Problem:
    """The problem with what `model` gives as its measurement, white noise within the band and a shape (n,) on top."""
    rng, tracks = np.random.default_rng(seed), []
    for track in problem.tracks:
        s = track.smoothed
        white = s.low_pass.apply(rng.standard_normal(len(s.time) * s.every), s.clock.rate_hz, s.every)
        output = s.output.copy()
        output[:, track.column] = track.simulated(model, coarse=problem.coarse) + noise * white[: len(s.time)]
        if shape is not None:
            output[:, track.column] += shape(track)
        floor = NOISE * s.low_pass.white_noise_gain(s.clock.rate_hz)
        tracks.append(replace(track, smoothed=replace(s, output=output), floor=floor))
    return replace(problem, tracks=tuple(tracks))


def plain(problem: Problem) -> Fitted:
    """The model without anything, its numbers where they are."""
    return problem.at(PLAIN, PLAIN.base())
