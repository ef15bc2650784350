"""No name, still a model: the shape of a mismatch that repeats, learned over the signal that it depends on."""

import math
from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mmt_drake.diagnosis.fit.bootstrap import deviations
from mmt_drake.diagnosis.fit.nameless import table_signals
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import chance
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.effects import tabulated_force
from mmt_drake.effects.effect import Effect
from mmt_drake.effects.tabulated_force import SIGNALS
from mmt_drake.errors import MmtError, attempt
from mmt_drake.model.structure import PositionOut
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.least_squares import minimise

WORTH = 0.25
"""A table is kept if it takes this share off the variance that is left on held-out data."""
OTHER, UNLIKELY = 0.1, 0.05
"""A law may be another one than was fitted if a free curve over what it depends on takes this share, and chance would
do that with less than this probability."""
_DEPENDS_ON = {"contact_stiffness": "deflection", "dry_friction": "sliding_velocity", "viscous": "sliding_velocity"}
"""Family of laws that are a curve over one signal -> that signal."""
_OVER_TIME = {"stiffness_drift": "stiffness_over_time", "stiffness_step": "stiffness_over_time"}
"""Those of its laws that are one over another signal."""
_WITHOUT_A_CURVE, _MORE_THAN_NOISE = ("timing", "drive_train"), 2.5
"""Families of driven bodies of whose laws nothing tells whether another one leaves less, a lag or a delay of the
actuator, a play or a soft zone; and the RMS over the noise above which one may."""
_BRANCHING = ("viscoelastic_relaxation", "hysteresis", "elastoplastic_play")
"""Laws that relax or yield at one rate, where materials have many: more of them side by side are another law."""
_WEAKER, _APART = 0.3, (0.25, 4.0)
"""A further branch begins with this part of the strength, and so many times what gives the first one its shape."""
_ASKING = 0.1
"""It is asked for only where this share of the time is left."""
SIGNIFICANT = 0.01
_LEAST_TRIED = 4
"""Signals that a table is learned over, however late it is."""
_STEPS, _FURTHER_STEPS = 4, 12
_SMALL = 1e-3  # [N] or [N/m] of a table that shows how far one moves a body
_RIDGE = 0.05  # of the residual's strength: what pulls the second differences of a table to 0
_TABLE = tabulated_force.EFFECT.name


@dataclass(frozen=True)
class Learned:
    """A table that was learned.

    A straight table over a velocity or a displacement is a damper or a spring. Where the structure has one there too,
    what is known is the force of both together: a slope of the table goes with the fitted number beside it.

    Attributes:
        fitted: the fit with it: a hypothesis whose last effect is the table, held as it was learned.
        half_width: (k,) half of the 95 % interval of each value [N].
    """

    fitted: Fitted
    half_width: Array

    @property
    def values(self) -> dict[str, Any]:
        """of, at, value."""
        return dict(self.fitted.hypothesis.held[_TABLE])


def tables(
    problem: Problem, refit: Fitted, executor: Executor, is_late: Callable[[], bool] = lambda: False
) -> list[Learned]:
    """A table over every signal that this structure and these recordings have, best first.

    Args:
        problem: the recordings.
        refit: the fit without a table.
        executor: tries the signals.
        is_late: whether time is over: then no further signal is tried, but for the first few.
    """
    found: list[Learned | None] = []
    for table in _over_each(problem, refit, table_signals(problem, refit.model), executor):
        found.append(table)
        if len(found) >= _LEAST_TRIED and is_late():
            break
    return sorted((table for table in found if table is not None), key=lambda table: table.fitted.cost)


def other_curves(problem: Problem, best: Fitted, executor: Executor) -> frozenset[str]:
    """Effects of a fit beside which a free curve over the signal that they depend on explains some of what is left.

    Their law then may be another one of the family; and so it may where no curve could tell.

    Args:
        problem: the recordings on the clock of the verdict.
        best: the fit.
        executor: learns the curves.
    """
    effects = [e for e in best.hypothesis.effects if e.axis != "z"]
    along = {e.name: _OVER_TIME.get(e.name, _DEPENDS_ON.get(e.family)) for e in effects}
    found = table_signals(problem, best.model, [of for of in SIGNALS if of in along.values()])
    better = {
        curve.values["of"]
        for curve in _over_each(problem, best, found, executor)
        if curve is not None and worth_while(problem, best, [curve], OTHER, UNLIKELY) is not None
    }
    may_be_another = isinstance(best.model, PositionOut) and problem.left(best) > _MORE_THAN_NOISE
    unasked = [e.name for e in effects if may_be_another and e.family in _WITHOUT_A_CURVE]
    return frozenset([name for name, of in along.items() if of in better] + unasked)


def more_branches(problem: Problem, best: Fitted, executor: Executor, watch: Watch) -> frozenset[str]:
    """Effects of a fit beside which one more of the same kind, faster or slower, explains some of what is left.

    Their law then may be another one of the family: a spectrum of relaxations, as of most materials, or of levels. So
    it may where there is no time to ask.

    Args:
        problem: the recordings on the clock of the verdict.
        best: the fit.
        executor: runs the fits.
        watch: hears what there was no time for.
    """

    def may_have_more(effect: Effect) -> bool:
        further = replace(effect, name=f"further_{effect.name}")
        if not best.hypothesis.admits(further):
            return False
        if not watch.has_left(_ASKING):
            watch.miss([f"{effect.name} + {further.name}"])
            return True
        known, wider = best.effect_values[effect.name], best.hypothesis.adding(further)
        shapes = [p.symbol for p in wider.fitted_parameters(further) if p.shape]
        own = {p.symbol: _WEAKER * known[p.symbol] for p in wider.fitted_parameters(further) if not p.shape}
        begun = [own | {symbol: times * known[symbol] for symbol in shapes} for times in _APART]
        starts = [(wider, best.numbers_for(wider, {further.name: values})) for values in begun]
        fits = problem.fits(starts, executor, steps=_FURTHER_STEPS)
        return any(_takes(problem, best, fitted, len(_APART), OTHER, UNLIKELY) for fitted in fits)

    branching = (e for e in best.hypothesis.effects if e.name in _BRANCHING)
    return frozenset(effect.name for effect in branching if may_have_more(effect))


def worth_while(
    problem: Problem, refit: Fitted, learned: Sequence[Learned], share: float = WORTH, significant: float = SIGNIFICANT
) -> Learned | None:
    """The best table, the parameters fitted again beside it; None where it is not worth while on held-out data.

    Args:
        problem: the recordings on the clock of the verdict.
        refit: the fit without a table, to that.
        learned: best first.
        share: of the variance that is left on held-out data, to be taken off.
        significant: chance must be less likely to do that.
    """
    if not learned:
        return None
    fitted = attempt(problem.fit, learned[0].fitted.hypothesis, learned[0].fitted.x, steps=6)
    if fitted is None:
        return None
    is_better = _takes(problem, refit, fitted, len(learned), share, significant)
    return replace(learned[0], fitted=fitted) if is_better else None


def without_effects(problem: Problem, refit: Fitted, learned: Learned) -> Learned | None:
    """A table over the signal of one that was learned beside effects, without these; None where it cannot be simulated.

    Args:
        problem: the recordings.
        refit: the fit without effects and table.
        learned: that table.
    """
    bare = problem.fit(refit.hypothesis, refit.x, steps=6)
    return _learned(problem, bare, learned.values["of"], learned.values["at"])


def elsewhere(problem: Problem, refit: Fitted, blocks: Container[str], executor: Executor) -> Iterator[Fitted]:
    """A table alone over every signal whose law acts in another block than these.

    Args:
        problem: the recordings.
        refit: the fit without effects and table.
        blocks: to be left out.
        executor: tries the signals.
    """
    bare = problem.fit(refit.hypothesis, refit.x, steps=6)
    signals = (signal for signal in table_signals(problem, bare.model) if SIGNALS[signal[0]].block not in blocks)
    return (table.fitted for table in _over_each(problem, bare, signals, executor) if table is not None)


def _takes(problem: Problem, before: Fitted, after: Fitted, tries: int, share: float, significant: float) -> bool:
    """Whether a fit takes this share off the variance that another leaves on held-out data, and not by chance."""
    was, now = (problem.ratio(f.model, f.skew, heldout=True) ** 2 - 1.0 for f in (before, after))
    return now <= (1.0 - share) * was and chance(problem, before, after, tries) <= significant


def _over_each(
    problem: Problem, fitted: Fitted, signals: Iterable[tuple[str, Sequence[float]]], executor: Executor
) -> Iterator[Learned | None]:
    """A table beside a fit over each signal with these knots, in their order."""
    return executor.map(_learned, *zip(*((problem, fitted, *signal) for signal in signals), strict=True))


def _spread(problem: Problem, refit: Fitted, of: str, at: Sequence[float]) -> float:
    """What a table's values are to be if they make what a fit leaves, in their unit.

    Raises:
        MmtError: a table as small as can be cannot be simulated.
    """
    left = problem.left(refit) * float(np.mean([track.floor for track in problem.tracks]))
    if isinstance(refit.model, PositionOut):  # what is left is no force: a straight table tells how far one goes
        straight = _SMALL * np.asarray(at) / np.abs(at).max()
        held = {
            "of": of,
            "at": list(at),
            "value": [max(float(v), 0.0) if SIGNALS[of].level else float(v) for v in straight],
        }
        model = refit.hypothesis.adding(tabulated_force.EFFECT, held).model(refit.x)
        moved = problem.objective(model, refit.skew) - refit.minimum.residual
        per_unit = math.sqrt(float(moved @ moved) / problem.samples()) / _SMALL
        return problem.left(refit) / max(per_unit, 1e-300)
    if SIGNALS[of].unit == "N/m":
        replayed = (track.replay(refit.model, problem.coarse, refit.late)[1] for track in problem.tracks)
        deflections = [np.std(states["deflection"]) for states in replayed if "deflection" in states]
        left /= max(float(np.mean(deflections)), 1e-300)
    return left


def _learned(problem: Problem, refit: Fitted, of: str, at: Sequence[float]) -> Learned | None:
    hypothesis, base = refit.hypothesis, refit.x
    n = len(base)
    strength = problem.left(refit)
    try:
        spread = _spread(problem, refit, of, at)
    except MmtError:
        return None
    bend = np.diff(np.eye(len(at)), 2, axis=0) * (_RIDGE * math.sqrt(problem.samples()) / spread)

    def residual(x: Array) -> Array:
        values = {"of": of, "at": at, "value": [float(v) for v in x[n:]]}
        model = hypothesis.adding(tabulated_force.EFFECT, values).model(x[:n])
        r = problem.objective(model, hypothesis.skew_of(x[:n]))
        return np.concatenate([r, strength * (bend @ x[n:])])

    low, high, scale = hypothesis.limits(base)
    lowest = 0.0 if SIGNALS[of].level else -np.inf
    known = np.full((len(refit.minimum.residual) + len(bend), n + len(at)), np.nan)
    known[: len(refit.minimum.residual), :n] = refit.minimum.jacobian
    known[len(refit.minimum.residual) :, :n] = 0.0
    try:
        found = minimise(
            residual,
            np.concatenate([base, np.zeros(len(at))]),
            np.concatenate([low, np.full(len(at), lowest)]),
            np.concatenate([high, np.full(len(at), np.inf)]),
            np.concatenate([scale, np.full(len(at), spread)]),
            steps=_STEPS,
            known=known,
        )
        held = {"of": of, "at": list(at), "value": [float(v) for v in found.x[n:]]}
        fitted = problem.fit(hypothesis.adding(tabulated_force.EFFECT, held), found.x[:n], steps=6)
    except MmtError:
        return None
    # The pull towards a smooth table is one block: what it bends is as likely to be wrong as what noise does.
    blocks = problem.objective_blocks()
    blocks = np.append(blocks, np.full(len(bend), blocks.max() + 1))
    known_to = deviations(found.jacobian, found.residual, blocks, problem.samples())
    return Learned(fitted, known_to.half_width[n:])
