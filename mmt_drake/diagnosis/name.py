"""Which physics is missing: every effect is tried beside what is known, from several starts; then pairs.

A missing effect distorts the fit without it, sometimes into another regime altogether. So every candidate starts from
that fit and from the nominal parameters. Screening goes by halves: a few steps from each start with the derivatives
after the known parameters carried over; a few steps more, with all derivatives, from the best of each effect and
origin; a fit in full of what is promising.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.hypothesis import Hypothesis
from mmt_drake.diagnosis.problem import Fitted, Problem
from mmt_drake.effects.effect import Effect, Scales
from mmt_drake.errors import MmtError

Array = NDArray[np.float64]

SCREENING_STEPS = 2
SECOND_STEPS = 3
REFINING_STEPS = 25
_PROMISING = 0.5
"""A candidate is fitted in full if screening gave it this share of the best one's improvement."""
_MOST_REFINED = 8
_FEW_STARTS = 8
_MANY_KEPT = 3
_MOST_SEEDS = 4
_FURTHER = 16
_PARTS = (1.0, 0.3, 0.1, 0.03)
_WORTH = 0.1
"""A fit is worth adding to if it gained this share of what the best one did."""

Told = Callable[[str], None]


@dataclass(frozen=True)
class Attempt:
    """One start of one candidate.

    Attributes:
        base: the fit that it starts from.
        effect: what is added to it.
        values: starting values of the effect.
    """

    base: Fitted
    effect: Effect
    values: Mapping[str, float]

    def screened(self, problem: Problem, steps: int = SCREENING_STEPS) -> Fitted | None:
        """The candidate after a few steps; None where it cannot be simulated there."""
        hypothesis, start, known = self._begin()
        try:
            return problem.fit(hypothesis, self._sized(problem, hypothesis, start), steps=steps, known=known)
        except MmtError:
            return None

    def _sized(self, problem: Problem, hypothesis: Hypothesis, start: Array) -> Array:
        """The start, or the part of the way to it from no effect at all that fits best, if it fits worse than the base.

        Starts are as large as the whole force; beside a plain effect a slight one would be lost beyond its neighbour.
        """
        base = self.base
        structure, effects = base.hypothesis.structure_values(base.x), base.hypothesis.effect_values(base.x)
        vanished = self.effect.vanished(base.model)
        nothing = hypothesis.vector(structure, {**effects, self.effect.name: vanished}, base.skew)
        best, least = start, math.inf
        for part in _PARTS:
            x = nothing + part * (start - nothing)
            try:
                r = problem.residual(hypothesis.model(x), hypothesis.skew_of(x))
            except (MmtError, RuntimeError):
                continue
            if float(r @ r) < least:
                best, least = x, float(r @ r)
            if least < base.cost:
                break
        return best

    def _begin(self) -> tuple[Hypothesis, Array, Array]:
        base = self.base
        optional = [p.symbol for p in self.effect.parameters if p.default is not None]
        held = {symbol: self.values[symbol] for symbol in optional if symbol in self.values}
        hypothesis = base.hypothesis.adding(self.effect, held)
        structure = base.hypothesis.structure_values(base.x)
        effects = base.hypothesis.effect_values(base.x)
        start = hypothesis.vector(structure, {**effects, self.effect.name: self.values}, base.skew)
        before = {(place.effect, place.symbol): i for i, place in enumerate(base.hypothesis.places())}
        known = np.full((len(base.minimum.residual), len(start)), np.nan)
        for j, place in enumerate(hypothesis.places()):
            if (i := before.get((place.effect, place.symbol))) is not None:
                known[:, j] = base.minimum.jacobian[:, i]
        return hypothesis, start, known


@dataclass(frozen=True)
class Screened:
    """An attempt and where a few steps took it."""

    attempt: Attempt
    fitted: Fitted


def attempts(bases: Sequence[Fitted], library: Iterable[Effect], scales: Scales) -> list[Attempt]:
    """Every start of every effect that can be added, from each of several fits of the same hypothesis."""
    return [
        Attempt(base, effect, values)
        for effect in library
        if bases[0].hypothesis.admits(effect)
        for values in effect.starts(scales)
        for base in bases
    ]


def screen(
    problem: Problem, tries: Sequence[Attempt], executor: Executor, told: Told = lambda _: None, *, further: int = 1000
) -> list[Screened]:
    """Screen all attempts; of each set of effects the best from each origin, best first.

    Args:
        problem: what is fitted.
        tries: the attempts.
        executor: runs them.
        told: is told what has been tried.
        further: how many take the second round of steps.
    """
    found: dict[tuple[frozenset[str], int], list[Screened]] = {}
    waiting = {executor.submit(attempt.screened, problem): attempt for attempt in tries}
    for done in as_completed(waiting):
        if (fitted := done.result()) is not None:
            told(" + ".join(fitted.hypothesis.names))
            key = (fitted.hypothesis.key, id(waiting[done].base))
            found.setdefault(key, []).append(Screened(waiting[done], fitted))
    kept = sorted((s for starts in found.values() for s in _kept(starts)), key=_cost)
    first = kept[:further]
    fits = executor.map(_fitted_on, [problem] * len(first), [s.fitted for s in first], [SECOND_STEPS] * len(first))
    again = [Screened(s.attempt, fit) for s, fit in zip(first, fits, strict=True)]
    return sorted(again + kept[further:], key=_cost)


def _kept(starts: list[Screened]) -> list[Screened]:
    """The best start, or where there are many, for there are many minima, the best few."""
    return sorted(starts, key=_cost)[: 1 if len(starts) <= _FEW_STARTS else _MANY_KEPT]


def _cost(screened: Screened) -> float:
    return screened.fitted.cost


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
    best: dict[frozenset[str], Fitted] = {}
    for fitted in sorted(fits, key=lambda f: f.cost):
        best.setdefault(fitted.hypothesis.key, fitted)
    return list(best.values())


def _fitted_on(problem: Problem, fitted: Fitted, steps: int) -> Fitted:
    again = problem.fit(fitted.hypothesis, fitted.x, steps=steps)
    return again if again.cost <= fitted.cost else fitted


def search(
    problem: Problem,
    base: Fitted,
    library: Iterable[Effect],
    scales: Scales,
    executor: Executor,
    *,
    enough: float,
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
        enough: RMS of the residual over the noise floor below which nothing more is sought.
        most: effects at once.
        told: is told what has been tried.

    Returns:
        Of each number of effects, from one on: the candidates, best first.
    """
    levels: list[list[Fitted]] = []
    nominal = problem.at(base.hypothesis, base.hypothesis.base())
    tries = attempts((base, nominal), library, scales)
    seeds = [base]
    best_starts: dict[str, Attempt] = {}
    for level in range(most):
        if level > 0:
            tries = _further(seeds, best_starts)
        screened = screen(problem, tries, executor, told, further=1000 if level == 0 else _FURTHER)
        if not screened:
            break
        if level == 0:
            best_starts = {s.attempt.effect.name: s.attempt for s in reversed(screened)}
        found = refine(problem, screened, min(seed.cost for seed in seeds), executor)
        levels.append(found)
        if found[0].cost <= enough**2 * problem.samples():
            break
        seeds = _seeds(found, min(seed.cost for seed in seeds))
    return levels


def _seeds(found: Sequence[Fitted], before: float) -> list[Fitted]:
    """The fits that a further effect is added to: the best ones, if they gained anything worth while."""
    gain = before - found[0].cost
    return [f for f in found if before - f.cost > _WORTH * gain][:_MOST_SEEDS]


def _further(seeds: Sequence[Fitted], starts: Mapping[str, Attempt]) -> list[Attempt]:
    """Each seed with each other effect from where that did best alone; every set once, from its better seed."""
    tries: dict[frozenset[str], Attempt] = {}
    for seed in seeds:
        for name, attempt in starts.items():
            if seed.hypothesis.admits(attempt.effect):
                names = frozenset((*seed.hypothesis.names, name))
                tries.setdefault(names, Attempt(seed, attempt.effect, attempt.values))
    return list(tries.values())
