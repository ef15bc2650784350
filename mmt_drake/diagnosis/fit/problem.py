"""Recordings made ready for fitting: tracks, held-out blocks, noise, and the fit of a hypothesis to them."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.tracks import COARSE, Track
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import attempt
from mmt_drake.model.parameters import NORMAL
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.least_squares import CONVERGED, Minimum, minimise, stay

SKEW_DEVIATION = 0.3
"""Two channels are read within a sample of each other; a skew is expected to deviate by this part of one."""
MOST_SKEW_S = 1e-3
"""The clocks of input and output may differ by a sample, but not by more than this [s]."""

BLOCK_S = 1.5
"""Length of the blocks over which errors are taken as independent [s] ..."""
LEAST_BLOCKS = 24
"""... at most this part of a recording."""
_SPLIT, _EVERY = 12, 3
"""A recording is split into so many blocks, of which every so manieth is held out."""
_QUIET = 0.05  # of what a fit leaves of the loudest track
_SETTLED = 1.5  # RMS of the residual over the noise floor


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
        """Residuals of all tracks over their noise, as they count: the sum of squares of pure noise is `samples`.

        Args:
            model: to replay.
            skew: of the output's clock [s].
            heldout: those of the held-out blocks instead of those that are fitted.
            coarse: instead of the problem's own.
        """
        coarse = self.coarse if coarse is None else coarse
        return np.concatenate([self._of(track, model, skew, heldout, coarse) for track in self.tracks])

    def _of(self, track: Track, model: Structure, skew: float, heldout: bool, coarse: float) -> Array:
        # What a verdict is built on must be fit to be simulated throughout; a search asks for what it looks at alone.
        simulated = track if coarse == 1.0 else track.part(heldout)
        residual = simulated.residual(model, skew, coarse)[track.compared(heldout)]
        return residual * (math.sqrt(share(track.smoothed)) * track.counts / track.floor)

    def samples(self, *, heldout: bool = False) -> float:
        """How many independent samples of noise the residuals are worth."""
        return math.fsum(share(t.smoothed) * np.count_nonzero(t.compared(heldout)) for t in self.tracks)

    def ratio(self, model: Structure, skew: float = 0.0, *, heldout: bool = False) -> float:
        """RMS of the residual over the noise floor, in the band compared: 1 where only noise is left."""
        r = self.residual(model, skew, heldout=heldout, coarse=1.0)
        return math.sqrt(float(r @ r) / self.samples(heldout=heldout))

    def ratios(self, residual: Array, *, heldout: bool = False) -> dict[str, float]:
        """Axis -> RMS of its residual over its noise floor; of all recordings together.

        Args:
            residual: of `residual` or `objective`.
            heldout: as of `residual`.
        """
        sums: dict[str, float] = {}
        samples: dict[str, float] = {}
        begin = 0
        for track in self.tracks:
            count = int(np.count_nonzero(track.compared(heldout)))
            own = residual[begin : begin + count]
            sums[track.axis] = sums.get(track.axis, 0.0) + float(own @ own)
            samples[track.axis] = samples.get(track.axis, 0.0) + share(track.smoothed) * count
            begin += count
        return {axis: math.sqrt(total / samples[axis]) for axis, total in sums.items() if samples[axis] > 0.0}

    def left(self, fitted: Fitted) -> float:
        """RMS of the residual of a fit over the noise, where it was fitted: of the axis that it leaves most of."""
        return max(self.ratios(fitted.minimum.residual).values())

    @property
    def unseen(self) -> tuple[str, ...]:
        """Parameters of the structure, and `effect.symbol` of effects, of which the recordings say nothing.

        Of a body that nothing drives only ratios can be told, as b/m of what falls: its mass stays as handed in.
        """
        axes = {track.axis for track in self.tracks}
        scale = () if any(track.tells_scale for track in self.tracks) else ("m",)
        hidden = (
            f"{effect.name}.{parameter.symbol}"
            for effect in LIBRARY.values()
            for parameter in effect.parameters
            if not set(parameter.seen_along) <= axes
        )
        return (*hidden, *scale, *(() if any(isinstance(track, NormalTrack) for track in self.tracks) else NORMAL))

    def by_recording(self) -> list[tuple[Track, ...]]:
        """The tracks of each recording, in their order."""
        return [tuple(tracks) for _, tracks in groupby(self.tracks, key=lambda track: id(track.smoothed))]

    def eased(self, fitted: Fitted) -> list[Problem]:
        """The one or two tracks, each alone, that a fit leaves most of; of these what is easiest (`Track.eased`).

        One that leaves next to nothing beside the other is none of them, nor a normal axis of which it leaves no more
        than noise, nor another axis where it leaves most of the normal one. A problem with nothing to leave out is its
        own only part.
        """

        def left(track: Track) -> float:
            r = self._of(track, fitted.model, fitted.skew, False, self.coarse)
            return float(r @ r)

        def is_settled(track: Track) -> bool:
            along = isinstance(track, NormalTrack) or isinstance(loudest, NormalTrack)
            return along and left(track) <= _SETTLED**2 * replace(self, tracks=(track,)).samples()

        if len(self.tracks) == 1 and self.tracks[0].eased() is self.tracks[0]:
            return [self]
        loudest = max(self.tracks, key=left)
        open_ones = [track for track in self.tracks if not is_settled(track)] or self.tracks
        first, *others = sorted(open_ones, key=left)[-1:-3:-1]
        chosen = [first, *(track for track in others if left(track) >= _QUIET * left(first))]
        return [replace(self, tracks=(track.eased(),)) for track in chosen]

    def cut(self, count: int) -> Problem | None:
        """The problem with each recording in so many windows (`Track.cut`); None where nothing is to be cut."""
        tracks = tuple(track.cut(count) for track in self.tracks)
        return None if all(map(operator.is_, tracks, self.tracks)) else replace(self, tracks=tracks)

    def fit(
        self,
        hypothesis: Hypothesis,
        start: Array,
        *,
        steps: int = 30,
        known: Array | None = None,
        converged_at: float = CONVERGED,
        secant: bool = False,
    ) -> Fitted:
        """Fit the free numbers of a hypothesis to the blocks that are not held out.

        Args:
            hypothesis: what is fitted.
            start: where to begin.
            steps: at most so many.
            known, converged_at, secant: see `minimise`.

        Raises:
            MmtError: the simulation diverges at the start.
        """
        residual, limits = partial(self.objective_at, hypothesis), hypothesis.limits(start)
        rough = hypothesis.rough(start)
        found = minimise(
            residual, start, *limits, steps=steps, known=known, converged_at=converged_at, secant=secant, rough=rough
        )
        return Fitted(hypothesis, found)

    def fits(
        self,
        starts: Iterable[tuple[Hypothesis, Array]],
        executor: Executor,
        *,
        steps: int,
        converged_at: float = CONVERGED,
        secant: bool = False,
    ) -> list[Fitted]:
        """`fit` from each start, in order, but for those that cannot be simulated."""

        def fitted(hypothesis: Hypothesis, x: Array) -> Fitted | None:
            return attempt(self.fit, hypothesis, x, steps=steps, converged_at=converged_at, secant=secant)

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

    @property
    def expected_skew(self) -> float:
        """Standard deviation of a skew that may be expected [s]: at most that of one anywhere within its bounds."""
        step = min(track.smoothed.clock.step for track in self.tracks)
        return min(SKEW_DEVIATION * step, MOST_SKEW_S / math.sqrt(3.0))

    def objective(self, model: Structure, skew: float) -> Array:
        """What a fit makes small: the residual and, behind it, the skew over what it may be expected to be."""
        return np.append(self.residual(model, skew), skew / self.expected_skew)

    def cost(self, hypothesis: Hypothesis, x: Array) -> float:
        """Sum of squares of the residual with these numbers; infinite where they cannot be simulated."""
        r = attempt(lambda: self.residual(hypothesis.model(x), hypothesis.skew_of(x)))
        return math.inf if r is None else float(r @ r)

    def blocks(self, *, heldout: bool = False) -> NDArray[np.intp]:
        """Number of the block that each residual belongs to, see `track_blocks`; those of all tracks are counted on."""
        numbers, first = [], 0
        for track in self.tracks:
            own = track_blocks(track)
            numbers.append(own[track.compared(heldout)] + first)
            first += int(own[-1]) + 1
        return np.concatenate(numbers)

    def touching(self, *, heldout: bool = False) -> Flags:
        """Which of the residuals were taken in contact."""
        return np.concatenate([track.smoothed.in_contact[track.compared(heldout)] for track in self.tracks])

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
    def structure_values(self) -> dict[str, float]:
        """The structural parameters found."""
        return self.hypothesis.structure_values(self.x)

    @property
    def effect_values(self) -> dict[str, dict[str, Any]]:
        """Effect, believed or added -> its parameters."""
        return self.hypothesis.effect_values(self.x)

    def numbers_for(self, hypothesis: Hypothesis, further: Mapping[str, Mapping[str, float]] | None = None) -> Array:
        """Where another hypothesis begins: with the numbers of this fit, and those of `further` effects."""
        return hypothesis.vector(self.structure_values, {**self.effect_values, **(further or {})}, self.skew)

    @cached_property
    def directions(self) -> Array:
        """(n, k) unit vectors across each other: where its numbers can take the residual."""
        return np.linalg.qr(self.minimum.jacobian)[0]

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
    longest = min(BLOCK_S, track.duration / LEAST_BLOCKS)
    pieces = np.maximum(np.ceil(seconds / longest), 1.0)
    stretch = np.searchsorted(edges, np.arange(len(track.time)), side="right")
    within = (track.time - track.time[starts[stretch]]) / np.maximum(seconds[stretch], 1e-300)
    own = np.minimum(within * pieces[stretch], pieces[stretch] - 1.0).astype(np.intp)
    return own + np.concatenate([[0], np.cumsum(pieces[:-1])]).astype(np.intp)[stretch]


def share(smoothed: Smoothed) -> float:
    """Independent samples of filtered white noise per sample of the clock of the fit."""
    gain = smoothed.low_pass.white_noise_gain(smoothed.clock.rate_hz)
    return min(1.0, gain**2 * smoothed.every)


def split(smoothed: Smoothed) -> Flags:
    """Which samples are held out: every third of twelve contiguous blocks of equal count of comparable samples."""
    usable = (smoothed.weight > 0.0) & smoothed.in_contact
    count = np.cumsum(usable)
    number = np.minimum(((count - 1).clip(0) * _SPLIT) // max(int(count[-1]), 1), _SPLIT - 1)
    flags: Flags = number % _EVERY == _EVERY - 1
    return flags
