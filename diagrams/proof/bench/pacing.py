"""Lateness of set-up 1 at 1 kHz by the wall clock, with and without a live view, beside a loop that does nothing."""

import math
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.realtime.runner import wait_until
from mmt_drake.viewer.charts import page
from mmt_drake.viewer.viewer import Viewer

_MINUTES = 0.4
_TURNS, _LONGEST_S = 4, 60.0  # turns at least, and the longest one
_BESIDE = 0.25  # of its time, what is measured beside set-up 1 takes
_PERIOD = 1e-3
_P99_US = 100.0  # target for lateness at a quiet machine


def measurements(minutes: float = _MINUTES) -> Iterator[Measurement]:
    """Lateness of ticks and overruns of each loop, in turns of a minute at most.

    Args:
        minutes: of set-up 1 in all; the others take a quarter of that each.
    """
    turns = max(_TURNS, math.ceil(60.0 * minutes / _LONGEST_S))
    seconds = 60.0 * minutes / turns
    with Viewer(page()) as viewer:
        loops: dict[str, Callable[[], Pace]] = {
            "bare loop": lambda: bare_loop(_BESIDE * seconds),
            "setup1 recorded": lambda: paced("setup1", seconds),
            "setup1 recorded and shown": lambda: paced("setup1", _BESIDE * seconds, viewer=viewer),
        }
        rounds = [{name: loop() for name, loop in loops.items()} for _ in range(turns)]
    yield loop_priority()
    p99 = {}
    for name in loops:
        late = np.concatenate([paces[name].late_s for paces in rounds]) * 1e6
        behind = np.concatenate([paces[name].behind_s for paces in rounds])
        median, p99[name], p999, worst = np.quantile(late, [0.5, 0.99, 0.999, 1.0])
        yield Measurement(f"{name}: lateness of a tick, median", median, "us")
        target = _P99_US if name == "setup1 recorded" else None
        yield Measurement(f"{name}: lateness of a tick, 99th percentile", p99[name], "us", target)
        yield Measurement(f"{name}: lateness of a tick, 99.9th percentile", p999, "us")
        yield Measurement(f"{name}: lateness of a tick, worst of {len(late)}", worst, "us")
        overruns = int(np.count_nonzero(behind > 0.0))
        yield Measurement(f"{name}: overruns, ticks not done when the next was due", overruns, "")
        yield Measurement(f"{name}: the same, of all ticks", 100.0 * overruns / len(behind), "%")
    for name in list(loops)[1:]:
        ratio = p99[name] / p99["bare loop"]
        yield Measurement(f"{name}: 99th percentile of lateness over the bare loop's", ratio, "x")


def loop_priority() -> Measurement:
    """The real-time priority that a loop gets here, unasked."""
    with real_time_process(ProcessOptions()):
        return Measurement("real-time priority of the loop, 0: none", os.sched_getparam(0).sched_priority, "")


def bare_loop(seconds: float) -> Pace:
    """The loop of `advance_paced` around nothing, at 1 kHz for so long [s]."""
    ticks = round(seconds / _PERIOD)
    pace, step, clock = Pace(ticks), round(_PERIOD * 1e9), time.monotonic_ns
    with real_time_process(ProcessOptions()):
        start = clock()
        for tick in range(ticks):
            due = start + tick * step
            began = wait_until(due)
            pace.began((began - due) * 1e-9)
            pace.done((clock() - due - step) * 1e-9)
    return pace


def paced(
    scenario: str, seconds: float, changes: tuple[str, ...] | list[str] = (), viewer: Viewer | None = None
) -> Pace:
    """How a scenario with changes keeps pace with the wall clock for so long [s], recorded."""
    pace = Pace()
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "out.mcap"
        chosen = load_scenario(scenario, changes or [])
        station = build_station(chosen, record=record, meshcat=viewer, worker=True, pace=pace)
        with real_time_process(ProcessOptions()):
            station.simulate(seconds, pace=pace)
    return pace
