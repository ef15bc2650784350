"""The fit that is delivered: of all explanations that stand, what can be said of every one."""

from collections.abc import Sequence

from mmt_drake.diagnosis.decide.budget import NAMELESS, BudgetPart
from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem

CLEARLY = 4.0
"""An effect beside others is worth naming if its share is so many times that of what nobody has named: it may have
taken from that alone."""


def agreed(problem: Problem, believed: ConfidenceSet, fits: Sequence[Fitted]) -> tuple[Fitted, bool]:
    """The fit that is delivered, and whether its names are sure.

    The simplest member of the confidence set, without those of its effects that must not be said, and those that
    other members do without: these take from what nobody has named. If it has an equal in the set, or nothing is
    common to all, no name is sure. But where the rest takes next to nothing, it does not matter which of its names are
    equal: what is common to all is delivered without it.

    Args:
        problem: what was fitted.
        believed: what is not ruled out.
        fits: what was held against each other.
    """
    best = believed.members[0]
    unsaid = believed.unsaid.get(best.hypothesis.key, frozenset())
    left_out = [e.name for e in best.hypothesis.effects if e.name in unsaid or believed.depth(e) is None]
    hypothesis = best.hypothesis.without(*left_out)
    if believed.has_equal(best):
        common = _fit_of(problem, best, hypothesis, fits) if hypothesis.effects else best
        nothing = max(f.cost for f in fits if not f.hypothesis.effects)
        slight = CLEARLY * (common.cost - best.cost) <= nothing - common.cost
        if common is not best and slight and not believed.has_equal(common):
            return common, True
        return believed.best(), False
    if not hypothesis.effects and not unsaid:
        return believed.best(), False  # of several explanations that have nothing in common
    return _fit_of(problem, best, hypothesis, fits), True


def outstanding(problem: Problem, best: Fitted, shares: Sequence[BudgetPart], fits: Sequence[Fitted]) -> Fitted:
    """The fit without those effects that do not stand out clearly from what nobody has named; itself if all or none do.

    Args:
        problem: what was fitted.
        best: the fit.
        shares: its budget.
        fits: what was held against each other.
    """
    # Beside others it may explain little more than they do, and they nothing without it.
    share = {part.part: max(part.share, part.unique or 0.0) for part in shares}
    names = best.hypothesis.names
    faint = [name for name in names if share.get(name, 0.0) < CLEARLY * share[NAMELESS]]
    if not faint or len(faint) == len(names):
        return best
    return _fit_of(problem, best, best.hypothesis.without(*faint), fits)


def _fit_of(problem: Problem, best: Fitted, hypothesis: Hypothesis, fits: Sequence[Fitted]) -> Fitted:
    """The fit of some of the effects of a fit: one of those at hand, or that from where it ended."""
    for fitted in fits:
        if fitted.hypothesis.key == hypothesis.key:
            return fitted
    return problem.fit(hypothesis, hypothesis.vector(best.structure_values, best.effect_values))
