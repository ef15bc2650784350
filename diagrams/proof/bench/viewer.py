"""Cost of the live view to the loop that it shows."""

import time
from collections.abc import Iterator

import numpy as np
from pydrake.systems.analysis import Simulator

from mmt_drake.diagrams.proof.bench.setup import value_at
from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.systems.live_view import SAMPLE_PERIOD, LiveView
from mmt_drake.viewer.charts import page
from mmt_drake.viewer.viewer import Viewer

_SECONDS = 3.0
_TICK = 1e-3  # [s]


def measurements(seconds: float = _SECONDS) -> Iterator[Measurement]:
    """Cost of what a `LiveView` does in one tick, shown the middle of a run in real time.

    Args:
        seconds: how long.
    """
    with Viewer(page()) as viewer:
        station = build_station(load_scenario("setup1"), meshcat=viewer)
        shown = station.diagram.GetSubsystemByName("live_view")
        then = shown.GetMyContextFromRoot(station.simulate(6.0).get_context())
        view = LiveView(viewer)
        context = view.CreateDefaultContext()
        for i in range(view.num_input_ports()):
            port = shown.get_input_port(i)
            if port.HasValue(then):
                view.get_input_port(i).FixValue(context, value_at(port, then))
        simulator = Simulator(view, context)
        simulator.Initialize()
        took = []
        for i in range(1, round(seconds / SAMPLE_PERIOD)):
            time.sleep(SAMPLE_PERIOD)
            start = time.perf_counter()
            simulator.AdvanceTo(i * SAMPLE_PERIOD)
            took.append(time.perf_counter() - start)
    per_tick = np.mean(took) * _TICK / SAMPLE_PERIOD
    yield Measurement("live view: cost per tick at 1 kHz, mean", float(per_tick) * 1e6, "us", 20.0)
    yield Measurement("live view: cost of a tick with a picture", float(np.quantile(took, 0.9)) * 1e6, "us", 300.0)
