"""`mmt-drake run`: builds the diagram that a scenario describes, runs it, and tells what came of it."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from mmt_drake.cli import hardware, two_sides
from mmt_drake.cli.main import INTERRUPTED
from mmt_drake.cli.options import reading
from mmt_drake.cli.output import RunFigure, print_json, say
from mmt_drake.cli.progress import progress, working
from mmt_drake.cli.run_options import SLIDERS
from mmt_drake.cli.run_summary import RunScores, RunSummary, further, tried
from mmt_drake.errors import BadInput
from mmt_drake.realtime import Pace, ProcessOptions, real_time_process
from mmt_drake.recording import Recording, load, save
from mmt_drake.recording.atomic import beside
from mmt_drake.recording.files import check_target, kept_as_recorded, native_of
from mmt_drake.recording.mcap_writer import McapWriter, whole_or_none

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.scenario import Scenario
    from mmt_drake.diagrams.stations.station import Station
    from mmt_drake.numeric.arrays import Array
    from mmt_drake.viewer.viewer import Viewer


def run(arguments: argparse.Namespace) -> int:
    """Run a scenario."""
    from mmt_drake.diagrams.stations.hands import Interactive
    from mmt_drake.diagrams.stations.scenario import operator_name
    from mmt_drake.diagrams.stations.station import build_station, worth_spreading
    from mmt_drake.effects import register_file

    for file in arguments.effects:
        register_file(file)
    target = None if arguments.record is None else Path(arguments.record)
    if target is not None:
        check_target(target)
        beside(target)
    replayed = _replayed(arguments)
    scenario = _scenario(arguments, replayed)
    looser = hardware.loosened_limits(arguments, scenario)
    sliders = replayed is None and isinstance(scenario.operator, Interactive) and not arguments.hardware
    paced = arguments.realtime or arguments.hardware or sliders
    pace = Pace() if paced else None
    process = _process(arguments, paced)
    with TemporaryDirectory(prefix="mmt-drake-") as folder, ExitStack() as opened:
        console = opened.enter_context(hardware.Console())
        known = not arguments.hardware and arguments.side != "operator" and scenario.several is None
        truth = scenario.environment.object.theta() if known else None  # of several it is now one's, now another's
        meshcat = opened.enter_context(
            _viewer(arguments.meshcat, arguments.port, needed=sliders, notices=looser, truth=truth)
        )
        native = native_of(target, folder)
        whole = arguments.side is None
        devices = hardware.open_devices(opened, arguments, scenario)
        hand, arm = devices.hand, devices.arm
        spread = not paced and worth_spreading(scenario, None)
        build = partial(build_station, spread=spread) if whole else two_sides.builder(arguments)
        with working(f"{scenario.name}: getting ready (a first run compiles for minutes)"):
            station = build(
                scenario,
                record=native,
                operator=replayed,
                meshcat=meshcat,
                worker=paced,  # in real time, what takes long is done beside the clock
                devices=devices,
                pace=pace,
                tell=console.tell,
                command=arguments.command_line,
            )
        assert station.recorder is not None  # it was asked for
        file = station.recorder.file
        start = time.perf_counter()
        switched = hand or arm
        with (
            whole_or_none(file, target or Path(folder)),
            nullcontext() if switched is None else console.switching(switched),
        ):
            simulated, interrupted, held = _simulate(station, pace, process)
        wall = time.perf_counter() - start
        recording = tried(lambda: _read_back(file, forces=arguments.side != "operator"))
        kept = None if target is None else file.path if target == native else target
        if target is not None and target != native:
            if isinstance(recording, BadInput):
                raise kept_as_recorded(recording, native, target)
            save(recording, target)
        if interrupted:
            say(f"mmt-drake: interrupted after {simulated:g} s; {kept or 'nothing'} is kept", stderr=True)
            return INTERRUPTED
        scores = RunScores.of(recording if whole else two_sides.apart(native))
        more: dict[str, RunFigure] = {}
        if not isinstance(recording, BadInput):
            if not whole:
                more["link"] = two_sides.figure(station, recording)
            if hand is not None:
                more["device"] = hardware.hand_figure(recording, hand)
            if arm is not None:
                more["arm"] = hardware.arm_figure(recording, arm)
            more |= further(recording)
    summary = RunSummary(
        scenario=scenario,
        operator=operator_name(scenario, replayed) if hand is None else hand.name,
        simulated_s=simulated,
        wall_s=wall,
        pacing=pace,
        process=held,
        scores=scores,
        recording=None if kept is None else str(kept),
        figures=more,
        gaps=station.recorder.dropped,
    )
    if arguments.json:
        print_json(summary.to_json())
    else:
        say("\n".join(summary.lines()))
    if station.recorder.trouble is not None:
        raise station.recorder.trouble  # last: all else has been printed
    return 0


@contextmanager
def _viewer(
    wanted: bool, port: int | None, *, needed: bool, notices: Sequence[str] = (), truth: Array | None = None
) -> Iterator[Viewer | None]:
    """The live view of the run, with a line that says where it is, and at the end one of the requests dropped.

    None if none is wanted, or none can be had.

    Args:
        wanted: whether it is.
        port: to be found at; None: any.
        needed: by the sliders of a hand.
        notices: what whoever looks has to know from the first moment on.
        truth: (10) theta of the object that is simulated.

    Raises:
        BadInput: none can be had although it is needed, for the sliders of a hand; a port for none.
    """
    if not wanted and port is not None:
        raise BadInput("--port", found="no --meshcat", expected="--meshcat beside it")
    if not wanted:
        yield None
        return
    from mmt_drake.model.parameters import THETA
    from mmt_drake.viewer.charts import page, station_panels
    from mmt_drake.viewer.viewer import Viewer

    known = None if truth is None else dict(zip(THETA, map(float, truth), strict=True))
    try:
        shown = Viewer(page(notices, station_panels(known)), port or 0)
    except BadInput as error:
        if needed or port is not None:
            raise
        say(f"viewer: none, the run goes on without; {error}", stderr=True)
        yield None
        return
    with shown:
        say(f"viewer: {shown.url}", stderr=True)
        yield shown
    if shown.refused:
        why = ", ".join(f"{count} x {reason}" for reason, count in sorted(shown.refused.items()))
        say(f"viewer: dropped what was not of its page: {why}", stderr=True)


def _read_back(file: McapWriter, *, forces: bool) -> Recording:
    """The recording that was made.

    Raises:
        BadInput: it cannot be read; or what stands there now is another run's.
    """
    recording = load(file.path, forces=forces)
    if not file.stands:
        raise BadInput(file.path, found="the recording of another run", expected="that of this one")
    return recording


def _replayed(arguments: argparse.Namespace) -> Recording | None:
    """The recording to replay, if one was asked for."""
    from mmt_drake.diagrams.stations.hands import load_operator

    if arguments.operator in (None, SLIDERS):
        for option, what in (("topic", "a bag whose topics it names"), ("map", "a file whose columns it names")):
            if getattr(arguments, option):
                found = f"--operator {SLIDERS}" if arguments.operator else "no --operator"
                raise BadInput(f"--{option}", found=found, expected=what)
        return None
    told = arguments.topic or arguments.map or arguments.axis
    if told:
        return load(arguments.operator, **reading(arguments), forces=False)
    return load_operator(arguments.operator)


def _scenario(arguments: argparse.Namespace, replayed: Recording | None) -> Scenario:
    """The scenario with everything that the command line changes in it."""
    from mmt_drake.diagrams.stations.hands import Interactive
    from mmt_drake.diagrams.stations.scenario import load_scenario

    own = {"estimator": "OwnEstimator", "renderer": "OwnRenderer"}
    named = ((part, kind, getattr(arguments, part)) for part, kind in own.items())
    parts = [f"{part}=!{kind} {{code: {json.dumps(code)}}}" for part, kind, code in named if code is not None]
    changes = [*arguments.set, *parts]
    scenario = load_scenario(arguments.scenario, changes, trust_library=arguments.trust_library)
    if arguments.operator == SLIDERS and not isinstance(scenario.operator, Interactive):
        scenario = replace(scenario, operator=Interactive())
    if arguments.seed is not None:
        scenario = replace(scenario, seed=arguments.seed)
    if arguments.seconds is not None:
        return replace(scenario, duration=arguments.seconds)
    fixed = any(change.partition("=")[0] == "duration" for change in arguments.set)
    return scenario if replayed is None or fixed else replace(scenario, duration=None)


def _process(arguments: argparse.Namespace, paced: bool) -> ProcessOptions:
    """The options of the process that the run asks of the system to be on time."""
    for option in ("priority", "cpu", "lock_memory"):
        value = getattr(arguments, option)
        if value is not None and value is not False and not paced:
            raise BadInput(f"--{option.replace('_', '-')}", found="no --realtime", expected="--realtime beside it")
    return ProcessOptions(arguments.priority, arguments.cpu, arguments.lock_memory)


def _simulate(station: Station, pace: Pace | None, process: ProcessOptions) -> tuple[float, bool, list[str]]:
    """Run the station and complete its recording.

    Returns:
        The simulated time [s], whether Ctrl-C ended it, and what was asked of the system to be on time.
    """
    reached, held = 0.0, list[str]()

    def note() -> str:
        return "" if pace is None else f", {pace.live()}"

    try:
        ready = real_time_process(process) if pace is not None else nullcontext(held)
        # The bar's thread begins before this one has a priority and a processor, which it would take over.
        with progress(station.scenario.name, station.duration, simulated=True, note=note) as show, ready as held:

            def update(now: float) -> None:
                nonlocal reached
                reached = now
                show(now)

            station.simulate(progress=update, pace=pace)
    except KeyboardInterrupt:
        return reached, True, held
    return reached, False, held
