"""Charts over time beside the scene: what they show, and the page that has both."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import jinja2

from mmt_drake.analysis.plotting import ESTIMATED, MEASURED, RENDERED
from mmt_drake.model.parameters import THETA_UNITS

SHOWN_SECONDS = 10.0
"""Length of the time axis [s]."""


@dataclass(frozen=True)
class ChartLine:
    """A line in a chart.

    Attributes:
        column: of a sample, see `COLUMNS`.
        label: in the legend.
        colour: as CSS has it.
    """

    column: int
    label: str
    colour: str


@dataclass(frozen=True)
class Chart:
    """One panel.

    Attributes:
        title: what is shown, with its unit.
        traces: its lines.
        wide: a panel over the whole width.
    """

    title: str
    traces: tuple[ChartLine, ...]
    wide: bool = False


MODEL_WORDS = (
    "",
    "<b>the model does not explain the force</b>",
    "<b>another object than before</b>",
    "not every number is known yet",
)
"""By `mmt_drake.estimation.output_error.adequacy.ModelStatus`."""

#: What a sample holds: numbers in this order, NaN where one is not known.
COLUMNS = (
    "time",
    *(f"force_{axis}" for axis in "xyz"),
    *(f"rendered_force_{axis}" for axis in "xyz"),
    "in_contact",
    "theta_stable",
    "model_status",
    *(f"theta_{symbol}" for symbol in THETA_UNITS),
)


def charts() -> tuple[Chart, ...]:
    """Force along each axis, measured and rendered; then every parameter."""
    forces = (
        Chart(
            f"force {axis} [N]",
            (
                ChartLine(COLUMNS.index(f"force_{axis}"), "measured", MEASURED),
                ChartLine(COLUMNS.index(f"rendered_force_{axis}"), "rendered", RENDERED),
            ),
            wide=True,
        )
        for axis in "xyz"
    )
    parameters = (
        Chart(f"{symbol} [{unit}]", (ChartLine(COLUMNS.index(f"theta_{symbol}"), symbol, ESTIMATED),))
        for symbol, unit in THETA_UNITS.items()
    )
    return (*forces, *parameters)


def page(notices: Sequence[str] = ()) -> str:
    """The page: the scene on one side, charts on the other; it fetches nothing but from where it is.

    Args:
        notices: lines above the charts.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mmt_drake.viewer", "templates"), undefined=jinja2.StrictUndefined
    )
    settings = {
        "width": len(COLUMNS),
        "contact": COLUMNS.index("in_contact"),
        "stable": COLUMNS.index("theta_stable"),
        "model": COLUMNS.index("model_status"),
        "models": MODEL_WORDS,
        "shown": SHOWN_SECONDS,
        "charts": [asdict(chart) for chart in charts()],
    }
    return environment.get_template("live.html.j2").render(settings=json.dumps(settings), notices=notices)
