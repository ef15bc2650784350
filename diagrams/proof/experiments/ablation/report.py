"""The ablation as one table, one figure, sentences and a page."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import BLACK, DPI, GREY, RED, WIDTH_IN, styled
from mmt_drake.analysis.signals import BAND_NAMES, BANDS
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import in_percent, significant
from mmt_drake.diagrams.proof.experiments.ablation.causes import CAUSES
from mmt_drake.diagrams.proof.experiments.ablation.claims import CLAIMS, REFERENCES
from mmt_drake.diagrams.proof.experiments.ablation.findings import findings, listed, ranges, reproducing
from mmt_drake.diagrams.proof.experiments.ablation.run import RUNS, Verdict, cases, verdicts_of
from mmt_drake.diagrams.proof.experiments.changes import Cause
from mmt_drake.diagrams.proof.experiments.comparison import Comparison, Findings
from mmt_drake.diagrams.proof.experiments.runs import Cases, ratio_of
from mmt_drake.diagrams.proof.experiments.targets import ESTIMATED, RENDERED
from mmt_drake.diagrams.proof.studies.study import reached_table, to_json

GROUPS: Final = {
    "none": "",
    "estimator": "estimator",
    "plant": "object and sensors",
    "renderer": "renderer",
    "hand": "the hand's motion",
    "together": "together",
}

_THESIS: Final = tuple(target.thesis or 0.0 for target in (*RENDERED.values(), ESTIMATED))
"""Errors in its experiment 1: of the rendered force below 0.3 Hz and in the two bands above, of the estimated force."""

_BANDS: Final = tuple(BANDS)[1:]
_MARKS: Final = {"raw": (44.0, False), "filtered": (13.0, True)}  # size, filled
_CLOSE: Final = {"wspace": 0.04}
_ROW_IN, _TOP_IN, _BOTTOM_IN = 0.2, 0.95, 0.12


def short_table(verdicts: Sequence[Verdict]) -> Table:
    """One row per cause, for a terminal: errors and figures reproduced against each force, verdict."""
    headers = ["cause"]
    for reference in REFERENCES:
        headers += [f"{reference}: {BAND_NAMES[band]} [%]" for band in _BANDS]
        headers += [f"{reference}: estimated [%]", f"{reference}: figures reproduced"]
    most = [in_percent(target.to_reach) for target in RENDERED.values()]
    rows: list[list[Cell]] = [
        ["the thesis", *(2 * [*map(in_percent, _THESIS), None]), None],
        ["to reach", *most, *([None] * 8)],
    ]
    for verdict in verdicts:
        rendered = verdict.rendered()
        missed = sum(figure.reached is False for figure in rendered)
        judged = "reached" if rendered else "not known"
        if missed:
            judged = f"missed in {missed} band{'s' if missed > 1 else ''}"
        row: list[Cell] = [verdict.cause.name]
        for reference in REFERENCES:
            row += [*map(in_percent, _errors(verdict, reference)), ranges(verdict.figures(reference)) or "none"]
        rows.append([*row, judged])
    caption = (
        "Error of the rendered force by band, of the estimated force, against the measured force, raw and as the "
        "estimator sees it, filtered; experiment 1. The verdict is on the rendered force against the plant's without "
        "noise, in bands that hold enough of it."
    )
    return Table([*headers, "verdict"], rows, caption)


def _errors(verdict: Verdict, reference: str) -> list[float | None]:
    """Of the rendered force in each of `_BANDS`, of the estimated force."""
    running = verdict.against[reference].running
    return [*(ratio_of(running.rendered_error, band) for band in _BANDS), ratio_of(running.estimated_error_raw)]


def figures_table(verdicts: Sequence[Verdict]) -> Table:
    """One row per figure of the thesis: what it shows, what counts as the same, and what reproduces it."""
    rows = []
    for claim in CLAIMS:
        by = (reproducing(verdicts, claim, reference) for reference in REFERENCES)
        names = ("everything" if len(b) == len(verdicts) else listed([cause.name for cause in b]) for b in by)
        rows.append([claim.name, claim.says, claim.needs, *(name or "nothing here" for name in names)])
    by_each = (f"reproduced by, against the {reference} force" for reference in REFERENCES)
    return Table(["figure", "what it shows", "counts as reproduced where", *by_each], rows)


@styled
def ablation_figure(verdicts: Sequence[Verdict]) -> Figure:
    """Causes by row: errors against each force as shaded numbers, figures of the thesis as rings and dots."""
    rows = _rows(verdicts)
    height = _TOP_IN + _ROW_IN * len(rows) + _BOTTOM_IN
    figure = Figure(figsize=(WIDTH_IN, height), dpi=DPI)
    FigureCanvasAgg(figure)
    margins = {"left": 0.345, "right": 0.995, "top": 1.0 - _TOP_IN / height, "bottom": _BOTTOM_IN / height}
    widths = (*(len(_BANDS) + 1 for _ in REFERENCES), 0.8 * len(CLAIMS))
    *errors, dots = figure.subplots(1, len(widths), sharey=True, width_ratios=widths, gridspec_kw=margins | _CLOSE)
    for panel, reference in zip(errors, REFERENCES, strict=True):
        _draw_errors(panel, rows, reference)
    _draw_dots(dots, rows)
    errors[0].set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=8.0)
    errors[0].set_ylim(len(rows) - 0.5, -0.5)
    for label, (_, row) in zip(errors[0].get_yticklabels(), rows, strict=True):
        if row is None:
            label.set(fontweight="bold", color=BLACK)
    return figure


def _rows(verdicts: Sequence[Verdict]) -> list[tuple[str, Verdict | str | None]]:
    """What stands in each row: a verdict, the thesis itself, or the heading of a group."""
    rows: list[tuple[str, Verdict | str | None]] = [("the thesis", "thesis")]
    for group, members in groupby(verdicts, key=lambda verdict: verdict.cause.group):
        rows += [(GROUPS[group], None)] if GROUPS[group] else []
        rows += [(verdict.cause.name, verdict) for verdict in members]
    return rows


def _draw_errors(panel: Axes, rows: Sequence[tuple[str, Verdict | str | None]], reference: str) -> None:
    values = np.full((len(rows), len(_BANDS) + 1), np.nan)
    for number, (_, row) in enumerate(rows):
        if isinstance(row, Verdict):
            values[number] = [np.nan if ratio is None else ratio for ratio in _errors(row, reference)]
        elif row is not None:
            values[number] = _THESIS
    panel.imshow(values, aspect="auto", cmap="OrRd", norm=LogNorm(0.003, 3.0, clip=True), alpha=0.85)
    for (number, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            text = significant(100.0 * value, 2 if value >= 0.001 else 1) if value < 10.0 else "> 1000"
            color = "white" if value > 0.5 else BLACK
            panel.text(column, number, text, ha="center", va="center", fontsize=6.5, color=color)
    names = [f"rendered,\n{BAND_NAMES[band]}" for band in _BANDS] + ["estimated,\nall"]
    panel.set_xticks(range(len(names)), names, rotation=90, fontsize=7.5)
    panel.set_title(f"{reference}: error [%]", fontsize=8, loc="center")
    panel.grid(visible=False)
    _bare(panel)


def _draw_dots(panel: Axes, rows: Sequence[tuple[str, Verdict | str | None]]) -> None:
    for number, (_, row) in enumerate(rows):
        if row is None:
            continue
        color = RED if isinstance(row, Verdict) else GREY
        for reference, (size, filled) in _MARKS.items():
            shown = [not isinstance(row, Verdict) or claim in row.reproduced(reference) for claim in CLAIMS]
            at, face = (np.flatnonzero(shown), np.full(sum(shown), number)), color if filled else "none"
            panel.scatter(*at, s=size, facecolors=face, edgecolors=color, linewidth=1.1)
    panel.set_xticks(range(len(CLAIMS)), [f"figure {claim.name}" for claim in CLAIMS], rotation=90, fontsize=7.5)
    panel.set_xlim(-0.6, len(CLAIMS) - 0.4)
    panel.set_title("reproduced (ring: raw, dot: filtered)", fontsize=8, loc="center")
    panel.grid(visible=True, axis="y", color="#EEEEEE", linewidth=0.6)
    _bare(panel)


def _bare(panel: Axes) -> None:
    panel.xaxis.tick_top()
    panel.tick_params(length=0)
    panel.grid(visible=False, axis="x")
    for spine in panel.spines.values():
        spine.set_visible(False)


def judge(cases: Cases) -> Findings:
    """Which figures of the thesis each cause reproduces, and what is left of the errors to reach."""
    verdicts = verdicts_of(cases)
    every = list(verdicts.values())
    reached = [figure for verdict in every for figure in verdict.figures_to_reach()]
    caption = (
        "One row per cause. Left: RMS of the error over that of the measured force, in percent. Right: where the runs "
        "with this cause show what a figure of the thesis shows, against the raw force a ring, against the filtered "
        "one a dot."
    )
    sections = [
        Section("Causes and figures", figures=[Picture(ablation_figure(every), caption, name="ablation")]),
        Section("What was to be reached", table=reached_table(reached)),
        Section("What counts as reproduced", table=figures_table(every)),
    ]
    figures = {
        f"{name}: {run}": {"cause": name, "group": verdict.cause.group, "run": run, **_against_filtered(verdict, run)}
        for name, verdict in verdicts.items()
        for run in RUNS
    }
    document = _document(every) | {"figures_to_reach": to_json(reached)}
    return Findings([short_table(every)], findings(every), sections, figures=figures, document=document)


def _against_filtered(verdict: Verdict, run: str) -> dict[str, Any]:
    """What the document tells of a run beside its errors against the raw force."""
    found = getattr(verdict.against["filtered"], run).to_json()
    return {f"{name}_filtered": found[name] for name in ("rendered_error", "between_switches_error")}


def _document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    causes = []
    for verdict in verdicts:
        runs = verdict.against["raw"]
        figures = {reference: list(verdict.figures(reference)) for reference in REFERENCES}
        spikes = {"running": runs.spikes, "frozen": runs.frozen_spikes}
        causes.append({"name": verdict.cause.name, "group": verdict.cause.group, "figures": figures, "spikes": spikes})
    claims = []
    for claim in CLAIMS:
        by = {reference: [c.name for c in reproducing(verdicts, claim, reference)] for reference in REFERENCES}
        said = {"thesis": claim.says, "needs": claim.needs, "reproduced_by": by}
        claims += [{"figure": figure, **said} for figure in claim.figures]
    return {"causes": causes, "figures": claims}


def ablation(causes: Sequence[Cause] = CAUSES) -> Comparison:
    """The comparison that puts in every cause, alone or with others as it says."""
    return Comparison(
        name="ablation",
        title="What is behind the thesis's figures?",
        lead=(
            "The thesis's estimated force follows the measured one while its rendered force does not, and it does not "
            "say why. The simplest candidate is no fault at all: what it plots as the measured force may be its "
            "estimator's own signal, which the filters delay. So errors and figures are given against both, the raw "
            "force and the filtered one. Each other candidate is put alone into a station that has none of them, then "
            "the likely ones together."
        ),
        cases=partial(cases, causes),
        judge=judge,
        heading="Ablation: operator {operator}",
        conditions=(
            "Operator {operator}, seed {seed}; every cause runs as experiment 1, once more with its parameters frozen "
            "after 5 s of contact, and as experiment 3. Recordings stand beside this page."
        ),
        file=lambda number, name: f"{number // len(RUNS):02d}_{name.rpartition(': ')[2]}",
    )


STUDIES: Final = {"ablation": replace(ablation().study, label="ablation, runs")}
