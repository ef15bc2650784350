"""One diagnosis against the truth: what was right, what was a false name, how good the numbers were.

Rules, in the order in which they decide:

* The *answer* is the set of names in `effects`, a `tabulated_force` left out: that is a shape, not a name.
* Published equals count as one another: constant force with Coulomb friction is asymmetric Coulomb friction as long as
  the force is not above the friction level. Where the model has friction already, constant force alone is.
* A name holds as deep as it is called `certain`: the law, a law of the same family, or one in the same block.
* `correct`, something concealed that has a name: named with exactly the true names, all of them certain as laws, or
  `ambiguous` with them in `effects`; `missing_physics`, or where a remainder is beneath it `partly_explained`. Where
  the truth has an equal, either will do, but unless the verdict is `ambiguous` the other one must be among
  `alternatives` as indistinguishable. `right_family`: the same, certain as a family at least.
* `correct`, something that has no name: `unexplained`, or named no deeper than its family or block, and the right
  block first. Nothing concealed: `no_mismatch` where the nominal parameters are exact, `parameters` where they are
  not.
* `false_name`: a name (with any verdict but `ambiguous`) that is not true at the depth called certain, nor true of a
  part of the remainder, or is one of an equal pair whose other is not listed; or `ambiguous` between sets of which
  none holds only true names.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from mmt_drake.effects import LIBRARY

Names = frozenset[str]

NOTICEABLE: Final = 3.0
"""Residual after refit over the noise floor from which on a person would notice."""
_CIRCULAR: Final = {"phase": 2.0 * math.pi}  # symbol -> period
_NO_NUMBER: Final = ("side",)  # right or wrong, without an interval


@dataclass(frozen=True)
class ScoredNumber:
    """One true number and what was said of it.

    Attributes:
        symbol: effect and parameter, `static_friction.Fs`; of the object `m`.
        relative_error: |value - true| / |true|; of an angle over its period.
        covered: whether the 95 % interval holds the true value; None without an interval.
    """

    symbol: str
    relative_error: float
    covered: bool | None


@dataclass(frozen=True)
class TrialScore:
    """How a diagnosis did; fields as in the rules above.

    Attributes:
        truth: the sealed truth.
        verdict: of the diagnosis; `crashed` if there was none.
        effects: names, without a tabulated force.
        correct, right_family, false_name: see above.
        block_correct: the leading blocks are those of the truth; None where nothing is concealed.
        residual_over_noise: held-out error after refit over the noise floor; None where it says nothing of it.
        seconds: that it took.
        heldout_nrmse, noise_floor: of the diagnosis.
        quantities: effect parameters, of correctly named effects.
        base_quantities: the object's parameters that were said to be wrong, where nothing false was named.
    """

    truth: Mapping[str, Any]
    verdict: str
    effects: tuple[str, ...]
    correct: bool
    right_family: bool
    false_name: bool
    block_correct: bool | None
    residual_over_noise: float | None
    seconds: float
    heldout_nrmse: Mapping[str, float]
    noise_floor: float | None
    quantities: tuple[ScoredNumber, ...]
    base_quantities: tuple[ScoredNumber, ...]

    @property
    def noticeable(self) -> bool:
        """Whether a person would notice what refitting leaves."""
        return self.residual_over_noise is not None and self.residual_over_noise >= NOTICEABLE

    def line(self) -> dict[str, Any]:
        """The case's entry in the trial's JSON."""
        return {
            **{name: self.truth[name] for name in ("case", "kind", "structure")},
            "truth": list(self.truth["truth"]),
            "verdict": self.verdict,
            "effects": list(self.effects),
            **{name: getattr(self, name) for name in ("correct", "right_family", "false_name", "block_correct")},
            "noticeable": self.noticeable,
            "size": self.truth["size"],
            "visibility": self.truth["visibility"],
            "seconds": self.seconds,
            "heldout_nrmse": dict(self.heldout_nrmse),
            "noise_floor": self.noise_floor,
        }


def score(truth: Mapping[str, Any], diagnosis: Mapping[str, Any], seconds: float) -> TrialScore:
    """Score one diagnosis.

    Args:
        truth: of `Case.truth`.
        diagnosis: the contract's `diagnosis.json`.
        seconds: that it took.
    """
    said = _Answer(truth, diagnosis)
    fit = diagnosis.get("fit") or {}
    errors, floor = fit.get("heldout_nrmse") or {}, fit.get("noise_floor")
    ratio = errors["refit"] / floor if floor and errors.get("refit") is not None else None
    false_name = said.is_false()
    return TrialScore(
        truth=truth,
        verdict=said.verdict,
        effects=said.names,
        correct=not false_name and said.is_correct(("law",)),
        right_family=not false_name and said.is_correct(("law", "family")),
        false_name=false_name,
        block_correct=said.block_correct(),
        residual_over_noise=ratio,
        seconds=seconds,
        heldout_nrmse=errors,
        noise_floor=floor,
        quantities=() if false_name else said.effect_quantities(),
        base_quantities=() if false_name or said.answer != said.real else said.base_quantities(),
    )


def equal_sets(truth: Mapping[str, Any]) -> tuple[Names, ...]:
    """Other sets of names that describe the truth exactly."""
    real = frozenset(truth["truth"])
    parameters = dict(zip(truth["truth"], truth["parameters"], strict=True))
    rest = real - {"asymmetric_friction", "constant_force", "coulomb_friction"}
    if "asymmetric_friction" in real:
        both = rest | {"constant_force", "coulomb_friction"}
        # An old Fc that is merely off counts as a wrong value, one that was 0 as a second name.
        return (both, rest | {"constant_force"}) if truth["base"].get("Fc", 0.0) else (both,)
    if "constant_force" in real:
        Fc = truth["base"].get("Fc", 0.0) + parameters.get("coulomb_friction", {"Fc": 0.0})["Fc"]
        if abs(parameters["constant_force"]["F"]) <= Fc:
            return (rest | {"asymmetric_friction"},)
    return ()


class _Answer:
    """What a diagnosis says, beside the truth.

    Attributes:
        verdict, effects: of the diagnosis.
        names: of the effects, without a tabulated force.
        answer: the set of them.
        depths: name -> how deep it is called certain.
        real: the true names.
        equals: other sets of names that describe the truth exactly.
        beside: names of what is nameless beside the truth: not false, and not asked for.
        alternatives: sets of names that are said to be indistinguishable.
    """

    def __init__(self, truth: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> None:
        self._truth, self._diagnosis, self.verdict = truth, diagnosis, str(diagnosis["verdict"])
        self.effects: Sequence[Mapping[str, Any]] = diagnosis.get("effects") or ()
        self.depths = {str(effect["name"]): effect.get("certain") for effect in self.effects}
        self.names = tuple(str(effect["name"]) for effect in self.effects if effect["name"] != "tabulated_force")
        self.answer, self.real, self.equals = frozenset(self.names), frozenset(truth["truth"]), equal_sets(truth)
        self.beside = frozenset(truth.get("not_false", ())) - self.real
        listed = [entry for entry in diagnosis.get("alternatives") or () if entry.get("indistinguishable") is True]
        self.alternatives = [frozenset(re.findall(r"\w+", str(entry["name"]))) for entry in listed]

    def is_false(self) -> bool:
        """Whether it names what is not true."""
        true_sets = (self.real, *self.equals)
        if self.verdict == "ambiguous":
            answers = [names - self.beside for names in (self.answer, *self.alternatives)]
            return not any(names and any(names <= true for true in true_sets) for names in answers)
        if not self.answer:
            return False
        if self.equals and self.answer in true_sets:
            # Either one of an equal pair, if the other, with or without what both share, is said to be as good.
            others = [other for other in true_sets if other != self.answer]
            return not any(names in (other, other - self.answer) for names in self.alternatives for other in others)
        return not all(map(self._is_true, self.names))

    def _is_true(self, name: str) -> bool:
        """Whether a name holds as deep as it is called certain."""
        partly = self._truth.get("not_false", ())
        if name in self.real or name in partly:
            return True
        known = [self._place(law) for law in (*self.real, *partly) if law in LIBRARY]
        families = {*self._truth.get("families", ()), *(family for family, _ in known)}
        blocks = {*self._truth["blocks"], *(self._place(law)[1] for law in partly)}
        (family, block), depth = self._place(name), self.depths.get(name)
        return (family in families and depth in ("family", "block")) or (block in blocks and depth == "block")

    def _place(self, name: str) -> tuple[str, str]:
        """Family and block of a law of the library in the structure of the case."""
        return LIBRARY[name].place_in(self._truth["structure"])

    def is_correct(self, enough: tuple[str, ...]) -> bool:
        """Whether an answer without a false name is right, names being certain as deep as is `enough`."""
        kind, true_sets = self._truth["kind"], (self.real, *self.equals)
        if kind == "outside":  # a name that is not false can but be true of family or block
            verdicts = ("unexplained", "partly_explained", "missing_physics")
            return self.verdict in verdicts and self.block_correct() is True
        if kind in ("none", "parameters"):
            return self.verdict == ("no_mismatch" if kind == "none" else "parameters") and not self.names
        found = self.answer - self.beside
        if self.verdict == "ambiguous":
            return found in true_sets
        if self.verdict != "missing_physics" and not (
            self.verdict == "partly_explained" and self._truth.get("remainder")
        ):
            return False
        if not all(self.depths.get(name) in enough for name in found):
            return False
        if found in true_sets:
            return True
        return "family" in enough and {LIBRARY[n].family for n in found} == {LIBRARY[n].family for n in self.real}

    def block_correct(self) -> bool | None:
        """Whether the blocks that lead are the true ones; None where nothing is concealed."""
        blocks = set(self._truth["blocks"])
        if not blocks:
            return None
        shares = (self._diagnosis.get("mismatch") or {}).get("blocks") or []
        ranked = [entry["block"] for entry in sorted(shares, key=lambda entry: -entry["share"])]
        if self.equals and ranked:  # friction and a constant force on the body
            return ranked[0] in blocks | {"friction", "body"}
        return len(ranked) >= len(blocks) and set(ranked[: len(blocks)]) == blocks

    def effect_quantities(self) -> tuple[ScoredNumber, ...]:
        """The parameters of the effects that are named truly."""
        real = dict(zip(self._truth["truth"], self._truth["parameters"], strict=True))
        return tuple(
            _quantity(f"{effect['name']}.{symbol}", symbol, true, effect["parameters"][symbol])
            for effect in self.effects
            for symbol, true in real.get(effect["name"], {}).items()
            if effect["parameters"].get(symbol) is not None and symbol not in _NO_NUMBER
        )

    def base_quantities(self) -> tuple[ScoredNumber, ...]:
        """The parameters of the object that were said to be wrong."""
        base = {name.replace("normal_", "normal."): value for name, value in self._truth["base"].items()}
        listed = self._diagnosis.get("parameters") or {}
        return tuple(_quantity(name, name, base[name], said) for name, said in listed.items() if base.get(name))


def _quantity(name: str, symbol: str, true: float, said: Mapping[str, Any]) -> ScoredNumber:
    off, interval = float(said["value"]) - true, said.get("ci95")
    period = _CIRCULAR.get(symbol)
    if period is not None:
        turns = period * round(off / period)
        off, interval = off - turns, interval and [end - turns for end in interval]
    covered = bool(interval[0] <= true <= interval[1]) if interval else None
    return ScoredNumber(name, abs(off) / (period or abs(true)), covered)
