"""Search of one joint: which effects earn their place on blocks that did not fit them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import stats

from mmt_drake.arms.folds import FoldFit, Folds
from mmt_drake.arms.laws import ARM_EFFECTS, DRY, VISCOUS
from mmt_drake.arms.problem import JointRows, Term
from mmt_drake.numeric.arrays import Array

BY_CHANCE = 0.01
"""A term earns its place if chance would make it so good with less than this probability ..."""
GAIN = 0.03
"""... and if it takes at least this part of the mean squared error that is left."""
_PLAIN = frozenset(("coulomb_friction", "viscous_friction", "constant_force", "rotor_inertia"))
_PLAIN_BY_CHANCE, _PLAIN_GAIN = 0.1, 0.2
"""The same of what every joint has, where it takes much: else a short log would leave out most of the torque. How sure
its name is, `verdict.certainty` says."""
_STATIC = "static_friction"
RARE = frozenset(("torque_gain", "joint_coupling", "torque_ripple", "ground_spring", "quadratic_drag", _STATIC))
"""Effects that few joints have. They draw a little of anything; one is taken only if it leaves ..."""
_RARE_GAIN = 0.35
"""... less by at least this part than what every joint has: friction, an offset, a rotor."""
_RIPPLE = "torque_ripple"
_SECOND = 0.3
"""A second period that takes more than this part of what the first one took is one of many."""
MOST = 5
"""Steps of a search; the first one chooses dry and viscous friction together."""
_STEP = 0.99
"""A step that leaves more than this part of what the one before it left is the last."""


@dataclass(frozen=True)
class JointSet:
    """Effects of one joint, and what they leave.

    Attributes:
        terms: chosen.
        fit: theirs.
    """

    terms: tuple[Term, ...]
    fit: FoldFit

    @property
    def names(self) -> frozenset[str]:
        """Of its effects."""
        return frozenset(term.effect for term in self.terms)

    def term(self, name: str) -> Term | None:
        """The term of an effect."""
        return next((term for term in self.terms if term.effect == name), None)


def chance_better(before: Array, after: Array) -> float:
    """Probability that chance makes one set so much better than another on folds held out (paired, one-sided).

    Args:
        before, after: (folds,) mean squared errors.
    """
    gains = np.log(np.maximum(before, 1e-300)) - np.log(np.maximum(after, 1e-300))
    spread = gains.std(ddof=1) / np.sqrt(len(gains)) if len(gains) > 1 else np.inf
    if spread == 0.0:
        return 0.0 if gains.mean() > 0.0 else 1.0
    return float(stats.t.sf(gains.mean() / spread, len(gains) - 1))


def earns(before: FoldFit, after: FoldFit, gain: float = GAIN, by_chance: float = BY_CHANCE) -> bool:
    """Whether what was added predicts better, and by enough to be told."""
    return after.cost < (1.0 - gain) * before.cost and chance_better(before.held_out, after.held_out) < by_chance


def _is_needed(found: JointSet, instead: JointSet) -> bool:
    """Whether a set of fewer terms, or with a simpler law, may not stand in the place of one.

    Dry friction gives way to viscous friction alone only where it takes nothing: every joint has it, and where speeds
    cannot tell the two apart, it is the one that does not grow beyond those that were seen.
    """
    if _has(found, DRY) and _has(instead, VISCOUS) and not _has(instead, DRY):
        return found.fit.cost < (1.0 - GAIN) * instead.fit.cost
    plain = instead.names < found.names and found.names - instead.names <= _PLAIN
    return earns(instead.fit, found.fit) or (plain and earns(instead.fit, found.fit, _PLAIN_GAIN, _PLAIN_BY_CHANCE))


def _has(found: JointSet, laws: Sequence[str]) -> bool:
    return not found.names.isdisjoint(laws)


class JointSearch:
    """The search of one joint under one belief about the links.

    Args:
        rows: of the joint.
        folds: its fits.
        held: terms that are always there, such as a payload's.
    """

    def __init__(self, rows: JointRows, folds: Folds, held: Sequence[Term] = ()) -> None:
        told = rows.told
        self._terms = [t for t in rows.terms if not ARM_EFFECTS[t.effect].reaches_all and all(told[list(t.columns)])]
        self._known, self._curve = rows.held, rows.curve
        self._folds, self._held, self._shared = folds, tuple(held), len(folds.fit(()).x)

    def fit(self, terms: Sequence[Term]) -> JointSet:
        """The set of these terms."""
        return JointSet(tuple(terms), self._folds.fit([c for t in (*self._held, *terms) for c in t.columns]))

    def squares(self, found: JointSet) -> dict[Term, float]:
        """Mean square of the torque of each term of a set by itself, over the inner blocks [(N m)^2]."""
        at, squares = self._shared + sum(len(t.columns) for t in self._held), {}
        for term in found.terms:
            x = found.fit.x[at : at + len(term.columns)]
            squares[term] = self._folds.mean_square(term.columns, x)
            at += len(term.columns)
        return squares

    def with_curve(self, found: JointSet) -> FoldFit:
        """The fit of a set beside any smooth curve over the way of the joint."""
        terms = [c for t in (*self._held, *found.terms) for c in t.columns]
        return self._folds.fit([*terms, *self._curve])

    def allowed(self, found: JointSet) -> bool:
        """Whether every number is one that its effect may have."""
        at = self._shared + sum(len(t.columns) for t in self._held)
        for term in found.terms:
            end = at + len(term.columns)
            law = ARM_EFFECTS[term.effect]
            x, known = found.fit.x[at:end], self._known.get(term.key)
            if not law.allows(x if known is None else law.at_bounds(x, known)):
                return False
            at = end
        return True

    def best(self, without: frozenset[str] = frozenset()) -> JointSet:
        """The best set: of what every joint has, unless something rarer leaves much less.

        Args:
            without: effects that are not tried.
        """
        plain, every = self._stepwise(without | RARE), self._stepwise(without | {_STATIC})
        if self._is_texture(every):
            every = self._stepwise(without | {_STATIC, _RIPPLE})
        best = every if earns(plain.fit, every.fit, _RARE_GAIN) else plain
        return best if _STATIC in without else self._breaking_away(best)

    def _breaking_away(self, found: JointSet) -> JointSet:
        """With a level of its own below some speed in the place of the law of dry friction, where that leaves less."""
        beside = [t for t in found.terms if t.effect not in DRY]
        if len(beside) == len(found.terms):
            return found
        sets = [s for t in self._terms if t.effect == _STATIC and self.allowed(s := self.fit([t, *beside]))]
        best = min(sets, key=lambda s: s.fit.cost, default=found)
        return best if earns(found.fit, best.fit, _RARE_GAIN) else found

    def _is_texture(self, found: JointSet) -> bool:
        """Whether what comes back over the way does so with many periods: then it is no ripple, which has one."""
        ripple = found.term(_RIPPLE)
        if ripple is None:
            return False
        none = self.fit([t for t in found.terms if t is not ripple]).fit.cost
        further = [t for t in self._terms if t.effect == _RIPPLE and t is not ripple]
        two = min((self.fit([*found.terms, t]).fit.cost for t in further), default=found.fit.cost)
        return found.fit.cost - two > _SECOND * (none - found.fit.cost)

    def _stepwise(self, without: frozenset[str]) -> JointSet:
        """The set that stepwise addition and removal end with."""
        now, path = self.fit(()), list[JointSet]()
        for _ in range(MOST):
            now = min((s for s in self._steps(now, without) if self.allowed(s)), key=lambda s: s.fit.cost, default=now)
            if path and now.fit.cost > _STEP * path[-1].fit.cost:
                break
            path.append(now)
        # Of what a step adds, part may earn its place only beside what comes after it: so the last step is looked at.
        return self._without_idle(path[-1], without) if path else now

    def _without_idle(self, found: JointSet, without: frozenset[str]) -> JointSet:
        """Without those terms that do not earn their place beside the others, the most idle first."""
        fewer = [s for t in found.terms if self.allowed(s := self.fit([u for u in found.terms if u is not t]))]
        fewer += [s for t in found.terms for s in self._simpler(found, t, without) if self.allowed(s)]
        idle = [s for s in fewer if not _is_needed(found, s)]
        return self._without_idle(min(idle, key=lambda s: s.fit.cost), without) if idle else found

    def _simpler(self, found: JointSet, term: Term, without: frozenset[str]) -> list[JointSet]:
        """Sets with the special case of a law in its place, or with dry friction in that of viscous friction."""
        alone = term.effect in VISCOUS and not _has(found, DRY)
        names = {*ARM_EFFECTS[term.effect].holds, *(DRY[:1] if alone else ())} - without
        return [self.fit([u if t is term else t for t in found.terms]) for u in self._terms if u.effect in names]

    def _steps(self, now: JointSet, without: frozenset[str]) -> Iterator[JointSet]:
        """Sets with one effect more, or with other laws of dry and of viscous friction."""
        tried = [t for t in self._terms if t.effect not in without]
        beside = [t for t in now.terms if not ARM_EFFECTS[t.effect].replaces]
        dry, viscous = ([None, *(t for t in tried if t.effect in laws)] for laws in (DRY, VISCOUS))
        for pair in product(dry, viscous):
            yield self.fit([*(t for t in pair if t is not None), *beside])
        for term in tried:
            if not ARM_EFFECTS[term.effect].replaces and term.effect not in now.names:
                yield self.fit([*now.terms, term])
