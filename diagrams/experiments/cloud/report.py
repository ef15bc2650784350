"""The experiment's table and figure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from diagrams.experiments.cloud.run import Case, Result
from mmt_drake.analysis.plotting import panels, save, styled
from mmt_drake.analysis.table import Cell, Table

_HEADERS = (
    "noise",
    "voxel [mm]",
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


def table(result: Result) -> Table:
    """One row a case; lags and heights by their median and the half-range of their middle 90 %."""
    rows: list[list[Cell]] = []
    for case in result.cases:
        s = case.score
        touch, late = _middle(s.touch_lags, 1e3)
        height, uneven = _middle(s.touch_heights, 1e3)
        rows.append(
            [
                case.noise,
                case.voxel * 1e3,
                case.points,
                case.roughness * 1e3,
                case.height * 1e3,
                s.missed,
                s.false,
                s.breaks,
                s.wrong * 100.0,
                touch,
                late,
                _middle(s.release_lags, 1e3)[0],
                height,
                uneven,
            ]
        )
    contacts = result.cases[0].score.contacts
    alpha = result.plan.alpha
    smoothed = "each frame by itself" if alpha == 1.0 else f"temporal filter with alpha {alpha:g}"
    caption = f"Contact on a measured cloud: {contacts} contacts in {result.seconds:.0f} s, {smoothed}"
    return Table(_HEADERS, rows, caption)


@styled
def figure(result: Result) -> Figure:
    """Errors of detection against the camera's noise, a line for each voxel."""
    drawn, axes = panels(2, 5.4, columns=2)
    drawn.subplots_adjust(hspace=0.28)
    shown: tuple[tuple[str, Callable[[Case], float]], ...] = (
        ("Missed and false contacts", lambda case: float(case.score.missed + case.score.false)),
        ("Breaks within contacts", lambda case: float(case.score.breaks)),
        ("Touch lag, 5 to 95 % [ms]", lambda case: _middle(case.score.touch_lags, 1e3)[0] or 0.0),
        ("Wrong samples [%]", lambda case: 100.0 * case.score.wrong),
    )
    for (title, value), panel in zip(shown, axes, strict=True):
        for number, voxel in enumerate(result.plan.voxel):
            cases = [case for case in result.cases if case.voxel == voxel]
            noise = np.array([case.noise for case in cases])
            if title.startswith("Touch lag"):
                lags = [case.score.touch_lags * 1e3 for case in cases]
                ends = np.array([np.percentile(lag, (5, 95)) if len(lag) else (0.0, 0.0) for lag in lags])
                panel.fill_between(noise, ends[:, 0], ends[:, 1], color=f"C{number}", alpha=0.12, linewidth=0)
            panel.plot(noise, [value(case) for case in cases], "o-", markersize=3, label=f"voxel {voxel * 1e3:g} mm")
        panel.set_title(title)
    axes[0].legend()
    for panel in axes[2:]:
        panel.set_xlabel("noise [stereo camera = 1]")
    return drawn


def write(result: Result, out: str | Path) -> list[Path]:
    """The table (`cloud.csv`) and the figure (`cloud.png`) in a folder, which is made.

    Raises:
        BadInput: they cannot be written.
    """
    from mmt_drake.recording.atomic import replacing, told

    out = Path(out)
    with told(out):
        out.mkdir(parents=True, exist_ok=True)
    made = table(result)
    rows = [",".join(made.headers)] + [",".join("" if c is None else f"{c:.6g}" for c in row) for row in made.rows]
    with replacing(out / "cloud.csv") as temporary:
        temporary.write_text("\n".join(rows) + "\n")
    return [out / "cloud.csv", save(figure(result), out / "cloud.png")]


def document(result: Result) -> dict[str, object]:
    """The same figures for `--json`, in SI units; lags of each contact seen."""
    return {
        "experiment": "cloud",
        "seed": result.plan.seed,
        "alpha": result.plan.alpha,
        "seconds": result.seconds,
        "cases": [
            {
                "noise": case.noise,
                "voxel_m": case.voxel,
                "points": case.points,
                "spacing_m": case.spacing,
                "roughness_m": case.roughness,
                "height_error_m": case.height,
                "surface_offset_m": case.offset,
                "contacts": case.score.contacts,
                "missed": case.score.missed,
                "false": case.score.false,
                "breaks": case.score.breaks,
                "wrong": case.score.wrong,
                "touch_lags_s": case.score.touch_lags.tolist(),
                "release_lags_s": case.score.release_lags.tolist(),
                "touch_heights_m": case.score.touch_heights.tolist(),
            }
            for case in result.cases
        ],
    }


def _middle(values: np.ndarray[tuple[int], np.dtype[np.float64]], scale: float) -> tuple[float | None, float | None]:
    """Median, and half the range from the 5th to the 95th percentile."""
    if len(values) == 0:
        return None, None
    low, median, high = np.percentile(values * scale, (5.0, 50.0, 95.0))
    return float(median), float(0.5 * (high - low))
