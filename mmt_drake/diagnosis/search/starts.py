"""One start of one effect beside what is known: a few steps on a part of the problem, then on all of it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

import numpy as np

from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.hypothesis import Hypothesis
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.diagnosis.search.in_plane import per_axis_if_better
from mmt_drake.effects.effect import Effect, Scales
from mmt_drake.errors import attempt
from mmt_drake.numeric.arrays import Array

SCREENING_STEPS = 3
SETTLING_STEPS = 8
SETTLED = 3e-3
"""Relative decrease of the sum of squares in a step below which a fit has settled, for the time being."""
SECOND_STEPS = 3
_PARTS = (1.0, 0.3, 0.1, 0.03)
_TURNED = 0.5
"""What a promise counts for where the effect is wanted with the other sign: it takes steps to turn."""


T = TypeVar("T")


@dataclass(frozen=True)
class Seed:
    """A fit that effects are added to.

    Attributes:
        fitted: to all tracks.
        part: the part of the problem that screening looks at.
        near: that part, with the same numbers or better ones.
    """

    fitted: Fitted
    part: Problem
    near: Fitted

    @classmethod
    def on_parts(
        cls, fitted: Fitted, parts: Sequence[Problem], *, steps: int = 0, instead: Problem | None = None
    ) -> list[Seed]:
        """A fit, to be screened on each of several parts where it can be simulated; on each it may take steps more.

        Where it can be simulated on none, on what is to be looked at `instead`, as it is.
        """

        def near(part: Problem) -> Fitted:
            one = part.fit(fitted.hypothesis, fitted.x, steps=steps, secant=True) if steps else fitted
            return part.at(one.hypothesis, one.x)

        found = ((part, attempt(near, part)) for part in parts)
        seeds = [cls(fitted, part, begun) for part, begun in found if begun is not None]
        return seeds if seeds or instead is None else cls.on_parts(fitted, [instead])


@dataclass(frozen=True)
class Start:
    """One start of one candidate.

    Attributes:
        seed: the fit that it starts from.
        effect: what is added to it.
        values: starting values of the effect.
        promised: the part of the seed's cost that the effect is expected to take, where other fits say so.
    """

    seed: Seed
    effect: Effect
    values: Mapping[str, float]
    promised: float = 0.0

    @property
    def name(self) -> str:
        """Of the effects that it tries together."""
        return " + ".join((*self.seed.fitted.hypothesis.names, self.effect.name))

    def promise(self) -> float:
        """The part of the seed's cost that a little of the effect says it would take, to first order; one simulation.

        How much of the residual lies along its change (`slight`). What is promised already, where it says no more or
        cannot be simulated.
        """
        change = self.slight()
        if change is None:
            return self.promised
        left = _across(self.seed.near.directions, self.seed.near.minimum.residual)
        along, size = -float(left @ change), float(change @ change)
        part = along**2 / (size * self.seed.near.cost) if size > 0.0 else 0.0
        return max(self.promised, part if along > 0.0 else _TURNED * part)

    def slight(self) -> Array | None:
        """What a little of the effect makes of the seed's residual, and the numbers that are fitted cannot make."""
        problem, base = self.seed.part, self.seed.near
        hypothesis, start, _ = self._begin(base)
        slight = self._slighter(base, hypothesis, start, [_PARTS[-1]])[0]
        changed = attempt(problem.objective_at, hypothesis, slight)
        return None if changed is None else _across(base.directions, changed - base.minimum.residual)

    def screened(self) -> Fitted | None:
        """The candidate after a few steps on the seed's part; None where it cannot be simulated there."""
        return self._fitted(self.seed.part, self.seed.near, SCREENING_STEPS)

    def settled(self, problem: Problem, screened: Fitted) -> Fitted | None:
        """More steps on the seed's part, then what that leaves of the whole problem; None as `screened`."""
        part = self.seed.part
        found = attempt(
            part.fit, screened.hypothesis, screened.x, steps=SETTLING_STEPS, converged_at=SETTLED, secant=True
        )
        if found is None or part is problem:
            return found
        return attempt(problem.unchanged, found.hypothesis, found.x)

    def widened(self, problem: Problem, settled: Fitted | None, most: float = math.inf) -> Fitted | None:
        """A few steps on the whole problem; anew from the seed if its part has led astray. None as `screened`.

        Friction of which nobody said whether it is a vector is both: laws that act along each axis by themselves have a
        start over it otherwise, and it may be left behind for that alone. What costs more than `most` is out and stays
        as it is, unless it has lost what it was added to.
        """
        is_out = settled is not None and most < settled.cost <= self.seed.fitted.cost
        found = settled if is_out else self._on_all(problem, settled)
        return None if found is None else per_axis_if_better(problem, found, SETTLING_STEPS)

    def _on_all(self, problem: Problem, settled: Fitted | None) -> Fitted | None:
        if settled is not None and self.seed.part is not problem:
            settled = problem.fit(settled.hypothesis, settled.x, steps=SECOND_STEPS, secant=True)
        if settled is not None and settled.cost <= self.seed.fitted.cost:
            return settled
        anew = self._fitted(problem, self.seed.fitted, SECOND_STEPS)
        return min((f for f in (settled, anew) if f is not None), key=lambda f: f.cost, default=None)

    def _fitted(self, problem: Problem, base: Fitted, steps: int) -> Fitted | None:
        hypothesis, start, known = self._begin(base)
        x = self._sized(problem, base, hypothesis, start)
        return attempt(problem.fit, hypothesis, x, steps=steps, known=known, secant=True)

    def _sized(self, problem: Problem, base: Fitted, hypothesis: Hypothesis, start: Array) -> Array:
        """The start, or the part of the way to it from no effect at all that fits best, if it fits worse than the base.

        Starts are as large as the whole force; beside a plain effect a slight one would be lost beyond its neighbour.
        To first order the numbers that are fitted already have given way to it: what they made up for in its absence is
        no reason to begin with less.
        """
        known = base.directions
        best, least, enough = start, math.inf, _squared(_across(known, base.minimum.residual))
        for x in self._slighter(base, hypothesis, start, _PARTS):
            left = attempt(problem.objective_at, hypothesis, x)
            if left is not None and (cost := _squared(_across(known, left))) < least:
                best, least = x, cost
            if least < enough:
                break
        return best

    def _slighter(self, base: Fitted, hypothesis: Hypothesis, start: Array, parts: Sequence[float]) -> list[Array]:
        """Parts of the way from no effect at all to the start; what shapes the effect is the start's on all of it."""
        shapes = {p.symbol for p in self.effect.parameters if p.shape}
        vanished = self.effect.vanished(base.model) | {s: v for s, v in self.values.items() if s in shapes}
        nothing = base.numbers_for(hypothesis, {self.effect.name: vanished})
        return [nothing + part * (start - nothing) for part in parts]

    def _begin(self, base: Fitted) -> tuple[Hypothesis, Array, Array]:
        optional = [p.symbol for p in self.effect.parameters if p.default is not None]
        held = {symbol: self.values[symbol] for symbol in optional if symbol in self.values}
        hypothesis = base.hypothesis.adding(self.effect, held)
        start = base.numbers_for(hypothesis, {self.effect.name: self.values})
        before = {parameter.key: i for i, parameter in enumerate(base.hypothesis.free_parameters())}
        known = np.full((len(base.minimum.residual), len(start)), np.nan)
        for j, parameter in enumerate(hypothesis.free_parameters()):
            if (i := before.get(parameter.key)) is not None:
                known[:, j] = base.minimum.jacobian[:, i]
        return hypothesis, start, known


@dataclass(frozen=True)
class Screened:
    """A start and where a few steps took it."""

    start: Start
    fitted: Fitted


def _across(known: Array, residual: Array) -> Array:
    """What of a residual directions cannot take."""
    left: Array = residual - known @ (known.T @ residual)
    return left


def _squared(residual: Array) -> float:
    return float(residual @ residual)


def together(starts: Sequence[Start], executor: Executor) -> list[tuple[float, Start, Start]]:
    """Of each two starts beside one seed the part of its cost that both together promise, the greatest first.

    Args:
        starts: one or more, one of each effect, all from one seed.
        executor: runs a simulation of each.
    """
    slight = zip(starts, executor.map(Start.slight, starts), strict=True)
    changes = [(start, change) for start, change in slight if change is not None and change.any()]
    near = starts[0].seed.near
    left = _across(near.directions, near.minimum.residual)
    return [(taken / near.cost, one, other) for taken, one, other in _taken_by_two(changes, left)]


def added(before: Fitted, singles: Iterable[Fitted]) -> list[tuple[float, Fitted, Fitted]]:
    """Of each two effects what both are expected to leave of the cost before them, the least first.

    Each has changed the residual, with all numbers fitted beside it. Both together are expected to change it by the sum
    of these, each in the amount that serves best: what one alone hides from first derivatives (a delay that the damper
    made up for) is in its own fit.

    Args:
        before: the fit without effects.
        singles: fits of one effect each, of the same problem.
    """
    left = before.minimum.residual
    changes = [(single, single.minimum.residual - left) for single in singles]
    return [(before.cost - taken, one, other) for taken, one, other in _taken_by_two(changes, left)]


def _taken_by_two(changes: Sequence[tuple[T, Array]], residual: Array) -> list[tuple[float, T, T]]:
    """Of each two changes how much of a residual's square they take in their best amounts, the greatest first."""
    found = []
    for (one, a), (other, b) in combinations(changes, 2):
        span, _ = np.linalg.qr(np.column_stack([a, b]))
        found.append((_squared(span.T @ residual), one, other))
    return sorted(found, key=lambda pair: -pair[0])


def all_starts(seeds: Sequence[Seed], library: Iterable[Effect], scales: Scales) -> list[Start]:
    """Every start of every effect that can be added, from each of several fits of the same hypothesis."""
    return [
        Start(seed, effect, values)
        for effect in library
        if seeds[0].fitted.hypothesis.admits(effect)
        for values in effect.starts(scales)
        for seed in seeds
        if _may_show(seed, effect)
    ]


def _may_show(seed: Seed, effect: Effect) -> bool:
    """Whether an effect may do anything to the part of the problem that its seed looks at.

    Along the surface normal what slides on the table shows nothing, nor does a law along it show along the surface but
    by the load of friction.
    """
    normal = {isinstance(track, NormalTrack) for track in seed.part.tracks}
    if normal == {True}:
        return effect.axis == "z" or effect.block in ("force_sensor", "channel", "geometry")
    return normal != {False} or effect.axis != "z" or "z" not in seed.fitted.hypothesis.nominal.AXES
