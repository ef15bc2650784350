"""Which physics is missing: every effect is tried beside what is known, from several starts; then pairs.

A missing effect distorts the fit without it, sometimes into another regime altogether. So every candidate starts from
that fit and from the nominal parameters. Screening goes by halves: a few steps from each start, on the track that is
explained worst, with the derivatives after the known parameters carried over; a few steps more, with all derivatives
and on all tracks, from the best of each effect and origin; a fit in full of what is promising. One track at first is
faster, and safer: an axis that slips now and then only takes stick-slip into one of many minima.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.attempts import SETTLED, SETTLING_STEPS, Attempt, Screened, Seed, attempts
from mmt_drake.diagnosis.hypothesis import Hypothesis
from mmt_drake.diagnosis.moments import placed
from mmt_drake.diagnosis.problem import Fitted, Problem
from mmt_drake.effects.effect import Effect, Scales
from mmt_drake.errors import MmtError

Array = NDArray[np.float64]

REFINING_STEPS = 25
_PROMISING = 0.5
"""A candidate is fitted in full if screening gave it this share of the best one's improvement."""
_MOST_REFINED = 8
_FEW_STARTS, _FEW_KEPT, _MANY_KEPT = 16, 1, 3
_WIDENED = 2
_SHAKEN, _TURNS, _MOVES = 2, 5, 8
_RUGGED = 5.0
"""RMS of the residual over the noise above which another minimum is sought where there are many ..."""
_NEAR = 4.0
"""... by fits that leave at most this many times as much variance as the best one."""
_MOST_SEEDS = 4
_FURTHER = 16
_WORTH = 0.1
"""A fit is worth adding to if it gained this share of what the best one did."""

Told = Callable[[str], None]
Enough = Callable[[Fitted], bool]


def screen(
    problem: Problem, tries: Sequence[Attempt], executor: Executor, told: Told = lambda _: None, *, further: int = 1000
) -> list[Screened]:
    """Screen all attempts; of each set of effects the best from each origin, best first.

    Args:
        problem: what is fitted.
        tries: the attempts.
        executor: runs them.
        told: is told what has been tried.
        further: how many go on to the whole problem; the others are left behind. All then look at the same part.
    """
    found: dict[tuple[frozenset[str], int], list[Screened]] = {}
    # In the order of the attempts, not of their ends: equals must come out the same whoever does the work.
    for attempt, fitted in zip(tries, executor.map(Attempt.screened, tries), strict=True):
        if fitted is not None:
            told(" + ".join(fitted.hypothesis.names))
            screened = Screened(attempt, fitted)
            found.setdefault((fitted.hypothesis.key, id(screened.attempt.seed.fitted)), []).append(screened)
    kept = sorted((s for starts in found.values() for s in _kept(starts)), key=lambda s: s.fitted.cost)[:further]
    fits = executor.map(Attempt.settled, *zip(*((s.attempt, problem, s.fitted) for s in kept), strict=True))
    settled: dict[frozenset[str], list[tuple[Attempt, Fitted | None]]] = {}
    for one, fit in zip(kept, fits, strict=True):
        settled.setdefault(one.fitted.hypothesis.key, []).append((one.attempt, fit))
    best = [pair for pairs in settled.values() for pair in sorted(pairs, key=_cost)[:_WIDENED]]
    fits = executor.map(Attempt.widened, *zip(*((attempt, problem, fit) for attempt, fit in best), strict=True))
    again = [Screened(attempt, fit) for (attempt, _), fit in zip(best, fits, strict=True) if fit is not None]
    return sorted(again, key=lambda s: s.fitted.cost)


def _cost(pair: tuple[Attempt, Fitted | None]) -> float:
    return math.inf if pair[1] is None else pair[1].cost


def _kept(starts: list[Screened]) -> list[Screened]:
    """The best starts, more where there are many, for there are many minima."""
    return sorted(starts, key=lambda s: s.left)[: _FEW_KEPT if len(starts) <= _FEW_STARTS else _MANY_KEPT]


def refine(problem: Problem, screened: Sequence[Screened], base_cost: float, executor: Executor) -> list[Fitted]:
    """Fit the promising sets of effects in full, from each origin; the best of each set, best first."""
    if not screened:
        return []
    gain = base_cost - screened[0].fitted.cost
    fits = [s.fitted for s in screened]
    good = [f.hypothesis.key for f in fits if base_cost - f.cost >= _PROMISING * gain]
    promising = set(list(dict.fromkeys(good))[:_MOST_REFINED])
    chosen = [f for f in fits if f.hypothesis.key in promising]
    fits += executor.map(_fitted_on, [problem] * len(chosen), chosen, [REFINING_STEPS] * len(chosen))
    return _best_of_each(fits)


def _best_of_each(fits: Iterable[Fitted]) -> list[Fitted]:
    """The best fit of each set of effects, best first."""
    best: dict[frozenset[str], Fitted] = {}
    for fitted in sorted(fits, key=lambda f: f.cost):
        best.setdefault(fitted.hypothesis.key, fitted)
    return list(best.values())


def swap(
    problem: Problem, found: Sequence[Fitted], library: Iterable[Effect], scales: Scales, executor: Executor, told: Told
) -> list[Fitted]:
    """Try others from all their starts in the place of the friction that the best fit has; all, best first.

    Laws of friction resemble each other, and beside a second effect the right one is easily missed from one start.
    """
    best = found[0]
    rubbing = [effect for effect in best.hypothesis.effects if effect.place == "Fc"]
    if not rubbing:
        return list(found)
    hypothesis = best.hypothesis.without(rubbing[0].name)
    structure, effects = best.hypothesis.structure_values(best.x), best.hypothesis.effect_values(best.x)
    rest = problem.at(hypothesis, hypothesis.vector(structure, effects, best.skew))
    siblings = [effect for effect in library if effect.place == "Fc"]
    tries = attempts(Seed.on_parts(rest, problem.eased(rest)[:1]), siblings, scales)
    others = refine(problem, screen(problem, tries, executor, told), rest.cost, executor)
    return _best_of_each([*found, *others])


def shake(problem: Problem, found: Sequence[Fitted], executor: Executor) -> list[Fitted]:
    """Move the best fits with many minima about and fit them again, keeping what is better; all, best first.

    Where bodies stick and slip, or something begins, one event more or less is another minimum, and there is no way
    down from there. Several moves of different size at once, and again from the best of them, until one leaves no more
    than another minimum could.
    """
    near = [f for f in found if f.cost <= _NEAR * found[0].cost]
    best = [f for f in near if any(map(_has_events, f.hypothesis.effects))][:_SHAKEN]
    keys = {f.hypothesis.key for f in best}
    rest = [f for f in found if f.hypothesis.key not in keys]
    for turn in range(_TURNS):
        least = min(f.cost for f in (found[0], *best))
        if not best or least <= _RUGGED**2 * problem.samples():
            break
        numbers = range(turn * _MOVES, (turn + 1) * _MOVES)
        moved = [(problem, f.hypothesis, f.hypothesis.moved(f.x, number)) for f in best for number in numbers]
        fits = list(executor.map(_fitted_again, *zip(*moved, strict=True)))
        for i, fitted in enumerate(best):
            again = [f for f in fits[i * _MOVES : (i + 1) * _MOVES] if f is not None]
            best[i] = min([fitted, *again], key=lambda f: f.cost)
    return sorted([*best, *rest], key=lambda f: f.cost)


def _has_events(effect: Effect) -> bool:
    return effect.place == "Fc" or any(p.shape for p in effect.parameters)


def _fitted_again(problem: Problem, hypothesis: Hypothesis, x: Array) -> Fitted | None:
    try:
        return problem.fit(hypothesis, x, steps=SETTLING_STEPS, converged_at=SETTLED)
    except MmtError:
        return None


def _fitted_on(problem: Problem, fitted: Fitted, steps: int) -> Fitted:
    again = problem.fit(fitted.hypothesis, placed(problem, fitted.hypothesis, fitted.x), steps=steps)
    return again if again.cost <= fitted.cost else fitted


def search(
    problem: Problem,
    base: Fitted,
    library: Iterable[Effect],
    scales: Scales,
    executor: Executor,
    *,
    enough: Enough,
    most: int = 3,
    told: Told = lambda _: None,
) -> list[list[Fitted]]:
    """Try one effect, then two, then three, as long as more than noise is left.

    Args:
        problem: what is fitted.
        base: the fit without effects.
        library: effects to try.
        scales: of the recordings.
        executor: runs the fits.
        enough: whether a fit leaves so little that nothing more need be sought.
        most: effects at once.
        told: is told what has been tried.

    Returns:
        Of each number of effects, from one on: the candidates, best first.
    """
    levels: list[list[Fitted]] = []
    nominal = problem.at(base.hypothesis, base.hypothesis.base())
    parts = problem.eased(base)
    origins = [*Seed.on_parts(base, parts, steps=SETTLING_STEPS), *Seed.on_parts(nominal, parts)]
    tries = attempts(origins, library, scales)
    seeds = [base]
    best_starts: dict[str, Attempt] = {}
    for level in range(most):
        if level > 0:
            parts = problem.eased(seeds[0])[:1]
            first, *others = (begun for seed in seeds for begun in Seed.on_parts(seed, parts))
            tries = [*attempts([first], library, scales), *_further(others, best_starts)]
        screened = screen(problem, tries, executor, told, further=1000 if level == 0 else _FURTHER)
        if not screened:
            break
        if level == 0:
            best_starts = {s.attempt.effect.name: s.attempt for s in reversed(screened)}
        found = refine(problem, screened, min(seed.cost for seed in seeds), executor)
        if level > 0 and not enough(found[0]):
            found = swap(problem, found, library, scales, executor, told)
        found = shake(problem, found, executor)
        levels.append(found)
        if enough(found[0]):
            break
        seeds = _seeds(found, min(seed.cost for seed in seeds))
        if not seeds:
            break
    return levels


def _seeds(found: Sequence[Fitted], before: float) -> list[Fitted]:
    """The fits that a further effect is added to: the best ones, if they gained anything worth while."""
    gain = before - found[0].cost
    return [f for f in found if before - f.cost > _WORTH * gain][:_MOST_SEEDS]


def _further(seeds: Sequence[Seed], starts: Mapping[str, Attempt]) -> list[Attempt]:
    """Each seed with each other effect from where that did best alone; every set once, from its better seed."""
    tries: dict[frozenset[str], Attempt] = {}
    for seed in seeds:
        for name, attempt in starts.items():
            if seed.fitted.hypothesis.admits(attempt.effect):
                names = frozenset((*seed.fitted.hypothesis.names, name))
                tries.setdefault(names, Attempt(seed, attempt.effect, attempt.values))
    return list(tries.values())
