"""What a fit says of the force sensor in free space, where nothing else acts."""

import math

import numpy as np

from mmt_drake.diagnosis.fit.problem import Fitted, Problem


def off_in_free_space(problem: Problem, fitted: Fitted) -> float:
    """By how many standard errors a fit misses the mean of the force in free space: the most of all tracks.

    Fitted and held-out samples count alike. 0 where there is no free space.

    Args:
        problem: the tracks.
        fitted: the fit.
    """
    most = 0.0
    for track in problem.tracks:
        s = track.smoothed
        free = s.free & (track.weight > 0.0)
        if s.rest is None or not free.any():
            continue
        white = s.rest.noise[track.column].std / math.sqrt(s.rest.seconds * s.clock.rate_hz)
        error = max(float(s.rest.standard_error[track.column]), white)
        mean = float(np.mean(track.residual(fitted.model, fitted.skew, problem.coarse)[free]))
        most = max(most, abs(mean) / error)
    return most
