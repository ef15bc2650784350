"""A diagnosis's recordings in figures to look into, one function each: evidence in, plots of a page out.

Colours are the same everywhere: measured black, the model handed in orange, refitted blue, with what was found green,
noise grey. Measured samples are points, what was simulated is a line.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
import plotly.graph_objects as go

from mmt_drake.analysis.interactive import Plot, cloud, curve, points, rows, shade
from mmt_drake.diagnosis.tell.evidence import Curve, Evidence, worst_windows
from mmt_drake.diagnosis.tell.figures_common import (
    COLORS,
    DASHES,
    HELDOUT,
    MEASURED,
    NAMES,
    NOISE,
    axis_label,
    binned,
    limits,
)
from mmt_drake.diagnosis.tell.result import EffectParameter, NamedEffect
from mmt_drake.effects.wording import words
from mmt_drake.numeric.arrays import Array, Flags

HELD_OUT = "held out from the fit"
_PER_OCTAVE = 12  # bins of a spectrum


def over_time(evidence: Evidence) -> Plot:
    """The output as measured and by every model, and below what the models leave, where samples count.

    What the best model leaves has a panel to its own scale, with two standard deviations of the noise to either side.
    """
    errors = evidence.errors
    best = next(reversed(errors), None)
    before = {name: values for name, values in errors.items() if name != best}
    panels = [300, *([150] if before else []), *([150] if best else [])]
    figure = rows(panels)
    every, last = np.ones(len(evidence.time), dtype=bool), len(panels)
    _measured(figure, evidence, 1, every)
    for name, output in evidence.models.items():
        _model(figure, evidence, output, name, 1, every)
    for name, values in before.items():
        _model(figure, evidence, values, name, 2, every, showlegend=False)
    if best:
        _model(figure, evidence, errors[best], best, last, every, showlegend=False)
        if evidence.noise is not None:
            low, high = -2.0 * evidence.noise, 2.0 * evidence.noise
            figure.add_hrect(y0=low, y1=high, fillcolor=NOISE, opacity=0.35, line_width=0, row=last, col=1)
    for row in range(1, last + 1):
        _shade_heldout(figure, evidence, row)
        label = axis_label(evidence.measured, None if row == 1 else "error")
        figure.update_yaxes(title_text=label, row=row, col=1)
    figure.update_xaxes(range=[float(evidence.time[0]), float(evidence.time[-1])])
    figure.update_xaxes(title_text="time [s]", row=last, col=1)
    return Plot(figure, _said_over_time(evidence), evidence.label)


def _said_over_time(evidence: Evidence) -> str:
    if not evidence.models:
        return "The recording as it is."
    best = NAMES[list(evidence.models)[-1]]
    said = [f"Top: measured samples as points, models as lines. Lowest panel: what the model {best} leaves, enlarged."]
    if evidence.noise is not None:
        said.append("Grey: two standard deviations of the noise; 95 % of a right model's error lie within.")
    if evidence.heldout_s:
        said.append("Shaded blue: held out from the fit.")
    said.append("Drag to zoom, double-click to go back; a click in the legend hides a curve.")
    return " ".join(said)


def closer(evidence: Evidence) -> list[Plot]:
    """Measured output and every model over the worst windows (`worst_windows`), each below the other.

    Empty where no model was run, or none is ever off.
    """
    windows = sorted(worst_windows(evidence))
    if not windows:
        return []
    figure = rows([210] * len(windows), shared=False)
    for row, (start, end) in enumerate(windows, 1):
        shown = (evidence.time >= start) & (evidence.time <= end)
        _measured(figure, evidence, row, shown, showlegend=row == 1)
        for name, output in evidence.models.items():
            _model(figure, evidence, output, name, row, shown, showlegend=row == 1)
        figure.update_xaxes(range=[start, end], row=row, col=1)
        figure.update_yaxes(title_text=axis_label(evidence.measured), row=row, col=1)
    figure.update_xaxes(title_text="time [s]", row=len(windows), col=1)
    figure.update_traces(selector={"mode": "markers"}, marker={"size": 5, "opacity": 0.6})
    told = NAMES["refit" if "refit" in evidence.models else next(iter(evidence.models))]
    said = f"Where the model {told} is furthest off, two seconds each, at full resolution, in order of time."
    return [Plot(figure, said, f"{evidence.label}: where it is furthest off")]


def error_over_states(evidence: Evidence) -> list[Plot]:
    """The error against every state: samples before the effects, medians and their 10 to 90 % spread before and after.

    Empty where there are no states, or no model was run.
    """
    residuals = {name: values[evidence.counted] for name, values in evidence.residuals.items()}
    if not evidence.states or not residuals:
        return []
    if len(residuals) == 3:
        del residuals["nominal"]  # the fit has removed what is only a wrong value
    before, found = next(iter(residuals)), []
    for state in evidence.states.values():
        figure, over = rows([240]), state.values[evidence.counted]
        hover = _hover(state.unit, evidence.measured.unit)
        cloud(figure, over, residuals[before], f"samples, {NAMES[before]}", NOISE, hovertemplate=hover)
        for name, values in residuals.items():
            centre, low, median, high = binned(over, values)
            color = COLORS[name]
            _area(figure, centre, (high, low), name, color, legend=False)
            line = {"color": color, "width": 2.0, "dash": DASHES[name]}
            curve(figure, centre, median, f"median, {NAMES[name]}", color, line=line, hovertemplate=hover)
        figure.update_xaxes(title_text=axis_label(state))
        figure.update_yaxes(title_text=axis_label(evidence.measured, "error"), range=limits(residuals[before]))
        figure.update_layout(height=figure.layout.height + 16, margin_t=52)
        title = f"{evidence.label}: error over {state.label}"
        found.append(Plot(figure, "", title, half=True))
    return found


def forces(evidence: Evidence) -> list[Plot]:
    """Restoring force over deflection and friction over sliding velocity: data, model before, model after."""
    named = {"restoring force": evidence.restoring, "friction": evidence.friction}
    return [_force(evidence, title, found) for title, found in named.items() if found is not None]


def _force(evidence: Evidence, title: str, found: Curve) -> Plot:
    figure, over = rows([300]), found.over.values
    hover = _hover(found.over.unit, found.force.unit)
    cloud(figure, over, found.force.values, "read off the recording", MEASURED, hovertemplate=hover)
    for name, values in found.models.items():
        cloud(figure, over, values, NAMES[name], COLORS[name], hovertemplate=hover)
    figure.update_traces(selector={"name": "read off the recording"}, marker={"opacity": 0.35, "size": 7})
    figure.update_layout(height=figure.layout.height + 16, margin_t=52)
    figure.update_xaxes(title_text=axis_label(found.over))
    figure.update_yaxes(title_text=axis_label(found.force), range=limits(found.force.values, *found.models.values()))
    return Plot(figure, "", f"{evidence.label}: {title}", half=True)


def spectrum(evidence: Evidence, band_hz: tuple[float, float] | None = None) -> list[Plot]:
    """Power spectral density of each model's error and of the sensor's noise; empty where none was computed.

    Args:
        evidence: with a spectrum.
        band_hz: shaded, the band in which the mismatch lies.
    """
    found = evidence.spectrum
    if found is None:
        return []
    figure, unit = rows([300]), f"{evidence.measured.unit}²/Hz"
    bins = _octave_bins(found.frequency)
    frequency, hover = _averaged(found.frequency, bins), _hover("Hz", unit)
    if band_hz is not None:
        shade(figure, [(max(band_hz[0], frequency[0]), band_hz[1])], "#F3EEDC", "band of the mismatch")
    for name, density in found.residuals.items():
        line = {"color": COLORS[name], "width": 1.8, "dash": DASHES[name]}
        curve(figure, frequency, _averaged(density, bins), NAMES[name], COLORS[name], line=line, hovertemplate=hover)
    if found.noise is not None:
        line = {"color": NOISE, "width": 3.0}
        curve(figure, frequency, _averaged(found.noise, bins), "noise", NOISE, line=line, hovertemplate=hover)
    ends = [float(np.log10(frequency[0])), float(np.log10(frequency[-1]))]
    figure.update_xaxes(type="log", title_text="frequency [Hz]", range=ends, dtick=1)
    figure.update_yaxes(type="log", title_text=f"error density [{unit}]", exponentformat="power", dtick=1)
    said = (
        "Where a model's line lies on the grey one, only noise is left; where it lies above, the model is wrong there."
    )
    return [Plot(figure, said, f"{evidence.label}: spectrum of the error")]


def learned_law(effect: NamedEffect) -> list[Plot]:
    """The table of a `tabulated_force` over its signal, with its 95 % interval; empty where it holds no table."""
    of, at, value = (effect.parameters.get(symbol, EffectParameter("", "")) for symbol in ("of", "at", "value"))
    if not (isinstance(at.value, tuple) and isinstance(value.value, tuple)):
        return []
    figure, color, over = rows([260]), COLORS["augmented"], np.asarray(at.value)
    if value.ci95 is not None:
        _area(figure, over, map(np.asarray, value.ci95), "95 % interval", color, legend=True)
    hover = _hover(at.unit, value.unit)
    curve(figure, over, np.asarray(value.value), "learned", color, mode="lines+markers", hovertemplate=hover)
    figure.update_xaxes(title_text=f"{words(str(of.value))} [{at.unit}]")
    figure.update_yaxes(title_text=f"missing force [{value.unit}]")
    said = "The learned force over the signal that it depends on, with its 95 % interval."
    return [Plot(figure, said, f"What is missing, over {words(str(of.value))}")]


def _measured(figure: go.Figure, evidence: Evidence, row: int, shown: Flags, **style: Any) -> None:
    values, hover = evidence.measured.values[shown], _hover("s", evidence.measured.unit)
    points(figure, evidence.time[shown], values, "measured", MEASURED, row=row, hovertemplate=hover, **style)


def _model(
    figure: go.Figure, evidence: Evidence, values: Array, name: str, row: int, shown: Flags, **style: Any
) -> None:
    style |= {"line": {"color": COLORS[name], "width": 1.2, "dash": DASHES[name]}, "legendgroup": name}
    hover = _hover("s", evidence.measured.unit)
    curve(figure, evidence.time[shown], values[shown], NAMES[name], COLORS[name], row=row, hovertemplate=hover, **style)


def _area(figure: go.Figure, over: Array, edges: Iterable[Array], name: str, color: str, *, legend: bool) -> None:
    """Fill what lies between two curves."""
    style: dict[str, Any] = {"fillcolor": f"{color}40", "line": {"width": 0.0}, "hoverinfo": "skip"}
    one, other = edges
    curve(figure, over, one, name, color, showlegend=False, **style)
    curve(figure, over, other, name, color, showlegend=legend, fill="tonexty", **style)


def _shade_heldout(figure: go.Figure, evidence: Evidence, row: int) -> None:
    shade(figure, evidence.heldout_s, HELDOUT, HELD_OUT, row)
    if row > 1 and evidence.heldout_s:
        figure.data[-1].update(showlegend=False)


def _hover(of: str, unit: str) -> str:
    """What stands beside a value that is pointed at: three digits and units."""
    return f"%{{fullData.name}}<br>%{{x:.4g}} {of}<br>%{{y:.3g}} {unit}<extra></extra>"


def _octave_bins(frequency: Array) -> Array:
    """The bin that each frequency falls into, (m,), from 0 on without gaps; NaN for those not above 0."""
    bins = np.full(len(frequency), np.nan)
    positive = frequency > 0.0
    bins[positive] = np.unique(np.floor(_PER_OCTAVE * np.log2(frequency[positive])), return_inverse=True)[1]
    return bins


def _averaged(values: Array, bins: Array) -> Array:
    """The mean of each bin: what a line over a logarithmic axis can show of a density."""
    known = np.isfinite(bins)
    index = bins[known].astype(np.intp)
    averaged: Array = np.bincount(index, values[known]) / np.bincount(index)
    return averaged
