"""How well set-up 1 keeps to the wall clock at 1 kHz, beside a loop that does nothing, in the same minute."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from diagrams.bench.measurement import Measurement
from diagrams.scenario import load_scenario
from diagrams.station import build_station
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.realtime.runner import SPIN, wait_until

_SECONDS = 6.0  # of one turn
_TURNS = 4
_PERIOD = 1e-3
_P99_US = 100.0  # target for lateness at a quiet machine


def measurements(seconds: float = _SECONDS, turns: int = _TURNS) -> Iterator[Measurement]:
    """Lateness of ticks and overruns, of both loops in turns.

    Args:
        seconds: of one turn of one loop.
        turns: of each loop.
    """
    loops: dict[str, Callable[[float], Pace]] = {
        "bare loop": bare_loop,
        "setup1 recorded": _station,
    }
    paces: dict[str, list[Pace]] = {name: [] for name in loops}
    for _ in range(turns):
        for name, loop in loops.items():
            paces[name].append(loop(seconds))
    p99 = {}
    for name, turns_of_it in paces.items():
        late = np.concatenate([pace.late_s for pace in turns_of_it]) * 1e6
        behind = np.concatenate([pace.behind_s for pace in turns_of_it])
        median, p99[name], p999, worst = np.quantile(late, [0.5, 0.99, 0.999, 1.0])
        yield Measurement(f"{name}: lateness of a tick, median", median, "us")
        target = _P99_US if name == "setup1 recorded" else None
        yield Measurement(f"{name}: lateness of a tick, 99th percentile", p99[name], "us", target)
        yield Measurement(f"{name}: lateness of a tick, 99.9th percentile", p999, "us")
        yield Measurement(f"{name}: lateness of a tick, worst of {len(late)}", worst, "us")
        yield Measurement(f"{name}: ticks not done when the next was due", 100.0 * float(np.mean(behind > 0.0)), "%")
    ratio = p99["setup1 recorded"] / p99["bare loop"]
    yield Measurement("setup1 recorded: 99th percentile of lateness over the bare loop's", ratio, "x")


def bare_loop(seconds: float) -> Pace:
    """The loop of `advance_paced` around nothing, at 1 kHz for so long [s]."""
    ticks = round(seconds / _PERIOD)
    pace, step, spin, clock = Pace(ticks), round(_PERIOD * 1e9), round(SPIN * 1e9), time.monotonic_ns
    with real_time_process(ProcessOptions()):
        start = clock()
        for tick in range(ticks):
            due = start + tick * step
            began = wait_until(due, spin)
            pace.note((began - due) * 1e-9, (clock() - due - step) * 1e-9)
    return pace


def _station(seconds: float) -> Pace:
    pace = Pace()
    with tempfile.TemporaryDirectory() as folder:
        station = build_station(load_scenario("setup1"), record=Path(folder) / "out.mcap", pace=pace)
        with real_time_process(ProcessOptions()):
            station.simulate(seconds, pace=pace)
    return pace
