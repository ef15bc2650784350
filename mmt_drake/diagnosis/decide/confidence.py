"""Confidence set of explanations: those that the recordings do not rule out, and what all of them agree on.

No real system is explained to its sensor's noise. So a name does not wait until nothing is left: it holds as deep as
every explanation that is not ruled out has it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Self, get_args

from mmt_drake.diagnosis.decide.depth import SLIGHT, Depth, is_kin
from mmt_drake.diagnosis.decide.exchange import at_their_limits, has, holds, is_simpler
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.floors import noise_kept_out
from mmt_drake.diagnosis.fit.free_space import SURELY, leaves_an_offset, off_in_free_space
from mmt_drake.diagnosis.fit.left_out import by_chance, in_most_blocks, jointly, left_out
from mmt_drake.diagnosis.fit.one_pass import may_be_any_curve
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.fit.validate import absent, chance, vanishing
from mmt_drake.diagnosis.search.equal import always_equal, are_equal, equal_sets, turns
from mmt_drake.effects.effect import Effect
from mmt_drake.numeric.arrays import Array

RULED_OUT = 0.01
"""An explanation is ruled out if chance would put the best one so far before it with less than this probability, and
not the other way about in most blocks ..."""
ALIKE = 2.0
"""... and, if it has a name, only if it leaves more than this many times as much beyond the noise, in variance. What
nobody has named is in every block and no chance: a wrong law may take from it what the right one leaves."""
NEXT_TO_NOTHING, RIGHT = 0.002, 10.0
"""... and more than this part of what is there to be explained: no law of a real machine is right to a thousandth. But
where the best one leaves so little beyond the noise that so many times that, and the noise, are less, its laws are."""

WELL = 0.05
"""With this probability at least, chance may well have put one explanation before another."""

MUCH_FARTHER = 3.0
"""In free space a fit is ruled out that misses the mean of the force so many times as far as another one, which counts
as missing it by `SURELY` at least."""


@dataclass(frozen=True)
class ConfidenceSet:
    """Explanations that the blocks left out do not rule out against the best.

    Attributes:
        members: simplest first: by number of effects, then of free numbers, then by what they leave.
        chances: of every explanation that was held against the best, see `by_chance`; 1 for the best.
        stood: all fits that are not ruled out; not all of them are members, see `of`.
        unsaid: set of effects -> those of them that must not be named.
        turning: whether the motion goes both ways; where it does not, more names are equal.
        rivals: further fits that stand, and may not be named because a bound made them what they are: no more than the
            block is sure against one that says something else.
        drawing: members that hold a simpler one as a special case (`Effect.holds`) and leave next to nothing less than
            it does: they say what that one says, and a little more.
        left: set of effects -> what its fit leaves of what it has not seen, a sum of squares.
        finer: laws that another one next to them draws (`at_their_limits`), which explains more than chance would.
    """

    members: tuple[Fitted, ...]
    chances: Mapping[frozenset[str], float]
    stood: tuple[Fitted, ...]
    unsaid: Mapping[frozenset[str], frozenset[str]]
    turning: bool = True
    rivals: tuple[Fitted, ...] = ()
    drawing: frozenset[frozenset[str]] = frozenset()
    left: Mapping[frozenset[str], float] = field(default_factory=dict)
    finer: frozenset[str] = frozenset()

    @property
    def standing(self) -> frozenset[frozenset[str]]:
        """Sets of effects (`Hypothesis.key`) that are not ruled out."""
        return frozenset(f.hypothesis.key for f in self.stood)

    @classmethod
    def of(
        cls, problem: Problem, fits: Sequence[Fitted], unsaid: Mapping[frozenset[str], frozenset[str]]
    ) -> ConfidenceSet:
        """The confidence set of fits of one problem, that of no effect among them.

        A fit with an effect that must not be named rules out others like any fit. It is a member only where nothing
        else remains: a law that draws another one, its further numbers at nothing, does not speak against that one. Nor
        does it rule that one out: that one is then no surer than its family.

        Args:
            problem: what was fitted.
            fits: of different sets of effects; one at least.
            unsaid: as in the attributes; nothing where a set is not in it.
        """
        numbers = problem.blocks()
        left = _as_noisy(problem, fits)
        costs = [float(r @ r) for r in left]
        limits = at_their_limits(problem, fits, unsaid)
        best = min((i for i in range(len(fits)) if i not in limits), key=costs.__getitem__)
        noise = problem.samples() / len(numbers)
        chances = [by_chance(numbers, r, left[best], noise) for r in left]
        for i, cost in enumerate(costs):
            if chances[i] >= RULED_OUT and cost > ALIKE * costs[best]:
                chances[i] = _with_unseen(problem, fits[i], fits[best], chances[i])
            if chances[i] < RULED_OUT and in_most_blocks(numbers, left[i], left[best], noise) < RULED_OUT:
                chances[i] = RULED_OUT
        for i in contradicted(problem, fits, chances):
            chances[i], costs[i] = 0.0, math.inf
        found, alike = cls.sifted(fits, costs, chances, unsaid, problem.samples())
        said = {f.hypothesis.key for f in found.members}
        rivals = tuple(
            f
            for f in found.stood
            if f.hypothesis.key not in said
            and at_bounds(f)
            and not any(m.hypothesis.key < f.hypothesis.key or is_simpler(m, f) for m in found.members)
        )
        near = [f for f in found.members if f.hypothesis.key in alike]
        leaves = {f.hypothesis.key: r for f, r in zip(fits, left, strict=True)}
        without = _without_effects(fits, costs)

        def is_at_a_limit(fitted: Fitted) -> bool:
            """Whether it leaves next to nothing less than one that it holds, as chance alone may well do.

            No interval shows a number that has no end.
            """
            own = leaves[fitted.hypothesis.key]
            slight = float(own @ own) + _next_to_nothing(without, float(own @ own))
            held = [leaves[one.hypothesis.key] for one in near if holds(fitted, one)]
            return any(r @ r <= slight and by_chance(numbers, r, own, noise) >= WELL for r in held)

        members = tuple(f for f in found.members if not is_at_a_limit(f))
        drawing = frozenset(f.hypothesis.key for f in members if any(is_simpler(one, f) for one in near))
        finer = frozenset(
            law
            for i, held in limits.items()
            for law, j in held.items()
            if by_chance(numbers, left[j], left[i], noise) < RULED_OUT
        )
        turning = turns(problem, fits[best])
        return replace(found, members=members, turning=turning, rivals=rivals, drawing=drawing, finer=finer)

    @classmethod
    def sifted(
        cls,
        fits: Sequence[Fitted],
        costs: Sequence[float],
        chances: Sequence[float],
        unsaid: Mapping[frozenset[str], frozenset[str]],
        noise: float,
    ) -> tuple[Self, frozenset[frozenset[str]]]:
        """The confidence set of fits, and those sets of effects that leave next to nothing more than the least.

        Args:
            fits: of different sets of effects.
            costs: what each leaves of what it has not seen, a sum of squares.
            chances: that chance alone puts the best before each.
            unsaid: as in the attributes.
            noise: the sum of squares that noise alone leaves.
        """
        least = min(costs)
        without = _without_effects(fits, costs)
        beyond, slight = max(least - noise, 0.0), _next_to_nothing(without, least)
        near = least + max((ALIKE - 1.0) * beyond, min(max(RIGHT * beyond, noise), slight))
        alike = [
            bool(f.hypothesis.effects) and c <= max(near, least + slight) for f, c in zip(fits, costs, strict=True)
        ]
        standing = [i for i, chance in enumerate(chances) if chance >= RULED_OUT or (alike[i] and costs[i] <= near)]
        members = [i for i in standing if not unsaid.get(fits[i].hypothesis.key)] or standing
        members.sort(key=lambda i: (len(fits[i].hypothesis.effects), len(fits[i].x), costs[i]))
        found = cls(
            tuple(fits[i] for i in members),
            {f.hypothesis.key: chance for f, chance in zip(fits, chances, strict=True)},
            tuple(fits[i] for i in standing),
            unsaid,
            left={f.hypothesis.key: cost for f, cost in zip(fits, costs, strict=True)},
        )
        return found, frozenset(f.hypothesis.key for f, near_least in zip(fits, alike, strict=True) if near_least)

    def best(self) -> Fitted:
        """Of the members with fewest effects the one that leaves least: the first where they cannot be told apart."""
        fewest = len(self.members[0].hypothesis.effects)
        some = [f for f in self.members if len(f.hypothesis.effects) == fewest]
        return max(some, key=lambda f: self.chances[f.hypothesis.key])

    def has_equal(self, fitted: Fitted) -> bool:
        """Whether a member says the same as a fit by other names, or its motion or model cannot say which it is."""
        return any(are_equal(fitted, other) for other in self.members) or bool(self._unsure(fitted))

    def _unsure(self, fitted: Fitted) -> frozenset[str]:
        """Effects of a fit that may as well be others, since the motion never turns or the model has no mass."""
        others = set(equal_sets(fitted, self.turning)).difference(always_equal(fitted))
        return frozenset(name for names in others for name in fitted.hypothesis.key - names)

    def depth(self, effect: Effect) -> Depth | None:
        """How deep every member has an effect; None where not even the block is sure."""
        if any(effect.name in self._unsure(f) for f in self.members):
            return None
        for depth in get_args(Depth):
            against = self.members if depth == "block" else (*self.members, *self.rivals)
            takes_more = effect.name in self.finer or any(self._takes_more_with_kin(effect, f) for f in self.stood)
            if depth == "law" and takes_more:
                continue
            if all(has(f, effect, depth) or (depth != "law" and self._draws(f, effect)) for f in against):
                return depth
        return None

    def _takes_more_with_kin(self, effect: Effect, fitted: Fitted) -> bool:
        """Whether a fit has an effect beside kin of it, and explains more by them than chance would.

        The kin need not be named. Those that take next to nothing of what the effect does draw what has no name, and no
        third law.
        """
        key, kin = fitted.hypothesis.key, {e.name for e in fitted.hypothesis.effects if is_kin(e, effect)}
        fewer = key - kin
        if not kin or effect.name not in key or self.chances.get(fewer, 1.0) >= min(WELL, self.chances[key]):
            return False
        beside, named, nothing = (self.left.get(one, math.nan) for one in (key, fewer, fewer - {effect.name}))
        return not named - beside < SLIGHT * (nothing - named)  # where one was not compared it is not known: NaN

    def _draws(self, fitted: Fitted, effect: Effect) -> bool:
        """Whether a member says what an effect says, and a little more, see `drawing`."""
        return fitted.hypothesis.key in self.drawing and any(effect.name in e.holds for e in fitted.hypothesis.effects)


def _as_noisy(problem: Problem, fits: Sequence[Fitted]) -> list[Array]:
    """What fits leave of blocks left out, as if each let as much of the input's noise through as the others.

    A lag in the place of a delay filters the noise of a measured velocity: that is no physics.
    """
    left = [left_out(problem, f) for f in fits]
    kept_out = noise_kept_out(problem, fits)
    return [r * math.sqrt(1.0 + more / float(r @ r)) if more else r for r, more in zip(left, kept_out, strict=True)]


def contradicted(problem: Problem, fits: Sequence[Fitted], chances: Sequence[float]) -> list[int]:
    """Which fits are ruled out by what the force sensor reads in free space, where another stands with no more effects.

    There nothing but the sensor acts, so that its offset is measured, however alike the two are in contact. A block of
    it is one block's word among all, so it is asked by itself. A fit with more effects does not rule out one with less:
    every sensor is a little off.

    Args:
        problem: what was fitted.
        fits: of different sets of effects.
        chances: that chance alone puts the best before each.
    """
    standing = [i for i, chance in enumerate(chances) if chance >= RULED_OUT]
    off = {i: off_in_free_space(problem, fits[i]) for i in standing}

    def rules_out(j: int, i: int) -> bool:
        no_more = len(fits[j].hypothesis.effects) <= len(fits[i].hypothesis.effects)
        return no_more and off[i] > MUCH_FARTHER * max(off[j], SURELY)

    return [i for i in standing if any(rules_out(j, i) for j in standing if fits[j].hypothesis.effects)]


def _without_effects(fits: Sequence[Fitted], costs: Sequence[float]) -> float:
    """What a fit of no effect leaves, of what each leaves; 0 where there is none."""
    return max((cost for f, cost in zip(fits, costs, strict=True) if not f.hypothesis.effects), default=0.0)


def _next_to_nothing(without: float, least: float) -> float:
    """What is next to nothing of what an explanation takes, from what is left without effects and with it."""
    return NEXT_TO_NOTHING * max(without - least, 0.0)


def _with_unseen(problem: Problem, fitted: Fitted, best: Fitted, seen: float) -> float:
    """Probability that chance alone puts the best so far before another one, on fitted and on held-out blocks together.

    What happens in few blocks, as a stop that is met three times, is one block's word among those that were fitted.
    Where held-out blocks alone would rule the other one out, both count.

    Args:
        problem: with the held-out blocks.
        fitted: the other one.
        best: the best on fitted blocks.
        seen: the probability on these alone.
    """
    unseen = chance(problem, fitted, best, 1)
    return seen if unseen >= RULED_OUT else jointly(seen, unseen)


def not_to_be_named(problem: Problem, refit: Fitted, fitted: Fitted) -> frozenset[str]:
    """Effects of a fit that must not be named, though it may rule out others.

    All of them where a bound made the fit what it is, where any curve would draw the same, or where they stand for an
    offset of the sensor that free space shows; those that may as well be nothing; and those that do not happen within
    the recordings.

    Args:
        problem: what was fitted.
        refit: the fit without effects.
        fitted: the fit with them.
    """
    stands_for = leaves_an_offset(problem, refit, fitted) or may_be_any_curve(problem, refit, fitted, RULED_OUT)
    if at_bounds(fitted) or stands_for:
        return fitted.hypothesis.key
    return vanishing(problem, fitted) | absent(problem, fitted)
