"""Which physics is missing: every effect is tried beside what is known, from several starts; then pairs.

Screening takes a few steps from each start with the derivatives after the known parameters carried over; what looks
promising is then fitted in full. A hypothesis with one more effect starts from the fit without it, where the
effect vanishes, too: so it can never fit worse.
"""

from __future__ import annotations

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
REFINING_STEPS = 25
_PROMISING = 0.5
"""A candidate is fitted in full if screening gave it this share of the best one's improvement."""
_MOST_REFINED = 8

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
            return problem.fit(hypothesis, start, steps=steps, known=known)
        except MmtError:
            return None

    def _begin(self) -> tuple[Hypothesis, Array, Array]:
        base = self.base
        held = {p.symbol: self.values[p.symbol] for p in self.effect.parameters if p.default is not None and p.symbol in self.values}
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


def attempts(base: Fitted, library: Iterable[Effect], scales: Scales) -> list[Attempt]:
    """Every start of every effect that can be added to a fit."""
    return [
        Attempt(base, effect, values)
        for effect in library
        if base.hypothesis.admits(effect)
        for values in effect.starts(scales)
    ]


def screen(
    problem: Problem, tries: Sequence[Attempt], executor: Executor, told: Told = lambda _: None
) -> list[Fitted]:
    """Screen all attempts; the best of each set of effects, best first."""
    best: dict[frozenset[str], Fitted] = {}
    for done in as_completed([executor.submit(attempt.screened, problem) for attempt in tries]):
        fitted = done.result()
        if fitted is None:
            continue
        told(" + ".join(fitted.hypothesis.names))
        names = frozenset(fitted.hypothesis.names)
        if names not in best or fitted.cost < best[names].cost:
            best[names] = fitted
    return sorted(best.values(), key=lambda f: f.cost)


def refine(problem: Problem, screened: Sequence[Fitted], base_cost: float, executor: Executor) -> list[Fitted]:
    """Fit the promising ones in full; best first, the others behind as they were screened."""
    if not screened:
        return []
    gain = base_cost - screened[0].cost
    promising = [f for f in screened if base_cost - f.cost >= _PROMISING * gain][:_MOST_REFINED]
    refined = list(executor.map(_refine, [problem] * len(promising), promising))
    rest = [f for f in screened if not any(f is p for p in promising)]
    return sorted(refined, key=lambda f: f.cost) + rest


def _refine(problem: Problem, fitted: Fitted) -> Fitted:
    again = problem.fit(fitted.hypothesis, fitted.x, steps=REFINING_STEPS)
    return again if again.cost <= fitted.cost else fitted
