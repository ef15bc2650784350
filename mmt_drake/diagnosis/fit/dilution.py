"""Regression dilution: what noise of the input has done to the numbers of a fit, and the fit without it.

Least squares takes the input for exact. Noise of a measured velocity is in a damper's force and in its derivative
alike, and draws the damper towards less; what goes with the damper follows.
"""

import operator
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.fit.floors import noisier
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

_DEAREST = 1.1
"""The numbers without it cost at most this many times as much: more is a step over events, no dilution."""
_RANK = 1e-9


def undiluted(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit with the numbers that it would have if its input had no noise; itself where that cannot be said.

    As much noise again moves the numbers by as much again (Cook and Stefanski 1994, Journal of the American Statistical
    Association 89: simulation and extrapolation). What it does by chance cancels between the same noise of either sign.

    Args:
        problem: what was fitted.
        fitted: the fit, where it ended.
    """
    tracks = [[noisier(t, np.random.default_rng(0), sign) for t in problem.tracks] for sign in (1.0, -1.0)]
    if not len(fitted.x) or all(map(operator.is_, tracks[0], problem.tracks)):
        return fitted
    steps = [attempt(_step, one, fitted) for one in (problem, *(replace(problem, tracks=tuple(t)) for t in tracks))]
    here, *noisy = (step for step in steps if step is not None)
    if len(noisy) < len(tracks):
        return fitted
    low, high, _ = fitted.hypothesis.limits(fitted.x)
    x = np.clip(fitted.x - (np.mean(noisy, axis=0) - here), low, high)
    found = attempt(problem.at, fitted.hypothesis, x)
    return fitted if found is None or found.cost > _DEAREST * fitted.cost else found


def _step(problem: Problem, fitted: Fitted) -> Array:
    """(k,) Gauss-Newton step from where a fit ended."""
    minimum = problem.at(fitted.hypothesis, fitted.x).minimum
    size = np.linalg.norm(minimum.jacobian, axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(-np.linalg.lstsq(minimum.jacobian / size, minimum.residual, rcond=_RANK)[0] / size)
