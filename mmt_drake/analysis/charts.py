"""Charts the thesis does not have: contact and its lags, parameters, energy, errors by band."""

import math
from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from mmt_drake.analysis.lags import Lags, lags
from mmt_drake.analysis.metrics import ForceError
from mmt_drake.analysis.passivity import passivity
from mmt_drake.analysis.plotting import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    legend_above,
    line,
    panels,
    shade,
    styled,
)
from mmt_drake.analysis.signals import BAND_NAMES, BANDS, delay_of, flag, stretches, vector
from mmt_drake.analysis.wording import milliseconds, significant
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA, THETA_UNITS
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording


@styled
def contact_timeline(recording: Recording, *, delay_s: float | None = None) -> Figure:
    """Times of contact of plant, detector and renderer, and the lag of every touch and release.

    Needs `in_contact` and `rendered_force_*`; `detected_contact` is drawn where it is there. Time is the operator's:
    what happens at the telerobot is drawn `delay_s` [s] earlier, at the hand's motion that caused it (`lags.lags`); by
    default as the recording tells it.

    Raises:
        BadInput: a needed column is missing or broken.
    """
    delay_s = delay_of(recording, delay_s)
    rows = [("plant", flag(recording, "in_contact"), delay_s, BLUE)]
    if "detected_contact" in recording:
        rows.append(("detected", flag(recording, "detected_contact"), delay_s, SKY))
    rows.append(("rendered", np.any(vector(recording, "rendered_force") != 0.0, axis=1), 0.0, RED))
    figure, (bars, late) = panels(2, 3.6, height_ratios=(len(rows), 3))
    time = recording.time
    for row, (_, flags, earlier, color) in enumerate(rows):
        spans = [(time[a] - earlier, time[b] - time[a]) for a, b in stretches(flags)]
        bars.broken_barh(spans, (row - 0.32, 0.64), color=color, linewidth=0)
    bars.set_yticks(range(len(rows)), [name for name, *_ in rows])
    bars.set_ylim(len(rows) - 0.5, -0.5)
    bars.grid(axis="y", visible=False)
    bars.set_title("Contact and lags")
    touch, release = lags(recording, delay_s)
    _lag_marks(late, "touch", touch, delay_s, "v", GREEN)
    _lag_marks(late, "release", release, delay_s, "^", ORANGE)
    late.set(xlabel="operator's time [s]", ylabel="lag [ms]")
    late.set_xlim(time[0] - delay_s, time[-1])
    late.margins(y=0.25)
    late.axhline(0.0, color=BLACK, linewidth=0.8)  # so that the scale shows how late, not how much lags scatter
    if late.get_legend_handles_labels()[0]:
        legend_above(bars, of=late)
    else:
        late.text(0.5, 0.5, "no answered touch or release", transform=late.transAxes, ha="center", color=GREY)
    return figure


def _lag_marks(panel: Axes, name: str, found: Lags, delay_s: float, marker: str, color: str) -> None:
    answered = [
        (event - delay_s, 1e3 * lag) for event, lag in zip(found.events_s, found.lags_s, strict=True) if lag is not None
    ]
    if answered and found.median_s is not None:
        label = f"{name}, median {milliseconds(found.median_s)}"
        panel.plot(*zip(*answered, strict=True), linestyle="", marker=marker, markersize=5, color=color, label=label)


@styled
def parameters(recording: Recording, *, truth: Mapping[str, float] | None = None) -> Figure:
    """Every estimated parameter over time, in one small panel each, with its true value where that is known.

    A panel's scale is that of the second half of the recording, since the first estimates may be larger by orders of
    magnitude. Stretches of stable theta are shaded.

    Args:
        recording: needs `theta_*` and `theta_stable`.
        truth: symbol (m, k1, k2, b1, b2, Fc, normal_k, normal_b) -> true value, SI units.

    Raises:
        BadInput: no `theta_*` columns, none for a name in `truth`, or no `theta_stable`.
    """
    names = [name for name in THETA if f"theta_{name}" in recording]
    if not names:
        raise BadInput(recording.source, found=f"columns {', '.join(recording.columns)}", expected="columns theta_*")
    truth = truth or {}
    for name in truth:
        if name not in names:
            raise BadInput("truth", at=name, found="a parameter not recorded", expected=f"one of {', '.join(names)}")
    stable = flag(recording, "theta_stable")
    rows = (len(names) + 1) // 2
    figure, grid = panels(rows, 0.8 + 1.15 * rows, columns=2)
    for panel in grid[len(names) :]:
        panel.set_axis_off()
    for panel, name in zip(grid, names, strict=False):
        values = recording[f"theta_{name}"]
        line(panel, recording.time, values, "estimated", color=BLUE)
        if name in truth:
            panel.axhline(truth[name], color=BLACK, linestyle="--", linewidth=1.0, label="true")
        panel.set_ylabel(f"{name} [{THETA_UNITS[name]}]")
        _scale(panel, values[len(values) // 2 :], truth.get(name))
    shade(grid[: len(names)], recording.time, stable)
    grid[0].set_title("Parameters over time")
    grid[0].set_xlim(recording.time[0], recording.time[-1])
    if truth:
        legend_above(grid[1])
    for panel in grid[-2:]:
        panel.set_xlabel("time [s]")
    return figure


def _scale(panel: Axes, values: Array, true: float | None) -> None:
    """The 1st to 99th percentile and the true value, with a margin."""
    known = values[np.isfinite(values)]
    ends = [*np.percentile(known, (1, 99))] if known.size else []
    ends += [] if true is None else [true]
    if ends:
        low, high = min(ends), max(ends)
        margin = max(0.3 * (high - low), 0.02 * max(abs(low), abs(high))) or 1.0
        panel.set_ylim(low - margin, high + margin)


@styled
def energy(recording: Recording) -> Figure:
    """Energy taken in at the operator's and at the telerobot's port over time (`passivity.passivity`).

    Raises:
        BadInput: a column is missing or broken.
    """
    found = passivity(recording)
    figure, (panel,) = panels(1, 3.0)
    line(panel, recording.time, found.operator.absorbed, "from the hand", color=RED)
    line(panel, recording.time, found.telerobot.absorbed, "into the environment", color=BLUE)
    line(panel, recording.time, found.between, "difference", color=PURPLE, linewidth=0.8)
    panel.axhline(0.0, color=BLACK, linewidth=0.8)
    if not found.operator.passive:
        panel.plot(
            found.operator.minimum_at, found.operator.minimum, "o", color=RED, markersize=5, label="worst, not passive"
        )
    panel.set(xlabel="time [s]", ylabel="energy [J]", title="Energy")
    panel.set_xlim(recording.time[0], recording.time[-1])
    if "in_contact" in recording:
        shade([panel], recording.time, flag(recording, "in_contact"))
    legend_above(panel)
    return figure


@styled
def error_bars(cases: Mapping[str, ForceError], *, title: str = "Error of the rendered force") -> Figure:
    """Tangential error by band, one group of bars per band and one bar per case, in percent on a logarithmic axis.

    Raises:
        BadInput: no case.
    """
    if not cases:
        raise BadInput("cases", found="none", expected="at least one")
    figure, (panel,) = panels(1, 3.6)
    width = 0.8 / len(cases)
    drawn: list[float] = []
    for number, (case, error) in enumerate(cases.items()):
        at = np.arange(len(BANDS)) + (number - (len(cases) - 1) / 2) * width
        heights = [np.nan if ratio is None else 100.0 * ratio for ratio in (error.tangential[band] for band in BANDS)]
        drawn += [height for height in heights if height > 0.0]
        bars = panel.bar(at, heights, 0.92 * width, label=case)
        if len(cases) <= 5:
            labels = ["" if np.isnan(height) else significant(height, 2) for height in heights]
            panel.bar_label(bars, labels, fontsize=7.5, padding=1)
    panel.set_yscale("log")
    panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    panel.yaxis.set_major_formatter("{x:g}")
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.set_xticks(range(len(BANDS)), [BAND_NAMES[band] for band in BANDS])
    panel.grid(axis="x", visible=False)
    panel.set_ylabel("RMS error / RMS force [%]")
    panel.set_title(title)
    if drawn:
        low, high = 10.0 ** math.floor(math.log10(0.9 * min(drawn))), max(drawn)
        room = 0.12 + 0.12 * math.ceil(len(cases) / 4)  # above the bars, for the rows of the legend
        panel.set_ylim(low, high * (high / low) ** room)
    panel.legend(loc="upper right", ncols=4, columnspacing=1.2)
    return figure
