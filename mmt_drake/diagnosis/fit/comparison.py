"""Fits of one problem: when one rules another out, when one has run into a bound, and where others may begin."""

from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.model.parameters import NORMAL
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import CONVERGED

RULED_OUT = 12.0
"""A rival is ruled out if it is worse by this much in -2 ln(likelihood), each free number counting ln(samples)."""

_FAR = (0.6, 1.6)
"""Times what it is a number is begun where another minimum is sought."""


def at_bounds(fitted: Fitted) -> frozenset[str]:
    """The structural parameters that a fit has driven to a bound, 0 apart: where it ended says nothing."""
    driven = set()
    for parameter, value in zip(fitted.hypothesis.free_parameters(fitted.x), fitted.x, strict=True):
        if not parameter.effect and parameter.symbol in fitted.hypothesis.free:
            room = 0.01 * parameter.scale
            if (parameter.low > 0.0 and value - parameter.low < 0.25 * room) or parameter.high - value < room:
                driven.add(parameter.symbol)
    return frozenset(driven)


def fit_widening(
    problem: Problem, hypothesis: Hypothesis, start: Array, *, steps: int, converged_at: float = CONVERGED
) -> Fitted:
    """`Problem.fit`, the bounds that it runs into moved out, until it runs into none that can be moved.

    Raises:
        MmtError: a start cannot be simulated.
    """
    fitted = problem.fit(hypothesis, start, steps=steps, converged_at=converged_at)
    while more := at_bounds(fitted) - fitted.hypothesis.widened:
        hypothesis = replace(fitted.hypothesis, widened=fitted.hypothesis.widened | more)
        fitted = problem.fit(hypothesis, fitted.x, steps=steps, converged_at=converged_at)
    return fitted


def elsewhere(fitted: Fitted) -> list[Array]:
    """The numbers of a fit with one of the structure far from what it is, each in turn, and within its bounds.

    Those of the normal axis have one minimum.
    """
    (low, high, _), starts = fitted.hypothesis.limits(fitted.x), []
    for i, symbol in enumerate(fitted.hypothesis.free):
        if symbol not in NORMAL and fitted.x[i] != 0.0:
            for times in _FAR:
                x = fitted.x.copy()
                x[i] *= times
                starts.append(np.clip(x, low, high))
    return starts
