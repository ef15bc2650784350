"""Figures on a page that can be zoomed, hovered over and saved as SVG, with nothing fetched (plotly)."""

import base64
import gzip
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from mmt_drake.analysis.plotting import GREY, envelope
from mmt_drake.numeric.arrays import Array

THINNED: Final = 2000
"""Samples at most in a curve of a page."""
THINNING: Final = (
    f"Curves of more than {THINNED} samples are thinned for this page: of each stretch the least and the greatest "
    "value stay, so that no peak is lost. Errors and verdicts are computed from all samples."
)

_AXIS: Final = {"gridcolor": "#e3e3e3", "linecolor": "#555", "zerolinecolor": "#bbb", "ticks": "outside", "ticklen": 3}
_FONT: Final = 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif'


@dataclass(frozen=True)
class Plot:
    """A figure of a page.

    Attributes:
        figure: drawn by the reader's browser, as wide as the page and as high as its layout says.
        caption: the sentences below it.
        title: above it.
        half: whether two of them stand side by side where there is room.
    """

    figure: go.Figure
    caption: str
    title: str = ""
    half: bool = False

    @property
    def height(self) -> int:
        """Of the figure [pixels]."""
        return int(self.figure.layout.height)


def rows(heights: Sequence[int], *, shared: bool = True) -> go.Figure:
    """A figure of panels below one another, in the style of the pages.

    Args:
        heights: of the panels [pixels].
        shared: whether all have one x axis, with its label below the last.
    """
    between = 18 if shared else 44
    inner = sum(heights) + between * (len(heights) - 1)
    figure = make_subplots(
        rows=len(heights),
        cols=1,
        shared_xaxes=shared,
        row_heights=list(heights),
        vertical_spacing=0.0 if len(heights) == 1 else between / inner,
    )
    figure.update_layout(
        height=inner + 90,
        margin={"l": 62, "r": 12, "t": 36, "b": 46},
        font={"family": _FONT, "size": 12, "color": "#333"},
        template="none",
        plot_bgcolor="#fff",
        paper_bgcolor="#fff",
        hovermode="closest",
        legend={
            "orientation": "h",
            "x": 0.0,
            "y": 1.0,
            "yanchor": "bottom",
            "xanchor": "left",
            "itemsizing": "constant",
        },
    )
    figure.update_xaxes(**_AXIS)
    figure.update_yaxes(**_AXIS, title_standoff=6)
    return figure


def curve(figure: go.Figure, x: Array, y: Array, name: str, color: str, *, row: int = 1, **style: Any) -> None:
    """Add a line, thinned to `THINNED` samples.

    Args:
        figure: of `rows`.
        x: (n,) increasing.
        y: (n,).
        name: in the legend, and beside a value that is pointed at.
        color: of the line.
        row: of the panel, from 1 on.
        style: of plotly's scatter.
    """
    figure.add_scatter(**_thin(x, y), name=name, mode="lines", line={"color": color, "width": 1.4}, row=row, col=1)
    figure.data[-1].update(**style)


def points(figure: go.Figure, x: Array, y: Array, name: str, color: str, *, row: int = 1, **style: Any) -> None:
    """Add samples as points, thinned as a `curve` is; x, (n,), increases."""
    figure.add_scatter(
        **_thin(x, y), name=name, mode="markers", marker={"color": color, "size": 5, "opacity": 0.7}, row=row, col=1
    )
    figure.data[-1].update(**style)


def cloud(figure: go.Figure, x: Array, y: Array, name: str, color: str, **style: Any) -> None:
    """Add points in no order, (n,) each, every n-th of more than `THINNED`."""
    shown = np.unique(np.linspace(0, len(x) - 1, min(len(x), THINNED)).astype(np.intp))
    marker = {"color": color, "size": 3.5, "opacity": 0.55}
    figure.add_scatter(x=_short(x[shown]), y=_short(y[shown]), name=name, mode="markers", marker=marker, row=1, col=1)
    figure.data[-1].update(**style)


def shade(figure: go.Figure, spans: Sequence[tuple[float, float]], color: str, name: str, row: int = 1) -> None:
    """Shade spans of x over the whole height of a panel, with a patch in the legend; nothing where there is none."""
    for start, end in spans:
        figure.add_vrect(x0=start, x1=end, fillcolor=color, line_width=0, layer="below", row=row, col=1)
    if spans:
        marker = {"symbol": "square", "color": color, "size": 12, "line": {"color": GREY, "width": 0.5}}
        figure.add_scatter(x=[None], y=[None], name=name, mode="markers", marker=marker, row=row, col=1)


def packed(plots: Sequence[Plot]) -> str:
    """The library and the figures as a page carries them: JSON, packed by gzip, in base64."""
    figures = [json.loads(plot.figure.to_json()) for plot in plots]
    text = json.dumps({"library": get_plotlyjs(), "figures": figures})
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode("ascii")


def unpacked(text: str) -> list[dict[str, Any]]:
    """The figures, data and layout, of what `packed` gave."""
    return json.loads(gzip.decompress(base64.b64decode(text)))["figures"]


def _thin(x: Array, y: Array) -> dict[str, Any]:
    kept_x, kept_y = envelope(x, y, THINNED // 2 - 1)
    return {"x": _short(kept_x), "y": _short(kept_y)}


def _short(values: Array) -> Any:
    """Half the bytes: seven digits are more than a figure shows."""
    return np.asarray(values, dtype=np.float32)
