"""Beliefs about the links of an arm: as the file says, with a payload, tilted, or with other inertial numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.arms.folds import Folds, SharedNumbers
from mmt_drake.arms.laws import ARM_EFFECTS, LATE
from mmt_drake.arms.problem import ArmProblem
from mmt_drake.arms.search import BY_CHANCE, RARE, JointSearch, JointSet, chance_better
from mmt_drake.arms.shared_fit import FREE_SAMPLES, Belief, SharedFit
from mmt_drake.diagnosis.search.watch import NOTHING, Watch
from mmt_drake.effects.wording import words
from mmt_drake.numeric.arrays import Array

LOOSE = (0.1, 0.3, 1.0, 3.0)
"""How far inertial numbers may go from the file's, in parts of the link's mass: what held-out blocks bear."""
AS_WELL = 1.25
"""One belief explains as well as another if it leaves no more than so many times as much: the simpler one is taken, and
what is rare is not named where other links explain a joint as well."""
_AS_MUCH = 1.02
"""Of two effects that look alike the first of the list is taken, if it leaves no more than so many times as much."""
_SAID = 3
"""Effects that are named while it still looks; more are counted."""
_LIKELIEST = 4
"""Beliefs beyond the file whose joints are searched beside each other."""
_TURNS = 4
"""Joints whose effects are chosen again beside what the others say, at most."""
_GUESSED = 0.5
"""Links are guessed where other numbers change their torque by this part of it, or more."""
GAIN = 0.05
"""A belief beyond the file earns its place by so much of the squared error of all joints, in the geometric mean."""

AS_THE_FILE_SAYS, OTHER_LINKS = "the links as the file says", "other inertial numbers of the links"
WHOLE_ARM = "a payload, the direction of gravity, a delay"
"""Stages of the search."""


@dataclass(frozen=True)
class Believed:
    """What the search found under one belief.

    Attributes:
        fit: of all joints together.
        sets: of each joint that moves.
    """

    fit: SharedFit
    sets: dict[int, JointSet]

    @property
    def cost(self) -> float:
        """Mean over the joints that move of the logarithm of what they leave of held-out blocks."""
        moving = list(self.sets)
        return float(np.log(np.maximum(np.nanmean(self.fit.held_out[moving], axis=1), 1e-300)).mean())


def searched(
    problem: ArmProblem, belief: Belief, weights: Array, without: Mapping[int, frozenset[str]] | None = None
) -> Believed:
    """The effects of every joint under a belief.

    Args:
        problem: what is to be explained.
        belief: about the links.
        weights: of the joints, see `SharedFit`.
        without: joint -> effects that are not tried on it.
    """
    sets: dict[int, JointSet] = {}
    for j in problem.moving:
        left_out = (without or {}).get(j, frozenset())
        sets[j] = joint_search(problem, belief, j).best(_left_out(belief, left_out))
    terms = {j: s.terms for j, s in sets.items()}
    return Believed(SharedFit(problem, belief, terms, weights), sets)


def joint_search(problem: ArmProblem, belief: Belief, joint: int) -> JointSearch:
    """The search of one joint under a belief."""
    row = problem.rows[joint]
    shared = None
    if belief.prior is not None:
        held = np.diag(belief.prior * row.spread(problem.inner) ** 2 * FREE_SAMPLES)
        shared = SharedNumbers(range(len(held)), np.zeros(len(held)), held)
    return JointSearch(row, Folds(row.sums, problem.inner, shared), belief.held_in(row))


def search_beside(found: Believed, joint: int) -> JointSearch:
    """The search of one joint beside what the other joints say of the numbers that all share.

    Args:
        found: sets of all joints.
        joint: its number.
    """
    row = found.fit.problem.rows[joint]
    return JointSearch(row, Folds(row.sums, found.fit.problem.inner, found.fit.known_without(joint)))


def together(found: Believed, without: Mapping[int, frozenset[str]] | None = None) -> Believed:
    """With sets of single joints that fit better to what the others say of the numbers that all share.

    A joint by itself bends these numbers, such as a payload's, to what no other joint bears out, in the place of an
    effect of its own. The joint whose set is the greatest gain to all comes first.

    Args:
        found: sets of all joints.
        without: joint -> effects that are not tried on it.
    """
    weights = np.zeros(len(found.fit.problem.rows))
    for j, own in found.sets.items():
        weights[j] = 1.0 / max(own.fit.cost, 1e-12)
    now = replace(found, fit=replace(found.fit, weights=weights))
    for _ in range(_TURNS):
        better_ones = []
        for j in now.sets:
            own = search_beside(now, j).best(_left_out(found.fit.belief, (without or {}).get(j, frozenset())))
            if own.terms != now.sets[j].terms:
                sets = {**now.sets, j: own}
                better_ones.append(Believed(replace(now.fit, sets={i: s.terms for i, s in sets.items()}), sets))
        best = min(better_ones, key=lambda b: b.cost, default=now)
        if not better(best, now):
            break
        now = best
    return replace(now, fit=replace(now.fit, weights=by_what_is_left(now)))


def again(found: Believed, problem: ArmProblem, watch: Watch) -> Believed:
    """The same belief about another problem, its joints searched once more if there is time.

    Args:
        found: what was found.
        problem: of the same logs.
        watch: the clock.
    """
    if watch.is_late():
        return replace(found, fit=replace(found.fit, problem=problem))
    without = dict.fromkeys(_on_guessed_links(found), frozenset({"load_dependent_friction"}))
    return together(searched(problem, found.fit.belief, found.fit.weights, without), without)


def _on_guessed_links(found: Believed) -> list[int]:
    """Joints whose links' torque is half another one than the file's, or more: what it is, is hardly known."""
    fit = found.fit
    if not fit.numbers_of_links:
        return []
    x, nominal, guessed = fit.fitted(fit.problem.inner)[fit.numbers_of_links], fit.problem.nominal, []
    for j in fit.problem.moving:
        gram = fit.problem.rows[j].sums[0][fit.problem.inner].sum(axis=0)[: len(x), : len(x)]
        if x @ gram @ x > _GUESSED**2 * ((nominal + x) @ gram @ (nominal + x)):
            guessed.append(j)
    return guessed


def _with_together(every: Sequence[Believed], some: Sequence[Believed]) -> list[Believed]:
    """All of these, in their order; joints of some of them searched together."""
    return [together(one) if any(one is likely for likely in some) else one for one in every]


def _left_out(belief: Belief, without: frozenset[str]) -> frozenset[str]:
    """Effects that are not tried: a gain beside free inertial numbers is the same as these scaled."""
    return without | {"torque_gain"} if belief.name == "refit" else without


def _refits(problem: ArmProblem) -> Iterator[Belief]:
    for loose in LOOSE:
        # In units of each joint's own spread; the shared fit weighs the joints by what they leave.
        yield Belief("refit", prior=1.0 / (loose * problem.scale) ** 2)


def _whole_arm(problem: ArmProblem) -> Iterator[Belief]:
    for term in problem.rows[problem.moving[0]].terms:
        if ARM_EFFECTS[term.effect].reaches_all:
            yield Belief(term.effect, (term,))


def better(one: Believed, other: Believed) -> bool:
    """Whether one belief predicts better than another, by enough to be told and not by chance."""
    moving = list(one.sets)
    before, after = (b.fit.held_out[moving].ravel() for b in (other, one))
    known = np.isfinite(before) & np.isfinite(after)
    return one.cost < other.cost + np.log(1.0 - GAIN) and chance_better(before[known], after[known]) < BY_CHANCE


def tightest(refits: Sequence[Believed]) -> Believed:
    """Of refits than which none predicts better by enough to be told, that which holds the links closest to the file.

    Args:
        refits: one or more, the tightest first.
    """
    least = min(b.cost for b in refits)
    return next(b for b in refits if b.cost + np.log(1.0 - GAIN) <= least)


def is_sensible(found: Believed) -> bool:
    """Whether what the belief adds to the arm has numbers that it may have: no arm carries more than it weighs."""
    fit, inner = found.fit, found.fit.problem.inner
    x = fit.fitted(inner)
    half = fit.deviations(x, inner)
    for term, at in fit.numbers_held:
        law = ARM_EFFECTS[term.effect]
        size = at[:1] if law.place == "link" else at  # a payload that has no mass is none
        if not law.allows(x[at]) or all(abs(x[size]) <= half[size]):
            return False
        if law.place == "link" and not (fit.are_told(inner)[at[0]] and x[at[0]] <= fit.problem.mass):
            return False
    return True


def is_late_under_way(late: Believed, none: Believed) -> bool:
    """Whether a delay or lag of the torque shows while the joints are under way, and not at turns alone.

    Friction that gives way before it slips has its torque turn later than the motion, and one that sticks sooner: that
    looks like a delay at turns, and is none.

    Args:
        late: with the delay.
        none: without it.
    """
    away = late.fit.problem.between_turns
    one, other = (replace(b, fit=replace(b.fit, problem=away)) for b in (late, none))
    return bool(np.isfinite(one.cost) and np.isfinite(other.cost)) and better(one, other)


def by_what_is_left(found: Believed) -> Array:
    """Weights of the joints, one over the mean squared error of what is held out [1/(N m)^2]; 0 of one that rests."""
    weights = np.zeros(len(found.fit.problem.rows))
    for j in found.sets:
        weights[j] = 1.0 / max(float(np.nanmean(found.fit.held_out[j])), 1e-12)
    return weights


def settled(problem: ArmProblem, watch: Watch, noise: Array) -> tuple[Believed, list[Believed]]:
    """The belief that is delivered, the simplest that no other one beats; and all that were tried.

    What every joint may have is always tried beside the links as the file says; the rest while there is time.

    Args:
        problem: what is to be explained.
        watch: the clock.
        noise: (joints,) mean squared noise of the torque [(N m)^2].
    """

    def tried_in_time(beliefs: Sequence[Belief]) -> Iterator[Believed]:
        for number, belief in enumerate(beliefs):
            if watch.is_late():
                watch.miss(b.said for b in beliefs[number:])
                return
            watch.did(belief.said, number, len(beliefs))
            one = searched(problem, belief, weights)
            watch.saw(_names(one), _over_noise(one, noise))
            yield one

    plain = dict.fromkeys(problem.moving, RARE)
    watch.begin(AS_THE_FILE_SAYS)
    first = searched(problem, Belief("none"), np.ones(len(problem.rows)), plain)
    weights = by_what_is_left(first)
    watch.saw(NOTHING, _over_noise(replace(first, fit=replace(first.fit, sets={})), noise))
    watch.saw(_names(first), _over_noise(first, noise))
    watch.answer()
    none = replace(first, fit=replace(first.fit, weights=weights))
    if watch.is_late():
        watch.miss(sorted(RARE))
    else:
        none = searched(problem, Belief("none"), weights)
    watch.begin(OTHER_LINKS)
    refits = list(tried_in_time(list(_refits(problem))))
    watch.begin(WHOLE_ARM)
    arms = [b for b in tried_in_time(list(_whole_arm(problem))) if is_sensible(b)]
    arms = [b for b in arms if b.fit.belief.name not in LATE or is_late_under_way(b, none)]
    if not watch.is_late():
        refits = _with_together(refits, [tightest(refits)])
        likeliest = sorted(arms, key=lambda b: b.cost)[:_LIKELIEST]
        arms = [b for b in _with_together(arms, likeliest) if is_sensible(b)]
    # What is rare is not taken on a joint where other links explain as much.
    doubtful = {j: RARE for j in problem.moving if any(_explains(b, none, j) for b in (*refits, *arms))}
    if any(none.sets[j].names & RARE for j in doubtful):
        none = searched(problem, Belief("none"), weights, doubtful)
    tried = [none, *arms, *refits]
    # A spring in a joint draws a little of any error of the links: it has to explain more than other links do.
    arms = [b for b in arms if b.fit.belief.name != "joint_elasticity" or all(better(b, r) for r in refits)]
    arms.sort(key=lambda b: b.cost)
    arms[:1] = sorted((b for b in arms[:2] if _alike(b, arms[0])), key=lambda b: tried.index(b))[:1]
    refit = tightest(refits) if refits else none
    if arms and better(arms[0], none) and (not refits or _as_well(arms[0], refit)):
        best = arms[0]
    else:
        best = refit if better(refit, none) else none
    if best is not none and watch.is_late():
        watch.miss(sorted(RARE))
    elif best is not none:
        arm = arms[0] if arms and best is refit else None
        best, more = _with_another(best, weights, watch)
        tried += more
        if arm is not None:
            both, more = _with_another(arm, weights, watch)
            tried += more
            best = both if both is not arm and better(both, none) and _as_well(both, best) else best
        best = together(best)
    return best, tried


def _with_another(found: Believed, weights: Array, watch: Watch) -> tuple[Believed, list[Believed]]:
    """A belief with one more effect of the whole arm, where that is better; and all that were tried.

    That is gravity, a delay, or a payload beside these.
    """
    belief, problem = found.fit.belief, found.fit.problem
    known = {ARM_EFFECTS[term.effect].family for term in belief.held}
    known |= {"inertia"} if belief.prior is not None else set()
    tried = []
    for term in problem.rows[problem.moving[0]].terms:
        law = ARM_EFFECTS[term.effect]
        if law.place == "joint" or law.family in known or watch.is_late():
            continue
        one = searched(problem, replace(belief, held=(*belief.held, term)), weights)
        if is_sensible(one) and (term.effect not in LATE or is_late_under_way(one, found)):
            tried.append(one)
    return min((b for b in tried if better(b, found)), key=lambda b: b.cost, default=found), tried


def _alike(one: Believed, best: Believed) -> bool:
    """Whether a belief is of the family of the best one, of the same place, and explains as much."""
    law, other = (ARM_EFFECTS[b.fit.belief.name] for b in (one, best))
    same = (law.family, one.fit.belief.held[0].where) == (other.family, best.fit.belief.held[0].where)
    return same and one.cost < best.cost + np.log(_AS_MUCH)


def _as_well(one: Believed, refit: Believed) -> bool:
    """Whether an effect of the whole arm stands for a refit: not if it leaves more and needs more of what is rare."""
    rare, of_refit = (sum(len(s.names & RARE) for s in b.sets.values()) for b in (one, refit))
    return one.cost < refit.cost + (np.log(AS_WELL) if rare <= of_refit else 0.0)


def _names(one: Believed) -> str:
    """What a belief adds to the model, in a few words."""
    joints = one.fit.problem.arm.joints
    every = [f"{t.effect} on {joints[j]}" for j, s in one.sets.items() for t in s.terms]
    said = ([] if one.fit.belief.name == "none" else [one.fit.belief.said]) + every[:_SAID]
    return words(" and ".join(said + ([f"{len(every) - _SAID} more"] if len(every) > _SAID else []))) or NOTHING


def _over_noise(one: Believed, noise: Array) -> float:
    """RMS of what is left over the noise, in the geometric mean of the joints that move."""
    moving = list(one.sets)
    left = np.nanmean(one.fit.held_out[moving], axis=1) / np.maximum(noise[moving], 1e-300)
    return float(np.exp(0.5 * np.log(np.maximum(left, 1e-300)).mean()))


def _explains(other: Believed, own: Believed, joint: int) -> bool:
    """Whether a joint is explained about as well by other links alone, which have one set of numbers for all joints."""
    if other.sets[joint].names & RARE:
        return False
    left, before = (float(np.nanmean(b.fit.held_out[joint])) for b in (other, own))
    return left < AS_WELL * before
