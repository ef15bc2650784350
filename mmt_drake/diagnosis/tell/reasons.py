"""Why an explanation was taken or not, in its own words."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.confidence import RULED_OUT, ConfidenceSet
from mmt_drake.diagnosis.fit.comparison import at_bounds
from mmt_drake.diagnosis.fit.problem import Fitted
from mmt_drake.diagnosis.tell.wording import capitalised, listed
from mmt_drake.effects.wording import words

HeldOutErrors = Mapping[frozenset[str], float | None]
"""Set of effects -> held-out error of its fit; None where the simulation of the raw recording diverges."""

_LEAST_CHANCE = 1e-6
_NEXT_TO_NOTHING = 1.02  # times the squared error
_NO_CHOICE = "Its held-out error is the lower one, but held-out blocks choose no name: they only confirm."


@dataclass(frozen=True)
class Reasons:
    """What the reasons of one diagnosis rest on.

    Attributes:
        named: the fit whose effects are named; None where none are.
        refit: held-out error without any effect.
        errors: held-out error of each set of effects.
        believed: what the sets that were fitted to the end came to; None where none were.
        ranked: all that was tried and is listed.
    """

    named: Fitted | None
    refit: float | None
    errors: HeldOutErrors
    believed: ConfidenceSet | None
    ranked: Sequence[Fitted] = ()

    def of(self, fitted: Fitted) -> str:
        """Why an explanation is named or is not, a sentence or two."""
        key = fitted.hypothesis.key
        if self.named is not None and key == self.named.hypothesis.key:
            return self._delivered()
        bounds = at_bounds(fitted)
        if bounds:
            return (
                f"{_many(bounds, 'ended')} at the edge of the range sought: a bound made this fit, it proves nothing."
            )
        if self.named is None:
            return self._unnamed(fitted)
        if self.believed is not None and key in self.believed.standing:
            return f"Not ruled out. {self._standing(fitted, self.named, self.believed)}"
        return " ".join(part for part in (self._behind(fitted, self.named), self._lower(fitted, self.named)) if part)

    def _delivered(self) -> str:
        members = () if self.believed is None else self.believed.members
        if len(members) > 1:
            return f"Delivered: the simplest of the {len(members)} that are not ruled out and may be named."
        return "Delivered: the only one that is not ruled out and may be named."

    def _unnamed(self, fitted: Fitted) -> str:
        """Of one that was tried where no name is given."""
        own, chance = self.errors.get(fitted.hypothesis.key), self._chance(fitted)
        if own is None:
            return "Its simulation of the whole recording diverges."
        if self.refit is None or own >= self.refit:
            return "It predicts held-out data no better than the parameters alone."
        ratio = significant(own / self.refit, 3)
        said = f"It leaves {ratio} times the held-out error of the parameters alone"
        if self.believed is not None and (unsaid := self.believed.unsaid.get(fitted.hypothesis.key)):
            return f"{said}. {_must_not(unsaid)}"
        if chance is None:
            return f"{said}: too much to be named."
        if chance < RULED_OUT:
            ruled_out = "Ruled out: another one, which has no name either, predicts blocks left out better."
            return f"{said}. {ruled_out} {_once(chance)}"
        return f"{said}: too much to be named. {_once(chance)}"

    def _standing(self, fitted: Fitted, named: Fitted, believed: ConfidenceSet) -> str:
        """Of one that is not ruled out beside the one that is named."""
        extra, lacking = _apart(fitted, named)
        unsaid = believed.unsaid.get(fitted.hypothesis.key, frozenset())
        if unsaid:
            return _must_not(unsaid)
        if not lacking:
            return f"But {_many(extra, 'is', 'are')} not needed beside {_names(named)}: simpler does as well."
        if not extra:
            return f"But without {_all(lacking)} too little is taken off to be named."
        return f"{capitalised(_all(extra))} does as well here as {_all(lacking)}."

    def _behind(self, fitted: Fitted, named: Fitted) -> str:
        """Of one that is ruled out, or that the search left behind."""
        extra, lacking = _apart(fitted, named)
        chance = self._chance(fitted)
        if not extra:
            what = f"without {_all(lacking)}"
        elif not lacking:
            what = f"with {_all(extra)} beside it"
        else:
            what = f"with {_all(extra)} in the place of {_all(lacking)}"
        if chance is not None:
            return f"Ruled out: it predicts blocks left out worse, {what}. {_once(chance)}"
        idle = self._idle(fitted)
        if idle:
            return idle
        ratio = fitted.cost / named.cost if named.cost > 0.0 else 1.0
        if ratio > _NEXT_TO_NOTHING:
            return f"Left behind by the search: {significant(ratio, 3)} times the squared error of the fit, {what}."
        return f"Left behind by the search: it fits no better, {what}."

    def _idle(self, fitted: Fitted) -> str:
        """What a part of it does as well without; nothing if no part does."""
        key = fitted.hypothesis.key
        parts = [f for f in self.ranked if f.hypothesis.key < key and f.cost <= _NEXT_TO_NOTHING * fitted.cost]
        if not parts:
            return ""
        best = min(parts, key=lambda f: f.cost)
        extra, own = key - best.hypothesis.key, _names(best)
        return f"{capitalised(_many(extra, 'takes', 'take'))} next to nothing off beside {own or 'the parameters'}."

    def _lower(self, fitted: Fitted, named: Fitted) -> str:
        own, best = self.errors.get(fitted.hypothesis.key), self.errors.get(named.hypothesis.key)
        return _NO_CHOICE if own is not None and best is not None and own < best else ""

    def _chance(self, fitted: Fitted) -> float | None:
        return None if self.believed is None else self.believed.chances.get(fitted.hypothesis.key)


def _must_not(unsaid: frozenset[str]) -> str:
    """Why effects have no name."""
    may = "must not be named: {} may do nothing of {} own, not happen here, or draw what any curve would"
    return f"But {_many(unsaid, may.format('it', 'its'), may.format('they', 'their'))}."


def _apart(fitted: Fitted, named: Fitted) -> tuple[frozenset[str], frozenset[str]]:
    """The effects that only the one has, and those that only the other has."""
    own, best = fitted.hypothesis.key, named.hypothesis.key
    return own - best, best - own


def _once(chance: float) -> str:
    if chance < _LEAST_CHANCE:
        return "Chance alone would do that less than once in a million times."
    if chance < 0.5:
        return f"Chance alone would do that once in {significant(1.0 / chance, 2)} times."
    return "That may well be chance."


def _names(fitted: Fitted) -> str:
    return _all(fitted.hypothesis.names)


def _all(names: Iterable[str]) -> str:
    return listed(map(words, sorted(names)))


def _many(names: Iterable[str], one: str, several: str | None = None) -> str:
    """Names and what is said of one or of several of them."""
    names = list(names)
    return f"{_all(names)} {one if len(names) == 1 else several or one}"
