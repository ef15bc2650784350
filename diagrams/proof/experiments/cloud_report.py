"""Findings, table, figure and page of the experiment on measured clouds."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.plotting import panels, styled
from mmt_drake.analysis.table import Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.proof.experiments.cloud_runs import CameraCase, CloudPlan, Result, cases_of, run_cloud
from mmt_drake.diagrams.proof.studies.columns import Column, documents, tabled
from mmt_drake.diagrams.proof.studies.of_known import of_known
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Report, Study


def cloud_findings(result: Result) -> list[str]:
    """The verdict: up to which noise contact is found without a slip, by which filters, and what these cost."""
    plan = result.plan
    # The fewest slips, and of those wrong for the least time.
    best = {
        noise: min(cases_of(result, noise=noise), key=lambda case: (case.score.slips, case.score.wrong))
        for noise in sorted(plan.noise)
    }
    sure = [noise for noise, case in best.items() if case.score.slips == 0]
    sentences = [_verdict(sure, best)]
    sentences += [_sentence(case) for case in best.values()]
    for alpha in plan.alpha:
        cases = cases_of(result, alpha=alpha)
        slips = sum(case.score.slips for case in cases)
        contacts = sum(case.score.contacts for case in cases)
        sentences.append(
            f"{filter_name(alpha).capitalize()}: {slips} slips in {contacts} contacts, all cameras together."
        )
    return sentences


def filter_name(alpha: float) -> str:
    """A temporal filter in words."""
    return "each frame by itself" if alpha == 1.0 else f"temporal filter with alpha {alpha:g}"


def _verdict(sure: Sequence[float], best: dict[float, CameraCase]) -> str:
    if not sure:
        return "Verdict: on no cloud that was tried is every contact found once and none besides."
    most = max(sure)
    unsure = [noise for noise in best if noise not in sure]
    rest = f"; with {_noise(min(unsure))} no filter that was tried is enough" if unsure else ""
    return (
        f"Verdict: with {_noise(most)} ({_mm(best[most].untouched.roughness)} left in the cloud) every contact is "
        f"found once and none besides, if the cloud is filtered well{rest}."
    )


def _sentence(case: CameraCase) -> str:
    chosen = f"voxels of {_mm(case.voxel)}, {filter_name(case.alpha)}"
    return f"With {_noise(case.noise)} best are {chosen}: {case.score.slips} slips."


def _noise(amount: float) -> str:
    return "no noise" if amount == 0.0 else f"{amount:g} times a stereo camera's noise"


def _mm(length: float) -> str:
    return f"{significant(1e3 * length, 3)} mm"


def _milli(value: float) -> float:
    return 1e3 * value


def _median(values: list[float]) -> float | None:
    return of_known(lambda some: 1e3 * np.median(some), values)


def _spread(values: list[float]) -> float | None:
    """Half the range from the 5th to the 95th percentile."""
    return of_known(lambda some: 500.0 * np.diff(np.percentile(some, (5.0, 95.0)))[0], values)


COLUMNS: Final[tuple[Column[CameraCase], ...]] = (
    Column(lambda case: case.noise, "noise", "noise"),
    Column(lambda case: case.voxel, "voxel_m", "voxel [mm]", _milli),
    Column(lambda case: case.alpha, "alpha", "alpha"),
    Column(lambda case: case.untouched.points, "points", "points"),
    Column(lambda case: case.untouched.spacing, "spacing_m"),
    Column(lambda case: case.untouched.roughness, "roughness_m", "roughness [mm]", _milli),
    Column(lambda case: case.untouched.height, "height_error_m", "height error [mm]", _milli),
    Column(lambda case: case.untouched.offset, "surface_offset_m"),
    Column(lambda case: case.score.contacts, "contacts"),
    Column(lambda case: case.score.missed, "missed", "missed"),
    Column(lambda case: case.score.false, "false", "false"),
    Column(lambda case: case.score.breaks, "breaks", "breaks"),
    Column(lambda case: case.score.wrong, "wrong", "wrong [%]", lambda share: 100.0 * share),
    Column(lambda case: case.score.touch_lags.tolist(), "touch_lags_s", "touch lag [ms]", _median),
    Column(lambda case: case.score.touch_lags.tolist(), "", "spread [ms]", _spread),
    Column(lambda case: case.score.release_lags.tolist(), "release_lags_s", "release lag [ms]", _median),
    Column(lambda case: case.score.touch_heights.tolist(), "touch_heights_m", "touch height [mm]", _median),
    Column(lambda case: case.score.touch_heights.tolist(), "", "spread [mm]", _spread),
)


def cloud_table(result: Result) -> Table:
    """One row a case; lags and heights by their median and the half-range of their middle 90 %."""
    caption = f"{result.cases[0].score.contacts} contacts in {result.seconds:.0f} s; alpha 1 is each frame by itself."
    return tabled(result.cases, COLUMNS, caption)


@styled
def figure(result: Result) -> Figure:
    """Errors of detection against the camera's noise, a line for each voxel and temporal filter."""
    drawn, axes = panels(2, 5.4, columns=2)
    drawn.subplots_adjust(hspace=0.28)
    shown: tuple[tuple[str, Callable[[CameraCase], float]], ...] = (
        ("Missed and false contacts", lambda case: float(case.score.missed + case.score.false)),
        ("Breaks within contacts", lambda case: float(case.score.breaks)),
        ("Touch lag, half-range of 90 % [ms]", lambda case: _spread(case.score.touch_lags.tolist()) or 0.0),
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
    plan, table, view = result.plan, cloud_table(result), result.plan.view
    lead = (
        f"A hand comes down {plan.touches} times at 1 to 20 cm/s on a box that a depth camera sees {plan.rate:g} times "
        f"a second from {view.height:g} m above, {view.tilt:g} deg from straight down. Drake renders the picture; the "
        "noise, holes and flying pixels of a stereo camera are put on it (`hw/realsense/noise.py`). Every camera is "
        "calibrated on the bare table through its own noise, its detector's offset measured on the untouched object. "
        f"Detected contact is held against the plant's; seed {plan.seed}. Nothing here was measured with a real camera."
    )
    picture = Picture(figure(result), "Errors of detection against the camera's noise.", name="cloud")
    document = {
        "experiment": "cloud",
        "seed": plan.seed,
        "simulated_s": result.seconds,
        "cases": documents(result.cases, COLUMNS),
    }
    return Report(
        document,
        title="Contact on a measured cloud",
        lead=lead,
        heading="Contact on a measured cloud, in simulation",
        own_tables=[table],
        sentences=cloud_findings(result),
        sections=[Section("Every camera", figures=[picture], table=table)],
    )


def _plan(asked: Asked) -> CloudPlan:
    plan = CloudPlan(seed=asked.seed)
    return plan if asked.count is None else replace(plan, touches=asked.count)


def _run(asked: Asked, progress: Progress) -> Report:
    return report_of(run_cloud(_plan(asked), progress))


def _seconds(asked: Asked) -> float:
    return float(_plan(asked).motion().cycle)


STUDIES: Final = {"cloud": Study("cloud", ("seed", "count"), _seconds, _run, simulated=True)}
