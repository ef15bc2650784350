"""The fit that is delivered: of all explanations that stand, what can be said of every one."""

from collections import defaultdict
from collections.abc import Collection, Sequence

from mmt_drake.diagnosis.decide.budget import NAMELESS, BudgetPart
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import intervals, within_reach_of_nothing

CLEARLY = 4.0
"""An effect beside others is worth naming if its share is so many times that of what nobody has named: it may have
taken from that alone."""

CORE = 0.1
"""Of an interval the part that is its core: a number that is less than so much of its uncertainty may be anything."""

SLIGHTER = 0.1
"""An effect that takes less than this part of what the greatest takes needs an interval that holds no nothing."""

BESIDE_THE_COMMON = 0.1
"""What not all explanations have is not said if it takes no more than this part of what is common to all takes."""


def agreed(problem: Problem, believed: ConfidenceSet, fits: Sequence[Fitted]) -> tuple[Fitted, bool]:
    """The fit that is delivered, and whether its names are sure.

    The simplest member of the confidence set, without those of its effects that must not be said. Those that other
    members do without go as well where all of them take next to nothing: these take from what nobody has named. If it
    has an equal in the set, or nothing is common to all, no name is sure. But where what is not common takes next to
    nothing, it does not matter which of its names are equal.

    Args:
        problem: what was fitted.
        believed: what is not ruled out.
        fits: what was held against each other.
    """
    best = believed.members[0]
    unsaid = believed.unsaid.get(best.hypothesis.key, frozenset())
    common = best.hypothesis.without(*(e.name for e in best.hypothesis.effects if believed.depth(e) is None), *unsaid)
    alone = _fit_of(problem, best, common, fits) if common.effects else best
    slight = alone is not best and _takes_next_to_nothing(best, alone, fits)
    if believed.has_equal(best):
        return (alone, True) if slight and not believed.has_equal(alone) else (believed.best(), False)
    if not common.effects and not unsaid:
        return believed.best(), False  # of several explanations that have nothing in common
    kept = common if slight or not common.effects else best.hypothesis.without(*unsaid)
    return _fit_of(problem, best, kept, fits), True


def _takes_next_to_nothing(best: Fitted, alone: Fitted, fits: Sequence[Fitted]) -> bool:
    """Whether a fit gains next to nothing over that of some of its effects alone, beside what these gain."""
    nothing = max(f.cost for f in fits if not f.hypothesis.effects)
    return alone.cost - best.cost <= BESIDE_THE_COMMON * (nothing - alone.cost)


def surely_there(
    problem: Problem, best: Fitted, fits: Sequence[Fitted], part: float = CORE, among: Collection[str] | None = None
) -> Fitted:
    """The fit without those effects of which this part of the told interval holds nothing; itself if there is none.

    These intervals allow for what nameless laws may hide, so that an effect which only stands for one of them is as
    wide as that. Where no more than the ends hold nothing the name is told, if next to nothing is left without a name,
    and no surer than its family.

    Args:
        problem: what was fitted.
        best: the fit.
        fits: what was held against each other.
        part: about the value; 1 is the whole interval.
        among: the effects that are asked; all by default.
    """
    cores = [_core(float(value), span, part) for value, span in zip(best.x, intervals(problem, best), strict=True)]
    unsure = within_reach_of_nothing(best, cores)
    unsure = unsure if among is None else unsure.intersection(among)
    return _fit_of(problem, best, best.hypothesis.without(*unsure), fits) if unsure else best


def _core(value: float, interval: tuple[float, float], part: float) -> tuple[float, float]:
    """The inner part of an interval, about the value; of one that a bound cuts off, by its longer side."""
    half = part * max(value - interval[0], interval[1] - value)
    return value - half, value + half


def outstanding(problem: Problem, best: Fitted, shares: Sequence[BudgetPart], fits: Sequence[Fitted]) -> Fitted:
    """The fit without those effects that do not stand out clearly from what nobody has named; itself if all or none do.

    Args:
        problem: what was fitted.
        best: the fit.
        shares: its budget.
        fits: what was held against each other.
    """
    share, names = _shares(shares), best.hypothesis.names
    faint = [name for name in names if share[name] < CLEARLY * share[NAMELESS]]
    if not faint or len(faint) == len(names):
        return best
    return _fit_of(problem, best, best.hypothesis.without(*faint), fits)


def beyond_doubt(problem: Problem, best: Fitted, shares: Sequence[BudgetPart], fits: Sequence[Fitted]) -> Fitted:
    """The fit without those much slighter effects of which the told interval holds nothing; itself if there is none.

    Arguments as for `outstanding`.
    """
    share, names = _shares(shares), best.hypothesis.names
    greatest = max(share[name] for name in names)
    return surely_there(problem, best, fits, 1.0, [name for name in names if share[name] < SLIGHTER * greatest])


def _shares(shares: Sequence[BudgetPart]) -> defaultdict[str, float]:
    """Of each part: beside others an effect may explain little more than they do, and they nothing without it."""
    return defaultdict(float, {part.part: max(part.share, part.unique or 0.0) for part in shares})


def _fit_of(problem: Problem, best: Fitted, hypothesis: Hypothesis, fits: Sequence[Fitted]) -> Fitted:
    """The fit of some of the effects of a fit: one of those at hand, or that from where it ended."""
    for fitted in fits:
        if fitted.hypothesis.key == hypothesis.key:
            return fitted
    return problem.fit(hypothesis, hypothesis.vector(best.structure_values, best.effect_values))
