"""How fits of one problem compare: when one rules another out, and when one has run into a bound."""

from dataclasses import replace

from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.numeric.least_squares import CONVERGED

RULED_OUT = 12.0
"""A rival is ruled out if it is worse by this much in -2 ln(likelihood), each free number counting ln(samples)."""


def at_bounds(fitted: Fitted) -> frozenset[str]:
    """The structural parameters that a fit has driven to a bound, 0 apart: where it ended says nothing."""
    driven = set()
    for place, value in zip(fitted.hypothesis.free_parameters(fitted.x), fitted.x, strict=True):
        if not place.effect and place.symbol in fitted.hypothesis.free:
            room = 0.01 * place.scale
            if (place.low > 0.0 and value - place.low < 0.25 * room) or place.high - value < room:
                driven.add(place.symbol)
    return frozenset(driven)


def widened(problem: Problem, fitted: Fitted, *, steps: int, converged_at: float = CONVERGED) -> Fitted:
    """A fit taken on with the bounds that it ran into moved out, until it runs into none that can be moved.

    Raises:
        MmtError: a start cannot be simulated.
    """
    while more := at_bounds(fitted) - fitted.hypothesis.widened:
        hypothesis = replace(fitted.hypothesis, widened=fitted.hypothesis.widened | more)
        fitted = problem.fit(hypothesis, fitted.x, steps=steps, converged_at=converged_at)
    return fitted
