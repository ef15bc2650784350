"""What happens once: when it did, and which data are left to be held out."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.errors import MmtError

Array = NDArray[np.float64]

_COARSELY, _FINELY = 60, 10
"""At how many moments of the recording, and then between the best one and its neighbours, it is tried."""


def placed(problem: Problem, hypothesis: Hypothesis, x: Array) -> Array:
    """The numbers with each moment where it explains most, all others as they were.

    A search that walks downhill sees a moment from near by only: it is tried all over the recording instead.
    """
    first = min(float(track.time[0]) for track in problem.tracks)
    duration = max(float(track.time[-1]) for track in problem.tracks) - first
    for i in _moments(hypothesis):
        apart = duration / (_COARSELY + 1)
        x = _best(problem, hypothesis, x, i, [apart * k for k in range(1, _COARSELY + 1)])
        x = _best(problem, hypothesis, x, i, [x[i] + apart * k / _FINELY for k in range(1 - _FINELY, _FINELY)])
    return x


def released(problem: Problem, fits: Iterable[Fitted]) -> Problem:
    """The problem with what is held out around a moment given to what is fitted, if other data are still held out.

    Where something happens once in a stretch that nothing was fitted to, nothing else tells when: the fit cannot
    foresee it, and the stretch cannot be held against it.

    Args:
        problem: as it was searched.
        fits: which may have moments.
    """
    moments = [float(f.x[i]) for f in fits for i in _moments(f.hypothesis)]
    tracks = tuple(_released(track, moments) for track in problem.tracks)
    if all(a is b for a, b in zip(tracks, problem.tracks, strict=True)):
        return problem
    return replace(problem, tracks=tracks)


def _released(track: Track, moments: Iterable[float]) -> Track:
    heldout = track.heldout.copy()
    edges = np.concatenate([[0], np.flatnonzero(np.diff(track.heldout)) + 1, [len(heldout)]])
    for moment in moments:
        at = int(np.searchsorted(track.time - track.time[0], moment))
        stretch = int(np.searchsorted(edges, at, side="right")) - 1
        if 0 <= stretch < len(edges) - 1:
            heldout[edges[stretch] : edges[stretch + 1]] = False
    if not np.any(heldout & (track.weight > 0.0)) or np.array_equal(heldout, track.heldout):
        return track
    return replace(track, heldout=heldout)


def _moments(hypothesis: Hypothesis) -> list[int]:
    """Which of the free numbers are moments."""
    moments = {(effect.name, p.symbol) for effect in hypothesis.effects for p in effect.parameters if p.moment}
    return [i for i, place in enumerate(hypothesis.free_parameters()) if (place.effect, place.symbol) in moments]


def _best(problem: Problem, hypothesis: Hypothesis, x: Array, i: int, moments: Sequence[float]) -> Array:
    """The numbers with the one at `i` as it is or at one of these moments, whichever fits best."""
    best, least = x, math.inf
    for moment in (float(x[i]), *(m for m in moments if m > 0.0)):
        moved = x.copy()
        moved[i] = moment
        try:
            r = problem.residual(hypothesis.model(moved), hypothesis.skew_of(moved))
        except MmtError:
            continue
        if float(r @ r) < least:
            best, least = moved, float(r @ r)
    return best
