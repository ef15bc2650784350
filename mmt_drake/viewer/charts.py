"""Charts over time beside the scene: what they show, and the page that has both."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

import jinja2

from mmt_drake.analysis.plotting import ESTIMATED, GREEN, MEASURED, RENDERED
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.wording import law_words
from mmt_drake.model.message_layout import ENTRY, MESSAGE, OF_SENSOR, SENSOR
from mmt_drake.model.parameters import THETA_UNITS
from mmt_drake.model_message import code_of
from mmt_drake.viewer.scene import LEGEND

SHOWN_SECONDS = 10.0
"""Length of the time axis [s]."""


@dataclass(frozen=True)
class ChartLine:
    """A line in a chart.

    Attributes:
        column: of a sample, see `Panels`.
        label: in the legend.
        colour: as CSS has it.
        width: of the line [px].
    """

    column: int
    label: str
    colour: str
    width: float = 1.5


@dataclass(frozen=True)
class Chart:
    """One panel.

    Attributes:
        title: what is shown, with its unit.
        traces: its lines.
        wide: a panel over the whole width.
        truth: a value that is drawn across; None: none is known.
    """

    title: str
    traces: tuple[ChartLine, ...]
    wide: bool = False
    truth: float | None = None


@dataclass(frozen=True)
class Panels:
    """What is charted.

    Attributes:
        columns: of a sample, the time [s] first; a number is NaN where it is not known.
        charts: panels of these.
        scene: whether there is something to be seen beside them.
    """

    columns: tuple[str, ...]
    charts: tuple[Chart, ...]
    scene: bool = True


MODEL_WORDS = (
    "",
    "<b>the model does not explain the force</b>",
    "<b>another object than before</b>",
    "not every number is known yet",
)
"""By `mmt_drake.estimation.output_error.adequacy.ModelStatus`."""
LEARNER_WORDS = ("", "looking for what is missing", "", "what is missing is not to be felt", "no name for it", "")
"""By `mmt_drake.learner_status.LearnerStatus`; laws that are told speak for themselves."""

CARRIED_WORDS = ("", "held on the table", "carried", "<b>slips in the grip</b>", "<b>slipped out of the grip</b>")
"""By the state of `mmt_drake.estimation.carried`; the mass [kg] stands behind it."""

_FORCES = {"true": "true_force", "estimated": "estimated_force", "measured": "force", "rendered": "rendered_force"}
_DRAWN = {"true": (GREEN, 5.0), "estimated": (ESTIMATED, 3.0), "measured": (MEASURED, 1.5), "rendered": (RENDERED, 1.5)}
"""Colour and width: where lines are one, all are seen, the first below."""
_TOLD = ("in_contact", "theta_stable", "model_status", "learner_status")
_LAWS = tuple(f"model_{name}" for name in MESSAGE[OF_SENSOR.start :])
_CARRIED = ("carried_state", "carried_m")
#: What a sample of a station holds: numbers in this order, NaN where one is not known.
COLUMNS = (
    "time",
    *(f"{name}_{axis}" for name in _FORCES.values() for axis in "xyz"),
    *_TOLD,
    *(f"theta_{symbol}" for symbol in THETA_UNITS),
    *_LAWS,
    *_CARRIED,
)

_NOT_KNOWN = (math.nan,) * len(THETA_UNITS)


def station_panels(truth: Mapping[str, float] | None = None) -> Panels:
    """Forces along each axis, then every parameter.

    Args:
        truth: symbol of theta -> the simulated object's own value, SI units.
    """
    forces = (
        Chart(
            f"force {axis} [N]",
            tuple(ChartLine(COLUMNS.index(f"{name}_{axis}"), label, *_DRAWN[label]) for label, name in _FORCES.items()),
            wide=True,
        )
        for axis in "xyz"
    )
    parameters = (
        Chart(
            f"{symbol} [{unit}]",
            (ChartLine(COLUMNS.index(f"theta_{symbol}"), symbol, ESTIMATED),),
            truth=None if truth is None else truth[symbol],
        )
        for symbol, unit in THETA_UNITS.items()
    )
    return Panels(COLUMNS, (*forces, *parameters))


def sample(time: float, values: Mapping[str, Sequence[float]]) -> list[float]:
    """A sample of `station_panels`, of values by the names of the ports of `mmt_drake.systems.live_view.LiveView`."""
    parts = {"measured": values.get("measurement", _NOT_KNOWN)[6:9]}
    parts |= {label: values.get(name, _NOT_KNOWN[:3]) for label, name in _FORCES.items() if label != "measured"}
    ports = ("in_contact", "stable", *_TOLD[2:])
    told = [values.get(name, _NOT_KNOWN)[0] for name in ports]
    laws = values.get("model", (math.nan,) * len(MESSAGE))[OF_SENSOR.start :]
    forces = (number for label in _FORCES for number in parts[label])
    held = values.get("carried", _NOT_KNOWN)[: len(_CARRIED)]
    return [time, *forces, *told, *values.get("theta", _NOT_KNOWN), *laws, *held]


def page(notices: Sequence[str] = (), panels: Panels | None = None, *, replay: bool = False) -> str:
    """The page: the scene on one side, charts on the other; it fetches nothing but from where it is.

    Args:
        notices: lines above the charts.
        panels: what is charted; `station_panels` by default.
        replay: of a recording, which may stand still.
    """
    panels = station_panels() if panels is None else panels
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mmt_drake.viewer", "templates"), undefined=jinja2.StrictUndefined
    )
    contact, stable, model, learner = (panels.columns.index(name) if name in panels.columns else -1 for name in _TOLD)
    told = _LAWS[0] in panels.columns
    settings = {
        "width": len(panels.columns),
        "contact": contact,
        "stable": stable,
        "model": model,
        "models": MODEL_WORDS,
        "learner": learner,
        "learners": LEARNER_WORDS,
        "carried": [panels.columns.index(name) for name in _CARRIED if name in panels.columns],
        "grips": CARRIED_WORDS,
        "laws": [panels.columns.index(name) for name in _LAWS[len(SENSOR) :: ENTRY] if name in panels.columns],
        "sensor": {panels.columns.index(_LAWS[i]): law_words(LIBRARY[n]) for i, n in enumerate(SENSOR) if told},
        "effects": {f"{code_of(name):.0f}": law_words(effect) for name, effect in LIBRARY.items()},
        "shown": SHOWN_SECONDS,
        "charts": [asdict(chart) for chart in panels.charts],
        "truth": GREEN,
        "replay": replay,
    }
    legend = LEGEND if panels.scene else ()
    text = json.dumps(settings).replace("<", "\\u003c")  # a name from a file ends no script
    return environment.get_template("live.html.j2").render(settings=text, notices=notices, legend=legend)
