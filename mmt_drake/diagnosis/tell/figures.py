"""The picture beside a report, for print: a matplotlib Figure of a recording, measured and simulated, no pyplot."""

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.nrmse import rms
from mmt_drake.analysis.plotting import legend_above, line, panels, styled
from mmt_drake.analysis.wording import significant
from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.diagnosis.tell.figures_common import COLORS, HELDOUT, MEASURED, NAMES, NOISE, axis_label, limits
from mmt_drake.numeric.arrays import Array

ENLARGED_BELOW = 0.3
"""Of the largest error; a smaller one is shown to its own scale too."""


@styled
def overview(evidence: Evidence) -> Figure:
    """The output as measured and as the best model has it, and below what each model leaves, to one scale.

    What the best one leaves comes once more, enlarged, if it is small beside the others. Errors are drawn where samples
    count; the grey band is two standard deviations of the noise to either side. Held-out blocks are shaded.
    """
    errors = evidence.errors
    best = next(reversed(errors), None)
    sizes = {name: np.nanmax(np.abs(values), initial=0.0) for name, values in errors.items()}
    rows = [*errors.items()]
    if best and sizes[best] < ENLARGED_BELOW * max(sizes.values()):
        rows.append((best, errors[best]))
    ratios = (1.6, *(1.0,) * len(rows))
    figure, drawn = panels(len(ratios), 0.9 + 0.85 * sum(ratios), height_ratios=ratios)
    top, below = drawn[0], drawn[1:]
    points = {
        "linestyle": "none",
        "marker": ".",
        "markersize": 3.0,
        "markeredgewidth": 0.0,
        "alpha": 0.6,
        "rasterized": True,
    }
    line(top, evidence.time, evidence.measured.values, "measured", color=MEASURED, **points)
    if best:
        line(top, evidence.time, evidence.models[best], NAMES[best], color=COLORS[best], linewidth=0.9)
    top.set_ylabel(axis_label(evidence.measured))
    top.set_title(evidence.label)
    legend_above(top)
    for number, (panel, (name, values)) in enumerate(zip(below, rows, strict=True)):
        enlarged = number == len(errors)
        line(panel, evidence.time, values, NAMES[name], color=COLORS[name], linewidth=0.8)
        panel.set_ylim(limits(*([values] if enlarged else errors.values())))
        if evidence.noise is not None:
            panel.axhspan(-2.0 * evidence.noise, 2.0 * evidence.noise, color=NOISE, alpha=0.4, linewidth=0, zorder=1.5)
            for edge in (-2.0 * evidence.noise, 2.0 * evidence.noise) if enlarged else ():
                panel.axhline(edge, color=MEASURED, linewidth=0.9, linestyle=(0, (4, 2)))
        panel.set_ylabel(axis_label(evidence.measured, "error"))
        note = f"{NAMES[name]}, enlarged" if enlarged else f"{NAMES[name]}: RMS {_rms(evidence, values)}"
        panel.set_title(note, loc="right", fontsize=8.5, fontweight="normal", pad=2.0)
    drawn[-1].set_xlabel("time [s]")
    top.set_xlim(evidence.time[0], evidence.time[-1])
    spans = [(start, end - start) for start, end in evidence.heldout_s]
    for panel in drawn:
        panel.broken_barh(spans, (0, 1), transform=panel.get_xaxis_transform(), color=HELDOUT, linewidth=0, zorder=0)
    return figure


def _rms(evidence: Evidence, error: Array) -> str:
    """Of the error over held-out samples, or over all that count where nothing was held out."""
    known = np.isfinite(error)
    chosen = known & evidence.heldout if np.any(known & evidence.heldout) else known
    return f"{significant(rms(error[chosen]), 3)} {evidence.measured.unit}{' held out' if evidence.heldout_s else ''}"
