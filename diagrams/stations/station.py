"""The one door: a scenario in, a Drake diagram out."""

import json
from collections.abc import Callable, Container, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Self

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, System

from mmt_drake import __version__
from mmt_drake.analysis.objects_touched import THINGS
from mmt_drake.ceilings import Option, loosened_constants
from mmt_drake.closing import Closing, close_all
from mmt_drake.diagrams.stations.estimators import OwnEstimator
from mmt_drake.diagrams.stations.nets import Nets, Tap, shown_first
from mmt_drake.diagrams.stations.own_parts import Make
from mmt_drake.diagrams.stations.parts import late
from mmt_drake.diagrams.stations.renderers import OwnRenderer
from mmt_drake.diagrams.stations.returned import RETURNED, returned
from mmt_drake.diagrams.stations.scenario import Scenario, loosened, operator_name
from mmt_drake.diagrams.stations.site import Devices, Site
from mmt_drake.diagrams.stations.surfaces import SimulatedDepthCamera
from mmt_drake.diagrams.stations.table import (
    AGES,
    NETS,
    OF_THE_MEASUREMENT,
    OUTPUTS,
    PARTS,
    READS,
    RECORDED,
    SHOWN_BEFORE,
)
from mmt_drake.errors import BadInput
from mmt_drake.network.parameters import usual_delay
from mmt_drake.own_code import own_code_named
from mmt_drake.processors import processors
from mmt_drake.realtime import Pace, advance_paced, warm
from mmt_drake.recording import Recording
from mmt_drake.recording.two_recordings import DELAY
from mmt_drake.systems.leaf import LeafSystem
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.recorder import McapRecorder
from mmt_drake.viewer.viewer import Viewer

_LONG = 20.0  # [s]: processes take a second or two to begin


@dataclass(frozen=True)
class Station:
    """A scenario, built.

    Every part can be fetched from the diagram by its name in `mmt_drake.diagrams.stations.table.PARTS`, and `recorder`.

    Attributes:
        scenario: what it was built from.
        diagram: the wired diagram; its outputs are `motion` (6), `measurement` (9), `theta` (10), `stable` (1),
            `in_contact` (1; not of a real object) and `rendered_force` (3).
        duration: of a run by default [s].
        recorder: writes the recording, if there is one.
        devices: in place of what would simulate them.
        begun: processes that work for it.
    """

    scenario: Scenario
    diagram: Diagram
    duration: float
    recorder: McapRecorder | None
    devices: Devices
    begun: Sequence[Closing] = field(default=(), kw_only=True)

    def simulate(
        self, seconds: float | None = None, *, progress: Callable[[float], None] | None = None, pace: Pace | None = None
    ) -> Simulator:
        """Run from time 0, bring devices to rest and close the recording.

        Args:
            seconds: how long; the scenario's duration by default.
            progress: called now and then with the simulation time [s].
            pace: keep to the wall clock, and take every tick down here.

        Raises:
            BadInput: what a part refuses; a part from a person's file raises.
        """
        simulator = Simulator(self.diagram)
        end = self.duration if seconds is None else seconds
        with self, own_code_named():
            simulator.Initialize()
            if pace is not None:
                warm(simulator)
                advance_paced(simulator, end, self.scenario.step, pace, ended=self._ended, progress=progress)
                return simulator
            while simulator.get_context().get_time() < end and not self._ended():
                # Slices keep the progress bar and Ctrl-C alive; the steps within are the same.
                simulator.AdvanceTo(min(end, simulator.get_context().get_time() + 0.5))
                if progress is not None:
                    progress(simulator.get_context().get_time())
        return simulator

    def _ended(self) -> bool:
        """Whether the run is over before its time."""
        return False

    def _close_parts(self) -> None:
        close_all(self.begun)
        for system in self.diagram.GetSystems():
            if isinstance(system, Closing) and system is not self.recorder:
                system.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None = None, *_: object) -> None:
        with ExitStack() as closing:  # from the last to the first, whatever becomes of one of them
            if self.recorder is not None:  # a person may end a run; an error leaves an older recording as it was
                closing.callback(self.recorder.close, whole=kind in (None, KeyboardInterrupt))
            closing.callback(self._close_parts)
            closing.callback(self.devices.close)  # nothing moves, and no force stays on, while a file is completed


def build_station(
    scenario: Scenario,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Viewer | None = None,
    worker: bool = False,
    spread: bool = False,
    devices: Devices = Devices(),
    pace: Pace | None = None,
    tell: Callable[[str], None] | None = None,
    estimator: str | Make | None = None,
    renderer: str | Make | None = None,
    command: str = "",
) -> Station:
    """Build the diagram that a scenario describes.

    Args:
        scenario: what to build.
        record: file for the recording, `.mcap`; none is made by default.
        operator: replaces the scenario's hand by this recording's motion, placed automatically.
        meshcat: shows the run, and has the sliders of an interactive hand.
        worker, spread: let what takes long have processes of its own, in real time or by simulated time (`Site`).
        devices: in place of what the scenario simulates: a camera where the scenario names a real one, an arm for
            telerobot and environment; it is moved by a hand on a device alone.
        pace: of the run to come, to be recorded.
        tell: called with a line for a person whenever the supervisor of a device has something new, and when a
            recording in real time ends early or has a gap.
        estimator, renderer: a person's own in the place of the scenario's: a class, or `my.py:MyEstimator`, called with
            `period` [s] (`mmt_drake.diagrams.stations.own_parts`).
        command: that asked for the run; stands in the recording (`Recording.made_by`).

    Raises:
        BadInput: something that the scenario names cannot be read or built; an own part lacks a port.
    """
    if estimator is not None:
        scenario = replace(scenario, estimator=OwnEstimator.of(estimator))
    if renderer is not None:
        scenario = replace(scenario, renderer=OwnRenderer.of(renderer))
    if devices.arm is not None and devices.hand is None:
        raise BadInput(scenario.name, found="an arm", expected="a hand on a device to move it, with its switches")
    site = Site(scenario, operator, meshcat, worker, devices, pace, tell, spread=spread)
    builder = DiagramBuilder()
    with ExitStack() as refused:
        refused.callback(site.close)
        recorder = wire(builder, site, build_parts(site), record, command=command)
        diagram = built(builder, scenario.name)
        refused.pop_all()
    return Station(scenario, diagram, site.duration, recorder, devices, begun=site.begun)


def built(builder: DiagramBuilder, name: str) -> Diagram:
    """The diagram of a station, whose parts know what they are connected to."""
    diagram = builder.Build()
    diagram.set_name(name)
    for system, index in diagram.connection_map():
        if isinstance(system, LeafSystem):
            system.take_as_connected(system.get_input_port(int(index)))
    return diagram


def worth_spreading(scenario: Scenario, seconds: float | None) -> bool:
    """Whether a run by simulated time is sooner done with processes of its own for what takes long."""
    long = (scenario.duration or 0.0) if seconds is None else seconds
    camera = isinstance(getattr(scenario.environment, "cloud", None), SimulatedDepthCamera)
    return camera and long >= _LONG and processors() > 1


def build_parts(site: Site) -> dict[str, System]:
    """The systems of a station by name, not yet wired.

    Raises:
        BadInput: as `build_station`.
    """
    _ = site.person, site.surface  # first: what these refuse has a place of its own in the scenario
    for part in PARTS:
        with site.refusals_named(part.name):
            system = part.build(site)
        if system is not None:
            site.parts[part.name] = system
    return site.parts


def reading(names: Container[str]) -> dict[str, str]:
    """What the parts of these names read: input port -> net."""
    return {port: net for port, net in READS.items() if port.partition(".")[0] in names}


def station_nets(site: Site, parts: Mapping[str, System], over: Mapping[str, Tap] | None = None) -> Nets:
    """The nets among those parts of a station that are here; `over` as for `wire`."""
    back = returned(site.scenario)
    joined = {
        "returned": " + ".join(RETURNED[name].net for name in back),
        "watched": " + ".join(AGES[name] for name in site.devices.watched if name in AGES),
    }
    return Nets(parts, NETS | joined, {"to_operator": back}, over or {})


def wire(
    builder: DiagramBuilder,
    site: Site,
    parts: Mapping[str, System],
    record: str | Path | None,
    *,
    over: Mapping[str, Tap] | None = None,
    reads: Mapping[str, str] = MappingProxyType({}),
    looser_link: tuple[Option, ...] = (),
    command: str = "",
) -> McapRecorder | None:
    """Add parts to a diagram and connect them, with their recorder, if there is to be one.

    Args:
        builder: of the diagram.
        site: of the station.
        parts: those that are here.
        record: file for the recording.
        over: ports of parts that are not here -> what shows them here.
        reads: what parts beside those of the table read.
        looser_link: limits of a link that are looser than shipped; those of the scenario are known.
        command: that asked for the run, to be recorded.
    """
    parts = dict(parts)
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    nets = station_nets(site, parts, over)
    all_reads = reading(parts) | dict(reads)
    recorder = None
    if record is not None:
        signals = {name: (net, tap.size) for name, net in RECORDED.items() if (tap := nets.tap(net)) is not None}
        if "compensation" in parts:
            beside = {name: size for name, (_, size) in signals.items() if name not in OF_THE_MEASUREMENT}
            nets.packets["beside"] = beside
            parts["beside"] = builder.AddNamedSystem("beside", _beside(site, nets, beside))
            all_reads["beside.sent"] = " + ".join(signals[name][0] for name in beside)
            signals |= {name: (f"beside.{name}", size) for name, size in beside.items()}
        clouds = site.scenario.clouds if nets.tap("surface") else "none"
        columns = [(name, size) for name, (_, size) in signals.items()]
        live = site.pace is not None or site.devices.hand is not None or site.devices.arm is not None
        recorder = McapRecorder(
            record,
            columns,
            site.step,
            clouds,
            realtime=live,
            tell=site.tell,
            constants=loosened_constants(loosened(site.scenario) + looser_link),
            made_by=made_by(site, command),
        )
        parts["recorder"] = builder.AddNamedSystem("recorder", recorder)
        all_reads["recorder.signals"] = " + ".join(net for net, _ in signals.values())
        all_reads["recorder.point_cloud"] = "surface"
    nets.connect(builder, all_reads, OUTPUTS)
    return recorder


def made_by(site: Site, command: str = "") -> dict[str, str]:
    """How a recording of this station is made, for `Recording.made_by`."""
    scenario = site.scenario
    words = {
        "version": __version__,
        "scenario": scenario.name,
        "seed": str(scenario.seed),
        "step_s": f"{scenario.step:g}",
        "operator": operator_name(scenario, site.operator) if site.devices.hand is None else site.devices.hand.name,
        DELAY: f"{usual_delay(scenario.to_telerobot, scenario.step):g}",
    }
    words |= {"side": site.side} if site.side is not None else {}
    words |= {THINGS: json.dumps(list(scenario.several.things))} if scenario.several is not None else {}
    return words | ({"command": command} if command else {})


def _beside(site: Site, nets: Nets, sizes: Mapping[str, int]) -> System:
    """What keeps signals until the measurement of their instant has come."""
    before = []
    for name, size in sizes.items():
        tap = nets.tap(SHOWN_BEFORE[name]) if name in SHOWN_BEFORE else None
        shown = np.zeros(size)
        if tap is not None:
            shown = shown_first(nets.parts[tap.part], tap.port)[tap.start : tap.start + tap.size]
        before.append(shown)
    return network_channel(late(site), sum(sizes.values()), site.step, initial=np.concatenate(before))
