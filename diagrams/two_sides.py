"""A scenario on two machines: the operator's side and the telerobot's side, a diagram each, and a link between.

The parts are those of `diagrams.station`; a network that the scenario simulates stays where its packets are sent,
before the real one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import Demultiplexer, Multiplexer

from diagrams.scenario import Scenario
from diagrams.station import Station, station_parts
from hw.link.link import Link
from hw.link.options import OPERATOR, TELEROBOT, Role, Signal
from hw.link.systems import CloudFromLink, CloudToLink, LinkEnd
from mmt_drake.errors import BadInput
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording
from mmt_drake.systems.recorder import McapRecorder

_PARTS = {
    "operator", "to_telerobot", "environment", "detector", "estimator", "to_operator", "renderer", "clouds_to_operator",
}  # fmt: skip
_FLAGS = 2  # stable and in_contact, behind theta

OpenLink = Callable[[Role, Mapping[Role, Signal], str], Link]
"""Makes a link from a role, what each role sends, and what else both sides must agree on."""

_Columns = list[tuple[OutputPort, tuple[str, ...]]]


@dataclass(frozen=True)
class Side(Station):
    """One side of a scenario, built.

    Attributes:
        link: to the other side.
        wait: for the other side before the clock starts [s]; None: do not wait.
    """

    link: Link
    wait: float | None

    def simulate(
        self,
        seconds: float | None = None,
        *,
        progress: Callable[[float], None] | None = None,
        pace: Pace | None = None,
    ) -> Simulator:
        """Wait for the other side, run from time 0 until the end or its goodbye, and close recording and link.

        Raises:
            BadInput: there is no other side, or it runs another scenario.
        """
        with self:
            if self.wait is not None:
                self.link.connect(self.wait)
            return super().simulate(seconds, progress=progress, pace=pace)

    def _ended(self) -> bool:
        return self.link.ended

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.link.close()
        super().__exit__(kind, error, trace)


def build_side(
    scenario: Scenario,
    side: Role,
    open_link: OpenLink,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Meshcat | None = None,
    wait: float | None = None,
) -> Side:
    """Build one side's diagram.

    Its systems keep their names in `build_station`; `link` is the `LinkEnd`. Outputs are the link's `alive` (1) and
    `status` (12), at the operator's side `motion` (6) and `rendered_force` (3), at the telerobot's `measurement` (9).

    Args:
        scenario: the same on both sides.
        side: which one.
        open_link: makes the link.
        record: file for this side's recording, `.mcap`.
        operator, meshcat: as for `build_station`; of no use at the telerobot's side but for where the hand starts.
        wait: how long to wait for the other side before the run [s].

    Raises:
        BadInput: as `build_station`; or the scenario has a part of which it is not known at which side it belongs.
    """
    parts, duration = station_parts(scenario, operator=operator, meshcat=meshcat)
    unknown = sorted(parts.keys() - _PARTS)
    theta = parts["estimator"].GetOutputPort("theta").size()
    if unknown or parts["to_operator"].GetInputPort("sent").size() != theta + _FLAGS:
        found = ", ".join(unknown) or "a renderer that wants more than theta, stable and in_contact"
        raise BadInput(scenario.name, found=found, expected="a scenario of parts that two sides know how to share")
    signals = _signals(parts["operator"], theta)
    link = open_link(side, signals, f"{scenario.name}, step {scenario.step:g} s")
    try:
        builder = DiagramBuilder()
        other = TELEROBOT if side == OPERATOR else OPERATOR
        end = LinkEnd(link, signals[side], signals[other], scenario.step)
        builder.AddNamedSystem("link", end)
        wire = _wire_operator if side == OPERATOR else _wire_telerobot
        columns = wire(builder, scenario, parts, link, end)
        recorder = None
        if record is not None:
            recorder = _recorder(builder, scenario, record, columns, parts if side == TELEROBOT else {})
        for name in ("alive", "status"):
            builder.ExportOutput(end.GetOutputPort(name), name)
        diagram = builder.Build()
    except BaseException:
        link.close()
        raise
    diagram.set_name(f"{scenario.name}-{side}")
    return Side(scenario, diagram, duration, recorder, link, wait)


def _signals(hand: System, theta: int) -> dict[Role, Signal]:
    """What crosses the link. A lost operator's probe stands still; of a lost telerobot's object nothing is felt."""
    start = hand.GetOutputPort("motion").Eval(hand.CreateDefaultContext())
    keep, zero = np.nan, 0.0
    motion = Signal(
        "motion",
        np.concatenate([start[:3], np.zeros(3)]),
        when_lost=np.array([keep] * 3 + [zero] * 3),
        motion=True,
    )
    model = Signal(
        "model",
        np.zeros(theta + _FLAGS),
        when_lost=np.array([keep] * theta + [zero] * _FLAGS),
        may_be_nan=np.arange(theta + _FLAGS) < theta,
    )
    return {OPERATOR: motion, TELEROBOT: model}


def _wire_operator(
    builder: DiagramBuilder, scenario: Scenario, parts: dict[str, System], link: Link, end: LinkEnd
) -> _Columns:
    hand, network, renderer = (
        builder.AddNamedSystem(name, parts[name]) for name in ("operator", "to_telerobot", "renderer")
    )
    motion = hand.GetOutputPort("motion")
    builder.Connect(motion, network.GetInputPort("sent"))
    builder.Connect(network.GetOutputPort("received"), end.GetInputPort("sent"))
    sizes = [renderer.GetInputPort("theta").size(), 1, 1]
    theta, stable, detected = _split(builder, end.GetOutputPort("received"), sizes)
    for port, name in ((motion, "motion"), (theta, "theta"), (stable, "stable"), (detected, "in_contact")):
        builder.Connect(port, renderer.GetInputPort(name))
    if "clouds_to_operator" in parts:
        clouds = builder.AddNamedSystem("clouds", CloudFromLink(link, 1.0 / scenario.environment.cloud.rate))
        builder.Connect(clouds.GetOutputPort("received"), renderer.GetInputPort("point_cloud"))
    rendered = renderer.GetOutputPort("force")
    builder.Connect(rendered, hand.GetInputPort("force"))
    if hand.HasInputPort("ages"):  # a supervised device that watches its peer
        builder.Connect(end.GetOutputPort("age"), hand.GetInputPort("ages"))
    builder.ExportOutput(motion, "motion")
    builder.ExportOutput(rendered, "rendered_force")
    return [
        (motion, ("master_position", "master_velocity")),
        (motion, ("position", "velocity")),  # the only probe that is known here is the one in the local model
        (detected, ("detected_contact",)),
        (theta, ("theta",)),
        (stable, ("theta_stable",)),
        (rendered, ("rendered_force",)),
    ]


def _wire_telerobot(
    builder: DiagramBuilder, scenario: Scenario, parts: dict[str, System], link: Link, end: LinkEnd
) -> _Columns:
    box, detector, estimator, network = (
        builder.AddNamedSystem(name, parts[name]) for name in ("environment", "detector", "estimator", "to_operator")
    )
    probe = end.GetOutputPort("received")
    builder.Connect(probe, box.GetInputPort("motion"))
    builder.Connect(_split(builder, probe, [3, 3])[0], detector.GetInputPort("position"))
    builder.Connect(box.GetOutputPort("point_cloud"), detector.GetInputPort("point_cloud"))
    measurement, detected = box.GetOutputPort("measurement"), detector.GetOutputPort("in_contact")
    builder.Connect(measurement, estimator.GetInputPort("measurement"))
    builder.Connect(detected, estimator.GetInputPort("in_contact"))
    theta, stable = estimator.GetOutputPort("theta"), estimator.GetOutputPort("stable")
    builder.Connect(_join(builder, (theta, stable, detected)), network.GetInputPort("sent"))
    builder.Connect(network.GetOutputPort("received"), end.GetInputPort("sent"))
    if "clouds_to_operator" in parts:
        clouds = builder.AddNamedSystem("clouds_to_operator", parts["clouds_to_operator"])
        sender = builder.AddNamedSystem("clouds", CloudToLink(link, 1.0 / scenario.environment.cloud.rate))
        builder.Connect(box.GetOutputPort("point_cloud"), clouds.GetInputPort("sent"))
        builder.Connect(clouds.GetOutputPort("received"), sender.GetInputPort("sent"))
    builder.ExportOutput(measurement, "measurement")
    return [
        (measurement, ("position", "velocity", "force")),
        (box.GetOutputPort("force"), ("true_force",)),
        (box.GetOutputPort("in_contact"), ("in_contact",)),
        (detected, ("detected_contact",)),
        (detector.GetOutputPort("proxy"), ("proxy_position",)),
        (theta, ("theta",)),
        (stable, ("theta_stable",)),
        (estimator.GetOutputPort("estimated_force"), ("estimated_force",)),
        (estimator.GetOutputPort("filtered_force"), ("filtered_force",)),
    ]


def _recorder(
    builder: DiagramBuilder, scenario: Scenario, path: str | Path, signals: _Columns, parts: Mapping[str, System]
) -> McapRecorder:
    """Records the signals, and the surface where there is an environment among the parts."""
    columns = [(name, port.size() // len(names)) for port, names in signals for name in names]
    recorder = McapRecorder(path, columns, scenario.step, scenario.clouds if parts else "none")
    builder.AddNamedSystem("recorder", recorder)
    builder.Connect(_join(builder, tuple(port for port, _ in signals)), recorder.GetInputPort("signals"))
    if parts:
        surface = parts["environment"].GetOutputPort("point_cloud")
        builder.Connect(surface, recorder.GetInputPort("point_cloud"))
    return recorder


def _split(builder: DiagramBuilder, port: OutputPort, sizes: list[int]) -> list[OutputPort]:
    parts: System = builder.AddSystem(Demultiplexer(sizes))
    builder.Connect(port, parts.get_input_port(0))
    return [parts.get_output_port(i) for i in range(len(sizes))]


def _join(builder: DiagramBuilder, ports: tuple[OutputPort, ...]) -> OutputPort:
    whole = builder.AddSystem(Multiplexer([port.size() for port in ports]))
    for i, port in enumerate(ports):
        builder.Connect(port, whole.get_input_port(i))
    return whole.get_output_port(0)
