"""Same scenario and seed, twice; and a Context cloned half-way."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram

from mmt_drake.diagrams.proof.studies.measurement import Measurement
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station

_SCENARIO = "setup1-everything"


def measurements() -> Iterator[Measurement]:
    """How much two runs differ that should not differ at all."""
    scenario = load_scenario(_SCENARIO)
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / name for name in ("first.mcap", "second.mcap")]
        for file in files:
            build_station(scenario, record=file).simulate(5.0)
        differing = bytes_apart(*files)
    yield Measurement(f"{_SCENARIO} run twice: bytes of the recordings that differ", differing, "bytes", 0.0)
    diagram = build_station(scenario).diagram
    straight = Simulator(diagram)
    straight.AdvanceTo(2.0)
    cloned = Simulator(diagram, straight.get_context().Clone())
    for simulator in (straight, cloned):
        simulator.AdvanceTo(4.0)
    difference = np.abs(_outputs(diagram, straight.get_context()) - _outputs(diagram, cloned.get_context())).max()
    yield Measurement(
        f"{_SCENARIO} from a Context cloned half-way: largest difference of an output", difference, "", 0.0
    )


def bytes_apart(one: Path, other: Path) -> float:
    """How many bytes of two files differ; all of them where one is longer."""
    first, second = (np.frombuffer(file.read_bytes(), np.uint8) for file in (one, other))
    return float(np.count_nonzero(first != second) if len(first) == len(second) else max(len(first), len(second)))


def _outputs(diagram: Diagram, context: Context) -> np.ndarray:
    return np.concatenate([diagram.get_output_port(i).Eval(context) for i in range(diagram.num_output_ports())])
