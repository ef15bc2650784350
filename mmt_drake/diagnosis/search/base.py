"""The fit without effects: is it only values that were wrong?"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from mmt_drake.diagnosis.fit.comparison import RULED_OUT, at_bounds, elsewhere, fit_widening
from mmt_drake.diagnosis.fit.floors import weighed, with_floors
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.prepare import Prepared, prepare
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.errors import attempt
from mmt_drake.model.parameters import NORMAL
from mmt_drake.model.structure import Structure
from mmt_drake.model_files import Model, compared
from mmt_drake.recording import Recording
from mmt_drake.windows import blocks_of

STARTS = 12
"""Beside the nominal parameters: valleys of m, k2 and b2 are long and shallow."""
STEPS, CONVERGED = 60, 1e-5
NOTHING_MISSING = 2.0
"""RMS of the residual over the noise floor up to which nothing need be missing."""
BEGUN, BEGUN_STEPS = 8.0, 8
"""Where what begins near ends at a bound, parameters are begun so many times as large and as small, for a few steps;
and so many of the best of these are fitted in full."""
TAKEN_ON = 3
CRUDE = 2.0
"""Where what leaves more than noise has a number so many times as large or as small as believed, the numbers of the
structure are begun elsewhere one by one: from far away the nearest minimum is often a poor one."""
MUCH, SHORTER = 20.0, 3.0
"""Where a body drifts and its model leaves so many times the noise, it is searched over windows that much shorter."""


def over_windows(
    recordings: Sequence[Recording], model: Model, prepared: Prepared, executor: Executor
) -> tuple[Prepared, Fitted]:
    """The recordings over windows that are short enough to search in, and the fit of all parameters over these.

    What is missing grows with the square of a window's length until it is no longer small, and what an effect promises
    to first order says nothing any more. The verdict is over the windows as they were: these tell numbers better.

    Args:
        recordings: as they came.
        model: as it was handed in; the length of its windows is open.
        prepared: the recordings over windows.
        executor: runs the fits.

    Raises:
        MmtError: the model cannot be simulated.
    """
    problem, length = prepared.problem, prepared.window_s
    assert problem is not None and length is not None  # a body that drifts, and was not refused
    _, refit = fit_base(problem, compared(model, length, prepared.initial), prepared.skew, executor)
    can = all(blocks_of(r.time, length / SHORTER) > blocks_of(r.time, length) for r in recordings)
    if not can or _left(problem, refit) <= MUCH:
        return prepared, refit
    return over_windows(recordings, model, prepare(recordings, replace(model, window_s=length / SHORTER)), executor)


def fit_base(
    problem: Problem, model: Structure, skew: float, executor: Executor, known: Fitted | None = None
) -> tuple[Fitted, Fitted]:
    """The nominal parameters with the clocks' skew fitted and nothing else; and all parameters fitted.

    Parameters are sought near their nominal values. A fit that ends at a bound proves nothing: its bounds are moved
    out, and where it leaves more than noise it is begun again far away too. What is given (`Structure.GIVEN`) is
    doubted only where other values leave no more than noise.

    Args:
        problem: what is fitted.
        model: nominal.
        skew: the largest skew allowed [s].
        executor: runs the fits.
        known: a fit of the same parameters to take on, whose bounds are kept; it was begun far away where that was
            called for.

    Raises:
        MmtError: the nominal model cannot be simulated.
    """
    reach = max(float(np.std(t.measured)) for t in problem.tracks)
    hypothesis = replace(Hypothesis.of(model, skew), reach=reach, unseen=problem.unseen)
    if known is not None:
        hypothesis = replace(known.hypothesis, nominal=hypothesis.nominal)
    start = hypothesis.base()
    nominal = problem.at(hypothesis, start)
    if hypothesis.has_skew:
        nominal = problem.at(hypothesis, problem.skew_alone(hypothesis, start))
    if known is None:
        problem = weighed(problem, nominal)
    further = [known.x] if known is not None else [hypothesis.moved(start, number) for number in range(STARTS)]
    starts = [(hypothesis, x) for x in (nominal.x, *further)]
    begun = sorted(problem.fits(starts, executor, steps=BEGUN_STEPS, secant=True), key=lambda f: f.cost)[:TAKEN_ON]
    taken_on = [(hypothesis, f.x) for f in begun]
    found = problem.fits(taken_on, executor, steps=STEPS, converged_at=CONVERGED)
    nearest = min(found, key=lambda f: f.cost)
    if known is None and not _is_noise(problem, nearest):
        doubting = doubted(problem, nearest, executor)
        if doubting is not None and _is_noise(problem, doubting):
            return nominal, doubting
        if at_bounds(nearest):
            found = _from_afar(problem, nearest, executor)
        nearest = min(found, key=lambda f: f.cost)
        if _is_crude(nearest) and not _is_noise(problem, nearest):
            found = [*found, *_from_elsewhere(problem, nearest, executor)]
    elif at_bounds(nearest):
        found = [fit_widening(problem, nearest.hypothesis, nearest.x, steps=STEPS, converged_at=CONVERGED)]
    least, scale = min(f.cost for f in found), hypothesis.limits(start)[2]
    # Of fits that the data do not tell apart, the one that changes least of what is believed.
    as_good = [f for f in found if f.cost <= least + RULED_OUT]
    return nominal, min(as_good, key=lambda f: float(np.sum(((f.x - start) / scale) ** 2)))


def _fair(problem: Problem, fitted: Fitted) -> Problem:
    """The problem with the noise that comes through the fit's own model, not through the nominal one."""
    return replace(problem, tracks=with_floors(problem.tracks, fitted.model))


def _left(problem: Problem, fitted: Fitted) -> float:
    """RMS of what a fit leaves over the noise."""
    fair = _fair(problem, fitted)
    return fair.left(fair.unchanged(fitted.hypothesis, fitted.x))


def _is_noise(problem: Problem, fitted: Fitted) -> bool:
    """Whether a fit leaves no more than noise."""
    fair = _fair(problem, fitted)
    return fair.unchanged(fitted.hypothesis, fitted.x).cost <= NOTHING_MISSING**2 * problem.samples()


def doubted(problem: Problem, nearest: Fitted, executor: Executor) -> Fitted | None:
    """The fit with what is given (`Structure.GIVEN`) free as well; None if there is nothing of the kind."""
    hypothesis = replace(nearest.hypothesis, doubted=nearest.hypothesis.nominal.GIVEN)
    if hypothesis.free == nearest.hypothesis.free:
        return None
    starts = (hypothesis.base(), hypothesis.vector(nearest.structure_values, {}))
    fits = problem.fits([(hypothesis, x) for x in starts], executor, steps=STEPS, converged_at=CONVERGED)
    return min(fits, key=lambda f: f.cost, default=None)


def _is_crude(fitted: Fitted) -> bool:
    """Whether a number of the structure is many times as large or as small as what was believed."""
    believed = fitted.hypothesis.structure_values(fitted.hypothesis.base())
    found = fitted.structure_values
    pairs = [(abs(found[s]), abs(value)) for s, value in believed.items() if s not in NORMAL and value != 0.0]
    return any(max(now, was) > CRUDE * min(now, was) for now, was in pairs)


def _from_elsewhere(problem: Problem, nearest: Fitted, executor: Executor) -> list[Fitted]:
    """Fits that begin with one number far from where the nearest one ended: a few steps each, and on from the best."""
    starts = [(nearest.hypothesis, x) for x in elsewhere(nearest)]
    begun = problem.fits(starts, executor, steps=BEGUN_STEPS, secant=True)
    return _let_go(problem, sorted(begun, key=lambda f: f.cost)[:TAKEN_ON], executor)


def _from_afar(problem: Problem, nearest: Fitted, executor: Executor) -> list[Fitted]:
    """Fits whose bounds gave way wherever they ran into them, from near and from far.

    Begun where the nearest one ended, and with every parameter alone, and all of them, far from their nominal values: a
    few steps each, and on from the best of them.
    """
    base, wide = nearest.hypothesis, replace(nearest.hypothesis, widened=frozenset(nearest.hypothesis.free))
    values = base.structure_values(base.base())
    far = [
        {s: factor * values[s] for s in some}
        for some in (*([s] for s in values), [*values])
        for factor in (BEGUN, 1.0 / BEGUN)
    ]
    starts = [(wide, wide.vector({**values, **some}, {})) for some in far]
    begun = problem.fits(starts, executor, steps=BEGUN_STEPS, secant=True)
    best = [nearest, *sorted(begun, key=lambda f: f.cost)[:TAKEN_ON]]
    return _let_go(problem, best, executor) or [nearest]


def _let_go(problem: Problem, fits: Sequence[Fitted], executor: Executor) -> list[Fitted]:
    """The fits taken on, with bounds that give way; those that can be simulated."""

    def let_go(f: Fitted) -> Fitted | None:
        return attempt(fit_widening, problem, f.hypothesis, f.x, steps=STEPS, converged_at=CONVERGED)

    return [f for f in executor.map(let_go, fits) if f is not None]
