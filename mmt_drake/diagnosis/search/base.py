"""The fit without effects: is it only values that were wrong?"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.comparison import RULED_OUT, at_bound
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem, with_floors
from mmt_drake.errors import MmtError
from mmt_drake.model.structure import Structure

Array = NDArray[np.float64]

STARTS = 12
"""Beside the nominal parameters: valleys of m, k2 and b2 are long and shallow."""
STEPS, CONVERGED = 60, 1e-5
NOISE_ALONE = 2.0
"""RMS of the residual over the noise floor up to which nothing need be missing."""
FAR, FAR_STEPS = 8.0, 8
"""Where what begins near ends at a bound, parameters are begun so many times as large and as small, for a few steps."""
FARTHEST, MOST_TURNS = 30.0, 6
"""A bound gives way, so often at most, to a parameter that is up to so many times its nominal value, or that part."""


def fit_base(
    problem: Problem, model: Structure, skew: float, executor: Executor, known: Fitted | None = None
) -> tuple[Fitted, Fitted]:
    """The nominal parameters with the clocks' skew fitted and nothing else; and all parameters fitted.

    Parameters are sought within the bounds that `Hypothesis` sets about their nominal values. Physics that is missing
    drives them to these bounds, and would drive them on; so beyond them only what leaves no more than noise counts. In
    the same way what is given (`Structure.GIVEN`) is doubted only where other values leave no more than noise.

    Args:
        problem: what is fitted.
        model: nominal.
        skew: the largest skew allowed [s].
        executor: runs the fits.
        known: a fit of the same parameters to start from, whose bounds are kept; from several starts where there is
            none.

    Raises:
        MmtError: the nominal model cannot be simulated.
    """
    hypothesis = Hypothesis(model, skew, doubted=() if known is None else known.hypothesis.doubted)
    start = hypothesis.base()
    nominal = problem.at(hypothesis, start)
    if hypothesis.has_skew:
        nominal = problem.at(hypothesis, problem.skew_alone(hypothesis, start))
    further = [known.x] if known is not None else [hypothesis.moved(start, number) for number in range(STARTS)]
    starts = [nominal.x, *further]
    bounded = hypothesis if known is None else _about(hypothesis, _centre(known.hypothesis))
    fits = executor.map(_fitted, [problem] * len(starts), [bounded] * len(starts), starts)
    found = [f for f in fits if f is not None]
    nearest = min(found, key=lambda f: f.cost)
    if known is None and not _is_noise(problem, nearest):
        if (doubting := _doubting(problem, nearest)) is not None:
            return nominal, doubting
        if at_bound(nearest) is not None:
            found += _from_afar(problem, nearest, executor)
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


def _is_noise(problem: Problem, fitted: Fitted) -> bool:
    """Whether a fit leaves no more than noise: what comes through its own model, not through the nominal one."""
    fair = replace(problem, tracks=with_floors(problem.tracks, fitted.model))
    return fair.unchanged(fitted.hypothesis, fitted.x).cost <= NOISE_ALONE**2 * problem.samples()


def _centre(hypothesis: Hypothesis) -> dict[str, float]:
    """The values that the bounds of the free parameters are set about."""
    return hypothesis.structure_values(hypothesis.base())


def _about(hypothesis: Hypothesis, values: Mapping[str, float]) -> Hypothesis:
    """The hypothesis with the bounds of some parameters set about other values."""
    return replace(hypothesis, nominal=hypothesis.nominal.with_parameters(**values))


def _doubting(problem: Problem, nearest: Fitted) -> Fitted | None:
    """The fit with what is given free as well; None if it leaves more than noise, or there is nothing of the kind."""
    hypothesis = replace(nearest.hypothesis, doubted=nearest.hypothesis.nominal.GIVEN)
    if hypothesis.free == nearest.hypothesis.free:
        return None
    starts = (hypothesis.base(), hypothesis.vector(nearest.hypothesis.structure_values(nearest.x), {}))
    fits = [f for start in starts if (f := _fitted(problem, hypothesis, start)) is not None]
    best = min(fits, key=lambda f: f.cost, default=None)
    return best if best is not None and _is_noise(problem, best) else None


def _from_afar(problem: Problem, nearest: Fitted, executor: Executor) -> list[Fitted]:
    """The best fit with its bounds wherever that takes them; nothing if it leaves more than noise.

    Begun where the nearest one ended, and with every parameter alone, and all of them, far from their nominal values: a
    few steps each, and on from the best of them.
    """
    near, centre = nearest.hypothesis, _centre(nearest.hypothesis)
    sets = [*([symbol] for symbol in centre), [*centre]]
    far = [_about(near, {s: factor * centre[s] for s in some}) for some in sets for factor in (FAR, 1.0 / FAR)]
    fits = executor.map(_begun, [problem] * len(far), far)
    best = min([nearest, *(f for f in fits if f is not None)], key=lambda f: f.cost)
    found = _let_go(problem, best, centre)
    if found is None or not _is_noise(problem, found):
        return []
    values = found.hypothesis.structure_values(found.x)
    return [replace(found, hypothesis=_about(near, {s: values[s] or centre[s] for s in centre}))]


def _begun(problem: Problem, hypothesis: Hypothesis) -> Fitted | None:
    """A few steps from the middle of the bounds; None as `_fitted`."""
    try:
        return problem.fit(hypothesis, hypothesis.base(), steps=FAR_STEPS)
    except MmtError:
        return None


def _let_go(problem: Problem, fitted: Fitted, centre: Mapping[str, float]) -> Fitted | None:
    """A fit taken on, and again with the bound moved that a parameter was driven to; None as `_fitted`."""
    found = _fitted(problem, fitted.hypothesis, fitted.x)
    for _ in range(MOST_TURNS):
        symbol = None if found is None else at_bound(found)
        if found is None or symbol is None:
            break
        value = found.hypothesis.structure_values(found.x)[symbol]
        if not 1.0 / FARTHEST <= value / centre[symbol] <= FARTHEST:
            break
        found = _fitted(problem, _about(found.hypothesis, {symbol: value}), found.x)
    return found
