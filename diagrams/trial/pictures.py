"""The trial's confusion matrix as a picture."""

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import BLACK, DPI, GREEN, GREY, RED, styled
from mmt_drake.diagrams.trial.score import TrialScore
from mmt_drake.diagrams.trial.summary import confusion
from mmt_drake.errors import BadInput


@styled
def confusion_picture(scores: Sequence[TrialScore]) -> Figure:
    """What was concealed (rows) against what was said (columns); right answers green, false names red.

    A cell whose cases were neither, a verdict that leaves the question open or an effect that was missed, is grey.

    Raises:
        BadInput: no score.
    """
    if not scores:
        raise BadInput("trial", found="no case", expected="at least one to draw")
    rows, columns, counts = confusion(scores)
    right, false = _shares(scores, rows, columns)
    width, height = 2.6 + 0.27 * len(columns), 2.2 + 0.21 * len(rows)
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((2.3 / width, 0.15 / height, 0.27 * len(columns) / width, 0.21 * len(rows) / height))
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(rows) - 0.5, -0.5))
    for i, j in zip(*np.nonzero(counts), strict=True):
        color = RED if false[i, j] else GREEN if right[i, j] else GREY
        share = counts[i, j] / counts[i].sum()
        axes.fill(
            [j - 0.5, j + 0.5, j + 0.5, j - 0.5],
            [i - 0.5, i - 0.5, i + 0.5, i + 0.5],
            color=color,
            alpha=0.25 + 0.6 * share,
            lw=0,
        )
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=7.5, color=BLACK)
    axes.set_xticks(range(len(columns)), [name.replace("_", " ") for name in columns], rotation=90, fontsize=7.5)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name in rows], fontsize=7.5)
    axes.xaxis.tick_top()
    axes.set_xticks(np.arange(len(columns) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(rows) + 1) - 0.5, minor=True)
    axes.grid(visible=False, which="major")
    axes.grid(visible=True, which="minor", color="#DDDDDD", linewidth=0.5)
    axes.tick_params(length=0, which="both")
    figure.text(0.02, 1.0 - 0.12 / height, "concealed (rows), said (columns)", fontsize=9, weight="bold", va="top")
    return figure


def _shares(
    scores: Sequence[TrialScore], rows: Sequence[str], columns: Sequence[str]
) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.int64]], np.ndarray[tuple[int, ...], np.dtype[np.int64]]]:
    """How many of each cell's cases were right, and how many false names."""
    right = np.zeros((len(rows), len(columns)), dtype=np.int64)
    false = np.zeros_like(right)
    for score in scores:
        own_rows, own_columns, _ = confusion([score])
        cell = rows.index(own_rows[0]), columns.index(own_columns[0])
        right[cell] += score.correct
        false[cell] += score.false_name
    return right, false
