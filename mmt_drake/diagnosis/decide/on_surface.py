"""Confidence set of explanations of a tip on a surface, by how they predict unseen times and unseen places."""

from collections.abc import Sequence

import numpy as np

from mmt_drake.diagnosis.decide.confidence import ConfidenceSet
from mmt_drake.diagnosis.fit.left_out import by_chance
from mmt_drake.diagnosis.fit.place_tables import LEARNED
from mmt_drake.diagnosis.fit.places import Explained, Scan
from mmt_drake.diagnosis.fit.problem import Fitted
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
    chances = [max(t, p) for t, p in zip(in_time, in_place, strict=True)]
    costs = [one.unseen_cost for one in explained]
    unsaid = {f.hypothesis.key: vanishing(scan.surface.problem, f) - set(LEARNED) for f in fits}
    found, _ = ConfidenceSet.sifted(fits, costs, chances, unsaid, 2.0 * noise * len(first.by_time))
    return found
