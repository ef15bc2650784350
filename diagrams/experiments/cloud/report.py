"""The experiment's table, figure and page."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import panels, styled
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.experiments.cloud.findings import cloud_findings, filter_name, middle
from mmt_drake.diagrams.experiments.cloud.run import Case, Result, cases_of
from mmt_drake.diagrams.studies.study import Report

_HEADERS = (
    "noise",
    "voxel [mm]",
    "alpha",
    "points",
    "roughness [mm]",
    "height error [mm]",
    "missed",
    "false",
    "breaks",
    "wrong [%]",
    "touch lag [ms]",
    "spread [ms]",
    "release lag [ms]",
    "touch height [mm]",
    "spread [mm]",
)


def cloud_table(result: Result) -> Table:
    """One row a case; lags and heights by their median and the half-range of their middle 90 %."""
    rows: list[list[Cell]] = []
    for case in result.cases:
        s, shown = case.score, case.untouched
        row: list[Cell] = [case.noise, 1e3 * case.voxel, case.alpha]
        row += [shown.points, 1e3 * shown.roughness, 1e3 * shown.height]
        row += [s.missed, s.false, s.breaks, 100.0 * s.wrong]
        row += [*_milli(s.touch_lags), _milli(s.release_lags)[0], *_milli(s.touch_heights)]
        rows.append(row)
    caption = f"{result.cases[0].score.contacts} contacts in {result.seconds:.0f} s; alpha 1 is each frame by itself."
    return Table(_HEADERS, rows, caption)


@styled
def figure(result: Result) -> Figure:
    """Errors of detection against the camera's noise, a line for each voxel and temporal filter."""
    drawn, axes = panels(2, 5.4, columns=2)
    drawn.subplots_adjust(hspace=0.28)
    shown: tuple[tuple[str, Callable[[Case], float]], ...] = (
        ("Missed and false contacts", lambda case: float(case.score.missed + case.score.false)),
        ("Breaks within contacts", lambda case: float(case.score.breaks)),
        ("Touch lag, half-range of 90 % [ms]", lambda case: _milli(case.score.touch_lags)[1] or 0.0),
        ("Wrong samples [%]", lambda case: 100.0 * case.score.wrong),
    )
    plan = result.plan
    for (title, value), panel in zip(shown, axes, strict=True):
        for (row, alpha), (number, voxel) in product(enumerate(plan.alpha), enumerate(plan.voxel)):
            cases = sorted(cases_of(result, alpha=alpha, voxel=voxel), key=lambda case: case.noise)
            line = ("-", "--", ":", "-.")[row % 4]
            label = f"{1e3 * voxel:g} mm, {filter_name(alpha)}"
            noise = np.array([case.noise for case in cases])
            panel.plot(noise, list(map(value, cases)), line, marker="o", color=f"C{number}", markersize=3, label=label)
        panel.set_title(title)
    axes[0].legend(fontsize="x-small")
    for panel in axes[2:]:
        panel.set_xlabel("noise [stereo camera = 1]")
    return drawn


def report_of(result: Result) -> Report:
    """What the cameras come to."""
    plan, table, found = result.plan, cloud_table(result), cloud_findings(result)
    view = plan.view
    lead = (
        f"A hand comes down {plan.touches} times at 1 to 20 cm/s on a box that a depth camera sees {plan.rate:g} times "
        f"a second from {view.height:g} m above, {view.tilt:g} deg from straight down. Drake renders the picture; the "
        "noise, holes and flying pixels of a stereo camera are put on it (`hw/realsense/noise.py`). Every camera is "
        "calibrated on the bare table through its own noise, its detector's offset measured on the untouched object. "
        f"Detected contact is held against the plant's; seed {plan.seed}. Nothing here was measured with a real camera."
    )
    section = Section(
        "What was found",
        "\n\n".join(found),
        figures=[Picture(figure(result), "Errors of detection against the camera's noise.", name="cloud")],
        table=table,
    )
    heading = "Contact on a measured cloud, in simulation"
    return Report(result.to_json(), heading, [table], found, "Contact on a measured cloud", lead, [section])


def _milli(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> tuple[float | None, float | None]:
    return middle(values * 1e3)
