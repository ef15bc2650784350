"""Regression dilution: what noise of the input has done to the numbers of a fit, and the fit without it.

Least squares takes the input for exact. Noise of a measured velocity is in a damper's force and in its derivative
alike, and draws the damper towards less; what goes with the damper follows.
"""

import operator
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.fit.floors import noisier
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.tracks import COARSE
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

_DEAREST = 1.05
"""The numbers without it cost at most this many times as much: more is a step over events, no dilution."""
_TURNS, _SETTLED = 4, 0.2
"""So many turns at most, until one moves no number by more than this part of all the way."""
_SCATTER = 0.1
"""Another draw of the noise has to move the numbers as the first did, but for this part of the cost that both change:
where bodies stick and slip noise moves them anywhere."""
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
    noisy, again = (_noisy_either_way(quick, seed) for seed in (0, 1))
    if not len(fitted.x) or all(map(operator.is_, noisy[0].tracks, problem.tracks)):
        return fitted
    low, high, _ = fitted.hypothesis.limits(fitted.x)
    begun, one, other = (_mean_step(some, fitted.hypothesis, fitted.x) for some in ([quick], noisy, again))
    if begun is None or one is None or other is None:
        return fitted
    apart, both = (fitted.minimum.jacobian @ way for way in (one - other, one + other - 2.0 * begun))
    if apart @ apart > _SCATTER * (both @ both):
        return fitted
    x = np.clip(fitted.x + begun - 0.5 * (one + other), low, high)
    for _ in range(_TURNS):
        here, one = (_mean_step(some, fitted.hypothesis, x) for some in ([quick], noisy))
        if here is None or one is None:
            return fitted
        before, x = x, np.clip(x + 2.0 * here - begun - one, low, high)
        if np.all(np.abs(x - before) <= _SETTLED * np.abs(x - fitted.x)):
            break
    found = attempt(problem.at, fitted.hypothesis, x)
    return found if found is not None and found.cost <= _DEAREST * fitted.cost else fitted


def _noisy_either_way(problem: Problem, seed: int) -> list[Problem]:
    """A problem with as much noise again on its input, and with the same noise of the other sign."""
    problems = []
    for sign in (1.0, -1.0):
        generator = np.random.default_rng(seed)
        problems.append(replace(problem, tracks=tuple(noisier(track, generator, sign) for track in problem.tracks)))
    return problems


def _mean_step(problems: Sequence[Problem], hypothesis: Hypothesis, x: Array) -> Array | None:
    """The mean of the steps of some problems from the same numbers; None where one cannot be simulated."""
    steps = [attempt(_step, problem, hypothesis, x) for problem in problems]
    known = [step for step in steps if step is not None]
    return np.asarray(np.mean(known, axis=0)) if len(known) == len(steps) else None


def _step(problem: Problem, hypothesis: Hypothesis, x: Array) -> Array:
    """(k,) Gauss-Newton step from these numbers."""
    minimum = problem.at(hypothesis, x).minimum
    size = np.linalg.norm(minimum.jacobian, axis=0)
    size[size == 0.0] = 1.0
    return np.asarray(-np.linalg.lstsq(minimum.jacobian / size, minimum.residual, rcond=_RANK)[0] / size)
