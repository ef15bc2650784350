"""The thesis's figures, drawn from a recording. `THESIS_FIGURES` maps each number to its function.

Every one takes the same arguments. `delay_s` [s], by default as the recording tells it, shifts the rendered force to
later times, so that cause and effect stand at the same place, as in the thesis's figures 14 and 35. `window_s` =
(from, to) [s] cuts the time axis; by default a figure shows the whole run, or picks its own window where it says so.
`axis` is the tangential axis. Shaded stretches are those in which the plant is in contact. All raise BadInput where a
column they draw is missing.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import (
    BLUE,
    ERROR,
    ESTIMATED,
    GREY,
    MEASURED,
    RENDERED,
    legend_above,
    line,
    panels,
    shade,
    styled,
)
from mmt_drake.analysis.signals import (
    BANDS,
    amplitude_spectrum,
    column,
    delay_of,
    delayed,
    flag,
    mean_step,
    on_even_clock,
)
from mmt_drake.analysis.windows import Window, dominant_window, frozen_since, wound_up
from mmt_drake.analysis.wording import milliseconds
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording

LOW_WINDOW_S: Final = 8.0
HIGH_WINDOW_S: Final = 3.0
SPECTRUM_TO_HZ: Final = 30.0


class FigureOf(Protocol):
    """The signature of every function of `THESIS_FIGURES`."""

    def __call__(
        self, recording: Recording, *, delay_s: float | None = None, window_s: Window | None = None, axis: str = "y"
    ) -> Figure: ...


@dataclass(frozen=True)
class ShownRun:
    """The part of a recording that is to be seen: the arguments of every figure."""

    recording: Recording
    delay_s: float
    window_s: Window | None
    axis: str

    def shown(self) -> Recording:
        """The recording on an even clock, the rendered force shifted by the delay, cut to the window."""
        even = on_even_clock(self.recording)
        if self.delay_s > 0.0:
            step = mean_step(even)
            rendered = {name: values for name, values in even.columns.items() if name.startswith("rendered_")}
            late = {name: delayed(values, self.delay_s, step) for name, values in rendered.items()}
            even = replace(even, columns={**even.columns, **late})
        if self.window_s is None:
            return even
        inside = (even.time >= self.window_s[0]) & (even.time <= self.window_s[1])
        if np.count_nonzero(inside) < 2:
            span = f"{even.time[0]:g} to {even.time[-1]:g} s"
            raise BadInput("window_s", found=self.window_s, expected=f"a part of {even.source}, {span}")
        return replace(even, time=even.time[inside], columns={name: x[inside] for name, x in even.columns.items()})

    def by_default(self, window_s: Callable[[], Window]) -> "ShownRun":
        """The same with a window, if none was asked for."""
        return self if self.window_s else replace(self, window_s=window_s())


_FIGURES: dict[int, FigureOf] = {}
THESIS_FIGURES: Final[Mapping[int, FigureOf]] = MappingProxyType(_FIGURES)


def _thesis(*numbers: int) -> Callable[[Callable[[ShownRun], Figure]], FigureOf]:
    """Make a function of recording, delay, window and axis of one that draws a view: these figures of the thesis."""

    def declared(draw: Callable[[ShownRun], Figure]) -> FigureOf:
        def drawn(
            recording: Recording, *, delay_s: float | None = None, window_s: Window | None = None, axis: str = "y"
        ) -> Figure:
            return draw(ShownRun(recording, delay_of(recording, delay_s), window_s, axis))

        drawn.__name__, drawn.__doc__ = draw.__name__, draw.__doc__
        figure = styled(drawn)
        _FIGURES.update(dict.fromkeys(numbers, figure))
        return figure

    return declared


@_thesis(8)
def input_position(view: ShownRun) -> Figure:
    """The hand's position, tangential and normal to the table (thesis figure 8). Needs `master_position_*`."""
    shown = view.shown()
    figure, axes = panels(2, 4.0)
    for panel, name in zip(axes, (view.axis, "z"), strict=True):
        line(panel, shown.time, 1e3 * column(shown, f"master_position_{name}"), name, color=BLUE)
        panel.set_ylabel(f"{name} [mm]")
    axes[0].set_title("Input position")
    return _finished(figure, axes, shown)


@_thesis(9, 14)
def measured_and_rendered(view: ShownRun) -> Figure:
    """Measured and rendered force and their difference (thesis figure 9; with a delay, 14)."""
    return _compared(view, "Measured and rendered force")


@_thesis(10)
def estimated_and_rendered(view: ShownRun) -> Figure:
    """The estimator's psi' theta and the rendered force (thesis figure 10)."""
    return _forces(view, ("estimated_force", "rendered_force"))


@_thesis(11)
def estimated_and_rendered_frozen(view: ShownRun) -> Figure:
    """The same for a run whose parameters were frozen, with the instant marked (thesis figure 11).

    Raises:
        BadInput: theta does not stand still in the second half of the recording.
    """
    return _forces(view, ("estimated_force", "rendered_force"), frozen=True)


@_thesis(24, 35)
def whole_run(view: ShownRun) -> Figure:
    """Position, measured and rendered force, tangential and normal (thesis figure 24; with a delay, 35).

    Needs `position_*`, `force_*`, `rendered_force_*`.
    """
    shown = view.shown()
    figure, axes = panels(4, 7.0)
    for name, (where, force) in zip((view.axis, "z"), (axes[:2], axes[2:]), strict=True):
        line(where, shown.time, 1e3 * column(shown, f"position_{name}"), name, color=BLUE)
        where.set_ylabel(f"probe {name} [mm]")
        _draw(force, shown, name, ("force", "rendered_force"), view.delay_s)
    axes[0].set_title("Position, measured and rendered force")
    legend_above(axes[0], of=axes[1])
    return _finished(figure, axes, shown)


@_thesis(25)
def low_frequencies(view: ShownRun) -> Figure:
    """Measured and rendered force where low frequencies dominate (thesis figure 25).

    By default the window of 8 s found by `dominant_window` for the band below 0.3 Hz.
    """
    view = view.by_default(lambda: dominant_window(view.recording, "below_0.3_hz", LOW_WINDOW_S, view.axis))
    return _compared(view, "Where low frequencies dominate")


@_thesis(26)
def high_frequencies(view: ShownRun) -> Figure:
    """Measured and rendered force where high frequencies dominate (thesis figure 26).

    By default the window of 3 s found by `dominant_window` for the band from 3 to 10 Hz.
    """
    view = view.by_default(lambda: dominant_window(view.recording, "3_to_10_hz", HIGH_WINDOW_S, view.axis))
    return _compared(view, "Where high frequencies dominate")


@_thesis(27)
def error_spectrum(view: ShownRun) -> Figure:
    """Amplitude spectrum of rendered less measured force, beside that of the measured force (thesis figure 27).

    By default from 5 s of accumulated contact to the end, releases included; `signals.amplitude_spectrum` says how.
    """
    shown = view.by_default(lambda: wound_up(view.recording)).shown()
    measured = column(shown, f"force_{view.axis}")
    signals = {
        "measured force": (measured, GREY),
        "rendered less measured": (column(shown, f"rendered_force_{view.axis}") - measured, ERROR),
    }
    return _spectra(shown, signals, view.axis, "Spectrum of the error")


@_thesis(28)
def force_spectrum(view: ShownRun) -> Figure:
    """Amplitude spectrum of the measured and of the rendered force (thesis figure 28), over the same samples as 27."""
    shown = view.by_default(lambda: wound_up(view.recording)).shown()
    signals = {
        "rendered force": (column(shown, f"rendered_force_{view.axis}"), RENDERED),
        "measured force": (column(shown, f"force_{view.axis}"), MEASURED),
    }
    return _spectra(shown, signals, view.axis, "Spectrum of the force")


@_thesis(29)
def estimator_error(view: ShownRun) -> Figure:
    """The measured force as the estimator sees it, its psi' theta, and their difference (thesis figure 29)."""
    return _compared(view, "Force at the estimator", ("filtered_force", "estimated_force"))


@_thesis(30)
def estimated_rendered_and_measured(view: ShownRun) -> Figure:
    """Measured, rendered and estimated force (thesis figure 30)."""
    return _forces(view, ("force", "rendered_force", "estimated_force"))


@_thesis(31)
def estimated_rendered_and_measured_frozen(view: ShownRun) -> Figure:
    """The same for a run whose parameters were frozen, with the instant marked (thesis figure 31).

    Raises:
        BadInput: theta does not stand still in the second half of the recording.
    """
    return _forces(view, ("force", "rendered_force", "estimated_force"), frozen=True)


# the measured force is drawn broad, so that it shows on both sides of what copies it
_LOOKS: Final[Mapping[str, tuple[str, dict[str, Any]]]] = {
    "force": ("measured", {"color": MEASURED, "linewidth": 1.7}),
    "filtered_force": ("measured, filtered", {"color": MEASURED, "linewidth": 1.7}),
    "rendered_force": ("rendered", {"color": RENDERED, "linewidth": 0.9}),
    "estimated_force": ("estimated", {"color": ESTIMATED, "linewidth": 0.9}),
}


def _draw(panel: Axes, shown: Recording, axis: str, names: tuple[str, ...], delay_s: float) -> None:
    for name in names:
        label, look = _LOOKS[name]
        if name == "rendered_force" and delay_s > 0.0:
            label += f", {milliseconds(delay_s)} later"
        line(panel, shown.time, column(shown, f"{name}_{axis}"), label, **look)
    panel.set_ylabel(f"force {axis} [N]")


def _compared(view: ShownRun, title: str, pair: tuple[str, str] = ("force", "rendered_force")) -> Figure:
    """A reference and its copy in one panel, the copy's error in another at the same scale."""
    shown = view.shown()
    figure, (forces, error) = panels(2, 4.4, height_ratios=(2, 1))
    _draw(forces, shown, view.axis, pair, view.delay_s)
    difference = column(shown, f"{pair[1]}_{view.axis}") - column(shown, f"{pair[0]}_{view.axis}")
    line(error, shown.time, difference, "difference", color=ERROR)
    forces.set_title(title)
    error.set_ylabel("difference [N]")
    legend_above(forces)
    return _finished(figure, [forces, error], shown)


def _forces(view: ShownRun, names: tuple[str, ...], frozen: bool = False) -> Figure:
    """Several forces in one panel; `frozen` demands and marks parameters that stand still."""
    since = frozen_since(view.recording) if frozen else None
    shown = view.shown()
    figure, (panel,) = panels(1, 3.2)
    _draw(panel, shown, view.axis, names, view.delay_s)
    panel.set_title("Estimated and rendered force" if since is None else f"Parameters frozen at {since:.2f} s")
    if since is not None and shown.time[0] <= since <= shown.time[-1]:
        panel.axvline(since, color=GREY, linestyle="--")
    legend_above(panel)
    return _finished(figure, [panel], shown)


def _spectra(shown: Recording, signals: Mapping[str, tuple[Array, str]], axis: str, title: str) -> Figure:
    """Amplitude spectra on logarithmic axes, the edges of the bands marked."""
    rate = 1.0 / mean_step(shown)
    figure, (panel,) = panels(1, 3.6)
    for label, (values, color) in signals.items():
        frequency, amplitude = amplitude_spectrum(values, rate)
        shown_part = frequency <= SPECTRUM_TO_HZ
        panel.loglog(frequency[shown_part], amplitude[shown_part], label=label, color=color)
    for edge in sorted({edge for band in BANDS.values() if band for edge in band if edge > 0.0}):
        panel.axvline(edge, color=GREY, linewidth=0.8, linestyle=":")
    panel.set(xlabel="frequency [Hz]", ylabel=f"amplitude, {axis} [N]", title=title)
    panel.margins(x=0.0)
    panel.xaxis.set_major_formatter("{x:g}")
    legend_above(panel)
    return figure


def _finished(figure: Figure, axes: list[Axes], shown: Recording) -> Figure:
    """Contact shaded, the time axis named and cut to what is shown."""
    if "in_contact" in shown:
        shade(axes, shown.time, flag(shown, "in_contact"))
    axes[-1].set_xlabel("time [s]")
    axes[-1].set_xlim(shown.time[0], shown.time[-1])
    return figure
