"""Budget of the error of the model handed in: wrong values, named effects, what nobody has named, and noise."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from mmt_drake.diagnosis.fit.errors import ErrorOverSpread, HeldOutPart, intervals_of
from mmt_drake.diagnosis.fit.prepare import Prepared
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.errors import attempt
from mmt_drake.model.structure import Structure

PARAMETERS, SHARED, NAMELESS, NOISE = "parameters", "shared", "nameless", "noise"
NO_EFFECTS = frozenset((PARAMETERS, SHARED, NAMELESS, NOISE))


@dataclass(frozen=True)
class BudgetPart:
    """One part of the error of the model handed in.

    Attributes:
        part: `parameters`, the name of an effect, `shared`, `nameless` or `noise`.
        share: of the mean squared held-out error, 0 to 1.
        unique: of an effect, what comes back without it after all else was fitted again; None where it was not, or
            where that model diverges over what is held out.
    """

    part: str
    share: float
    unique: float | None = None


@dataclass(frozen=True)
class Ruler:
    """Mean squared held-out errors of models over the variance of what was measured, of all recordings together.

    Recordings count as they do in the fit (`mmt_drake.diagnosis.fit.floors.weighed`).

    Attributes:
        prepared: the recordings.
        problem: whose blocks are held out.
    """

    prepared: Prepared
    problem: Problem

    def of(self, model: Structure) -> float:
        """The error of a model; infinite where its simulation diverges."""
        error = attempt(self._of_all, lambda held: held.error(model))
        return math.inf if error is None else error

    def noise(self, model: Structure) -> float:
        """What noise alone leaves of a right model like this one."""
        return self._of_all(lambda held: held.noise(model))

    @property
    def heldout(self) -> list[HeldOutPart]:
        """Of every recording what is held out."""
        pairs = zip(self.prepared.recordings, self.problem.by_recording(), strict=True)
        return [
            HeldOutPart(
                recording,
                intervals_of(tracks[0].time, tracks[0].heldout),
                tracks[0].smoothed,
                tuple(track.axis for track in tracks if track.axis and track.is_whole),
            )
            for recording, tracks in pairs
        ]

    def _of_all(self, error: Callable[[HeldOutPart], ErrorOverSpread]) -> float:
        errors = [error(held) for held in self.heldout]
        counts = [(tracks[0].counts / tracks[0].floor) ** 2 for tracks in self.problem.by_recording()]
        squares = math.fsum(c * e.rms**2 for c, e in zip(counts, errors, strict=True))
        return squares / math.fsum(c * e.spread**2 for c, e in zip(counts, errors, strict=True))


def budget(
    ruler: Ruler, nominal: Structure, best: Fitted, wrong: Collection[str], without: Mapping[str, Fitted]
) -> tuple[BudgetPart, ...]:
    """The budget of a delivered model, counted backwards from it; shares sum to 1 and none is negative.

    What comes back when something is taken out of the delivered model, all else as it is: wrong values set back to what
    was handed in; an effect taken out, the mean over all orders in which the effects can go (Shapley 1953). What is
    back when all are out but by none of them is shared. Booked forwards, from the refit without effects, wrong values
    would get what they take on in the place of the effects.

    Args:
        ruler: tells errors.
        nominal: the model handed in.
        best: the fit that is delivered.
        wrong: parameters whose interval excludes what was handed in.
        without: effect -> the delivered set without it, fitted again.
    """
    names = best.hypothesis.names
    before, after = ruler.of(nominal), ruler.of(best.model)
    if before == 0.0:  # to the last bit as handed in
        nothing = (PARAMETERS, *names, SHARED, NAMELESS)
        return (*(BudgetPart(part, 0.0) for part in nothing), BudgetPart(NOISE, 1.0))
    if not after < before:
        after = before
    noise = min(ruler.noise(best.model), after)
    back = {kept: _left(ruler, best, (), kept) for kept in subsets(names)}
    ceiling = max(before, max((e for e in back.values() if math.isfinite(e)), default=before))
    back = {kept: min(e, ceiling) for kept, e in back.items()}
    shares = {name: max(shapley(name, names, back), 0.0) for name in names}
    reset = min(_left(ruler, best, wrong, names), ceiling)
    shares[PARAMETERS] = max(reset - after, 0.0) if wrong else 0.0
    gone, booked = before - after, math.fsum(shares.values())
    if booked > gone:
        shares = {part: share * gone / booked for part, share in shares.items()}
    alone = {name: ruler.of(fitted.model) for name, fitted in without.items()}
    unique = {name: max(error - after, 0.0) / before for name, error in alone.items() if math.isfinite(error)}
    parts = [BudgetPart(PARAMETERS, shares[PARAMETERS] / before)]
    parts += [BudgetPart(name, shares[name] / before, unique.get(name)) for name in names]
    parts += [BudgetPart(SHARED, max(gone - booked, 0.0) / before)]
    return (*parts, BudgetPart(NAMELESS, (after - noise) / before), BudgetPart(NOISE, noise / before))


def subsets(names: Sequence[str]) -> list[frozenset[str]]:
    """All sets of some of these names, the empty one first."""
    return [frozenset(some) for count in range(len(names) + 1) for some in combinations(names, count)]


def shapley(name: str, names: Sequence[str], errors: Mapping[frozenset[str], float]) -> float:
    """What comes back without an effect, the mean over all orders in which the effects can go (Shapley 1953).

    Args:
        name: of the effect.
        names: of all.
        errors: what is left with each of `subsets(names)`.
    """
    others = [n for n in names if n != name]
    total = 0.0
    for kept in subsets(others):
        orders = math.factorial(len(kept)) * math.factorial(len(others) - len(kept)) / math.factorial(len(names))
        total += orders * (errors[kept] - errors[kept | {name}])
    return total


def _left(ruler: Ruler, fitted: Fitted, reset: Collection[str], kept: Collection[str]) -> float:
    """What `_taken_from` leaves; without bound where it is none, as a body that loses more mass than was handed in."""
    model = attempt(_taken_from, fitted, reset, kept)
    return math.inf if model is None else ruler.of(model)


def _taken_from(fitted: Fitted, reset: Collection[str], kept: Collection[str]) -> Structure:
    """The model of a fit with some parameters as they were handed in, and some of its effects only."""
    hypothesis, effects = fitted.hypothesis, fitted.effect_values
    structure = {s: v for s, v in fitted.structure_values.items() if s not in reset}
    for effect, handed in hypothesis.believed:
        back = {s: v for s, v in handed.items() if f"{effect.name}.{s}" in reset}
        effects[effect.name] = {**effects[effect.name], **back}
    hypothesis = hypothesis.without(*(name for name in hypothesis.names if name not in kept))
    return hypothesis.model(hypothesis.vector(structure, effects))
