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
  not; where the hand excited too little, `insufficient_data` too.
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
        verdict: as told; `crashed` if there was none.
        effects: names as told, without a tabulated force.
        correct, right_family, false_name: see above.
        block_correct: the leading blocks are those of the truth; None where nothing is concealed.
        residual_over_noise: held-out error after refit over the noise floor; None if not told.
        seconds: that it took.
        heldout_nrmse: as told.
        noise_floor: as told.
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
            "case": self.truth["case"],
            "kind": self.truth["kind"],
            "structure": self.truth["structure"],
            "truth": list(self.truth["truth"]),
            "verdict": self.verdict,
            "effects": list(self.effects),
            "correct": self.correct,
            "right_family": self.right_family,
            "false_name": self.false_name,
            "block_correct": self.block_correct,
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
    verdict = str(diagnosis["verdict"])
    told = diagnosis.get("effects") or []
    names = tuple(str(effect["name"]) for effect in told if effect["name"] != "tabulated_force")
    answer, real = frozenset(names), frozenset(truth["truth"])
    equals = equal_sets(truth)
    depths = {str(effect["name"]): effect.get("certain") for effect in told}
    false_name = _is_false(verdict, answer, truth, equals, depths, diagnosis)
    block = _block_correct(truth, equals, diagnosis)
    fit = diagnosis.get("fit") or {}
    errors, floor = fit.get("heldout_nrmse") or {}, fit.get("noise_floor")
    ratio = errors["refit"] / floor if floor and errors.get("refit") is not None else None
    named = [effect for effect in told if effect["name"] in real]
    return TrialScore(
        truth=truth,
        verdict=verdict,
        effects=names,
        correct=not false_name and _is_correct(truth, verdict, names, depths, equals, block, ("law",)),
        right_family=not false_name and _is_correct(truth, verdict, names, depths, equals, block, ("law", "family")),
        false_name=false_name,
        block_correct=block,
        residual_over_noise=ratio,
        seconds=seconds,
        heldout_nrmse=errors,
        noise_floor=floor,
        quantities=_effect_quantities(truth, named) if not false_name else (),
        base_quantities=_base_quantities(truth, diagnosis) if not false_name and answer == real else (),
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


def _alternatives(diagnosis: Mapping[str, Any]) -> list[Names]:
    """Sets of names among the alternatives that are said to be indistinguishable."""
    listed = diagnosis.get("alternatives") or []
    return [
        frozenset(re.findall(r"\w+", str(entry["name"]))) for entry in listed if entry.get("indistinguishable") is True
    ]


def _is_false(
    verdict: str,
    answer: Names,
    truth: Mapping[str, Any],
    equals: Sequence[Names],
    depths: Mapping[str, str | None],
    diagnosis: Mapping[str, Any],
) -> bool:
    real = frozenset(truth["truth"])
    if verdict == "ambiguous":
        told = [answer, *_alternatives(diagnosis)]
        true_sets = (real, *equals)
        return not any(names and any(names <= true for true in true_sets) for names in told)
    if not answer:
        return False
    for true in equals:
        # Either one of an equal pair, if the other is said to be as good.
        others = [other for other in (real, *equals) if other != true]
        if answer == true:
            return not _lists_one_of(others, answer, diagnosis)
    if answer == real and equals:
        return not _lists_one_of(list(equals), answer, diagnosis)
    partly = truth.get("not_false", ())
    blocks = {*truth["blocks"], *(LIBRARY[name].block for name in partly)}
    families = {*truth.get("families", ()), *(LIBRARY[name].family for name in (*real, *partly) if name in LIBRARY)}

    def is_true(name: str) -> bool:
        if name in real or name in partly:
            return True
        told, depth = LIBRARY[name], depths.get(name)
        family, block = told.family, told.block
        if truth["structure"] == "driven_body" and told.in_driven_body is not None:
            family, block = told.in_driven_body
        return (family in families and depth in ("family", "block")) or (block in blocks and depth == "block")

    return not all(is_true(name) for name in answer)


def _lists_one_of(others: Sequence[Names], answer: Names, diagnosis: Mapping[str, Any]) -> bool:
    """Whether an alternative, with or without what it shares with the answer, is one of these sets."""
    told = _alternatives(diagnosis)
    return any(names in (other, other - answer) for names in told for other in others)


def _is_correct(
    truth: Mapping[str, Any],
    verdict: str,
    names: tuple[str, ...],
    depths: Mapping[str, str | None],
    equals: Sequence[Names],
    block: bool | None,
    enough: tuple[str, ...],
) -> bool:
    kind, real = truth["kind"], frozenset(truth["truth"])
    if kind == "outside":  # a name that is not false can but be true of family or block
        return verdict in ("unexplained", "partly_explained", "missing_physics") and block is True
    if kind in ("none", "parameters"):
        expected = {"no_mismatch"} if kind == "none" else {"parameters"}
        if truth["motion"] != "rich":
            expected.add("insufficient_data")
        return verdict in expected and not names
    extra = frozenset(truth.get("not_false", ())) - real
    found = [name for name in names if name not in extra]
    if verdict == "ambiguous":
        return frozenset(found) in (real, *equals)
    if verdict != "missing_physics" and not (verdict == "partly_explained" and truth.get("remainder")):
        return False
    if not all(depths.get(name) in enough for name in found):
        return False
    if frozenset(found) in (real, *equals):
        return True
    return "family" in enough and {LIBRARY[n].family for n in found} == {LIBRARY[n].family for n in real}


def _block_correct(truth: Mapping[str, Any], equals: Sequence[Names], diagnosis: Mapping[str, Any]) -> bool | None:
    blocks = set(truth["blocks"])
    if not blocks:
        return None
    shares = (diagnosis.get("mismatch") or {}).get("blocks") or []
    ranked = [entry["block"] for entry in sorted(shares, key=lambda entry: -entry["share"])]
    if equals and ranked:  # friction and a constant force on the body
        return ranked[0] in blocks | {"friction", "body"}
    return len(ranked) >= len(blocks) and set(ranked[: len(blocks)]) == blocks


def _effect_quantities(truth: Mapping[str, Any], named: Sequence[Mapping[str, Any]]) -> tuple[ScoredNumber, ...]:
    real = dict(zip(truth["truth"], truth["parameters"], strict=True))
    found = []
    for effect in named:
        for symbol, true in real[effect["name"]].items():
            told = effect["parameters"].get(symbol)
            if told is not None and symbol not in _NO_NUMBER:
                found.append(_quantity(f"{effect['name']}.{symbol}", symbol, true, told))
    return tuple(found)


def _base_quantities(truth: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> tuple[ScoredNumber, ...]:
    base = {name.replace("normal_", "normal."): value for name, value in truth["base"].items()}
    listed = diagnosis.get("parameters") or {}
    return tuple(_quantity(name, name, base[name], told) for name, told in listed.items() if base.get(name))


def _quantity(name: str, symbol: str, true: float, told: Mapping[str, Any]) -> ScoredNumber:
    off, interval = float(told["value"]) - true, told.get("ci95")
    period = _CIRCULAR.get(symbol)
    if period is not None:
        turns = period * round(off / period)
        off, interval = off - turns, interval and [end - turns for end in interval]
    covered = bool(interval[0] <= true <= interval[1]) if interval else None
    return ScoredNumber(name, abs(off) / (period or abs(true)), covered)
