"""A diagnosis in one paragraph."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.budget import PARAMETERS
from mmt_drake.diagnosis.decide.verdict import NAMING, Verdict
from mmt_drake.diagnosis.tell.result import TABULATED, Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.wording import (
    bounded,
    followed,
    in_degrees,
    model_words,
    noise_words,
    part_words,
    rms_words,
    share_words,
)
from mmt_drake.effects.wording import words

MOST_WARNINGS: Final = 3
"""More are counted only: the report has them all."""

_LEAST_SHARE = 0.005  # of a budget
_NEARLY_ALL = 0.95  # of a budget: what such a part leaves is counted once more, by itself
_MOST = 0.5  # of the mismatch beyond the noise
NOT_ITS_OWN: Final = "So the numbers that fit best need not be the system's own."
"""Of a refit beside which something is missing that nobody has named."""
_UNSETTLED: Final = (
    "Other values of the parameters predict held-out data to their noise. Yet it cannot be told which are wrong, nor "
    "whether anything is missing: what they were fitted to leaves a little more."
)
_WHITE: Final = 1.1  # times the noise floor
_COLOURED: Final = 2.0  # times the noise floor: noise of sensors that is not white leaves so much of a right model
_SO_LITTLE: Final = (
    "What is left is more than white noise of the sensors, {} times that, and no effect of the library was found to "
    "explain it. So little may be noise of another colour as well as physics without a name: it cannot be told which."
)
_MOST_UNTRIED: Final = 5  # named; more are counted

_DEPTHS: Final = {
    "family": "; certain is {family}, another law of it would do as well",
    "block": "; certain is only that it acts in the block {block}",
    None: "; not certain, another effect would do as well",
}
_ACCOUNTED_FOR: Final = {
    "bias": {"force_bias", "force_drift"},
    "hum": {"periodic_disturbance"},
    "offset": {"time_delay", "force_lag"},
    "saturation": {"force_saturation"},
}
"""Warnings that say what an effect says already."""


def summary_of(diagnosis: Diagnosis) -> str:
    """What was found, what to do about it, and what to keep in mind with it, for a person who acts on it."""
    tellers = (bounds_of, budget_of, _verdict, lambda d: untried_of(d.untried), _errors, _where, _warnings)
    return " ".join(part for part in (tell(diagnosis) for tell in tellers) if part)


def bounds_of(d: Diagnosis) -> str:
    """That the fit without effects proves nothing, where it ran into its bounds; else nothing."""
    driven = " and ".join(d.at_bounds)
    return f"Without effects, fitting drives {driven} out of all bounds: that fit proves nothing." if driven else ""


def budget_of(d: Diagnosis) -> str:
    """What the error of the model handed in is made of, in a sentence; nothing where that is noise or unknown.

    Beside numbers that were far off all else looks like nothing: then a second sentence says what that is.
    """
    shares = {part_words(part.part, d.effects): part.share for part in d.budget}
    said = _shares(shares)
    if not said or d.verdict == "no_mismatch":
        return ""
    wrong = part_words(PARAMETERS)
    rest = 1.0 - shares.get(wrong, 0.0)
    others = {part: share / rest for part, share in shares.items() if part != wrong and rest > 0.0}
    told = d.verdict != "parameters" and others and rest < 1.0 - _NEARLY_ALL
    of_rest = f" Of the rest: {_shares(others)}." if told else ""
    return f"Of the model's squared error on held-out data: {said}.{of_rest}"


def _shares(shares: Mapping[str, float]) -> str:
    return ", ".join(f"{share_words(share)} {part}" for part, share in shares.items() if share >= _LEAST_SHARE)


def _verdict(d: Diagnosis) -> str:
    changes = ", ".join(
        f"{name} {significant(p.nominal, 3)} -> {bounded(p.value, p.ci95)[0]} {p.unit}"
        for name, p in d.parameters.items()
    )
    real = "Something real is missing from the model, and "
    real += (
        "what there was time to try does not explain it."
        if d.untried
        else ("no effect of the library was found to explain it.")
    )
    if d.parameters:
        real += f" {NOT_ITS_OWN}"
    others = ", or ".join(words(a.name) for a in d.alternatives if a.indistinguishable)
    left_out = f"The model leaves out {_listed((e for e in d.effects if e.name != TABULATED), d.verdict)}"
    tables = [f"over the {words(str(e.parameters['of'].value))}" for e in d.effects if e.name == TABULATED]
    white, little = beyond_white(d), may_be_noise(d)
    rest = f"; a table {tables[0]} takes some of that" if tables else ""
    said: dict[Verdict, str] = {
        "no_mismatch": f"The nominal model explains the recording to its noise; nothing needs to be changed. {white}",
        "parameters": f"The structure is right, but values were not: {changes}. {white}",
        "missing_physics": f"{left_out}.",
        "partly_explained": f"{left_out}, and more that nobody has named{rest}.",
        "ambiguous": f"{left_out}; these recordings cannot tell it from {others}.",
        "unexplained": _UNSETTLED if is_unsettled(d) else _SO_LITTLE.format(little) if little else real,
        "insufficient_data": d.summary,
    }
    return said[d.verdict].rstrip()


def is_unsettled(d: Diagnosis) -> bool:
    """Whether nothing is explained, although a refit leaves no more than noise on held-out data."""
    if d.fit is None or d.verdict != "unexplained":
        return False
    left, floor = d.fit.heldout_nrmse.refit, d.fit.noise_floor
    return left is not None and floor is not None and left <= floor


def may_be_noise(d: Diagnosis) -> str | None:
    """How many times the noise is left where nothing explains it and it may be noise of another colour; else None."""
    if d.fit is None or d.verdict != "unexplained" or d.effects or d.untried or not d.fit.noise_floor:
        return None
    errors = d.fit.heldout_nrmse
    times = min(e for e in (errors.nominal, errors.refit, math.inf) if e is not None) / d.fit.noise_floor
    return significant(times, 3) if times <= _COLOURED else None


def beyond_white(d: Diagnosis) -> str:
    """That a refit, or what needs none, leaves more than white noise does, in a sentence; nothing where it does not."""
    left = floor = None
    if d.fit is not None:
        errors, floor = d.fit.heldout_nrmse, d.fit.noise_floor
        left = errors.nominal if d.verdict == "no_mismatch" else errors.refit
    if left is None or floor is None or left <= _WHITE * floor or not d.tried:
        return ""
    return "What is left is more than white noise of the sensors, but follows no signal and no law of the library."


def untried_of(untried: Sequence[str]) -> str:
    """What there was no time to try, in a sentence; nothing where that is nothing."""
    if not untried:
        return ""
    more = len(untried) - _MOST_UNTRIED
    others = f" and {more} more" if more > 0 else ""
    names = ", ".join(map(words, untried[:_MOST_UNTRIED]))
    return f"There was no time to try {names}{others}; --time-budget gives more."


def _listed(effects: Iterable[NamedEffect], verdict: Verdict) -> str:
    said = []
    for effect in effects:
        told = [
            f"{symbol} = {bounded(p.value, p.ends)[0]}" + (f" {p.unit}" if p.unit != "1" else "")
            for symbol, own in effect.parameters.items()
            if isinstance((p := in_degrees(effect, own)).value, float)
        ]
        depth = "" if verdict == "ambiguous" else _DEPTHS.get(effect.certain, "")  # there, none is sure
        depth = depth.format(family=words(effect.family), block=words(effect.block))
        along = f" along {effect.axis}" if effect.axis else ""
        beside = ", ".join(told) + depth
        said.append(f"{words(effect.name)}{along}" + (f" ({beside.removeprefix('; ')})" if beside else ""))
    return " and ".join(said)


def _errors(d: Diagnosis) -> str:
    if d.fit is None or d.fit.heldout_nrmse.nominal is None:
        return ""
    fit, e = d.fit, d.fit.heldout_nrmse
    said = f"On held-out data the RMS error is {rms_words(fit, d.fit.heldout_nrmse.nominal)} with {model_words(d)}"
    if d.verdict != "no_mismatch" and e.refit is not None:
        said += f", {rms_words(fit, e.refit)} with its parameters fitted"
        if d.verdict in NAMING and e.augmented is not None:
            said += f", {rms_words(fit, e.augmented)} with what was missing"
    return f"{said}{noise_words(fit)}."


def _where(d: Diagnosis) -> str:
    if d.verdict not in ("unexplained", "ambiguous", "partly_explained") or not d.mismatch.blocks or is_unsettled(d):
        return ""
    block = d.mismatch.blocks[0]
    said = "If physics, it" if may_be_noise(d) else "It"
    said += f" most likely acts in the block {words(block.block)}"
    signal = followed(d.mismatch)
    if signal is not None:
        said += f", and follows the {words(signal.signal)}"
    axis, share = next(iter(d.mismatch.axes.items()), ("", 0.0))
    if share > _MOST:
        said += f"; it shows along {axis}"
    return said + "."


def warnings_of(d: Diagnosis) -> list[str]:
    """What the check of the recordings warned of, but for what the effects account for; the first `MOST_WARNINGS`."""
    names = {effect.name for effect in d.effects}
    said = [f.text for f in d.preflight if f.severity == "warn" and not names & _ACCOUNTED_FOR.get(f.code, set())]
    left = len(said) - MOST_WARNINGS
    return [*said[:MOST_WARNINGS], *([f"And {left} more (see the report)."] if left > 0 else [])]


def _warnings(d: Diagnosis) -> str:
    said = warnings_of(d)
    return f"Keep in mind: {' '.join(said)}" if said else ""
