"""Confidence set of explanations of a tip on a surface, by how they predict unseen times and unseen places."""

from collections.abc import Sequence

import numpy as np

from mmt_drake.diagnosis.decide.confidence import ALIKE, NEXT_TO_NOTHING, RULED_OUT, ConfidenceSet
from mmt_drake.diagnosis.fit.left_out import by_chance
from mmt_drake.diagnosis.fit.places import Explained, Scan
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.fit.surface_fit import SHAPE
from mmt_drake.diagnosis.fit.validate import vanishing


def believed_of(scan: Scan, explained: Sequence[Explained], fits: Sequence[Fitted]) -> ConfidenceSet:
    """The confidence set, see `ConfidenceSet`; as there, what has a name is ruled out only if it leaves much more.

    Chance has to be ruled out over blocks of time and over places, each by itself.

    Args:
        scan: the recordings and how they are cut.
        explained: the explanations, that without effects among them.
        fits: the same, in their order.
    """
    seen = ~scan.surface.heldout
    best = int(np.argmin([one.unseen_cost for one in explained]))
    noise, first = scan.noise, explained[best]
    in_time = [by_chance(scan.block[seen], one.by_time, first.by_time, noise) for one in explained]
    in_place = [by_chance(scan.cell[seen], one.by_place, first.by_place, noise) for one in explained]
    chances = {f.hypothesis.key: max(t, p) for f, t, p in zip(fits, in_time, in_place, strict=True)}
    costs = [one.unseen_cost for one in explained]
    without = max(cost for f, cost in zip(fits, costs, strict=True) if not f.hypothesis.effects)
    nameless = (ALIKE - 1.0) * (costs[best] - 2.0 * noise * len(first.by_time))
    near = costs[best] + max(nameless, NEXT_TO_NOTHING * (without - costs[best]), 0.0)
    alike = [bool(f.hypothesis.effects) and cost <= near for f, cost in zip(fits, costs, strict=True)]
    standing = [i for i, f in enumerate(fits) if chances[f.hypothesis.key] >= RULED_OUT or alike[i]]
    problem = scan.surface.problem
    unsaid = {f.hypothesis.key: vanishing(problem, f) - {SHAPE} for f in fits}
    members = [i for i in standing if not unsaid[fits[i].hypothesis.key]] or standing
    members.sort(key=lambda i: (len(fits[i].hypothesis.effects), len(fits[i].x), explained[i].unseen_cost))
    return ConfidenceSet(
        tuple(fits[i] for i in members), chances, frozenset(fits[i].hypothesis.key for i in standing), unsaid
    )
