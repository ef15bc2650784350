"""Fits that differ in one law: which laws one fit has in another's place, and which of these hold which."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import get_args

from mmt_drake.diagnosis.decide.depth import AT, Depth, is_kin
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.one_pass import passes_once
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import absent
from mmt_drake.diagnosis.search.equal import are_equal
from mmt_drake.effects.effect import Effect
from mmt_drake.model.structure import PositionOut

_RIVALS = 2
"""Sets that are compared at each depth: which of them is the better one may show on the accurate clock alone."""


def has(fitted: Fitted, effect: Effect, depth: Depth) -> bool:
    """Whether a fit has an effect, as deep as that."""
    at = AT[depth]
    return any(at(own) == at(effect) for own in fitted.hypothesis.effects)


def exchanged(one: Fitted, other: Fitted) -> list[tuple[Effect, Effect]]:
    """The law of one fit that the other has not, and the one that it has instead; empty where they differ otherwise."""
    mine, theirs = set(one.hypothesis.effects), set(other.hypothesis.effects)
    own, instead = mine - theirs, theirs - mine
    return [(own.pop(), instead.pop())] if len(own) == len(instead) == 1 else []


def is_simpler(one: Fitted, other: Fitted) -> bool:
    """Whether one fit is the other with a simpler law in the place of one."""
    return any(law.is_simpler_than(replaced) for law, replaced in exchanged(one, other))


def holds(one: Fitted, other: Fitted) -> bool:
    """Whether one fit is the other with a law in the place of one that it holds (`Effect.holds`)."""
    return any(held.name in law.holds for law, held in exchanged(one, other))


def as_good_kin(named: Fitted, fits: Sequence[Fitted], errors: Mapping[frozenset[str], float | None]) -> frozenset[str]:
    """Laws of a fit in whose place another one of their family predicts no worse, with no more numbers.

    A law that the blocks of the choice rule out may be the right one all the same, where blocks that nobody has seen
    do not bear that out.

    Args:
        named: the fit.
        fits: what was held against it.
        errors: set of effects -> error on blocks that no choice has seen; None where there is none.
    """
    known = {key: error for key, error in errors.items() if error is not None}
    least = known.get(named.hypothesis.key, math.inf)
    as_good = [f for f in fits if len(f.x) <= len(named.x) and known.get(f.hypothesis.key, math.inf) <= least]
    return frozenset(law.name for f in as_good for law, instead in exchanged(named, f) if is_kin(law, instead))


def at_their_limits(
    problem: Problem, fits: Sequence[Fitted], unsaid: Mapping[frozenset[str], frozenset[str]]
) -> dict[int, dict[str, int]]:
    """Which fits draw a simpler law, and that is all they may say: the law -> the fit that has it in their law's place.

    Friction that sets in as fast as any recording shows is Coulomb friction. Where all goes by once a law of more
    numbers may be any curve (`may_be_any_curve`), and says nothing of a simpler one.

    Args:
        problem: what was fitted.
        fits: of different sets of effects.
        unsaid: set of effects -> those of them that must not be named.
    """
    found: dict[int, dict[str, int]] = {}
    if isinstance(fits[0].hypothesis.nominal, PositionOut) and passes_once(problem, fits[0]):
        return found
    for i, fitted in enumerate(fits):
        hidden = unsaid.get(fitted.hypothesis.key, frozenset())
        held = {
            one.name: j
            for j, other in enumerate(fits)
            if not unsaid.get(other.hypothesis.key)
            for law, one in exchanged(fitted, other)
            if law.name in hidden and is_kin(law, one) and one.name in law.holds
        }
        if held and not at_bounds(fitted) and hidden <= absent(problem, fitted):
            found[i] = held
    return found


def contenders(ranked: Sequence[Fitted], count: int) -> list[Fitted]:
    """What must be compared in full: the best, the best single effects, and what could do without their names.

    For every effect of the best set, the best sets that lack its law, its family and its block; and beside every law
    the simpler one that it may draw, which alone may be named then.

    Args:
        ranked: best first.
        count: how many of the best, and of the best single effects.
    """
    first = [*ranked[:count], *[f for f in ranked if len(f.hypothesis.effects) == 1][:count]]
    chosen = list(first)
    for effect in dict.fromkeys(e for f in first[:1] for e in f.hypothesis.effects):
        for depth in get_args(Depth):
            chosen += [f for f in ranked if not has(f, effect, depth)][:_RIVALS]
    for f in list(chosen):  # no set is named that its subset equals, nor one of two published equals as if sure
        chosen += [g for g in ranked if g.hypothesis.key < f.hypothesis.key or are_equal(f, g) or is_simpler(g, f)]
    return list({id(f): f for f in chosen}.values())
