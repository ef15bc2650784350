"""Common parts of a diagnosis's figures: how each model is drawn, names for people, layouts, binned curves."""

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from mmt_drake.analysis.plotting import BLACK, BLUE, DPI, GREEN, GREY, ORANGE, WIDTH_IN
from mmt_drake.diagnosis.tell.evidence import Evidence, Series
from mmt_drake.numeric.arrays import Array

MEASURED: Final = BLACK
NOISE: Final = GREY
COLORS: Final = {"nominal": ORANGE, "refit": BLUE, "augmented": GREEN}
DASHES: Final = {"nominal": (0, (5, 2)), "refit": (0, (2, 1.2)), "augmented": "solid"}
"""Lines are told apart without colour too, on a grey print."""
HELDOUT: Final = "#E1ECF5"
POINTS: Final = 4000
"""Samples at most in a cloud of points."""


def axis_label(signal: Series, what: str | None = None) -> str:
    """`label [unit]`, with another word for the label if given; nothing in brackets without a unit."""
    label = what or signal.label
    return f"{label} [{signal.unit}]" if signal.unit else label


def grid(rows: int, columns: int, height_in: float, *, share_y: bool = False) -> tuple[Figure, list[Axes]]:
    """A figure of panels, row by row, each with its own x axis.

    Args:
        rows: of panels.
        columns: of panels.
        height_in: height of the figure [inch].
        share_y: one scale for all.
    """
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    panels = list(figure.subplots(rows, columns, squeeze=False, sharey=share_y).flat)
    for panel in panels:
        # ticks are made when first drawn, perhaps under other settings: say their looks now
        panel.tick_params(labelsize=8.5, color="#555555", labelcolor="#333333")
        panel.locator_params(axis="x", nbins=10 // columns)
    return figure, panels


def shade_heldout(panels: Iterable[Axes], evidence: Evidence) -> None:
    """Shade the held-out blocks in every panel."""
    spans = [(start, end - start) for start, end in evidence.heldout_s]
    for panel in panels:
        panel.broken_barh(spans, (0, 1), transform=panel.get_xaxis_transform(), color=HELDOUT, linewidth=0, zorder=0)


def legend_below(figure: Figure, panels: Iterable[Axes], *, heldout: bool = False) -> None:
    """One row below the whole figure with the signals of all panels, and a patch for held-out blocks if asked for."""
    handles: dict[str, Artist] = {}
    for panel in panels:
        handles = dict(zip(*panel.get_legend_handles_labels()[::-1], strict=True)) | handles
    if heldout:
        handles["held out from the fit"] = Patch(color=HELDOUT)
    if not handles:
        return
    legend = figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=6, columnspacing=1.4, handlelength=2.2
    )
    for handle in legend.legend_handles:
        if isinstance(handle, Line2D) and handle.get_marker() == ".":  # of a cloud: too small and pale to be seen
            handle.set(markersize=8.0, alpha=1.0)


def cloud(panel: Axes, over: Array, values: Array, label: str, color: str, **style: Any) -> None:
    """Points, thinned to `POINTS`."""
    shown = np.unique(np.linspace(0, len(over) - 1, min(len(over), POINTS)).astype(np.intp))
    settings = {"markersize": 1.8, "alpha": 0.35, **style}
    panel.plot(over[shown], values[shown], ".", color=color, label=label, markeredgewidth=0, **settings)


def binned(over: Array, values: Array, bins: int = 28, least: int = 12) -> tuple[Array, Array, Array, Array]:
    """The median of `values` in equal bins of `over`, with its spread: four (m,) arrays.

    Bins span the 0.5th to the 99.5th percentile, so that a stray sample does not stretch them; those with fewer than
    `least` samples are left out.

    Returns:
        centre of each bin, 10th percentile, median, 90th percentile of the values in it.
    """
    if len(over) == 0:
        return np.empty(0), np.empty(0), np.empty(0), np.empty(0)
    low, high = np.percentile(over, (0.5, 99.5))
    edges = np.linspace(low, high, bins + 1)
    which = np.digitize(over, edges) - 1
    full = [k for k in range(bins) if np.count_nonzero(which == k) >= least]
    quantiles = np.array([np.percentile(values[which == k], (10, 50, 90)) for k in full]).reshape(-1, 3)
    return 0.5 * (edges[:-1] + edges[1:])[full], quantiles[:, 0], quantiles[:, 1], quantiles[:, 2]


def scale(panel: Axes, *values: Array) -> None:
    """Fit the y axis to all but the utmost thousandth of the values, with a margin."""
    finite = np.concatenate([array[np.isfinite(array)] for array in values])
    if finite.size:
        low, high = np.percentile(finite, (0.05, 99.95))
        margin = 0.08 * (high - low) or 1.0
        panel.set_ylim(low - margin, high + margin)
