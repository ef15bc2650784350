"""The noise floor of a track: what the noise of the sensors leaves of perfect data, given a model."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import fft

from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import DrivenTrack, Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import attempt
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.zero_phase import LowPass

LEAST_NOISE = 1e-4
"""No model is held to more than this part of what was measured, however little noise there is; of a closed loop, which
brings the body to its goal whatever the model is, of how far it stays from that."""

_MUCH_MORE = 2.0
"""So many times the variance that a floor allows for is more of the input's noise than a law without events lets
through."""


def with_floors(tracks: Sequence[Track], model: Structure) -> tuple[Track, ...]:
    """The tracks with the noise that a model leaves of perfect data: the output's own, and the input's through it.

    Noise of the input's position and rate, white within the band, is sent through the model beside the input. What it
    and the states of windows add is one draw a window, so by chance it may be more: a deviation of that is allowed for.
    """
    generator = np.random.default_rng(0)
    result = []
    for track in tracks:
        own, through = float(track.smoothed.output_noise[track.column]), noise_through(track, model, generator)
        told = track.measured
        if isinstance(model, DrivenBodyModel) and model.controller is not None:
            told = told - track.smoothed.input[:, 0]
        least = LEAST_NOISE * float(np.std(told[track.weight > 0.0]))
        if isinstance(track, DrivenTrack):
            through *= 1.0 + math.sqrt(2.0 / max(track.windows.count, 2))
        result.append(replace(track, floor=max(math.hypot(own, through), least)))
    return tuple(result)


def weighed(problem: Problem, fitted: Fitted) -> Problem:
    """A problem whose recordings count as what a fit leaves of each says: to a fit that is noise, too.

    By their own noise alone, a machine's slowest recording would outweigh all others where its friction sticks and
    slips as no law has it. Where the fit leaves noise alone they count as they did. Errors beyond all that was measured
    are numbers that are wrong, no noise.
    """

    def left(tracks: tuple[Track, ...]) -> tuple[float, float]:
        alone = Problem(tuple(replace(track, counts=1.0) for track in tracks), problem.coarse)
        samples, r = alone.samples(), alone.residual(fitted.model, fitted.skew)
        strongest = max(float(np.std(track.measured)) / track.floor for track in tracks)
        return samples, max(min(float(r @ r), samples * strongest**2), samples)

    if len(recordings := problem.by_recording()) == 1:
        return problem
    told = [left(tracks) for tracks in recordings]
    of_all = math.fsum(n for n, _ in told) / math.fsum(n * n / squares for n, squares in told)
    counts = [math.sqrt(of_all * n / squares) for n, squares in told]
    pairs = zip(recordings, counts, strict=True)
    return replace(problem, tracks=tuple(replace(track, counts=c) for tracks, c in pairs for track in tracks))


def noise_kept_out(problem: Problem, fits: Sequence[Fitted]) -> list[float]:
    """By how much less each fit leaves than others because its model lets less of the input's noise through.

    A sum of squares over the noise, 0 or more, against the one that lets most through of those with the same friction.
    A filter that is not there leaves less of noisy data than the right model does. Where bodies stick and slip noise
    moves the slips, and one friction is not held to what another one does then; nor is any to what lets through much
    more than the floor allows for.

    Args:
        problem: what was fitted.
        fits: of the same problem.
    """
    kept_out = np.zeros(len(fits))
    rubbing = [frozenset(e.name for e in fit.hypothesis.effects if e.target == "Fc") for fit in fits]
    alike = np.array([[one == other for other in rubbing] for one in rubbing])
    for track in problem.tracks:
        allowed = _MUCH_MORE * max(track.floor**2 - float(track.smoothed.output_noise[track.column]) ** 2, 0.0)
        noisy = noisier(track, np.random.default_rng(0))
        through = (attempt(_apart, track, noisy, fit.model) for fit in fits)
        squares = np.array([allowed if rms is None else min(rms**2, allowed) for rms in through])
        most = np.where(alike & (squares < allowed), squares, 0.0).max(axis=1)
        worth = track.counts**2 * replace(problem, tracks=(track,)).samples() / track.floor**2
        kept_out += worth * np.maximum(most - squares, 0.0)
    return kept_out.tolist()


def noise_through(track: Track, model: Structure, generator: np.random.Generator) -> float:
    """RMS of what the noise of the input, and of what states are fitted to, adds to the simulated output.

    Raises:
        MmtError: a simulation diverges.
    """
    return _apart(track, noisier(track, generator), model)


def _apart(track: Track, noisy: Track, model: Structure) -> float:
    """RMS by which a model's output differs between a track and one with more noise; raises as `noise_through`."""
    if noisy is track:
        return 0.0
    difference = (noisy.simulated(model) - track.simulated(model)) * track.weight
    return math.sqrt(float(difference @ difference) / max(int(np.count_nonzero(track.weight)), 1))


def noisier(track: Track, generator: np.random.Generator, sign: float = 1.0) -> Track:
    """The track with as much noise again on its input and on what states are fitted to; itself where neither is."""
    s = track.smoothed
    if not isinstance(track, DrivenTrack):
        return replace(track, smoothed=_noisier_input(s, generator, sign)) if s.input_rate_noise.any() else track
    if not s.input_noise.any() and track.windows.at_rest:
        return track
    white, own = sign * generator.standard_normal((2, len(s.time), 1))
    smeared = s.low_pass.apply(own, s.rate_hz)
    if not s.input_filter.is_identity:
        white = s.input_filter.apply(white, s.rate_hz)
        white /= white.std()
    size = s.output_noise[0] / max(float(smeared.std()), 1e-300)
    columns = {"input": s.input + s.input_noise * white, "output": s.output + size * smeared}
    return replace(track, smoothed=replace(s, **columns, nearby=s.nearby + size * own))


def _noisier_input(smoothed: Smoothed, generator: np.random.Generator, sign: float) -> Smoothed:
    """The recording with as much noise again on its smoothed input.

    As `Fusion` leaves it of white noise on both columns: that of the position has a density in proportion to
    1 / (a^2 + w^2), within the band, and that of its rate is the derivative of it.
    """
    n, crossover, rate_hz = len(smoothed.time), smoothed.input_crossover, smoothed.clock.rate_hz
    white = sign * generator.standard_normal((n * smoothed.every, len(crossover)))
    pairs = zip(white.T, smoothed.input_band_hz, strict=True)
    within = np.column_stack([LowPass(float(band)).apply(own, rate_hz, smoothed.every) for own, band in pairs])
    spectrum = fft.rfft(within, axis=0)
    w = 2.0 * np.pi * fft.rfftfreq(n, 1.0 / smoothed.rate_hz)[:, np.newaxis]
    spectrum = spectrum / np.where(np.isfinite(crossover), np.hypot(crossover, w), 1.0)
    x, u = (fft.irfft(own, n, axis=0) for own in (spectrum, 1j * w * spectrum))
    moving = smoothed.input_rate != 0.0  # a standstill has no noise left
    size = smoothed.input_rate_noise / np.maximum(u.std(axis=0), 1e-300) * moving
    return replace(smoothed, input=smoothed.input + size * x, input_rate=smoothed.input_rate + size * u)
