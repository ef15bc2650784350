"""Confirmation of names on blocks that no choice has seen."""

from collections.abc import Sequence

from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.decide.exchange import has
from mmt_drake.diagnosis.decide.gate import SIGNIFICANT
from mmt_drake.diagnosis.fit.left_out import gained_by_chance, jointly
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import chance

_NO_GAIN = 0.5
"""Held-out blocks speak against a name, whatever all others say, where chance would make such a gain so often."""


def is_confirmed(
    problem: Problem,
    refit: Fitted,
    delivered: Fitted,
    believed: ConfidenceSet,
    fits: Sequence[Fitted],
    tried: int | None = None,
) -> bool:
    """Whether held-out blocks bear out the names of a delivered fit.

    They do where it predicts them better than the fit without effects does, by more than chance.

    Of a short recording they are few. So they do as well where they and the blocks that were fitted say so together
    (`left_out.jointly`): those by what each fit leaves of a block that it is
    taken not to have seen, as likely by chance as the number of sets that were tried makes it (Bonferroni).

    And they do where the best explanation has the names as deep as they are sure, and predicts them better than every
    explanation that lacks one of them: what is delivered is the simplest that is not ruled out, and leaves so much in a
    short recording that a few blocks may not tell it from nothing, though all that its names rest on is told by them.
    Each of those must be beaten for itself, so that their number makes no success likelier (Berger 1982, Technometrics
    24: an intersection-union test).

    Args:
        problem: with the held-out blocks.
        refit: the fit without effects.
        delivered: the fit whose effects are to be named.
        believed: what was not ruled out.
        fits: all that was compared.
        tried: how many sets of as many effects were tried; None: held-out blocks alone count.
    """
    unseen = chance(problem, refit, delivered, 1)
    if unseen < SIGNIFICANT:
        return True
    if tried is not None and unseen < _NO_GAIN:
        seen = min(1.0, tried * gained_by_chance(problem, refit, delivered))
        if jointly(unseen, seen) < SIGNIFICANT:
            return True
    depths = {effect: believed.depth(effect) for effect in delivered.hypothesis.effects}
    sure = [(effect, depth) for effect, depth in depths.items() if depth is not None]
    best = max(fits, key=lambda f: believed.chances.get(f.hypothesis.key, 0.0))

    def lacks(fitted: Fitted) -> bool:
        return not all(has(fitted, effect, depth) for effect, depth in sure)

    without = [f for f in fits if lacks(f)]
    if len(sure) < len(depths) or best in without:
        return False
    return all(chance(problem, f, best, 1) < SIGNIFICANT for f in without)
