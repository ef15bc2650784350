"""Sentences of a report, verdict by verdict."""

from typing import Final

from mmt_drake.analysis.page import Banner
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.decide.mismatch import Mismatch
from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.tell.result import Diagnosis, Fit
from mmt_drake.diagnosis.tell.summary import is_unsettled, may_be_noise
from mmt_drake.diagnosis.tell.wording import FOLLOWED, capitalised, followed, listed, rms_words, span
from mmt_drake.effects.wording import words

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
        "unexplained": "Other values predict it, but cannot be told apart"
        if is_unsettled(diagnosis)
        else "A little more than white noise is left, and no known effect explains it"
        if may_be_noise(diagnosis)
        else "Something real is missing, and no known effect explains it",
        "insufficient_data": "This recording cannot tell whether the model is right",
    }
    return capitalised(titles[diagnosis.verdict])


def prediction(diagnosis: Diagnosis, fit: Fit) -> str:
    """How the errors on held-out data are to be read."""
    errors = fit.heldout_nrmse
    said = ["RMS error of simulations on stretches of the recordings that nothing was fitted to."]
    if fit.spread is not None:
        spread = rms_words(fit, 1.0)
        said.append(f"What was measured there varies by {spread} (standard deviation).")
    best = next((e for e in (errors.augmented, errors.refit, errors.nominal) if e is not None), None)
    if best is not None and fit.noise_floor:
        ratio, floor = significant(best / fit.noise_floor, 3), rms_words(fit, fit.noise_floor)
        said.append(f"Noise alone leaves {floor}: the best model is at {ratio} times that.")
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
        first, *others = mismatch.blocks
        also = f", then {listed(words(one.block) for one in others)}" if others else ""
        said.append(f"The mismatch belongs {'most of all ' if others else ''}to the block {words(first.block)}{also}.")
    signal = followed(mismatch)
    alike = [words(one.signal) for one in mismatch.depends_on if one.score > FOLLOWED]
    if signal is not None:
        concentrated = f", most of all where {signal.where}" if signal.where else ""
        said.append(f"The error follows the {words(signal.signal)}{concentrated}.")
    elif len(alike) > 1:
        said.append(f"It follows {listed(alike[:3])} about alike: this motion does not tell which of them matters.")
    if mismatch.band_hz is not None:
        low, high = (significant(end, 3) for end in mismatch.band_hz)
        said.append(f"It lies between {low} and {high} Hz.")
    if mismatch.intervals_s:
        more = len(mismatch.intervals_s) - 8
        stretches = listed([*map(span, mismatch.intervals_s[:8]), f"{more} more" if more > 0 else ""])
        said.append(f"In time: {stretches}.")
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


def _runs(fit: Fit) -> str:
    if fit.window_s is None:
        return "from rest at the first sample"
    length = significant(fit.window_s, 3)
    return (
        f"over {length} s at a time: the whole recording where the model allows, else from states fitted in a lead-in"
    )


def method(diagnosis: Diagnosis) -> str:
    """How the figures of the report are defined."""
    fit = diagnosis.fit
    if fit is None:
        return "No model was fitted: the check that comes first found that the recording cannot tell."
    said = [
        f"Simulations get the recorded motion or input and never the recorded output, {_runs(fit)}. 'As handed in' is "
        "the model that was believed (`nominal` in diagnosis.json); 'with parameters fitted' the same structure with "
        "its numbers fitted (`refit`); 'with what was found' has the effects as well (`augmented`).",
        "The held-out error is the RMS of measured less simulated, both as recorded and unfiltered, the mean of the "
        "error not removed, over the samples that count (for a contact, those in contact) within the held-out blocks. "
        "Over the standard deviation of what was measured there it is the `heldout_nrmse` of diagnosis.json, which "
        "`mmt-drake simulate` gives again. The noise floor is the same figure for the sensor's noise, that of the "
        "position carried through the model. Units are those of the model file; where it names none, m and N.",
    ]
    facts = []
    if fit.axes:
        facts.append(f"Axes that moved: {listed(fit.axes)}.")
    if fit.heldout_s:
        blocks = listed(map(span, fit.heldout_s))
        facts.append(f"Held out: {blocks}.")
    if diagnosis.tried:
        facts.append(f"Explanations tried: {diagnosis.tried}.")
    if diagnosis.seconds is not None:
        facts.append(f"Computed in {significant(diagnosis.seconds, 3)} s.")
    return "\n\n".join([*said, " ".join(facts)])
