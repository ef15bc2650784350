"""Figures of a run or of several, put into words and tables."""

from collections.abc import Mapping
from typing import Final

from mmt_drake.analysis.metrics import STAGES, ForceError, Metrics
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import milliseconds, percent

_CAPTION: Final = (
    "RMS(force - measured) / RMS(measured), in contact, after the wind-up phase: the rendered force by band, in the "
    "second half of the contact time, and along z; the estimated force. A dash: never, or not known."
)
_STAGES: Final = dict(
    zip(STAGES, ("first 0.5 s of contact", "all contact after it", "first 50 ms of every touch"), strict=True)
)


def lines(metrics: Metrics) -> list[str]:
    """The figures of one run, one line each, for a terminal."""
    lines = [f"rendered force: {_error(metrics.rendered_error)}"]
    if metrics.rendered_error_true is not None:
        lines.append(f"  against the force without noise: {percent(metrics.rendered_error_true.tangential['all'])}")
    stages = (
        f"{words} {percent(error.tangential['all'])}"
        for name, error in metrics.stages.items()
        if (words := _STAGES.get(name))
    )
    each = metrics.median_touch_error
    told = "" if each is None else f" (median of the touches {percent(each)})"
    lines.append(f"  from the first touch on: {', '.join(stages)}{told}")
    if metrics.switch_error is not None:
        lines.append(f"  around touches and releases: {percent(metrics.switch_error.tangential['all'])}")
    if metrics.between_switches_error is not None:
        lines.append(f"  between them: {percent(metrics.between_switches_error.tangential['all'])}")
    if metrics.estimated_error is not None:
        lines.append(f"estimated force: {_error(metrics.estimated_error)}")
        stable = metrics.time_to_stable_s
        verdict = (
            "not stable at the end; waiting after each touch may help (estimator.settle, 0.5 s)"
            if stable is None
            else f"stable after {stable:.3f} s of contact"
        )
        lines.append(f"parameters: {verdict}")
    for name, found in (("touch", metrics.touch), ("release", metrics.release)):
        answered = sum(lag is not None for lag in found.lags_s)
        if found.median_s is not None:
            typical = f"{milliseconds(found.median_s)} (median of {answered}, of {len(found.lags_s)} in all)"
            lines.append(f"{name} lag: {typical}")
    return lines


def error_table(cases: Mapping[str, Metrics], settled: Mapping[str, Metrics]) -> Table:
    """Errors [%] and lags [ms] of several runs, one row each.

    Args:
        cases: name of a run -> its figures.
        settled: the same names -> its figures over the second half of the contact time alone.
    """
    headers = ["case", *(f"{name} [%]" for name in BAND_NAMES.values()), "2nd half [%]", "z [%]"]
    headers += ["estimated [%]", "stable after [s]", "touch lag [ms]", "release lag [ms]"]
    rows: list[list[Cell]] = []
    for case, metrics in cases.items():
        rendered = metrics.rendered_error
        ratios = [*(rendered.tangential[band] for band in BAND_NAMES), settled[case].rendered_error.tangential["all"]]
        ratios += [rendered.normal["all"]]
        ratios += [None if metrics.estimated_error is None else metrics.estimated_error.tangential["all"]]
        row: list[Cell] = [case, *(_scaled(ratio, 100.0) for ratio in ratios), metrics.time_to_stable_s]
        rows.append([*row, _scaled(metrics.touch.median_s, 1e3), _scaled(metrics.release.median_s, 1e3)])
    return Table(headers, rows, _CAPTION)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _error(error: ForceError) -> str:
    whole, *bands = (f"{name} {percent(error.tangential[band])}" for band, name in BAND_NAMES.items())
    return f"error {whole.removeprefix('all ')} ({', '.join(bands)}); normal {percent(error.normal['all'])}"
