"""What may be said of an arm: which effects are sure, how deep their names hold, and whose the error is."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mmt_drake.arms.arm_effect import ArmEffect
from mmt_drake.arms.beliefs import Believed, search_beside
from mmt_drake.arms.laws import ARM_EFFECTS
from mmt_drake.arms.problem import ArmProblem, Term
from mmt_drake.arms.search import BY_CHANCE, RARE, JointSet, chance_better
from mmt_drake.arms.shared_fit import OTHER_NUMBERS, SharedFit
from mmt_drake.diagnosis.decide.budget import NAMELESS, NOISE, PARAMETERS, SHARED, BudgetPart, shapley, subsets
from mmt_drake.diagnosis.decide.delivered import CLEARLY
from mmt_drake.diagnosis.decide.depth import Depth, beside_the_nameless, beside_the_untried
from mmt_drake.diagnosis.search.watch import Watch
from mmt_drake.numeric.arrays import Array

_DEPTHS: Final[tuple[Depth, ...]] = ("block", "family", "law")
LEAVES: Final[dict[Depth, float]] = {"law": 2.0, "family": 1.25, "block": 1.25}
"""What explains a joint without a name is ruled out if it leaves so many times as much, in variance, of blocks that
were not fitted, and not by chance. Without a law another of its family draws most of what it draws."""
NEXT_TO_NOTHING = 0.003
"""What takes less than this part of the mismatch of its joint has no name: shapes are sought on a grid. A model that is
off by more than the torque, its masses guessed, makes no friction smaller."""
WHOLE_NAMES = ("torque_ripple",)
"""Laws that are named as such or not at all: part of any shape over the way has the period of one."""
OVER_THE_WAY = ("constant_force", "ground_spring")
"""Laws that any curve over the way of a joint has a part of ..."""
CURVED = 0.15
"""... and that have no name if beside them such a curve takes more than this part of what they take."""
LEANS = 2.0
"""An effect whose own torque has more than so many times the squares of the mismatch leans on another one, of the
other sign, and has no name."""
_RIVALS = "what else it could be on"
"""... the joint: what there was no time to hold against its names."""
_SPLIT_AT_MOST = 6
"""Parts of a joint's error that are told apart; what is left of more is told together."""


@dataclass(frozen=True)
class Certainty:
    """How sure a name is.

    Attributes:
        term: that was found.
        depth: to which its name holds; None: others explain the joint as well without it.
        instead: the effects that stand in its place where others explain about as much without it.
    """

    term: Term
    depth: Depth | None
    instead: tuple[str, ...]


def certainty(problem: ArmProblem, found: Believed, joint: int, watch: Watch) -> list[Certainty]:
    """How sure each effect of a joint is: no surer than there was time to look, the coarsest depth first.

    Args:
        problem: the logs.
        found: what is delivered.
        joint: its number.
        watch: the clock.
    """
    search = search_beside(found, joint)
    own = search.fit(found.sets[joint].terms)
    untried = _untried(watch.missed)
    row, told = problem.rows[joint], []
    _, _, energy, samples = row.sums
    nominal = float(energy[problem.inner].sum() / max(samples[problem.inner].sum(), 1.0))
    mismatch = min(nominal, row.spread(problem.inner) ** 2)
    squares = search.squares(own)
    curve = search.with_curve(own)
    by_first_order = found.fit.belief.name == "joint_elasticity"
    for term in own.terms:
        law = ARM_EFFECTS[term.effect]
        depth: Depth | None = None
        instead: tuple[str, ...] = ()
        for at in _DEPTHS:
            if watch.is_late():
                watch.miss([f"{_RIVALS} {problem.arm.joints[joint]}"])
                break
            rival = search.best(_without(law, at))
            if not _ruled_out(rival, own, LEAVES[at]):
                if rival.fit.cost <= LEAVES["family"] * own.fit.cost:
                    instead = tuple(sorted(rival.names - own.names))
                break
            depth = at
        gone = search.fit([t for t in own.terms if t is not term]).fit.cost
        took = gone - own.fit.cost
        nameless = (
            took < NEXT_TO_NOTHING * mismatch,
            squares[term] > LEANS * nominal,
            term.effect in WHOLE_NAMES and depth != "law",
            term.effect in OVER_THE_WAY and own.fit.cost - curve.cost > CURVED * took,
            term.effect in RARE and by_first_order,  # of a spring: what it leaves looks like them
        )
        if any(nameless):
            depth = None
        told.append(Certainty(term, depth and beside_the_untried(depth, law, untried), instead))
    return told


def outstanding(fit: SharedFit, joint: int, x: Array, told: Sequence[Certainty], noise: float) -> list[Certainty]:
    """How sure each effect of a joint is beside what nobody has named there: not at all if it takes less than that.

    Beside effects that stand out from it clearly, one has to do so as well.

    Args:
        fit, joint, x, told, noise: as for `joint_budget`.
    """
    shares = {part.part: part.share for part in joint_budget(fit, joint, x, told, noise)}
    nameless = shares.get(NAMELESS, 0.0)
    clear = {c.term.effect for c in told if shares.get(c.term.effect, 0.0) >= CLEARLY * nameless}

    def beside(one: Certainty) -> Depth | None:
        name = one.term.effect
        if name not in shares:  # told together with others
            return one.depth
        if shares[name] <= nameless or (clear and name not in clear):
            return None
        depth = beside_the_nameless(one.depth, shares[name], nameless, may_be_all=False)
        return None if name in WHOLE_NAMES and depth != "law" else depth

    return [replace(one, depth=beside(one)) for one in told]


def _untried(missed: Iterable[str]) -> list[ArmEffect]:
    """Effects that there was no time to try; other inertial numbers count as a payload, which they hold."""
    names = [what.partition(" of ")[0] for what in missed]
    return [ARM_EFFECTS["payload" if name == OTHER_NUMBERS else name] for name in names if not name.startswith(_RIVALS)]


def arm_certainty(term: Term, found: Believed, tried: Sequence[Believed]) -> Depth | None:
    """How sure an effect of the whole arm is that a belief adds.

    A payload is a special case of other inertial numbers, which say what it says and more: these are no rivals of it.

    Args:
        term: the effect.
        found: what is delivered.
        tried: every belief.
    """
    law = ARM_EFFECTS[term.effect]
    depth: Depth | None = None
    for at in _DEPTHS:
        same = _without(law, at)
        rivals = [
            b
            for b in tried
            if not (b.fit.belief.name == "refit" and law.place == "link")
            and not any(t.effect in same and (at != "law" or t == term) for t in b.fit.belief.held)
        ]
        if any(b.cost < found.cost + math.log(LEAVES[at]) for b in rivals):
            break
        depth = at
    return depth


def _without(law: ArmEffect, depth: Depth) -> frozenset[str]:
    """Effects that a rival at a depth does without: those of the same block, family or law, and what holds that law."""
    alike = [e for e in ARM_EFFECTS.values() if e.reaches_all == law.reaches_all]
    if depth == "block":
        return frozenset(e.name for e in alike if e.block == law.block)
    if depth == "family":
        return frozenset(e.name for e in alike if e.family == law.family)
    return frozenset(e.name for e in alike if e.name == law.name or law.name in e.holds)


def _ruled_out(rival: JointSet, own: JointSet, leaves: float) -> bool:
    return rival.fit.cost > leaves * own.fit.cost and chance_better(rival.fit.held_out, own.fit.held_out) < BY_CHANCE


def without_idle_numbers(found: Believed) -> Believed:
    """What is delivered, less what its intervals let do nothing, and with two numbers that are alike as one.

    Effects that add nothing that is sure are no names, and no physics.
    """
    fit, inner = found.fit, found.fit.problem.inner
    x = fit.fitted(inner)
    half = fit.deviations(x, inner)
    for joint in fit.sets:
        for term, at in fit.numbers_of(joint):
            simpler = _simpler(fit.problem, joint, term, x[at], half[at])
            if simpler is not term:
                return without_idle_numbers(without(found, joint, term, simpler))
    return found


def forbidden(found: Believed, x: Array) -> tuple[int, Term] | None:
    """A joint and a term of it with numbers that it must not have; None where there is none.

    Args:
        found: what is delivered.
        x: its numbers.
    """
    for joint in found.fit.sets:
        known = found.fit.problem.rows[joint].held
        for term, at in found.fit.numbers_of(joint):
            law = ARM_EFFECTS[term.effect]
            if not law.allows(law.at_bounds(x[at], known.get(term.key, 0.0))):
                return joint, term
    return None


def without(found: Believed, joint: int, term: Term, instead: Term | None = None) -> Believed:
    """What is delivered without a term of a joint, or with another one in its place."""
    kept = tuple(t for t in (instead if t is term else t for t in found.fit.sets[joint]) if t is not None)
    sets = {**found.sets, joint: search_beside(found, joint).fit(kept)}
    return Believed(replace(found.fit, sets={j: s.terms for j, s in sets.items()}), sets)


def _simpler(problem: ArmProblem, joint: int, term: Term, x: Array, half: Array) -> Term | None:
    """The term; the simpler one that it may as well be; or None where it may as well be nothing, or must not be."""
    law = ARM_EFFECTS[term.effect]
    if all(abs(x) <= half) or any(law.at_bounds(x, problem.rows[joint].held.get(term.key, 0.0)) < law.least):
        return None
    if len(x) == 2 and law.holds and abs(x[0] - x[1]) <= math.hypot(half[0], half[1]):
        return next(t for t in problem.rows[joint].terms if t.effect == law.holds[0])
    return term


def joint_budget(
    fit: SharedFit, joint: int, x: Array, told: Sequence[Certainty], noise: float
) -> tuple[BudgetPart, ...]:
    """Whose the mismatch of a joint is, over the outer blocks.

    Each part has the error that comes back without it, averaged over the orders in which parts can be taken away.

    Args:
        fit: delivered.
        joint: its number.
        x: its numbers, fitted to the inner blocks.
        told: how sure its effects are; what is not sure is told together as shared.
        noise: mean squared noise of the torque [(N m)^2].
    """
    outer = fit.problem.outer
    parts: dict[str, list[int]] = {}
    if fit.numbers_of_links:
        parts[PARAMETERS] = fit.numbers_of_links
    for term, at in fit.numbers_held:
        parts[term.effect] = at
    sure = {c.term: c.depth for c in told}
    for term, at in fit.numbers_of(joint):
        name = term.effect if sure.get(term) else SHARED
        parts[name] = [*parts.get(name, []), *at]
    while len(parts) > _SPLIT_AT_MOST:
        last = list(parts)[-1] if list(parts)[-1] != SHARED else list(parts)[-2]
        parts[SHARED] = [*parts.get(SHARED, []), *parts.pop(last)]
    left = _coalitions(fit, joint, x, parts, outer)
    nominal, whole = left[frozenset()], left[frozenset(parts)]
    if not nominal > 0.0:
        return ()
    shares = {name: max(shapley(name, list(parts), left), 0.0) for name in parts}
    explained = max(nominal - whole, 0.0)
    total = sum(shares.values())
    shares = {name: (share / total * explained / nominal if total else 0.0) for name, share in shares.items()}
    floor = min(noise, whole, nominal) / nominal
    found = [BudgetPart(name, share) for name, share in shares.items()]
    return (*found, BudgetPart(NAMELESS, max(1.0 - sum(shares.values()) - floor, 0.0)), BudgetPart(NOISE, floor))


def _coalitions(
    fit: SharedFit, joint: int, x: Array, parts: Mapping[str, Sequence[int]], blocks: Sequence[int]
) -> dict[frozenset[str], float]:
    """What each set of parts leaves of a joint's torque [(N m)^2]."""
    left = {}
    for names in subsets(list(parts)):
        some = np.zeros_like(x)
        for name in names:
            some[list(parts[name])] = x[list(parts[name])]
        left[names] = float(fit.errors(some, blocks)[joint])
    return left
