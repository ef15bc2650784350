"""Figures of a run or of several, put into words and tables."""

from __future__ import annotations

from collections.abc import Mapping

from mmt_drake.analysis.metrics import ForceError, Metrics
from mmt_drake.analysis.page import Cell, Table
from mmt_drake.analysis.signals import BAND_NAMES


def lines(metrics: Metrics) -> list[str]:
    """The figures of one run, one line each, for a terminal."""
    told = [f"rendered force: {_error(metrics.rendered_error)}"]
    if metrics.rendered_error_true is not None:
        told.append(f"  against the force without noise: {_percent(metrics.rendered_error_true.tangential['all'])}")
    if metrics.switch_error is not None:
        told.append(f"  around touches and releases: {_percent(metrics.switch_error.tangential['all'])}")
    if metrics.between_switches_error is not None:
        told.append(f"  between them: {_percent(metrics.between_switches_error.tangential['all'])}")
    if metrics.estimated_error is not None:
        told.append(f"estimated force: {_error(metrics.estimated_error)}")
        stable = metrics.time_to_stable_s
        verdict = "not stable at the end" if stable is None else f"stable after {stable:.3f} s of contact"
        told.append(f"parameters: {verdict}")
    for name, found in (("touch", metrics.touch), ("release", metrics.release)):
        answered = sum(lag is not None for lag in found.lags_s)
        if found.median_s is not None:
            lag_ms = f"{1e3 * found.median_s:.4g} ms"
            told.append(f"{name} lag: {lag_ms} (median of {answered}, of {len(found.lags_s)} in all)")
    return told


def error_table(cases: Mapping[str, Metrics]) -> Table:
    """Errors [%] and lags [ms] of several runs, one row each."""
    headers = ["case", *(f"rendered, {name} [%]" for name in BAND_NAMES.values()), "rendered, z [%]"]
    headers += ["estimated [%]", "stable after [s]", "touch lag [ms]", "release lag [ms]"]
    rows: list[list[Cell]] = []
    for case, metrics in cases.items():
        rendered = metrics.rendered_error
        estimated = None if metrics.estimated_error is None else metrics.estimated_error.tangential["all"]
        row: list[Cell] = [case, *(_scaled(rendered.tangential[band], 100.0) for band in BAND_NAMES)]
        row += [_scaled(rendered.normal["all"], 100.0), _scaled(estimated, 100.0)]
        row += [metrics.time_to_stable_s, _scaled(metrics.touch.median_s, 1e3), _scaled(metrics.release.median_s, 1e3)]
        rows.append(row)
    return Table(headers, rows, "Errors: RMS(force - measured) / RMS(measured), in contact, after the wind-up phase.")


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _percent(ratio: float | None) -> str:
    return "-" if ratio is None else f"{100.0 * ratio:.3g} %"


def _error(error: ForceError) -> str:
    whole, *bands = (f"{name} {_percent(error.tangential[band])}" for band, name in BAND_NAMES.items())
    return f"error {whole.removeprefix('all ')} ({', '.join(bands)}); normal {_percent(error.normal['all'])}"
