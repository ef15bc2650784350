"""Recordings made ready for fitting: tracks, held-out blocks, noise, and the fit of a hypothesis to them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.tracks import COARSE, DrivenTrack, Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.errors import attempt
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.least_squares import CONVERGED, Minimum, minimise, stay

SKEW_DEVIATION = 0.3
"""Two channels are read within a sample of each other; a skew is expected to deviate by this part of one."""

LEAST_NOISE = 1e-4
"""No model is held to more than this part of what was measured, however little noise there is; of a closed loop, which
brings the body to its goal whatever the model is, of how far it stays from that."""

BLOCK_S = 1.5
"""Length of the blocks over which errors are taken as independent [s] ..."""
LEAST_BLOCKS = 24
"""... at most this part of a recording."""


@dataclass(frozen=True)
class Problem:
    """What hypotheses are fitted to.

    Attributes:
        tracks: the outputs that moved, of all recordings.
        coarse: integration step over the accurate one, see `tracks.COARSE`.
    """

    tracks: tuple[Track, ...]
    coarse: float = COARSE

    def residual(
        self, model: Structure, skew: float = 0.0, *, heldout: bool = False, coarse: float | None = None
    ) -> Array:
        """Residuals of all tracks over their noise, so that the sum of squares of pure noise is `samples`.

        Args:
            model: to replay.
            skew: of the output's clock [s].
            heldout: those of the held-out blocks instead of those that are fitted.
            coarse: instead of the problem's own.
        """
        coarse = self.coarse if coarse is None else coarse
        return np.concatenate([self._of(track, model, skew, heldout, coarse) for track in self.tracks])

    def _of(self, track: Track, model: Structure, skew: float, heldout: bool, coarse: float) -> Array:
        chosen = (track.heldout == heldout) & (track.weight > 0.0)
        return track.residual(model, skew, coarse)[chosen] * (math.sqrt(share(track.smoothed)) / track.floor)

    def samples(self, *, heldout: bool = False) -> float:
        """How many independent samples of noise the residuals are worth."""
        return math.fsum(
            share(t.smoothed) * np.count_nonzero((t.heldout == heldout) & (t.weight > 0.0)) for t in self.tracks
        )

    def ratio(self, model: Structure, skew: float = 0.0, *, heldout: bool = False) -> float:
        """RMS of the residual over the noise floor, in the band compared: 1 where only noise is left."""
        r = self.residual(model, skew, heldout=heldout, coarse=1.0)
        return math.sqrt(float(r @ r) / self.samples(heldout=heldout))

    def left(self, fitted: Fitted) -> float:
        """RMS of the residual of a fit over the noise, where it was fitted."""
        return math.sqrt(fitted.cost / self.samples())

    def by_recording(self) -> list[tuple[Track, ...]]:
        """The tracks of each recording, in their order."""
        return [tuple(tracks) for _, tracks in groupby(self.tracks, key=lambda track: id(track.smoothed))]

    def eased(self, fitted: Fitted) -> list[Problem]:
        """The one or two tracks, each alone, that a fit leaves most of; of these what is easiest (`Track.eased`).

        A problem with nothing to leave out is its own only part.
        """

        def left(track: Track) -> float:
            r = self._of(track, fitted.model, fitted.skew, False, self.coarse)
            return float(r @ r)

        if len(self.tracks) == 1 and self.tracks[0].eased() is self.tracks[0]:
            return [self]
        return [replace(self, tracks=(track.eased(),)) for track in sorted(self.tracks, key=left)[-1:-3:-1]]

    def fit(
        self,
        hypothesis: Hypothesis,
        start: Array,
        *,
        steps: int = 30,
        known: Array | None = None,
        converged_at: float = CONVERGED,
    ) -> Fitted:
        """Fit the free numbers of a hypothesis to the blocks that are not held out.

        Args:
            hypothesis: what is fitted.
            start: where to begin.
            steps: at most so many Jacobians.
            known, converged_at: see `minimise`.

        Raises:
            MmtError: the simulation diverges at the start.
        """
        residual, limits = partial(self.objective_at, hypothesis), hypothesis.limits(start)
        found = minimise(residual, start, *limits, steps=steps, known=known, converged_at=converged_at)
        return Fitted(hypothesis, found)

    def fits(
        self,
        starts: Iterable[tuple[Hypothesis, Array]],
        executor: Executor,
        *,
        steps: int,
        converged_at: float = CONVERGED,
    ) -> list[Fitted]:
        """`fit` from each start, in order, but for those that cannot be simulated."""

        def fitted(hypothesis: Hypothesis, x: Array) -> Fitted | None:
            return attempt(self.fit, hypothesis, x, steps=steps, converged_at=converged_at)

        return [f for f in executor.map(fitted, *zip(*starts, strict=True)) if f is not None]

    def at(self, hypothesis: Hypothesis, x: Array) -> Fitted:
        """A hypothesis with given numbers, and the derivatives there.

        Raises:
            MmtError: the simulation diverges.
        """
        return Fitted(hypothesis, stay(partial(self.objective_at, hypothesis), x, *hypothesis.limits(x)))

    def unchanged(self, hypothesis: Hypothesis, x: Array) -> Fitted:
        """A hypothesis with given numbers and no derivatives: to compare, not to fit on.

        Raises:
            MmtError: the simulation diverges.
        """
        return self.fit(hypothesis, x, steps=0)

    def skew_alone(self, hypothesis: Hypothesis, x: Array) -> Array:
        """The numbers with the skew of the clocks fitted and nothing else."""

        def shifted(skew: Array) -> Array:
            return self.objective_at(hypothesis, np.array([*x[:-1], skew[0]]))

        found = minimise(shifted, x[-1:], *(limit[-1:] for limit in hypothesis.limits(x)))
        return np.array([*x[:-1], found.x[0]])

    def objective_at(self, hypothesis: Hypothesis, x: Array) -> Array:
        """`objective` with the numbers of a hypothesis."""
        return self.objective(hypothesis.model(x), hypothesis.skew_of(x))

    def objective(self, model: Structure, skew: float) -> Array:
        """What a fit makes small: the residual and, behind it, the skew over what it may be expected to be."""
        expected = SKEW_DEVIATION * min(track.smoothed.clock.step for track in self.tracks)
        return np.append(self.residual(model, skew), skew / expected)

    def cost(self, hypothesis: Hypothesis, x: Array) -> float:
        """Sum of squares of the residual with these numbers; infinite where they cannot be simulated."""
        r = attempt(lambda: self.residual(hypothesis.model(x), hypothesis.skew_of(x)))
        return math.inf if r is None else float(r @ r)

    def blocks(self, *, heldout: bool = False) -> NDArray[np.intp]:
        """Number of the block that each residual belongs to, see `track_blocks`; those of all tracks are counted on."""
        numbers, first = [], 0
        for track in self.tracks:
            own = track_blocks(track)
            numbers.append(own[(track.heldout == heldout) & (track.weight > 0.0)] + first)
            first += int(own[-1]) + 1
        return np.concatenate(numbers)

    def touching(self, *, heldout: bool = False) -> Flags:
        """Which of the residuals were taken in contact."""
        parts = [t.smoothed.in_contact[(t.heldout == heldout) & (t.weight > 0.0)] for t in self.tracks]
        return np.concatenate(parts)

    def objective_blocks(self) -> NDArray[np.intp]:
        """Number of the block that each element of `objective` belongs to; the skew is one of its own."""
        numbers = self.blocks()
        return np.append(numbers, numbers.max() + 1)


@dataclass(frozen=True)
class Fitted:
    """A hypothesis with its numbers found.

    Attributes:
        hypothesis: what was fitted.
        minimum: where the fit ended.
    """

    hypothesis: Hypothesis
    minimum: Minimum

    @property
    def x(self) -> Array:
        """The numbers."""
        return self.minimum.x

    @property
    def cost(self) -> float:
        """Sum of squares over the noise."""
        return self.minimum.cost

    @property
    def model(self) -> Structure:
        """The model with the numbers found."""
        return self.hypothesis.model(self.minimum.x)

    @property
    def skew(self) -> float:
        """How much later the output's clock reads than the input's [s]."""
        return self.hypothesis.skew_of(self.minimum.x)

    @property
    def late(self) -> float:
        """By how much the input of a driven body is late in it [s]: with another it may be beyond integration."""
        return self.model.additions.delay + self.skew


def track_blocks(track: Track) -> NDArray[np.intp]:
    """Number of the block (n,) that each sample of a track belongs to, from 0 on.

    A block is at most BLOCK_S long, shorter in a short recording, and never goes beyond a stretch that is held out, or
    one that is fitted.
    """
    edges = np.flatnonzero(np.diff(track.heldout)) + 1
    starts = np.concatenate([[0], edges])
    seconds = np.diff(np.append(track.time[starts], track.time[-1]))
    longest = min(BLOCK_S, float(track.time[-1] - track.time[0]) / LEAST_BLOCKS)
    pieces = np.maximum(np.ceil(seconds / longest), 1.0)
    stretch = np.searchsorted(edges, np.arange(len(track.time)), side="right")
    within = (track.time - track.time[starts[stretch]]) / np.maximum(seconds[stretch], 1e-300)
    own = np.minimum(within * pieces[stretch], pieces[stretch] - 1.0).astype(np.intp)
    return own + np.concatenate([[0], np.cumsum(pieces[:-1])]).astype(np.intp)[stretch]


def share(smoothed: Smoothed) -> float:
    """Independent samples of filtered white noise per sample of the clock of the fit."""
    gain = smoothed.low_pass.white_noise_gain(smoothed.clock.rate_hz)
    return min(1.0, gain**2 * smoothed.every)


def split(smoothed: Smoothed, blocks: int = 12, every: int = 3) -> Flags:
    """Which samples are held out: every so manieth of contiguous blocks of equal count of comparable samples.

    Args:
        smoothed: the recording.
        blocks: how many.
        every: the last of every so many blocks is held out.
    """
    usable = (smoothed.weight > 0.0) & smoothed.in_contact
    count = np.cumsum(usable)
    number = np.minimum(((count - 1).clip(0) * blocks) // max(int(count[-1]), 1), blocks - 1)
    flags: Flags = number % every == every - 1
    return flags


def with_floors(tracks: Sequence[Track], model: Structure, seed: int = 0) -> tuple[Track, ...]:
    """The tracks with the noise that a model leaves of perfect data: the output's own, and the input's through it.

    Noise of the input's position and rate, white within the band, is sent through the model beside the input.
    """
    generator = np.random.default_rng(seed)
    result = []
    for track in tracks:
        own, through = float(track.smoothed.output_noise[track.column]), noise_through(track, model, generator)
        told = track.measured
        if isinstance(model, DrivenBodyModel) and model.controller is not None:
            told = told - track.smoothed.input[:, 0]
        least = LEAST_NOISE * float(np.std(told[track.weight > 0.0]))
        result.append(replace(track, floor=max(math.hypot(own, through), least)))
    return tuple(result)


def noise_through(track: Track, model: Structure, generator: np.random.Generator) -> float:
    """RMS of what the noise of the input, and of what states are fitted to, adds to the simulated output.

    Raises:
        MmtError: a simulation diverges.
    """
    noisier = _noisier(track, generator)
    if noisier is track:
        return 0.0
    difference = (noisier.simulated(model) - track.simulated(model)) * track.weight
    return math.sqrt(float(difference @ difference) / max(int(np.count_nonzero(track.weight)), 1))


def _noisier(track: Track, generator: np.random.Generator) -> Track:
    """The track with as much noise again on its input and on what states are fitted to; itself where neither is."""
    s = track.smoothed
    if not isinstance(track, DrivenTrack):
        return replace(track, smoothed=_noisier_input(s, generator)) if s.input_rate_noise.any() else track
    if not s.input_noise.any() and track.windows.at_rest:
        return track
    white, own = generator.standard_normal((2, len(s.time), 1))
    smeared = s.low_pass.apply(own, s.rate_hz)
    size = s.output_noise[0] / max(float(smeared.std()), 1e-300)
    columns = {"input": s.input + s.input_noise * white, "output": s.output + size * smeared}
    return replace(track, smoothed=replace(s, **columns, nearby=s.nearby + size * own))


def _noisier_input(smoothed: Smoothed, generator: np.random.Generator) -> Smoothed:
    """The recording with as much noise again on its smoothed input."""
    rate = smoothed.rate_hz
    shape = smoothed.input.shape
    white = generator.standard_normal(shape)
    smooth_noise = smoothed.low_pass.apply(white, rate)
    smooth_noise /= np.maximum(smooth_noise.std(axis=0), 1e-300)
    u = smooth_noise * smoothed.input_rate_noise
    # Position and rate belong to each other; below the corner the position's own noise holds the integral back.
    corner = np.divide(
        smoothed.input_rate_noise, smoothed.input_noise, out=np.zeros(shape[1]), where=smoothed.input_noise > 0.0
    )
    x = np.zeros(shape)
    decay = np.exp(-np.minimum(corner, rate) / rate)
    for i, a in enumerate(decay.tolist()):
        x[:, i] = lfilter([1.0 / rate], [1.0, -a], u[:, i])
    moving = smoothed.input_rate != 0.0  # a standstill has no noise left
    return replace(smoothed, input=smoothed.input + x * moving, input_rate=smoothed.input_rate + u * moving)
