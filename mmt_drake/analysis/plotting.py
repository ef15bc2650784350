"""The style of all figures: colours, thinning of long signals, and files."""

import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from mmt_drake.analysis.signals import stretches
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.atomic import replacing, writing

# The Okabe-Ito palette: told apart by every kind of colour vision, and in grey by their lightness.
BLACK, ORANGE, SKY, GREEN, BLUE, RED, PURPLE = (
    "#222222",
    "#E69F00",
    "#56B4E9",
    "#009E73",
    "#0072B2",
    "#D55E00",
    "#CC79A7",
)
MEASURED, RENDERED, ESTIMATED, ERROR = BLACK, RED, BLUE, GREEN
GREY: Final = "#8A8A8A"

WIDTH_IN: Final = 7.2
LEFT_IN, RIGHT_IN, TOP_IN, BOTTOM_IN = 0.76, 0.1, 0.32, 0.48
DPI: Final = 130
PIXELS: Final = 1800  # bins of a thinned signal: twice the columns of a figure at DPI

STYLE: Final[dict[str, Any]] = {
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#555555",
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.prop_cycle": cycler(color=[BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK]),
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "lines.solid_joinstyle": "round",
    "xtick.color": "#333333",
    "ytick.color": "#333333",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "legend.borderaxespad": 0.2,
    "path.simplify": True,
    "agg.path.chunksize": 20000,
}


@contextmanager
def in_style(**changes: Any) -> Iterator[None]:
    """matplotlib in the style of this module, with some settings changed; the caller's own come back afterwards."""
    settings: dict[Any, Any] = {**STYLE, **changes}  # matplotlib's types know the keys one by one
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(settings)
        yield


styled: Final = in_style()
"""Decorator: draw a figure in the style of this module, whatever the caller's matplotlib settings."""


def panels(
    rows: int, height_in: float, *, columns: int = 1, height_ratios: Sequence[float] | None = None
) -> tuple[Figure, list[Axes]]:
    """A figure of panels, row by row, that share the x axis; no pyplot, so nothing to close.

    Margins are fixed in inches: time axes of figures below one another line up, and no layout has to be solved.

    Args:
        rows: how many panels stand above one another.
        height_in: height of the figure [inch].
        columns: how many stand beside one another.
        height_ratios: (rows,) relative heights.
    """
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI)
    FigureCanvasAgg(figure)
    row_in = (height_in - TOP_IN - BOTTOM_IN) / rows
    column_in = (WIDTH_IN - LEFT_IN - RIGHT_IN) / columns
    grid = figure.subplots(
        rows,
        columns,
        sharex=True,
        squeeze=False,
        height_ratios=height_ratios,
        gridspec_kw={
            "left": LEFT_IN / WIDTH_IN,
            "right": 1.0 - RIGHT_IN / WIDTH_IN,
            "top": 1.0 - TOP_IN / height_in,
            "bottom": BOTTOM_IN / height_in,
            "hspace": 0.2 / max(row_in - 0.2, 0.2),
            "wspace": LEFT_IN / (column_in - LEFT_IN / 2),
        },
    )
    for panel in grid.flat:
        # ticks are made when first drawn, perhaps under other settings: say their looks now
        panel.tick_params(labelsize=8.5, color="#555555", labelcolor="#333333")
        panel.yaxis.set_label_coords(-(LEFT_IN - 0.2) / (panel.get_position().width * WIDTH_IN), 0.5)
    return figure, list(grid.flat)


def envelope(time: Array, values: Array, bins: int = PIXELS) -> tuple[Array, Array]:
    """Samples that draw the same line: the least and the greatest of each of `bins` bins, in order of time.

    Bins hold equal numbers of samples. The first and the last sample are kept, and a signal of up to 2 `bins` samples
    is returned as it is. NaN is left out of a bin's extremes; a bin of NaN alone stays NaN, so a gap stays a gap.
    """
    n = len(values)
    if n <= 2 * bins:
        return time, values
    edges = np.linspace(0, n, bins + 1).astype(np.intp)[:-1]
    low, high = np.fmin.reduceat(values, edges), np.fmax.reduceat(values, edges)
    bin_of = np.repeat(np.arange(bins), np.diff(np.append(edges, n)))
    kept = np.zeros(n, dtype=bool)
    for extreme in (low, high):
        hits = np.flatnonzero(values == extreme[bin_of])
        _, first = np.unique(bin_of[hits], return_index=True)
        kept[hits[first]] = True
    kept[edges[np.isnan(low)]] = True
    kept[[0, n - 1]] = True
    return time[kept], values[kept]


def line(axes: Axes, time: Array, values: Array, label: str, **style: Any) -> None:
    """Draw a signal against time, thinned to what can be seen."""
    axes.plot(*envelope(time, values), label=label, **style)


def shade(axes: Iterable[Axes], time: Array, flags: Flags) -> None:
    """Shade the stretches of time in which a flag is set, in every panel."""
    spans = [(float(time[a]), float(time[b] - time[a])) for a, b in stretches(flags)]
    for panel in axes:
        panel.broken_barh(spans, (0, 1), transform=panel.get_xaxis_transform(), color="#F1F1EC", linewidth=0, zorder=0)


def legend_above(axes: Axes, of: Axes | None = None) -> None:
    """A one-row legend over the right end of a panel, where it hides no data; `of` another panel's signals."""
    handles, labels = (of or axes).get_legend_handles_labels()
    axes.legend(
        handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=6, handlelength=1.6, columnspacing=1.2
    )


def png(figure: Figure, dpi: int = DPI) -> bytes:
    """The figure as a PNG file's bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=dpi)
    return buffer.getvalue()


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure, `.png`, `.pdf` or `.svg` by the ending of its name; the folder is made if need be.

    Raises:
        BadInput: another ending, or the file cannot be written.
    """
    path = Path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("png", "pdf", "svg"):
        raise BadInput(path, found=f"ending {path.suffix!r}", expected=".png, .pdf or .svg")
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, dpi=DPI)
    write_whole(path, buffer.getvalue())
    return path


def write_whole(path: Path, content: bytes) -> None:
    """Write a file in one move (`recording.atomic.replacing`), its folder made if need be.

    Raises:
        BadInput: the folder cannot be made or the file not written.
    """
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_bytes(content)
