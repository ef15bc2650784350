"""What a reader of a report sees first: the verdict in plain words, what the error is made of, what to do, whence."""

from collections.abc import Iterable, Sequence
from typing import Final

from mmt_drake.analysis.page import Bar, Section
from mmt_drake.analysis.plotting import GREY, PURPLE, RED
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.budget import NAMELESS, NOISE, PARAMETERS, SHARED, BudgetPart
from mmt_drake.diagnosis.tell.evidence import Evidence, worst_windows
from mmt_drake.diagnosis.tell.figures_common import COLORS
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.report_tables import effect_rows
from mmt_drake.diagnosis.tell.result import TABULATED, Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.summary import beyond_white, bounds_of, warnings_of
from mmt_drake.diagnosis.tell.wording import (
    PERCENT,
    capitalised,
    followed,
    listed,
    model_words,
    noise_words,
    part_words,
    rms_words,
    share_words,
    span,
)
from mmt_drake.effects.wording import words

BUDGET, NEXT, SOURCES = "What the model's error is made of", "What to do next", "Where this comes from"

PART_COLORS: Final = {PARAMETERS: COLORS["refit"], SHARED: PURPLE, NAMELESS: RED, NOISE: GREY}
"""Of the parts of a budget that are no effects."""
_BACKWARDS: Final = (
    "Counted backwards from the best model: what comes back of the error if wrong values are set back, or an effect is "
    "taken out."
)
_MOST_STRETCHES: Final = 3


def lead(diagnosis: Diagnosis) -> str:
    """The verdict's meaning in a few sentences, for one who knows neither the method nor the file formats."""
    said = [text for text in (bounds_of(diagnosis),) if text]
    if diagnosis.verdict == "insufficient_data":
        return " ".join([*said, diagnosis.summary])
    if diagnosis.first_model is not None:
        said.append("No model was handed in: one was fitted to the recordings first, and stands for it.")
    said += [text for text in (*_sure(diagnosis), *_errors(diagnosis)) if text]
    if diagnosis.untried:
        some = "1 explanation was" if len(diagnosis.untried) == 1 else f"{len(diagnosis.untried)} explanations were"
        said.append(f"{some} not tried for lack of time; what is said here promises nothing against that.")
    return " ".join(said)


def _sure(d: Diagnosis) -> Iterable[str]:
    match d.verdict:
        case "no_mismatch":
            yield beyond_white(d) or "What the model leaves is no more than the noise of the sensors."
        case "parameters":
            yield "With other values the same equations explain the recording; no physics is missing."
            yield beyond_white(d)
        case "unexplained":
            yield "More than noise is left, and no law that was tried takes enough of it off to be named."
        case "ambiguous":
            yield "More than one explanation fits, and these recordings do not tell them apart."
        case "missing_physics" | "partly_explained":
            for effect in d.effects:
                name, family, block = words(effect.name), words(effect.family), words(effect.block)
                if effect.certain == "law":
                    yield f"That it is {name} is certain: every explanation that the data do not rule out has this law."
                elif effect.certain == "family":
                    yield f"That it is {family} is certain; that it is {name} and no other law of that family is not."
                elif effect.certain == "block":
                    yield f"Certain is only that something is missing in the {block}; {name} is the simplest that fits."
                elif effect.name != TABULATED:
                    yield f"That something more is missing is certain; that it is {name} is not."


def _errors(d: Diagnosis) -> Iterable[str]:
    if d.fit is None or (handed_in := d.fit.heldout_nrmse.nominal) is None:
        return
    fit, errors, nominal = d.fit, d.fit.heldout_nrmse, rms_words(d.fit, handed_in)
    told = f"On stretches that no fit has seen, {model_words(d)} is off by {nominal}"
    if d.verdict != "no_mismatch" and errors.augmented is not None and d.effects:
        told += f", with {listed(_called(effect) for effect in d.effects)} by {rms_words(fit, errors.augmented)}"
    elif d.verdict != "no_mismatch" and errors.refit is not None:
        told += f", with its parameters fitted by {rms_words(fit, errors.refit)}"
    yield f"{told} (RMS){noise_words(fit)}."


def _called(effect: NamedEffect) -> str:
    return "a learned table" if effect.name == TABULATED else words(effect.name)


def first_screen(diagnosis: Diagnosis, evidence: Sequence[Evidence], provenance: Provenance) -> list[Section]:
    """The cards below the verdict: budget, next steps, provenance.

    Args:
        diagnosis: what was found.
        evidence: of the first recording on; may be empty.
        provenance: of the report.
    """
    facts = provenance.facts
    if diagnosis.first_model is not None:
        facts = [
            (what, about) if what != "Model" else (what, f"{diagnosis.first_model}, fitted here")
            for what, about in facts
        ]
    return [_budget(diagnosis, evidence), Section(NEXT, items=next_steps(diagnosis)), Section(SOURCES, facts=facts)]


def _budget(d: Diagnosis, evidence: Sequence[Evidence]) -> Section:
    if not d.budget:
        refused = [finding.text for finding in d.preflight if finding.severity == "refuse"]
        text = "No model was run, so there is no error to divide." if d.fit is None else "It is not known."
        return Section(BUDGET, text, items=refused)
    shown = [part for part in d.budget if part.part != SHARED or part.share >= 0.005]
    bars = [
        Bar(
            capitalised(part_words(part.part, d.effects)),
            part.share,
            share_words(part.share),
            PART_COLORS.get(part.part, COLORS["augmented"]),
            _whereabouts(d, part, evidence),
        )
        for part in shown
    ]
    return Section(BUDGET, bars=bars, remark=f"{PERCENT} {_BACKWARDS}")


def _whereabouts(d: Diagnosis, part: BudgetPart, evidence: Sequence[Evidence]) -> str:
    """Where and when a part of the error arises."""
    match part.part:
        case "parameters":
            if part.share == 0.0:
                return "" if d.parameters else "None is wrong."
            changes = [f"{name} {_three(p.nominal)} → {_three(p.value)} {p.unit}" for name, p in d.parameters.items()]
            return f"{', '.join(changes)}; throughout." if changes else "Throughout."
        case "shared":
            return "Cannot be split between them."
        case "noise":
            if d.fit is None or d.fit.noise_floor is None:
                return "Throughout."
            return f"Sensors, throughout: {rms_words(d.fit, d.fit.noise_floor)} RMS."
        case "nameless":
            if part.share < 0.005:
                return ""
            return _placed(d, _nameless_place(d), _when_nameless(d, evidence))
    effect = next((effect for effect in d.effects if effect.name == part.part), None)
    if effect is None:
        return ""
    place = [words(effect.block), _state(d)]
    numbers = [f"{row[0]} {row[1]} {row[3]}".removesuffix(" 1") for row in effect_rows(effect)]
    size = f"{', '.join(numbers)}. " if numbers else ""
    return size + _placed(d, ", ".join(filter(None, place)), d.mismatch.intervals_s)


def _nameless_place(d: Diagnosis) -> str:
    for effect in d.effects:
        if effect.name == TABULATED:
            return f"follows the {words(str(effect.parameters['of'].value))}"
    if d.effects or not d.mismatch.blocks:
        return ""
    return ", ".join(filter(None, [f"most likely {words(d.mismatch.blocks[0].block)}", _state(d)]))


def _state(d: Diagnosis) -> str:
    """Where along the signal that the error follows it is strongest; nothing where that is none, or the time."""
    signal = followed(d.mismatch)
    return "" if signal is None or signal.signal == "time" else signal.where


def _when_nameless(d: Diagnosis, evidence: Sequence[Evidence]) -> Sequence[tuple[float, float]]:
    """Where the best model is furthest off; where none has an effect, where the refitted one stands out."""
    if not d.effects and d.mismatch.intervals_s:
        return d.mismatch.intervals_s
    first = next((one for one in evidence if one.models), None)
    return [] if first is None else sorted(worst_windows(first, length_s=1.0, of=list(first.models)[-1]))


def _placed(d: Diagnosis, place: str, stretches: Sequence[tuple[float, float]]) -> str:
    said = [f"Where: {place}."] if place else []
    if stretches:
        more = len(stretches) - _MOST_STRETCHES
        listing = listed([*map(span, stretches[:_MOST_STRETCHES]), f"{more} more" if more > 0 else ""])
        of = " of the first recording" if len(d.recordings) > 1 else ""
        said.append(f"When: most at {listing}{of}.")
    return " ".join(said)


def next_steps(diagnosis: Diagnosis) -> list[str]:
    """What to do about the verdict, the most pressing first, and what to keep in mind."""
    said = [] if diagnosis.next_recording is None else [diagnosis.next_recording]
    said += _steps(diagnosis)
    if diagnosis.untried:
        said.append("Give it more time: --time-budget. What was not tried is listed under 'Explanations tried'.")
    return [*said, *(f"Keep in mind: {text}" for text in warnings_of(diagnosis))]


def _steps(d: Diagnosis) -> list[str]:
    file = d.model or "the model that was found"
    match d.verdict:
        case "no_mismatch":
            return [
                "Nothing has to be changed.",
                "An effect below the noise would need a stronger motion or a quieter sensor to show.",
            ]
        case "parameters":
            return [f"Take over the values found: {file} has them.", _check(d)]
        case "missing_physics":
            return [f"Use {file} in the place of the model: it has what was found.", _check(d)]
        case "partly_explained":
            rest = next((part.share for part in d.budget if part.part == NAMELESS), 0.0)
            return [
                f"Use {file} in the place of the model as far as it goes: {share_words(rest)} is still without a name.",
                "Look at where and when that remains, at the left; a law of your own can be tried with --effects.",
            ]
        case "ambiguous":
            known = [] if d.next_recording else ["Record a motion in which the explanations differ."]
            return [*known, f"Until then trust {file} only for motions like the recorded ones."]
        case "unexplained":
            return [
                "Look at where and when the error arises, and at the machine there: sensor, cables, mounting.",
                "A law of your own can be tried with --effects.",
            ]
        case _:
            return [] if d.next_recording else ["Record again without what stopped the check."]


def _check(d: Diagnosis) -> str:
    return (
        f"Check {'it' if d.model else 'that'} on a recording of another motion: `mmt-drake simulate` tells the error."
    )


def _three(value: float) -> str:
    return significant(value, 3)
