"""`mmt-drake run`: builds the diagram that a scenario describes, runs it, and tells what came of it."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mmt_drake.analysis import summary
from mmt_drake.analysis.metrics import Metrics, measure
from mmt_drake.analysis.passivity import Passivity, passivity
from mmt_drake.cli.main import INTERRUPTED
from mmt_drake.cli.options import add_topics, seconds, seed
from mmt_drake.cli.pacing import Pacing
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput, MissingDependency
from mmt_drake.network.config import ChannelConfig, load_trace
from mmt_drake.network.parameters import whole_ticks
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.atomic import beside
from mmt_drake.recording.files import check_target

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

    from diagrams.scenario import Scenario
    from diagrams.station import Station

EPILOG = """\
examples:
  mmt-drake run setup1
  mmt-drake run setup1 --operator hand.csv --record out.mcap
  mmt-drake run setup1-delay --set estimator.equations=without_d --set to_operator.jitter=0.02 --seconds 20
  mmt-drake run my_scenario.yaml --set 'operator={motion: chirp}' --seed 3 --json

With --operator the run lasts as long as that motion, unless --seconds or --set duration=... says otherwise.
A hand on sliders (operator: !Interactive) needs --meshcat and always runs in real time."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("scenario", metavar="SCENARIO", help="a YAML file, or the name of a shipped scenario")
    parser.add_argument("--operator", metavar="REC", help="replay the probe motion of a recording, put onto the table")
    add_topics(parser)
    parser.add_argument("--record", metavar="OUT", help="keep the recording: .mcap, .csv or .npz")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="change the scenario; may be given again"
    )
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time")
    parser.add_argument("--seed", type=seed, metavar="S", help="of noise and networks, in place of the scenario's")
    parser.add_argument("--hardware", action="store_true", help="real devices in place of simulated ones")
    parser.add_argument("--realtime", action="store_true", help="keep to the wall clock, and tell where it was missed")
    parser.add_argument("--meshcat", action="store_true", help="start a viewer for the browser of this machine")
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON document and nothing else")


@dataclass(frozen=True)
class Summary:
    """What came of a run.

    Attributes:
        scenario: what was run.
        operator: whose motion it was.
        simulated_s, wall_s: how long it took, in simulated and in real time [s].
        pacing: how well it kept to the wall clock; None where it was not meant to.
        metrics: errors of force and lags, or why there are none.
        energy: at both ends, or why it is not known.
        recording: the file that was kept.
    """

    scenario: Scenario
    operator: str
    simulated_s: float
    wall_s: float
    pacing: Pacing | None
    metrics: Metrics | BadInput
    energy: Passivity | BadInput
    recording: str | None

    def lines(self) -> list[str]:
        """For a terminal."""
        speed = self.simulated_s / self.wall_s
        told = [
            f"{self.scenario.name}, operator {self.operator}: {self.simulated_s:.3f} s simulated in "
            f"{self.wall_s:.2f} s, {speed:.3g} times real time"
        ]
        if isinstance(self.metrics, BadInput):
            told.append(f"force errors and lags: none; {_why(self.metrics)}")
        else:
            told += summary.lines(self.metrics)
        told += [f"energy: not known; {_why(self.energy)}"] if isinstance(self.energy, BadInput) else self.energy.lines()
        told.append("overruns: not paced" if self.pacing is None else self.pacing.line())
        told.append(f"recording: {self.recording or 'not kept (--record OUT keeps it)'}")
        return told

    def to_json(self) -> dict[str, Any]:
        """The same as data; `missing` says why `errors` or `energy` is null."""
        absent = {"errors": self.metrics, "energy": self.energy}
        return {
            "scenario": self.scenario.name,
            "seed": self.scenario.seed,
            "operator": self.operator,
            "simulated_s": self.simulated_s,
            "wall_s": self.wall_s,
            "overruns": None if self.pacing is None else self.pacing.to_json(),
            "errors": None if isinstance(self.metrics, BadInput) else self.metrics.to_json(),
            "energy": None if isinstance(self.energy, BadInput) else self.energy.to_json(),
            "missing": {name: _why(reason) for name, reason in absent.items() if isinstance(reason, BadInput)},
            "recording": self.recording,
        }


def main(arguments: argparse.Namespace) -> int:
    """Run a scenario."""
    if arguments.hardware:
        raise MissingDependency("--hardware: there is no hardware driver in this version; without it, run simulates")
    from diagrams.station import build_station

    target = None if arguments.record is None else Path(arguments.record)
    if target is not None:
        check_target(target)
        beside(target)
    hand = _hand(arguments)
    scenario = _scenario(arguments, hand)
    meshcat = _viewer() if arguments.meshcat else None
    pacing = Pacing() if arguments.realtime or _interactive(scenario, hand) else None
    with TemporaryDirectory(prefix="mmt-drake-") as folder:
        native = target if target is not None and target.suffix.lower() == ".mcap" else Path(folder) / "run.mcap"
        station = build_station(scenario, record=native, operator=hand, meshcat=meshcat)
        start = time.perf_counter()
        with _whole_or_none(native, target):
            simulated, interrupted = _simulate(station, pacing)
        wall = time.perf_counter() - start
        recording = _tried(lambda: load(native))
        if target is not None and target != native:
            if isinstance(recording, BadInput):
                raise recording
            save(recording, target)
    if interrupted:
        print(f"mmt-drake: interrupted after {simulated:g} s; {target or 'nothing'} is kept", file=sys.stderr)
        return INTERRUPTED
    if isinstance(recording, BadInput):
        metrics, energy = recording, recording
    else:
        delay = usual_delay(scenario.to_telerobot, scenario.step)
        metrics = _tried(lambda: measure(recording, delay_s=delay))
        energy = _tried(lambda: passivity(recording))
    told = Summary(
        scenario=scenario,
        operator=_named(scenario, hand),
        simulated_s=simulated,
        wall_s=wall,
        pacing=pacing,
        metrics=metrics,
        energy=energy,
        recording=None if target is None else str(target),
    )
    print(json.dumps(told.to_json(), indent=2, allow_nan=False) if arguments.json else "\n".join(told.lines()))
    return 0


def usual_delay(config: ChannelConfig, step: float) -> float:
    """The delay [s] that most packets of a direction have: of the play-out buffer, else the trace's median, else `delay`.

    A channel delivers at its ticks, `step` [s] apart, so this is a multiple of it.

    Raises:
        BadInput: the trace cannot be read.
    """
    delay = config.playout or config.delay
    if config.trace is not None and not config.playout:
        delay = float(np.nanmedian(load_trace(config.trace)[:-1, 1]))
    return whole_ticks(delay, step) * step


def _hand(arguments: argparse.Namespace) -> Recording | None:
    """The recording to replay, if one was asked for."""
    from diagrams.station import load_operator

    if arguments.operator is None:
        if arguments.topic:
            raise BadInput("--topic", found="no --operator", expected="a bag whose topics it names")
        return None
    topics = dict(arguments.topic)
    return load(arguments.operator, topics, forces=False) if topics else load_operator(arguments.operator)


def _scenario(arguments: argparse.Namespace, hand: Recording | None) -> Scenario:
    """The scenario with everything that the command line changes in it."""
    from diagrams.scenario import load_scenario

    scenario = load_scenario(arguments.scenario, arguments.set)
    if arguments.seed is not None:
        scenario = replace(scenario, seed=arguments.seed)
    if arguments.seconds is not None:
        return replace(scenario, duration=arguments.seconds)
    told = any(change.partition("=")[0] == "duration" for change in arguments.set)
    return scenario if hand is None or told else replace(scenario, duration=None)


def _interactive(scenario: Scenario, hand: Recording | None) -> bool:
    from diagrams.scenario import Interactive

    return hand is None and isinstance(scenario.operator, Interactive)


def _named(scenario: Scenario, hand: Recording | None) -> str:
    """Whose motion it is, in a word."""
    from diagrams.scenario import Recorded, Scripted

    if hand is not None:
        return hand.source
    if isinstance(scenario.operator, Recorded):
        return scenario.operator.file
    return scenario.operator.motion if isinstance(scenario.operator, Scripted) else "sliders"


def _viewer() -> Meshcat:
    """Meshcat, which nobody but this machine can reach."""
    from pydrake.geometry import Meshcat, MeshcatParams

    meshcat = Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    print(f"viewer: {meshcat.web_url()}", file=sys.stderr)
    return meshcat


def _simulate(station: Station, pacing: Pacing | None) -> tuple[float, bool]:
    """Run the station; gives the simulated time [s], and whether Ctrl-C ended it. The recording is complete then too."""
    reached = 0.0
    try:
        with progress(station.scenario.name, station.duration, simulated=True) as show:

            def update(now: float) -> None:
                nonlocal reached
                reached = now
                show(now)

            station.simulate(progress=update, realtime=pacing is not None, monitor=pacing)
    except KeyboardInterrupt:
        return reached, True
    return reached, False


@contextmanager
def _whole_or_none(native: Path, target: Path | None) -> Iterator[None]:
    """Leaves no part of a recording behind when the run fails."""
    try:
        yield
    except BadInput as error:
        native.unlink(missing_ok=True)
        if str(error.source) == str(native):
            where = target or native.parent
            raise BadInput(where, found=error.found, expected="room for the recording; its beginning is removed") from error
        raise


T = TypeVar("T")


def _tried(compute: Callable[[], T]) -> T | BadInput:
    """The result, or what stands against it."""
    try:
        return compute()
    except BadInput as error:
        return error


def _why(reason: BadInput) -> str:
    return f"found {reason.found}, expected {reason.expected}"
