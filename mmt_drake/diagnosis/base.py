"""The fit without effects: is it only values that were wrong?"""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.gate import RULED_OUT
from mmt_drake.diagnosis.hypothesis import Hypothesis
from mmt_drake.diagnosis.problem import Fitted, Problem
from mmt_drake.errors import MmtError
from mmt_drake.model.structure import Structure

Array = NDArray[np.float64]

STARTS = 12
"""Beside the nominal parameters: valleys of m, k2 and b2 are long and shallow."""
STEPS, CONVERGED = 60, 1e-5


def fit_base(
    problem: Problem, model: Structure, skew: float, executor: Executor, known: Fitted | None = None
) -> tuple[Fitted, Fitted]:
    """The nominal parameters with the clocks' skew fitted and nothing else; and all parameters fitted.

    Args:
        problem: what is fitted.
        model: nominal.
        skew: the largest skew allowed [s].
        executor: runs the fits.
        known: a fit of the same parameters to start from; from several starts where there is none.

    Raises:
        MmtError: the nominal model cannot be simulated.
    """
    hypothesis = Hypothesis(model, skew)
    start = hypothesis.base()
    nominal = problem.at(hypothesis, start)
    if hypothesis.has_skew:
        nominal = problem.at(hypothesis, problem.skew_alone(hypothesis, start))
    further = [known.x] if known is not None else [hypothesis.moved(start, number) for number in range(STARTS)]
    starts = [nominal.x, *further]
    fits = executor.map(_fitted, [problem] * len(starts), [hypothesis] * len(starts), starts)
    found = [f for f in fits if f is not None]
    least, scale = min(f.cost for f in found), hypothesis.limits(start)[2]
    # Of fits that the data do not tell apart, the one that changes least of what is believed.
    as_good = [f for f in found if f.cost <= least + RULED_OUT]
    return nominal, min(as_good, key=lambda f: float(np.sum(((f.x - start) / scale) ** 2)))


def _fitted(problem: Problem, hypothesis: Hypothesis, start: Array) -> Fitted | None:
    """A fit of the parameters; None where the start cannot be simulated."""
    try:
        return problem.fit(hypothesis, start, steps=STEPS, converged_at=CONVERGED)
    except MmtError:
        return None
