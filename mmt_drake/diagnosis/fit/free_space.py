"""What a fit says of the force sensor in free space, where nothing else acts."""

import math
from typing import NamedTuple

import numpy as np

from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import Track

SURELY = 5.0
"""So many standard errors are no chance."""
_TAKEN, _MUCH = 0.2, 0.25
"""Effects take much where they take this part of all that they do. An offset is much that makes this part of the mean
square of what a refit leaves."""


class _Missed(NamedTuple):
    """What a fit leaves along a track: mean in free space and its standard error [N], and mean square of all [N^2]."""

    track: Track
    mean: float
    error: float
    square: float

    @property
    def is_off(self) -> bool:
        """Whether the mean is no chance."""
        return abs(self.mean) > SURELY * self.error


def off_in_free_space(problem: Problem, fitted: Fitted) -> float:
    """By how many standard errors a fit misses the mean of the force in free space: the most of all tracks.

    Fitted and held-out samples count alike. 0 where there is no free space.

    Args:
        problem: the tracks.
        fitted: the fit.
    """
    return max((abs(missed.mean) / missed.error for missed in _missed(problem, fitted)), default=0.0)


def leaves_an_offset(problem: Problem, refit: Fitted, fitted: Fitted) -> bool:
    """Whether a fit leaves an offset of the sensor that may as well be what it has effects for.

    Free space shows the offset along an axis where the effects take much, the fit misses it, and it is much of what a
    refit leaves there: what takes that in contact and not in free space is no physics of the contact.

    Args:
        problem: the tracks.
        refit: the fit without effects.
        fitted: the fit with them.
    """
    after = _missed(problem, fitted)
    if not any(missed.is_off for missed in after):
        return False
    before = _missed(problem, refit)
    taken = [(b.square - a.square) / a.track.floor**2 for b, a in zip(before, after, strict=True)]
    return any(
        a.is_off and own > _TAKEN * sum(taken) and a.mean**2 > _MUCH * b.square
        for b, a, own in zip(before, after, taken, strict=True)
    )


def _missed(problem: Problem, fitted: Fitted) -> list[_Missed]:
    """Of every track, one without free space with a mean of 0; nothing where there is no free space at all."""
    if all(track.smoothed.rest is None for track in problem.tracks):
        return []
    found = []
    for track in problem.tracks:
        s = track.smoothed
        used = track.weight > 0.0
        residual = track.residual(fitted.model, fitted.skew, problem.coarse)
        mean, error, free = 0.0, math.inf, s.free & used
        if s.rest is not None and free.any():
            white = s.rest.noise[track.column].std / math.sqrt(s.rest.seconds * s.clock.rate_hz)
            mean, error = float(np.mean(residual[free])), max(float(s.rest.standard_error[track.column]), white)
        found.append(_Missed(track, mean, error, float(np.mean(residual[used] ** 2))))
    return found
