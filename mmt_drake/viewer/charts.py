"""Charts over time beside the scene: what they show, their page, and how samples get there.

Meshcat draws no charts and serves no pages but its own. Its connection to the browser carries properties of things in
the scene, though, so samples travel as a property that nothing in the scene has, and the page reads them from a
connection of its own. Like all of Meshcat that costs the sender a call; packing and sending is done in C++, beside.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

import jinja2
from pydrake.geometry import Meshcat

from mmt_drake.analysis.plotting import ESTIMATED, MEASURED, RENDERED
from mmt_drake.model.parameters import THETA_UNITS

SHOWN_SECONDS = 10.0
"""Length of the time axis [s]."""

PATH, PROPERTY = "/charts", "samples"
"""Where the samples travel."""


@dataclass(frozen=True)
class Trace:
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
    traces: tuple[Trace, ...]
    wide: bool = False


#: What a sample holds: numbers in this order, NaN where one is not known.
COLUMNS = (
    "time",
    *(f"force_{axis}" for axis in "xyz"),
    *(f"rendered_force_{axis}" for axis in "xyz"),
    "in_contact",
    "theta_stable",
    *(f"theta_{symbol}" for symbol in THETA_UNITS),
)


def charts() -> tuple[Chart, ...]:
    """Force along each axis, measured and rendered; then every parameter."""
    forces = (
        Chart(
            f"force {axis} [N]",
            (
                Trace(COLUMNS.index(f"force_{axis}"), "measured", MEASURED),
                Trace(COLUMNS.index(f"rendered_force_{axis}"), "rendered", RENDERED),
            ),
            wide=True,
        )
        for axis in "xyz"
    )
    parameters = (
        Chart(f"{symbol} [{unit}]", (Trace(COLUMNS.index(f"theta_{symbol}"), symbol, ESTIMATED),))
        for symbol, unit in THETA_UNITS.items()
    )
    return (*forces, *parameters)


class Samples:
    """Collects samples and sends them, in batches, to whoever looks.

    Args:
        meshcat: whose connection carries them.
    """

    def __init__(self, meshcat: Meshcat) -> None:
        self._meshcat = meshcat
        self._waiting: list[float] = []

    def add(self, values: list[float]) -> None:
        """Take one sample, in the order of `COLUMNS`."""
        self._waiting += values

    def send(self) -> None:
        """Send what has come together since the last time."""
        waiting, self._waiting = self._waiting, []
        if waiting:
            self._meshcat.SetProperty(PATH, PROPERTY, waiting)


def page(meshcat_url: str) -> str:
    """The page: the scene on one side, charts on the other; it fetches nothing but from Meshcat's own address."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mmt_drake.viewer", "templates"), undefined=jinja2.StrictUndefined
    )
    told = {
        "width": len(COLUMNS),
        "contact": COLUMNS.index("in_contact"),
        "stable": COLUMNS.index("theta_stable"),
        "property": PROPERTY,
        "shown": SHOWN_SECONDS,
        "charts": [asdict(chart) for chart in charts()],
    }
    return environment.get_template("live.html.j2").render(
        scene=meshcat_url, socket=meshcat_url.replace("http", "ws", 1), told=json.dumps(told)
    )
