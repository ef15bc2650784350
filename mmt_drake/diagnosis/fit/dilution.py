"""Regression dilution: what noise of the input has done to the numbers of a fit, and the fit without it.

Least squares takes the input for exact. Noise of a measured velocity is in a damper's force and in its derivative
alike, and draws the damper towards less; what goes with the damper follows.
"""

import operator
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.fit.floors import noisier
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import COARSE
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

_DEAREST = 1.1
"""The numbers without it cost at most this many times as much: more is a step over events, no dilution."""
_TURNS, _SETTLED = 4, 0.2
"""So many turns at most, until one moves no number by more than this part of all the way."""
_RANK = 1e-9


def undiluted(problem: Problem, fitted: Fitted) -> Fitted:
    """A fit with the numbers that it would have if its input had no noise; itself where that cannot be said.

    As much noise again moves the numbers by as much again (Cook and Stefanski 1994, Journal of the American Statistical
    Association 89: simulation and extrapolation). What it does by chance cancels between the same noise of either sign.
    That is asked again where it leads to, until the noise there explains the way back.

    Args:
        problem: what was fitted.
        fitted: the fit, where it ended.
    """
    quick = replace(problem, coarse=max(problem.coarse, COARSE))
    noisy = [_noisier(quick, sign) for sign in (1.0, -1.0)]
    if not len(fitted.x) or all(map(operator.is_, noisy[0].tracks, problem.tracks)):
        return fitted
    low, high, _ = fitted.hypothesis.limits(fitted.x)
    x, slack = fitted.x, None  # what a quick step makes of the minimum itself
    for _ in range(_TURNS):
        steps = [attempt(_step, one, fitted.hypothesis, x) for one in (quick, *noisy)]
        here, *others = (step for step in steps if step is not None)
        if len(others) < len(noisy):
            return fitted
        slack = here if slack is None else slack
        before, x = x, np.clip(x + 2.0 * here - slack - np.mean(others, axis=0), low, high)
        if np.all(np.abs(x - before) <= _SETTLED * np.abs(x - fitted.x)):
            break
    found = attempt(problem.at, fitted.hypothesis, x)
    return found if found is not None and found.cost <= _DEAREST * fitted.cost else fitted


def _noisier(problem: Problem, sign: float) -> Problem:
    """A problem with as much noise again on its input; one for all tracks would be no noise of theirs."""
    generator = np.random.default_rng(0)
    return replace(problem, tracks=tuple(noisier(track, generator, sign) for track in problem.tracks))


def _step(problem: Problem, hypothesis: Hypothesis, x: Array) -> Array:
    """(k,) Gauss-Newton step from these numbers."""
    minimum = problem.at(hypothesis, x).minimum
    size = np.linalg.norm(minimum.jacobian, axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(-np.linalg.lstsq(minimum.jacobian / size, minimum.residual, rcond=_RANK)[0] / size)
