"""The ablation as one table, one figure, sentences and a page."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations, groupby
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
from mmt_drake.analysis.wording import in_percent, percent, significant
from mmt_drake.diagrams.experiments.ablation.causes import CAUSES, Cause
from mmt_drake.diagrams.experiments.ablation.claims import CLAIMS, Claim
from mmt_drake.diagrams.experiments.ablation.run import RUNS, Verdict, cases, verdicts_of
from mmt_drake.diagrams.experiments.comparison import Comparison, Findings
from mmt_drake.diagrams.experiments.runs import Cases, ratio_of
from mmt_drake.diagrams.experiments.targets import ESTIMATED, RENDERED
from mmt_drake.diagrams.studies.study import reached_table, to_json
from mmt_drake.model.parameters import THETA, THETA_UNITS

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
_FEW: Final = 4  # names in a sentence; a table has them all
_ROW_IN, _TOP_IN, _BOTTOM_IN = 0.2, 0.95, 0.12


def findings(verdicts: Sequence[Verdict]) -> list[str]:
    """What came out, figure by figure; every name and number is the result's."""
    sentences = [_figure_sentence(verdicts, claim) for claim in CLAIMS]
    every = sorted(figure for claim in CLAIMS for figure in claim.figures)
    for what, groups in (
        ("One cause reproduces", ("estimator", "plant", "renderer", "hand")),
        ("Several together reproduce", ("together",)),
    ):
        among = [verdict for verdict in verdicts if verdict.cause.group in groups]
        if not among:
            continue
        most = max(len(verdict.figures) for verdict in among)
        best = [verdict for verdict in among if len(verdict.figures) == most]
        missing = [figure for figure in every if figure not in best[0].figures]
        left = f", all but {_listed(missing)}" if len(best) == 1 and missing else ""
        names = "; ".join(verdict.cause.name for verdict in best)
        sentences.append(f"{what} at most {most} of the {len(every)} figures{left}: {names}.")
    return sentences + _pairs_sentence(verdicts, len(every))


def _pairs_sentence(verdicts: Sequence[Verdict], every: int) -> list[str]:
    """Which two causes, each by itself, reproduce more figures between them than any one does."""
    alone = {v.cause.name: set(v.figures) for v in verdicts if v.cause.group not in ("none", "together")}
    shown = {(one, other): len(alone[one] | alone[other]) for one, other in combinations(alone, 2)}
    most = max(shown.values(), default=0)
    if most <= max(map(len, alone.values()), default=0):
        return []
    best = [" and ".join(pair) for pair, count in shown.items() if count == most]
    return [f"Two causes, each in runs of its own, reproduce at most {most} of the {every} figures: {'; '.join(best)}."]


def reproducing(verdicts: Sequence[Verdict], claim: Claim) -> list[Cause]:
    """The causes that reproduce what a figure shows."""
    return [verdict.cause for verdict in verdicts if claim in verdict.reproduced]


def _figure_sentence(verdicts: Sequence[Verdict], claim: Claim) -> str:
    by = reproducing(verdicts, claim)
    alone = [cause.name for cause in by if cause.group not in ("together", "none")]
    together = [cause.name for cause in by if cause.group == "together"]
    name = f"Figure{'s' if len(claim.figures) > 1 else ''} {claim.name}: {claim.says}"
    if len(by) == len(verdicts):
        return f"{name} Reproduced whatever is put in."
    if not by:
        return f"{name} Reproduced by nothing here."
    inherent = "with nothing put in, too; " if any(cause.group == "none" for cause in by) else ""
    by_alone = f"by {_few(alone)} alone" if alone else "by no single cause"
    return f"{name} Reproduced {inherent}{by_alone}{f'; together by {_few(together)}' if together else ''}."


def _few(names: Sequence[str]) -> str:
    """The first names of many."""
    shown = _listed(names[:_FEW])
    return shown if len(names) <= _FEW else f"{shown} and {len(names) - _FEW} more"


def _listed(things: Sequence[object]) -> str:
    return ", ".join(map(str, things))


def short_table(verdicts: Sequence[Verdict]) -> Table:
    """One row per cause, for a terminal: rendered error by band, estimated error, verdict, figures reproduced."""
    headers = ["cause", *(f"{name} [%]" for name in BAND_NAMES.values()), "estimated [%]", "verdict"]
    headers.append("figures reproduced")
    most = [in_percent(target.to_reach) for target in RENDERED.values()]
    rows: list[list[Cell]] = [
        ["the thesis", None, *map(in_percent, _THESIS), None, None],
        ["to reach", None, *most, None, None, None],
    ]
    for verdict in verdicts:
        metrics = verdict.cases["running"].metrics
        errors = [ratio_of(metrics.rendered_error, band) for band in BANDS] + [ratio_of(metrics.estimated_error)]
        rendered = verdict.rendered()
        missed = sum(figure.reached is False for figure in rendered)
        judged = "reached" if rendered else "not known"
        if missed:
            judged = f"missed in {missed} band{'s' if missed > 1 else ''}"
        rows.append([verdict.cause.name, *map(in_percent, errors), judged, _listed(verdict.figures) or "none"])
    caption = (
        "Error of the rendered force by band, of the estimated force; experiment 1. The verdict is on the rendered "
        "force against the plant's without noise, in bands that hold enough of it."
    )
    return Table(headers, rows, caption)


def ablation_table(verdicts: Sequence[Verdict]) -> Table:
    """One row per cause: both errors by band, every parameter, figures reproduced."""
    headers = ["cause", *(f"rendered, {name} [%]" for name in BAND_NAMES.values())]
    headers += [f"estimated, {name} [%]" for name in BAND_NAMES.values()]
    headers += [f"{name} [{unit}]" for name, unit in THETA_UNITS.items()]
    headers += ["frozen: estimated, rendered [%]", "spikes differ: running, frozen [%]", "delayed: low, high [%]"]
    headers.append("figures reproduced")
    true = verdicts[0].cases["running"].truth
    nothing: list[Cell] = [None] * len(BANDS)
    rows: list[list[Cell]] = [["the true object", *nothing, *nothing, *(true[name] for name in THETA), "", "", "", ""]]
    for verdict in verdicts:
        metrics, frozen, delayed = (verdict.cases[run].metrics for run in ("running", "frozen", "delayed"))
        between = delayed.between_switches_error
        rows.append(
            [
                verdict.cause.name,
                *(in_percent(ratio_of(metrics.rendered_error, band)) for band in BANDS),
                *(in_percent(ratio_of(metrics.estimated_error, band)) for band in BANDS),
                *(metrics.parameters.get(name) for name in THETA),
                f"{percent(ratio_of(frozen.estimated_error))}, {percent(ratio_of(frozen.rendered_error))}",
                ", ".join(percent(verdict.spikes[run]) for run in ("running", "frozen")),
                f"{percent(ratio_of(between, _BANDS[0]))}, {percent(ratio_of(between, _BANDS[-1]))}",
                _listed(verdict.figures) or "none",
            ]
        )
    return Table(headers, rows, "Errors and last parameters of experiment 1, from 5 s of contact on.")


def figures_table(verdicts: Sequence[Verdict]) -> Table:
    """One row per figure of the thesis: what it shows, what counts as the same, and what reproduces it."""
    rows = []
    for claim in CLAIMS:
        by = reproducing(verdicts, claim)
        names = "everything" if len(by) == len(verdicts) else _listed([cause.name for cause in by])
        rows.append([claim.name, claim.says, claim.needs, names or "nothing here"])
    return Table(["figure", "what it shows", "counts as reproduced where", "reproduced by"], rows)


@styled
def ablation_figure(verdicts: Sequence[Verdict]) -> Figure:
    """Causes by row: errors as shaded numbers, figures of the thesis as dots."""
    rows = _rows(verdicts)
    height = _TOP_IN + _ROW_IN * len(rows) + _BOTTOM_IN
    figure = Figure(figsize=(WIDTH_IN, height), dpi=DPI)
    FigureCanvasAgg(figure)
    margins = {"left": 0.385, "right": 0.99, "top": 1.0 - _TOP_IN / height, "bottom": _BOTTOM_IN / height}
    errors, dots = figure.subplots(
        1, 2, sharey=True, width_ratios=(len(_BANDS) + 1, 1.15 * len(CLAIMS)), gridspec_kw={**margins, "wspace": 0.04}
    )
    _draw_errors(errors, rows)
    _draw_dots(dots, rows)
    errors.set_yticks(range(len(rows)), [name for name, _ in rows])
    errors.set_ylim(len(rows) - 0.5, -0.5)
    for label, (_, row) in zip(errors.get_yticklabels(), rows, strict=True):
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


def _draw_errors(panel: Axes, rows: Sequence[tuple[str, Verdict | str | None]]) -> None:
    values = np.full((len(rows), len(_BANDS) + 1), np.nan)
    for number, (_, row) in enumerate(rows):
        if isinstance(row, Verdict):
            metrics = row.cases["running"].metrics
            ratios = [ratio_of(metrics.rendered_error, band) for band in _BANDS] + [ratio_of(metrics.estimated_error)]
            values[number] = [np.nan if ratio is None else ratio for ratio in ratios]
        elif row is not None:
            values[number] = _THESIS
    panel.imshow(values, aspect="auto", cmap="OrRd", norm=LogNorm(0.003, 3.0, clip=True), alpha=0.85)
    for (number, column), value in np.ndenumerate(values):
        if np.isfinite(value):
            text = significant(100.0 * value, 2 if value >= 0.001 else 1) if value < 10.0 else "> 1000"
            color = "white" if value > 0.5 else BLACK
            panel.text(column, number, text, ha="center", va="center", fontsize=7.0, color=color)
    names = [f"rendered,\n{BAND_NAMES[band]}" for band in _BANDS] + ["estimated,\nall"]
    panel.set_xticks(range(len(names)), names, rotation=90, fontsize=7.5)
    panel.set_title("error [%]", fontsize=9, loc="center")
    panel.grid(visible=False)
    _bare(panel)


def _draw_dots(panel: Axes, rows: Sequence[tuple[str, Verdict | str | None]]) -> None:
    for number, (_, row) in enumerate(rows):
        if row is None:
            continue
        shown = [not isinstance(row, Verdict) or claim in row.reproduced for claim in CLAIMS]
        panel.scatter(
            np.flatnonzero(shown),
            np.full(sum(shown), number),
            s=34,
            color=RED if isinstance(row, Verdict) else GREY,
            linewidth=0,
        )
    panel.set_xticks(range(len(CLAIMS)), [f"figure {claim.name}" for claim in CLAIMS], rotation=90, fontsize=7.5)
    panel.set_xlim(-0.6, len(CLAIMS) - 0.4)
    panel.set_title("reproduced", fontsize=9, loc="center")
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
        "One row per cause. Left: RMS of the error over that of the measured force, in percent. Right: a dot where the "
        "runs with this cause show what a figure of the thesis shows."
    )
    sections = [
        Section("Causes and figures", figures=[Picture(ablation_figure(every), caption, name="ablation")]),
        Section("What was to be reached", table=reached_table(reached)),
        Section("Every error, every parameter", table=ablation_table(every)),
        Section("What counts as reproduced", table=figures_table(every)),
    ]
    figures = {
        f"{name}: {run}": {"cause": name, "group": verdict.cause.group, "run": run}
        for name, verdict in verdicts.items()
        for run in RUNS
    }
    document = _document(every) | {"figures_to_reach": to_json(reached)}
    return Findings([short_table(every)], findings(every), sections, figures=figures, document=document)


def _document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    causes = []
    for verdict in verdicts:
        cause = {"name": verdict.cause.name, "group": verdict.cause.group}
        causes.append({**cause, "figures": list(verdict.figures), "spikes": dict(verdict.spikes)})
    figures = []
    for claim in CLAIMS:
        by = [cause.name for cause in reproducing(verdicts, claim)]
        said = {"thesis": claim.says, "needs": claim.needs, "reproduced": bool(by), "reproduced_by": by}
        figures += [{"figure": figure, **said} for figure in claim.figures]
    return {"causes": causes, "figures": figures}


def ablation(causes: Sequence[Cause] = CAUSES) -> Comparison:
    """The comparison that puts in every cause, alone or with others as it says."""
    return Comparison(
        name="ablation",
        title="What is behind the thesis's figures?",
        lead=(
            "The thesis's estimated force follows the measured one while its rendered force does not, and it does not "
            "say why. Here each candidate is put alone into a station that has none of them, then the likely ones "
            "together."
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
