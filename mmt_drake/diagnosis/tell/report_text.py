"""Sentences of a report, verdict by verdict."""

from collections.abc import Iterable
from typing import Final

from mmt_drake.analysis.page import Banner
from mmt_drake.analysis.wording import percent, significant
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.tell.result import Diagnosis, Fit
from mmt_drake.diagnosis.tell.wording import words

BANNERS: Final[dict[Verdict, Banner]] = {
    "no_mismatch": Banner("No mismatch beyond noise", "good"),
    "parameters": Banner("Wrong parameter values", "fair"),
    "missing_physics": Banner("Physics is missing", "bad"),
    "partly_explained": Banner("Physics is missing, a part of it without a name", "bad"),
    "ambiguous": Banner("Ambiguous: more than one explanation", "open"),
    "unexplained": Banner("Unexplained: no known effect fits", "bad"),
    "insufficient_data": Banner("Not enough data to say", "neutral"),
}


def headline(diagnosis: Diagnosis) -> str:
    """The verdict as a title."""
    named = listed(words(effect.name) for effect in diagnosis.effects)
    rivals = [words(one.name) for one in diagnosis.alternatives if one.indistinguishable]
    titles: dict[Verdict, str] = {
        "no_mismatch": "The model explains the recording to its noise",
        "parameters": "The structure is right, parameter values are not",
        "missing_physics": f"The model leaves out {named}",
        "partly_explained": f"The model leaves out {named}, and more that nobody has named",
        "ambiguous": f"{listed((named, *rivals), 'or')}: this recording cannot tell",
        "unexplained": "Something real is missing, and no known effect explains it",
        "insufficient_data": "This recording cannot tell whether the model is right",
    }
    return capitalised(titles[diagnosis.verdict])


def capitalised(text: str) -> str:
    """The text with a capital first letter, the others as they are."""
    return text[:1].upper() + text[1:]


def listed(names: Iterable[str], last: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`."""
    *most, end = [name for name in names if name] or [""]
    return f"{', '.join(most)} {last} {end}" if most else end


def prediction(diagnosis: Diagnosis, fit: Fit) -> str:
    """How the errors on held-out data are to be read."""
    errors = fit.heldout_nrmse
    said = ["Error of free-running simulations on stretches of the recordings that nothing was fitted to."]
    if errors.nominal is not None:
        said.append(f"The model as handed in is off by {percent(errors.nominal)} of the measured signal's spread.")
    if errors.nominal and errors.refit is not None:
        gain = f"{percent(errors.refit)}"
        said.append(f"With its own parameters fitted as well as they can be, {gain} remain.")
    if errors.augmented is not None and diagnosis.effects:
        said.append(f"With {listed(words(effect.name) for effect in diagnosis.effects)}, {percent(errors.augmented)}.")
    best = next((e for e in (errors.augmented, errors.refit, errors.nominal) if e is not None), None)
    if best is not None and fit.noise_floor:
        ratio = significant(best / fit.noise_floor, 3)
        said.append(f"Sensor noise alone leaves {percent(fit.noise_floor)}: the best model is at {ratio} times that.")
    if best is not None and fit.noise_floor and best < 0.9 * fit.noise_floor:
        said.append("An error below the noise floor is a warning: a model may be following noise.")
    return " ".join(said)


def found(diagnosis: Diagnosis) -> tuple[str, str]:
    """Title and text over the effects of a diagnosis."""
    names = listed(words(effect.name) for effect in diagnosis.effects)
    if diagnosis.verdict == "unexplained":
        return "A law without a name", "No effect in the library explains what is missing, but its shape repeats."
    if diagnosis.verdict == "ambiguous":
        return "What may be missing", f"The best explanation is {names}. {undecided(diagnosis)}"
    return "What is missing", f"Found: {names}."


def whereabouts(mismatch: Mismatch) -> str:
    """Where simulation and recording differ."""
    said = []
    if mismatch.blocks:
        first = mismatch.blocks[0]
        said.append(f"{percent(first.share)} of the mismatch belongs to the block {words(first.block)}.")
    if mismatch.depends_on:
        first_signal = mismatch.depends_on[0]
        concentrated = f", most of all where {first_signal.where}" if first_signal.where else ""
        said.append(f"The error follows the {words(first_signal.signal)}{concentrated}.")
    if mismatch.band_hz is not None:
        low, high = (significant(end, 3) for end in mismatch.band_hz)
        said.append(f"It lies between {low} and {high} Hz.")
    if mismatch.intervals_s:
        stretches = listed(
            f"{significant(start, 4)} to {significant(end, 4)} s" for start, end in mismatch.intervals_s[:8]
        )
        more = len(mismatch.intervals_s) - 8
        said.append(f"In time: {stretches}{f', and {more} more' if more > 0 else ''}.")
    return " ".join(said)


def replayed(diagnosis: Diagnosis) -> str:
    """Which blocks of a station differ from their replay."""
    blocks = dict.fromkeys(one.block for one in diagnosis.replays)
    known = {one.block for one in diagnosis.replays if one.nrmse is not None or one.differs}
    off = [words(block) for block in blocks if any(one.differs for one in diagnosis.replays if one.block == block)]
    right = [words(block) for block in blocks if block in known and words(block) not in off]
    said = ["Every block was replayed by itself on what was recorded at its inputs."]
    if off:
        said.append(f"Off by more than rounding and noise: {listed(off)}.")
    if right:
        said.append(f"Right, whatever was handed in: {listed(right)}.")
    if len(known) < len(blocks):
        said.append(f"Not recorded: {listed(words(block) for block in blocks if block not in known)}.")
    return " ".join(said)


def undecided(diagnosis: Diagnosis) -> str:
    """What the recording leaves open."""
    alike = [words(one.name) for one in diagnosis.alternatives if one.indistinguishable]
    named = listed(words(effect.name) for effect in diagnosis.effects)
    if alike:
        said = f"This recording cannot tell {named or 'what was found'} from {listed(alike, 'or')}."
    elif diagnosis.alternatives:
        said = "The nearest other explanations; the recording speaks against each of them."
    elif diagnosis.verdict in ("missing_physics", "partly_explained"):
        said = f"Nothing else that was tried was found to be indistinguishable from {named}."
    elif diagnosis.verdict == "unexplained":
        said = (
            "Which law it is. No effect of the library, with any values that were tried, takes enough off to be named."
        )
    else:
        said = "An effect too small to rise above the noise would not have been seen."
    return said


def method(diagnosis: Diagnosis) -> str:
    """How the figures of the report are defined."""
    fit = diagnosis.fit
    if fit is None:
        return "No model was fitted: the check that comes first found that the recording cannot tell."
    said = [
        "All simulations run free: they start at rest at the first sample, get the recorded motion or input and never "
        "see the recorded output. Nominal is the model as it was handed in; refit has the same structure with its "
        "parameters fitted; augmented has the effects found as well.",
        "The held-out error (NRMSE) is sqrt(mean((measured - simulated)²)) / std(measured), both as recorded and "
        "unfiltered, the mean of the error not removed, over the samples that count (for a contact, those in contact) "
        "within the held-out blocks. The noise floor is the same figure for the sensor's noise, that of the position "
        "carried through the model.",
    ]
    facts = []
    if fit.axes:
        facts.append(f"Axes that moved: {listed(fit.axes)}.")
    if fit.heldout_s:
        blocks = listed(f"{significant(start, 4)} to {significant(end, 4)} s" for start, end in fit.heldout_s)
        facts.append(f"Held out: {blocks}.")
    if diagnosis.tried:
        facts.append(f"Explanations tried: {diagnosis.tried}.")
    if diagnosis.seconds is not None:
        facts.append(f"Computed in {significant(diagnosis.seconds, 3)} s.")
    return "\n\n".join([*said, " ".join(facts)])
