"""What a fit says of the force sensor in free space, where nothing else acts."""

import math
from collections.abc import Iterator
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
    """Mean of what a fit leaves of the force in free space, along one track, and its standard error [N]."""

    track: Track
    mean: float
    error: float


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
    missed = {id(one.track): one for one in _missed(problem, fitted)}
    if not any(abs(one.mean) > SURELY * one.error for one in missed.values()):
        return False
    before, after = (
        [float(np.mean(t.residual(f.model, f.skew, problem.coarse)[t.weight > 0.0] ** 2)) for t in problem.tracks]
        for f in (refit, fitted)
    )
    taken = [(b - a) / t.floor**2 for b, a, t in zip(before, after, problem.tracks, strict=True)]
    return any(
        (one := missed.get(id(track))) is not None
        and abs(one.mean) > SURELY * one.error
        and own > _TAKEN * sum(taken)
        and one.mean**2 > _MUCH * left
        for track, own, left in zip(problem.tracks, taken, before, strict=True)
    )


def _missed(problem: Problem, fitted: Fitted) -> Iterator[_Missed]:
    for track in problem.tracks:
        s = track.smoothed
        free = s.free & (track.weight > 0.0)
        if s.rest is None or not free.any():
            continue
        white = s.rest.noise[track.column].std / math.sqrt(s.rest.seconds * s.clock.rate_hz)
        error = max(float(s.rest.standard_error[track.column]), white)
        mean = float(np.mean(track.residual(fitted.model, fitted.skew, problem.coarse)[free]))
        yield _Missed(track, mean, error)
