"""Set-up 1 as a whole: speed, what each system costs, and what grows with the duration."""

import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, InputPort, PortDataType, System
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource, VectorLogSink

from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.site import Site
from mmt_drake.diagrams.stations.station import build_parts, build_station

_TICKS = 5000

#: Systems of a station and the outputs that something reads at every tick.
PARTS = {
    "operator": ("motion",),
    "to_telerobot": ("received",),
    "environment": ("readout",),
    "detector": (),
    "estimator": (),
    "to_operator": ("received",),
    "renderer": ("readout",),
}

_SCENARIOS = ("setup1", "setup1-delay", "setup1-free-running")


def measurements() -> Iterator[Measurement]:
    """Speed of the complete set-up with recording, cost per system and per simulated second."""
    with tempfile.TemporaryDirectory() as folder:
        seconds = {name: _run(name, 60.0, Path(folder)) for name in _SCENARIOS}
        for name, wall in seconds.items():
            target = 20.0 if name == "setup1" else None
            yield Measurement(f"{name} complete, recorded: speed", 60.0 / wall, "x real time", target, at_least=True)
        memory = _resident()
        long = _run("setup1", 240.0, Path(folder))
        grown = _resident() - memory
        yield Measurement(
            "cost of a simulated second, 240 s run against 60 s run", long / 4.0 / seconds["setup1"], "x", 1.2
        )
        size = (Path(folder) / "out.mcap").stat().st_size / 240.0
        yield Measurement("memory kept per simulated second", grown / 240.0 / 1e3, "kB", size / 1e3)
        yield Measurement("recording per simulated second", size / 1e3, "kB")
    yield from _per_system()


def _run(name: str, duration: float, folder: Path) -> float:
    """Wall time of one run with recording [s]."""
    station = build_station(load_scenario(name), record=folder / "out.mcap")
    start = time.perf_counter()
    station.simulate(duration)
    return time.perf_counter() - start


def _resident() -> float:
    """Memory of this process that is in use now [bytes]."""
    return float(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _per_system() -> Iterator[Measurement]:
    """Each system by itself, its inputs held at what they are in the middle of a run."""
    scenario = replace(load_scenario("setup1-delay"), clouds="none")
    station = build_station(scenario)
    context = station.simulate(6.0).get_context()
    fresh = build_parts(Site(scenario))
    empty = _alone_us(ConstantVectorSource([0.0]), {}, ("y0",))
    for name, outputs in PARTS.items():
        system = station.diagram.GetSubsystemByName(name)
        own = system.GetMyContextFromRoot(context)
        ports = [system.get_input_port(i) for i in range(system.num_input_ports())]
        inputs = {port.get_name(): value_at(port, own) for port in ports if port.HasValue(own)}
        yield Measurement(f"cost per tick: {name}", _alone_us(fresh[name], inputs, outputs) - empty, "us")
    yield Measurement("cost per tick: Drake's Simulator itself", empty, "us")


def _alone_us(system: System, inputs: dict[str, object], outputs: tuple[str, ...]) -> float:
    """Wall time per tick [us] of a diagram that holds nothing but this system."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, value in inputs.items():
        held = ConstantValueSource(value) if isinstance(value, AbstractValue) else ConstantVectorSource(value)
        builder.AddSystem(held)
        builder.Connect(held.get_output_port(), system.GetInputPort(name))
    for port in (system.GetOutputPort(name) for name in outputs):
        sink = builder.AddSystem(VectorLogSink(port.size(), 1e-3))
        builder.Connect(port, sink.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.1)
    best = np.inf
    for i in range(3):
        start = time.perf_counter()
        simulator.AdvanceTo(0.1 + (i + 1) * _TICKS * 1e-3)
        best = min(best, time.perf_counter() - start)
    return float(best / _TICKS * 1e6)


def value_at(port: InputPort, context: Context) -> object:
    """What a port reads, as a source would hold it."""
    value = port.Eval(context)
    return AbstractValue.Make(value) if port.get_data_type() == PortDataType.kAbstractValued else value
