"""Runs of cases, one after the other or on several cores, and what is measured of their recordings."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.analysis.metrics import AFTER_S, ForceError, Metrics, measure
from mmt_drake.analysis.summary import error_table
from mmt_drake.analysis.table import Table
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, unheard
from mmt_drake.diagrams.stations.estimators import estimator_name
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.scenario import Scenario, operator_name, updates_name
from mmt_drake.diagrams.stations.site import Devices
from mmt_drake.diagrams.stations.station import Station, build_station
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA
from mmt_drake.recording import Recording, load
from mmt_drake.recording.atomic import replacing, writing
from mmt_drake.recording.mcap_writer import whole_or_none


@dataclass(frozen=True)
class MeasuredRun:
    """One run, measured. All figures but `wall_s` are computed from the recording.

    Attributes:
        name: of the case.
        scenario: what was built.
        operator: whose motion it was: the scenario's, in a word, or the recording that was replayed.
        recording: the file it left.
        metrics: errors, lags, parameters.
        settled: the same over the second half of the contact time alone (never before `AFTER_S` of it).
        peak_force: the largest component of the rendered force in the whole run [N].
        peak_at: when that was [s].
        wall_s: how long the simulation took [s].
    """

    name: str
    scenario: Scenario
    operator: str
    recording: Path
    metrics: Metrics
    settled: Metrics
    peak_force: float
    peak_at: float
    wall_s: float

    @cached_property
    def samples(self) -> Recording:
        """The recording, read when it is first asked for."""
        return load(self.recording)

    @property
    def truth(self) -> dict[str, float]:
        """The object's true parameters, by the names of `theta_*`, SI units; Fc is the sliding level."""
        return dict(zip(THETA, map(float, self.scenario.environment.object.theta()), strict=True))

    @property
    def true_error(self) -> ForceError:
        """Error of the rendered force against the plant's without noise, which every station that simulates records."""
        error = self.metrics.rendered_error_true
        assert error is not None
        return error

    def further_off(self, other: MeasuredRun) -> float | None:
        """By how much the error of the rendered force, against the plant's without noise, is larger than another's."""
        ours, theirs = (case.true_error.tangential["all"] for case in (self, other))
        return None if ours is None or theirs is None else ours - theirs

    def to_json(self) -> dict[str, Any]:
        """One entry of `cases` of `experiment --json`: plain numbers, strings, None, lists and dicts."""
        chosen = self.scenario.estimator
        return {
            "name": self.name,
            "estimator": estimator_name(chosen),
            "equations": getattr(chosen, "equations", None),
            "freeze_after_s": getattr(chosen, "freeze_after", None),
            "renderer": self.scenario.renderer.name,
            "updates": updates_name(self.scenario),
            "switching": self.scenario.switching,
            "recording": str(self.recording),
            **self.metrics.to_json(),
            "settled_error": self.settled.rendered_error.to_json(),
            "rendered_peak_n": self.peak_force,
            "rendered_peak_at_s": self.peak_at,
        }


Cases = Mapping[str, MeasuredRun]
"""By their names."""


def ratio_of(error: ForceError | None, band: str = "all") -> float | None:
    """The tangential error in one band; None where it is not known."""
    return None if error is None else error.tangential[band]


def errors_of(cases: Cases) -> Table:
    """Errors of every case, over the whole run and its second half."""
    return error_table(
        {name: case.metrics for name, case in cases.items()}, {name: case.settled for name, case in cases.items()}
    )


def run_cases(
    scenarios: Mapping[str, Scenario], files: Mapping[str, Path], asked: Asked, progress: Progress = unheard
) -> Cases:
    """Run and measure scenarios.

    Args:
        scenarios: name of a case -> what to build.
        files: name of a case -> where its recording goes.
        asked: an operator's recording replaces every scenario's hand; the numbers do not depend on the jobs, of which
            more than one need a script whose entry stands under `if __name__ == "__main__"`.
        progress: called with the number of cases done.

    Raises:
        BadInput: jobs below 1, an operator that cannot be read, or see `run_case`.
    """
    if asked.jobs < 1:
        raise BadInput("jobs", found=asked.jobs, expected="1 or more")
    operator = None if asked.operator is None else load_operator(asked.operator)
    # Bad input is found, and kernels are compiled, once and here, before there are folders and processes.
    build_station(next(iter(scenarios.values())), operator=operator)
    for file in files.values():
        with writing(file.parent):
            file.parent.mkdir(parents=True, exist_ok=True)
    tasks = [partial(run_case, name, scenario, files[name], operator) for name, scenario in scenarios.items()]
    return {case.name: case for case in results_of(tasks, asked.jobs, progress)}


def run_case(
    name: str,
    scenario: Scenario,
    file: Path,
    operator: Recording | None = None,
    *,
    devices: Devices = Devices(),
    play: Callable[[Station], object] = Station.simulate,
) -> MeasuredRun:
    """Run one scenario into a recording and measure that.

    Args:
        name: of the case.
        scenario: what is built.
        file: for the recording.
        operator: a recording that replaces the scenario's hand.
        devices: in the place of what simulates them.
        play: runs the station.

    Raises:
        BadInput: the scenario cannot be built, the file not be written, or the run has nothing to measure; nothing
            is left then, and an older file is as it was.
    """
    with replacing(file) as temporary:
        station = build_station(scenario, record=temporary, operator=operator, devices=devices)
        assert station.recorder is not None  # it was asked for
        with whole_or_none(station.recorder.file, file):
            start = time.perf_counter()
            play(station)
            wall_s = time.perf_counter() - start
        recording = replace(load(temporary), source=str(file))
        metrics = measure(recording)
        settled = measure(recording, after_s=max(AFTER_S, metrics.contact_s / 2))
    rendered = np.max(np.abs(recording.vector("rendered_force")), axis=1)
    peak = int(np.argmax(rendered))
    return MeasuredRun(
        name=name,
        scenario=scenario,
        operator=operator_name(scenario, operator) if devices.hand is None else devices.hand.name,
        recording=file,
        metrics=metrics,
        settled=settled,
        peak_force=float(rendered[peak]),
        peak_at=float(recording.time[peak]),
        wall_s=wall_s,
    )
