"""The report of a diagnosis: one page that says what was found, shows it, and can be read by one who was not there."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section, write_page
from mmt_drake.diagnosis.tell import figures, figures_summary, report_tables, report_text
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.result import TABULATED, Diagnosis, NamedEffect
from mmt_drake.diagnosis.tell.summary import budget_of
from mmt_drake.diagnosis.tell.wording import words
from mmt_drake.effects import LIBRARY

DETAILED: Final = 2
"""Pieces of evidence that get every picture."""
OVERVIEWS: Final = 4
"""Pieces that get the picture over time at least; a page with more would be too large to be sent around."""
REPORT_DPI: Final = 150


def write_report(diagnosis: Diagnosis, evidence: Sequence[Evidence], path: str | Path) -> Path:
    """Write `report.html`: everything in it, nothing fetched, no scripts.

    Args:
        diagnosis: what was found.
        evidence: what it was found in, the most telling first; may be empty, as where a recording was refused.
        path: of the page; its folder is made if need be.

    Raises:
        BadInput: the file cannot be written.
    """
    parts = (
        _budget(diagnosis),
        _prediction(diagnosis),
        _over_time(evidence),
        _mismatch(diagnosis, evidence),
        _blocks(diagnosis),
        _missing(diagnosis, evidence),
        _parameters(diagnosis),
        _rivals(diagnosis),
        _spectra(diagnosis, evidence),
        _open_questions(diagnosis),
        _preflight(diagnosis),
        _method(diagnosis),
    )
    sections = [section for part in parts for section in part]
    title, banner = report_text.headline(diagnosis), report_text.BANNERS[diagnosis.verdict]
    lead = diagnosis.summary
    if diagnosis.recordings:
        lead += f"\n\nRecordings: {', '.join(diagnosis.recordings)}."
    return write_page(path, title, sections, lead, banner)


def _budget(diagnosis: Diagnosis) -> Iterable[Section]:
    caption = (
        "Counted backwards from the best model: what comes back of the error when wrong values are set back, or an "
        "effect is taken out. What nobody has named stays with it; noise would stay with a right one too."
    )
    drawn = _picture(figures_summary.budget(diagnosis.budget), caption)
    if drawn:
        yield Section("What the model's error is made of", budget_of(diagnosis), drawn)


def _prediction(diagnosis: Diagnosis) -> Iterable[Section]:
    fit = diagnosis.fit
    if fit is None:
        return
    caption = "The dashed line is what sensor noise alone leaves; no model can do better than that."
    drawn = _picture(figures_summary.heldout_errors(fit), caption)
    table = report_tables.recordings_table(diagnosis)
    yield Section("How well each model predicts", report_text.prediction(diagnosis, fit), drawn, table)


def _over_time(evidence: Sequence[Evidence]) -> Iterable[Section]:
    drawn: list[Picture] = []
    caption = "Where the model without new effects is furthest off. The broad grey line is the recording."
    for number, one in enumerate(evidence[:OVERVIEWS]):
        drawn += _picture(figures.overview(one), _overview_caption(one))
        drawn += _picture(figures.zooms(one), caption) if number < DETAILED else []
    if not drawn:
        return
    left = len(evidence) - OVERVIEWS
    text = f"The first {OVERVIEWS} are shown; {left} more were used." if left > 0 else ""
    yield Section("Measured and simulated over time", text, drawn)


def _overview_caption(evidence: Evidence) -> str:
    said = [f"Recording {evidence.label}: as it is."]
    if evidence.models:
        said = [
            f"Recording {evidence.label}: on top as measured and by the best model; below what each model leaves, "
            "to one scale, and once more enlarged where that is too small to be seen."
        ]
    if evidence.models and evidence.noise is not None:
        said.append("Grey: two standard deviations of the sensor's noise; 95 % of a right model's error lie within.")
    if evidence.heldout_s:
        said.append("Shaded blue: held out from the fit.")
    return " ".join(said)


def _mismatch(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    mismatch = diagnosis.mismatch
    caption = "Left, the part of the system that the error belongs to; right, how far a curve over one signal tells it."
    drawn = _picture(figures_summary.where(mismatch), caption)
    caption = (
        "A flat line at zero means that the error has nothing to do with the signal below it; a step, slope or bow is "
        "the trace of something missing. Bands hold 80 % of the samples."
    )
    drawn += _pictures(evidence, figures.residual_over_states, caption)
    text, table = report_text.whereabouts(mismatch), report_tables.dependence_table(diagnosis)
    if drawn or text:
        yield Section("Where they differ", text, drawn, table)


def _blocks(diagnosis: Diagnosis) -> Iterable[Section]:
    if diagnosis.replays:
        table = report_tables.block_table(diagnosis.replays)
        yield Section("Block by block", report_text.replayed(diagnosis), table=table)


def _missing(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    caption = (
        "Black, the force read off the recording with every other term of the model taken away; blue, the same force "
        "in the refitted model without the effects found; green, with them. Green should lie on black."
    )
    drawn = _pictures(evidence, figures.curves, caption)
    if diagnosis.effects:
        yield Section(*report_text.found(diagnosis))
        for effect in diagnosis.effects:
            yield _effect(effect)
    if drawn:
        yield Section("Restoring force and friction", figures=drawn, inner=bool(diagnosis.effects))


def _effect(effect: NamedEffect) -> Section:
    said = [f"Block: {words(effect.block)}."]
    if effect.certain is not None:
        said.append(f"Certain is the {effect.certain}: every explanation that is not ruled out has it.")
    drawn, formula = list[Picture](), ""
    if effect.name == TABULATED:
        said.append(
            "Its shape was learned from the recording and kept because it predicts held-out data better. "
            "It says what the missing law looks like, not what it is."
        )
        caption = "The learned force over the signal that it depends on, with its 95 % interval."
        drawn = _picture(figures_summary.learned_law(effect), caption)
    elif effect.name in LIBRARY:
        law = LIBRARY[effect.name]
        formula = law.equation
        if law.replaces:
            said.append(f"It takes the place of {law.replaces}.")
        if law.equal_to:
            said.append(f"No recording of this kind can tell it from {report_text.listed(map(words, law.equal_to))}.")
        said.append(f"Source: {law.source}.")
    title, table = report_text.capitalised(words(effect.name)), report_tables.effect_table(effect)
    return Section(title, " ".join(said), drawn, table, formula, inner=True)


def _parameters(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.parameter_table(diagnosis)
    numbers = [p.value for effect in diagnosis.effects for p in effect.parameters.values()]
    of_effects = any(isinstance(value, float | int) and value != 0.0 for value in numbers)
    caption = "Points are values, bars 95 % intervals."
    if table is not None:
        caption += " A structural parameter is wrong where its bar leaves out the dashed line at 1."
    if of_effects:
        caption += " A parameter of an effect means something where its bar leaves out the dashed line at 0."
    text = "" if table is not None else "No parameter of the structure differs from its nominal value."
    if diagnosis.fit is not None:
        drawn = _picture(figures_summary.parameters(diagnosis), caption)
        yield Section("Parameters", text, drawn, table)
    curves = report_tables.curve_table(diagnosis)
    if curves is not None:
        yield Section("Parameters over what was recorded beside", table=curves, inner=True)


def _rivals(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.candidate_table(diagnosis)
    if table is None:
        return
    caption = "Each explanation where it leaves the held-out error; further left is better. Hollow: rejected."
    drawn = _picture(figures_summary.rivals(diagnosis), caption)
    text = "Each was added to the model and fitted anew."
    if diagnosis.tried > len(diagnosis.candidates):
        text = f"Of {diagnosis.tried}, the {len(diagnosis.candidates)} that came out best. {text}"
    yield Section("Explanations tried", text, drawn, table)


def _spectra(diagnosis: Diagnosis, evidence: Sequence[Evidence]) -> Iterable[Section]:
    band = diagnosis.mismatch.band_hz
    caption = (
        "Where a model's line lies on the grey one, only noise is left at that frequency; where it lies above, the "
        "model is wrong there." + (" Shaded: the band of the mismatch." if band is not None else "")
    )
    drawn = _pictures(evidence, lambda one: figures.spectra(one, band), caption)
    if drawn:
        yield Section("Spectrum of the error", figures=drawn)


def _open_questions(diagnosis: Diagnosis) -> Iterable[Section]:
    if diagnosis.verdict != "insufficient_data":
        table = report_tables.alternative_table(diagnosis)
        yield Section("What cannot be told", report_text.undecided(diagnosis), table=table)
    if diagnosis.next_recording is not None:
        yield Section("What to record next", diagnosis.next_recording)


def _preflight(diagnosis: Diagnosis) -> Iterable[Section]:
    table = report_tables.finding_table(diagnosis)
    text = "" if table is not None else "The check of clock, units, signs, noise and motion found nothing to tell."
    yield Section("State of the recording", text, table=table)


def _method(diagnosis: Diagnosis) -> Iterable[Section]:
    yield Section("How this was computed", report_text.method(diagnosis))
    if diagnosis.model is not None:
        recording = diagnosis.recordings[0] if diagnosis.recordings else "RECORDING"
        yield Section(
            "See for yourself",
            "The model that was found stands beside this page and gives the augmented figure again:",
            formula=f"mmt-drake simulate --model {diagnosis.model} \\\n    --operator {recording} --out simulated.csv",
            inner=True,
        )


def _pictures(evidence: Sequence[Evidence], draw: Callable[[Evidence], Figure | None], caption: str) -> list[Picture]:
    """One picture of each of the first pieces of evidence that has what it shows."""
    return [picture for one in evidence[:DETAILED] for picture in _picture(draw(one), caption)]


def _picture(figure: Figure | None, caption: str) -> list[Picture]:
    """A figure on the page; none where there is nothing to show."""
    return [] if figure is None else [Picture(figure, caption, REPORT_DPI)]
