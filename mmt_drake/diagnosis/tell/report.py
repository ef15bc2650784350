"""The report of a diagnosis: one page that says what was found, shows it, and can be read by one who was not there."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Final

from mmt_drake.analysis.interactive import THINNING, Plot
from mmt_drake.analysis.page import Bar, Section, write_page
from mmt_drake.diagnosis.tell import plots, report_tables, report_text
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.figures_common import COLORS, NAMES, NOISE
from mmt_drake.diagnosis.tell.first_screen import first_screen, lead
from mmt_drake.diagnosis.tell.provenance import Provenance
from mmt_drake.diagnosis.tell.result import TABULATED, Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.summary import NOT_ITS_OWN, is_unsettled
from mmt_drake.diagnosis.tell.wording import all_words, capitalised, listed, rms_words
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.wording import words

DETAILED: Final = 2
"""Pieces of evidence that get every figure."""
OVERVIEWS: Final = 4
"""Pieces that get the figure over time at least; a page with more would be too large to be sent around."""


def write_report(
    diagnosis: Diagnosis, evidence: Sequence[Evidence], path: str | Path, provenance: Provenance | None = None
) -> Path:
    """Write `report.html`: everything in it, its scripts too, and nothing fetched.

    Args:
        diagnosis: what was found.
        evidence: what it was found in, the most telling first; may be empty, as where a recording was refused.
        path: of the page; its folder is made if need be.
        provenance: of the report; without it the recordings are told with their hashes, and that no command was typed.

    Raises:
        BadInput: the file cannot be written.
    """
    provenance = Provenance.of(diagnosis.recordings) if provenance is None else provenance
    parts = (
        _over_time(evidence),
        _prediction(diagnosis),
        _mismatch(diagnosis, evidence),
        _blocks(diagnosis),
        _missing(diagnosis, evidence),
        _parameters(diagnosis),
        _rivals(diagnosis),
        _spectra(diagnosis, evidence),
        _open_questions(diagnosis),
        _preflight(diagnosis),
        _method(diagnosis, provenance),
    )
    sections = [section for part in parts for section in part]
    title, banner = report_text.headline(diagnosis), report_text.BANNERS[diagnosis.verdict]
    first = first_screen(diagnosis, evidence, provenance)
    return write_page(path, title, sections, lead(diagnosis), banner, first)


def _over_time(evidence: Sequence[Evidence]) -> Iterable[Section]:
    drawn: list[Plot] = []
    for number, one in enumerate(evidence[:OVERVIEWS]):
        drawn.append(plots.over_time(one))
        drawn += plots.closer(one) if number < DETAILED else []
    if not drawn:
        return
    left = len(evidence) - OVERVIEWS
    text = f"The first {OVERVIEWS} are shown; {left} more were used." if left > 0 else ""
    yield Section("Measured and simulated over time", text, drawn, remark=THINNING)


def _prediction(diagnosis: Diagnosis) -> Iterable[Section]:
    fit = diagnosis.fit
    if fit is None:
        return
    errors = {name: error for name, error in vars(fit.heldout_nrmse).items() if error is not None}
    if not diagnosis.effects:
        errors.pop("augmented", None)  # what is delivered is the refit then
    longest = max([*errors.values(), fit.noise_floor or 0.0], default=1.0) or 1.0
    bars = [Bar(capitalised(NAMES[n]), e / longest, rms_words(fit, e), COLORS[n]) for n, e in errors.items()]
    if fit.noise_floor is not None:
        bars.append(Bar("Noise alone", fit.noise_floor / longest, rms_words(fit, fit.noise_floor), NOISE))
    table = report_tables.recordings_table(diagnosis)
    yield Section("How well each model predicts", report_text.prediction(diagnosis, fit), table=table, bars=bars)


def _mismatch(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    drawn = [plot for one in evidence[:DETAILED] for plot in plots.error_over_states(one)]
    text = report_text.whereabouts(diagnosis.mismatch)
    remark = (
        "A flat line at zero means that the error has nothing to do with the signal below it; a step, slope or bow is "
        "the trace of something missing. Bands hold 80 of 100 samples."
    )
    if drawn or text:
        yield Section("Where they differ", text, drawn, remark=remark if drawn else "")


def _blocks(diagnosis: Diagnosis) -> Iterable[Section]:
    if diagnosis.replays:
        table = report_tables.block_table(diagnosis.replays)
        yield Section("Block by block", report_text.replayed(diagnosis), table=table)


def _missing(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    drawn = [plot for one in evidence[:DETAILED] for plot in plots.forces(one)]
    remark = (
        "Black, the force read off the recording with every other term of the model taken away; blue, the same force "
        "in the fitted model without the effects found; green, with them. Green should lie on black."
    )
    if diagnosis.effects:
        yield Section(*report_text.found(diagnosis))
        for effect in diagnosis.effects:
            yield _effect(effect)
    if drawn:
        yield Section("Restoring force and friction", figures=drawn, inner=bool(diagnosis.effects), remark=remark)


def _effect(effect: NamedEffect) -> Section:
    said = [f"Block: {words(effect.block)}."]
    if effect.certain is not None:
        said.append(f"Certain is the {effect.certain}: every explanation that is not ruled out has it.")
    drawn, formula = list[Plot](), ""
    if effect.name == TABULATED:
        said.append(
            "Its shape was learned from the recording and kept because it predicts held-out data better. "
            "It says what the missing law looks like, not what it is."
        )
        drawn = plots.learned_law(effect)
    elif effect.name in LIBRARY:
        law = LIBRARY[effect.name]
        formula = law.equation
        if law.replaces:
            said.append(f"It takes the place of {law.replaces}.")
        if law.equal_to:
            said.append(f"No recording of this kind can tell it from {listed(map(words, law.equal_to))}.")
        said.append(f"Source: {law.source}.")
    title, table = capitalised(words(effect.name)), report_tables.effect_table(effect)
    return Section(title, " ".join(said), drawn, table, formula, inner=True)


def _parameters(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.parameter_table(diagnosis)
    if diagnosis.fit is not None:
        text = "" if table is not None else "No parameter of the structure differs from the value handed in."
        if table is not None and diagnosis.verdict == "unexplained" and not is_unsettled(diagnosis):
            text = f"Something is missing. {NOT_ITS_OWN}"
        yield Section("Parameters", text, table=table)
    curves = report_tables.curve_table(diagnosis)
    if curves is not None:
        yield Section("Parameters over what was recorded beside", table=curves, inner=True)


def _rivals(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.candidate_table(diagnosis)
    untried = f"Not tried for lack of time: {all_words(diagnosis.untried)}." if diagnosis.untried else ""
    if table is None:
        if untried:
            yield Section("Explanations tried", untried)
        return
    text = "Each was added to the model and fitted anew."
    if diagnosis.tried > len(diagnosis.candidates):
        text = f"Of {diagnosis.tried}, the {len(diagnosis.candidates)} that came out best. {text}"
    yield Section("Explanations tried", text, table=table, remark=untried)


def _spectra(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    band = diagnosis.mismatch.band_hz
    drawn = [plot for one in evidence[:DETAILED] for plot in plots.spectrum(one, band)]
    if drawn:
        yield Section("Spectrum of the error", figures=drawn)


def _open_questions(diagnosis: Diagnosis) -> Iterable[Section]:
    if diagnosis.verdict != "insufficient_data":
        table = report_tables.alternative_table(diagnosis)
        yield Section("What cannot be told", report_text.undecided(diagnosis), table=table)


def _preflight(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.finding_table(diagnosis)
    text = "" if table is not None else "The check of clock, units, signs, noise and motion found nothing to tell."
    yield Section("State of the recording", text, table=table)


def _method(diagnosis: Diagnosis, provenance: Provenance) -> Iterable[Section]:
    yield Section("How this was computed", report_text.method(diagnosis), table=report_tables.hash_table(provenance))
    yield Section("In one paragraph", diagnosis.summary, inner=True)
    if diagnosis.model is not None:
        recording = diagnosis.recordings[0] if diagnosis.recordings else "RECORDING"
        yield Section(
            "See for yourself",
            "The model that was found stands beside this page and gives the error with what was found again:",
            formula=f"mmt-drake simulate --model {diagnosis.model} \\\n    --operator {recording} --out simulated.csv",
            inner=True,
        )
