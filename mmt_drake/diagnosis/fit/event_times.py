"""Times of what happens once, and the data that are left to be held out."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.numeric.arrays import Array

_AS_WELL = 4.0
"""An event may as well be where the cost is no more than that from its own: two standard deviations of its time."""
_COARSELY, _FINELY = 60, 10
"""At how many times in the recording, and then between the best one and its neighbours, it is tried."""


def at_best_times(problem: Problem, hypothesis: Hypothesis, x: Array) -> Array:
    """The numbers with each event time where it explains most, all others as they were.

    A search that walks downhill sees an event time from near by only: it is tried all over the recording instead.
    """
    first = min(float(track.time[0]) for track in problem.tracks)
    duration = max(float(track.time[-1]) for track in problem.tracks) - first
    for i in event_times(hypothesis):
        apart = duration / (_COARSELY + 1)
        x = _best(problem, hypothesis, x, i, [apart * k for k in range(1, _COARSELY + 1)])
        x = _best(problem, hypothesis, x, i, [x[i] + apart * k / _FINELY for k in range(1 - _FINELY, _FINELY)])
    return x


def released(problem: Problem, fits: Iterable[Fitted]) -> Problem:
    """The problem with what is held out around an event given to what is fitted, if other data are still held out.

    Where something happens once in a stretch that nothing was fitted to, or may as well have happened in that as just
    beside it, nothing else tells when: the fit cannot foresee it, and the stretch cannot be held against it.

    Args:
        problem: as it was searched.
        fits: which may have events.
    """
    times = [time for f in fits for i in event_times(f.hypothesis) for time in _possible(problem, f, i)]
    tracks = tuple(_released(track, times) for track in problem.tracks)
    if all(a is b for a, b in zip(tracks, problem.tracks, strict=True)):
        return problem
    return replace(problem, tracks=tracks)


def _possible(problem: Problem, fitted: Fitted, i: int) -> list[float]:
    """The event time at `i`, and one in each stretch next to it that is held out, where that costs hardly more."""
    own = float(fitted.x[i])
    middles: dict[float, None] = {}
    for track in problem.tracks:
        edges, stretch = _stretch(track, own)
        for beside in (stretch - 1, stretch + 1):
            if 0 <= beside < len(edges) - 1 and track.heldout[edges[beside]]:
                middles[float(track.time[(edges[beside] + edges[beside + 1]) // 2] - track.time[0])] = None
    here = problem.cost(fitted.hypothesis, fitted.x) if middles else 0.0

    def may_be(time: float) -> bool:
        cost = problem.cost(fitted.hypothesis, np.array([*fitted.x[:i], time, *fitted.x[i + 1 :]]))
        return abs(cost - here) <= _AS_WELL

    return [own, *filter(may_be, middles)]


def _stretch(track: Track, time: float) -> tuple[NDArray[np.intp], int]:
    """Where stretches that are held out and such that are not begin and end, and in which a time is."""
    edges = np.concatenate([[0], np.flatnonzero(np.diff(track.heldout)) + 1, [len(track.heldout)]])
    at = int(np.searchsorted(track.time - track.time[0], time))
    return edges, int(np.searchsorted(edges, at, side="right")) - 1


def _released(track: Track, times: Iterable[float]) -> Track:
    heldout = track.heldout.copy()
    for time in times:
        edges, stretch = _stretch(track, time)
        if 0 <= stretch < len(edges) - 1:
            heldout[edges[stretch] : edges[stretch + 1]] = False
    if not np.any(heldout & (track.weight > 0.0)) or np.array_equal(heldout, track.heldout):
        return track
    return replace(track, heldout=heldout)


def event_times(hypothesis: Hypothesis) -> list[int]:
    """Which of the free numbers are event times."""
    times = {(effect.name, p.symbol) for effect in hypothesis.effects for p in effect.parameters if p.moment}
    return [i for i, parameter in enumerate(hypothesis.free_parameters()) if parameter.key in times]


def _best(problem: Problem, hypothesis: Hypothesis, x: Array, i: int, times: Sequence[float]) -> Array:
    """The numbers with the one at `i` as it is or at one of these times, whichever fits best."""
    tries = [x, *(np.array([*x[:i], time, *x[i + 1 :]]) for time in times if time > 0.0)]
    return min(tries, key=lambda moved: problem.cost(hypothesis, moved))
