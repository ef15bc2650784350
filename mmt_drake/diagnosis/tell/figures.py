"""A diagnosis in pictures, one function each: evidence in, a matplotlib Figure out, no pyplot.

Colours are the same everywhere: measured black, the nominal model orange, refitted blue, augmented green, noise grey.
"""

import math

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import GREY, legend_above, line, panels, styled
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.figures_common import (
    COLORS,
    DASHES,
    MEASURED,
    NOISE,
    axis_label,
    binned,
    cloud,
    grid,
    legend_below,
    scale,
    shade_heldout,
)
from mmt_drake.numeric.arrays import Array

Window = tuple[float, float]

ENLARGED_BELOW = 0.3
"""Of the largest error; a smaller one is shown to its own scale too."""


@styled
def overview(evidence: Evidence) -> Figure:
    """The output as measured and as the best model has it, and below what each model leaves, to one scale.

    What the best one leaves comes once more, enlarged, if it is small beside the others. Errors are drawn where samples
    count; the grey band is two standard deviations of the noise to either side. Held-out blocks are shaded.
    """
    errors = {name: np.where(evidence.counted, values, np.nan) for name, values in evidence.residuals.items()}
    best = next(reversed(errors), None)
    sizes = {name: np.nanmax(np.abs(values), initial=0.0) for name, values in errors.items()}
    rows = [*errors.items()]
    if best and sizes[best] < ENLARGED_BELOW * max(sizes.values()):
        rows.append((best, errors[best]))
    ratios = (1.6, *(1.0,) * len(rows))
    figure, drawn = panels(len(ratios), 0.9 + 0.85 * sum(ratios), height_ratios=ratios)
    top, below = drawn[0], drawn[1:]
    line(top, evidence.time, evidence.measured.values, "measured", color=MEASURED, linewidth=2.0, alpha=0.6)
    if best:
        line(top, evidence.time, evidence.models[best], best, color=COLORS[best], linewidth=0.9)
    top.set_ylabel(axis_label(evidence.measured))
    top.set_title(evidence.label)
    legend_above(top)
    for number, (panel, (name, values)) in enumerate(zip(below, rows, strict=True)):
        enlarged = number == len(errors)
        line(panel, evidence.time, values, name, color=COLORS[name], linewidth=0.8)
        scale(panel, *([values] if enlarged else errors.values()))
        if evidence.noise is not None:
            panel.axhspan(-2.0 * evidence.noise, 2.0 * evidence.noise, color=NOISE, alpha=0.4, linewidth=0, zorder=1.5)
            for edge in (-2.0 * evidence.noise, 2.0 * evidence.noise) if enlarged else ():
                panel.axhline(edge, color=MEASURED, linewidth=0.9, linestyle=(0, (4, 2)))
        panel.set_ylabel(axis_label(evidence.measured, "error"))
        note = f"{name}, enlarged" if enlarged else f"{name}: RMS {_rms(evidence, values)}"
        panel.set_title(note, loc="right", fontsize=8.5, fontweight="normal", pad=2.0)
    drawn[-1].set_xlabel("time [s]")
    top.set_xlim(evidence.time[0], evidence.time[-1])
    shade_heldout(drawn, evidence)
    return figure


def _rms(evidence: Evidence, error: Array) -> str:
    """Of the error over held-out samples, or over all that count where nothing was held out."""
    known = np.isfinite(error)
    chosen = known & evidence.heldout if np.any(known & evidence.heldout) else known
    value = math.sqrt(float(np.mean(error[chosen] ** 2))) if np.any(chosen) else 0.0
    return f"{significant(value, 3)} {evidence.measured.unit}{' held out' if evidence.heldout_s else ''}"


def worst_windows(evidence: Evidence, count: int = 3, length_s: float = 2.0) -> list[Window]:
    """The windows (from, to) [s] in which the model without new effects is furthest off, worst first.

    It is the refitted model where there is one, else the nominal. Samples that count add their squared error. Windows
    do not overlap, and lie in held-out blocks where any is long enough; there are fewer than `count` where nothing
    else has an error to show.
    """
    residuals = evidence.residuals
    if not residuals:
        return []
    error = residuals["refit"] if "refit" in residuals else next(iter(residuals.values()))
    energy = np.concatenate([[0.0], np.cumsum(np.where(evidence.counted, error**2, 0.0))])
    fitted = np.concatenate([[0], np.cumsum(~evidence.heldout)])
    ends = np.searchsorted(evidence.time, evidence.time + length_s)
    score = np.where(ends < len(evidence.time), energy[ends] - energy[:-1], 0.0)
    untouched = (fitted[ends] == fitted[:-1]) & (score > 0.0)
    score = np.where(untouched, score, 0.0) if np.any(untouched) else score
    found: list[Window] = []
    while len(found) < count and np.any(score > 0.0):
        start = float(evidence.time[int(np.argmax(score))])
        found.append((start, start + length_s))
        score[np.abs(evidence.time - start) < length_s] = 0.0
    return found


@styled
def zooms(evidence: Evidence) -> Figure | None:
    """Measured output and every model over the worst windows (`worst_windows`), each below the other.

    None where no model was run, or none is ever off.
    """
    windows = worst_windows(evidence)
    if not windows:
        return None
    figure, drawn = grid(len(windows), 1, 0.5 + 1.65 * len(windows))
    for panel, (start, end) in zip(drawn, sorted(windows), strict=True):
        shown = (evidence.time >= start) & (evidence.time <= end)
        time = evidence.time[shown]
        panel.plot(time, evidence.measured.values[shown], color=MEASURED, linewidth=3.2, alpha=0.45, label="measured")
        for name, output in evidence.models.items():
            panel.plot(time, output[shown], color=COLORS[name], linestyle=DASHES[name], linewidth=1.3, label=name)
        panel.set_xlim(start, end)
        panel.set_ylabel(axis_label(evidence.measured))
    drawn[0].set_title(f"{evidence.label}: where it is furthest off")
    drawn[-1].set_xlabel("time [s]")
    shade_heldout(drawn, evidence)
    legend_below(figure, drawn[:1], heldout=bool(evidence.heldout_s))
    return figure


@styled
def residual_over_states(evidence: Evidence) -> Figure | None:
    """The error against every state: points before the effects, medians with their 10 to 90 % spread before and after.

    None where there are no states, or no model was run.
    """
    residuals = {name: values[evidence.counted] for name, values in evidence.residuals.items()}
    if not evidence.states or not residuals:
        return None
    if len(residuals) == 3:
        del residuals["nominal"]  # the fit has removed what is only a wrong value
    columns = min(2, len(evidence.states))
    rows = math.ceil(len(evidence.states) / columns)
    figure, drawn = grid(rows, columns, 0.4 + 1.9 * rows, share_y=True)
    for panel in drawn[len(evidence.states) :]:
        panel.set_visible(False)
    before = next(iter(residuals))
    for number, (panel, state) in enumerate(zip(drawn, evidence.states.values(), strict=False)):
        over = state.values[evidence.counted]
        cloud(panel, over, residuals[before], f"{before}, samples", GREY)
        for name, values in residuals.items():
            centre, low, median, high = binned(over, values)
            panel.fill_between(centre, low, high, color=COLORS[name], alpha=0.25, linewidth=0)
            panel.plot(centre, median, color=COLORS[name], linestyle=DASHES[name], label=f"{name}, median")
        panel.set_xlabel(axis_label(state))
        if number % columns == 0:
            panel.set_ylabel(axis_label(evidence.measured, "error"))
    drawn[0].set_title(f"{evidence.label}: error over the states")
    scale(drawn[0], residuals[before])
    legend_below(figure, drawn[:1])
    return figure


@styled
def curves(evidence: Evidence) -> Figure | None:
    """Restoring force over deflection and friction over sliding velocity: data, model before, model after.

    None where neither was computed.
    """
    named = {"restoring force": evidence.restoring, "friction": evidence.friction}
    known = {title: found for title, found in named.items() if found is not None}
    if not known:
        return None
    figure, drawn = grid(1, len(known), 3.1)
    for panel, (title, found) in zip(drawn, known.items(), strict=True):
        over = found.over.values
        cloud(panel, over, found.force.values, "data", MEASURED, alpha=0.25)
        for name, values in found.models.items():
            cloud(panel, over, values, name, COLORS[name], alpha=0.6)
        panel.set(xlabel=axis_label(found.over), ylabel=axis_label(found.force), title=f"{evidence.label}: {title}")
        scale(panel, found.force.values, *found.models.values())
    legend_below(figure, drawn)
    return figure


@styled
def spectra(evidence: Evidence, band_hz: Window | None = None) -> Figure | None:
    """Power spectral density of each model's error and of the sensor's noise; None where none was computed.

    Args:
        evidence: with a spectrum.
        band_hz: shaded, the band in which the mismatch lies.
    """
    found = evidence.spectrum
    if found is None:
        return None
    figure, (panel,) = grid(1, 1, 3.0)
    bins = _octave_bins(found.frequency)
    frequency = _averaged(found.frequency, bins)
    if band_hz is not None:
        panel.axvspan(max(band_hz[0], frequency[0]), band_hz[1], color="#F3EEDC", linewidth=0, label="mismatch")
    for name, density in found.residuals.items():
        panel.plot(frequency, _averaged(density, bins), color=COLORS[name], linestyle=DASHES[name], label=name)
    if found.noise is not None:
        panel.plot(frequency, _averaged(found.noise, bins), color=NOISE, linewidth=2.0, alpha=0.8, label="sensor noise")
    panel.set(xscale="log", yscale="log", xlabel="frequency [Hz]", xlim=(frequency[0], frequency[-1]))
    panel.set_ylabel(f"error density [{evidence.measured.unit}²/Hz]")
    panel.xaxis.set_major_formatter("{x:g}")
    panel.set_title(f"{evidence.label}: spectrum of the error")
    legend_below(figure, [panel])
    return figure


def _octave_bins(frequency: Array, per_octave: int = 12) -> Array:
    """The bin that each frequency falls into, (m,), from 0 on without gaps; NaN for those not above 0."""
    bins = np.full(len(frequency), np.nan)
    positive = frequency > 0.0
    bins[positive] = np.unique(np.floor(per_octave * np.log2(frequency[positive])), return_inverse=True)[1]
    return bins


def _averaged(values: Array, bins: Array) -> Array:
    """The mean of each bin: what a line over a logarithmic axis can show of a density."""
    known = np.isfinite(bins)
    index = bins[known].astype(np.intp)
    averaged: Array = np.bincount(index, values[known]) / np.bincount(index)
    return averaged
