"""What becomes of a station's signals in its recording: columns, and rows of one instant."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from mmt_drake.ceilings import Option, loosened_constants
from mmt_drake.diagrams.ports import join, shown_first, split
from mmt_drake.diagrams.scenario import Scenario, loosened
from mmt_drake.diagrams.station_live import Columns
from mmt_drake.diagrams.station_return import Ports, knows_held_body
from mmt_drake.diagrams.telerobots import rests_at
from mmt_drake.network.config import ChannelConfig
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.recorder import McapRecorder

_ESTIMATED = {
    "theta": "theta",
    "stable": "theta_stable",
    "estimated_force": "estimated_force",
    "filtered_force": "filtered_force",
    "deviation": "theta_deviation",
    "status": "estimator_status",
    "held_body": "held_body",
}
"""Ports of estimators -> columns."""

RETURNED = {"theta": "theta", "stable": "theta_stable", "in_contact": "detected_contact", "held_body": "held_body"}
"""The same of what crosses the network to the operator."""

# What a telerobot measures comes late through its compensation, and with it whatever is made of it.
_OF_THE_MEASUREMENT = ("position", "detected_contact", "theta", "estimat", "filtered_force", "held_body")


def estimator_columns(scenario: Scenario, ports: Ports) -> Columns:
    """What an estimator tells: ports by their names, as `wire_estimator` gives them, and the columns of each."""
    unknown = () if knows_held_body(scenario) else ("held_body",)
    return tuple((ports[port], (name,)) for port, name in _ESTIMATED.items() if port in ports and port not in unknown)


def wire_recorder(
    builder: DiagramBuilder,
    scenario: Scenario,
    path: str | Path,
    parts: Mapping[str, System],
    signals: Columns,
    *,
    live: Columns,
    surface: OutputPort | None,
    tell: Callable[[str], None] | None,
    looser_link: tuple[Option, ...] = (),
) -> McapRecorder:
    """Add a recorder, called `recorder`, to a diagram that is being built.

    Args:
        builder: of the diagram, with all parts in it.
        scenario: that it is built from.
        path: of the file.
        parts: the station's that are here, by name.
        signals: what is recorded.
        live: and what a run in real time tells beside; empty of any other.
        surface: the cloud; None where it is not known.
        tell: as `McapRecorder` has it.
        looser_link: limits of a link that are looser than shipped; those of the scenario are known.
    """
    signals += live
    if "compensation" in parts:
        signals = _of_one_instant(builder, scenario.step, parts, signals)
    columns = [(name, port.size() // len(names)) for port, names in signals for name in names]
    clouds = "none" if surface is None else scenario.clouds
    constants = loosened_constants(loosened(scenario) + looser_link)
    recorder = McapRecorder(path, columns, scenario.step, clouds, realtime=bool(live), tell=tell, constants=constants)
    builder.AddNamedSystem("recorder", recorder)
    builder.Connect(join(builder, tuple(port for port, _ in signals)), recorder.GetInputPort("signals"))
    if surface is not None:
        builder.Connect(surface, recorder.GetInputPort("point_cloud"))
    return recorder


def _of_one_instant(builder: DiagramBuilder, step: float, parts: Mapping[str, System], signals: Columns) -> Columns:
    """The signals of a station whose measurement comes late: the others wait for it."""
    waiting = tuple((port, names) for port, names in signals if not names[0].startswith(_OF_THE_MEASUREMENT))
    shown = _before(parts)
    before = [shown.get(names[0], np.zeros(port.size())) for port, names in waiting]
    late = ChannelConfig(delay=parts["compensation"].ticks_late * step)
    sizes = tuple(port.size() for port, _ in waiting)
    beside = builder.AddNamedSystem("beside", network_channel(late, sum(sizes), step, initial=np.concatenate(before)))
    builder.Connect(join(builder, tuple(port for port, _ in waiting)), beside.GetInputPort("sent"))
    left = iter(split(builder, beside.GetOutputPort("received"), sizes))
    return tuple((port if names[0].startswith(_OF_THE_MEASUREMENT) else next(left), names) for port, names in signals)


def _before(parts: Mapping[str, System]) -> dict[str, NDArray[np.float64]]:
    """What is shown before a run, by the first name of a port's columns; zeros are left out."""
    arm = parts["arm"]
    before = {"proxy_position": rests_at(arm)}
    if "operator" in parts:
        before["master_position"] = shown_first(parts["operator"], "motion")
    if "camera" in parts:
        before["camera_fault"] = shown_first(parts["camera"], "camera")[:1]
    if arm.HasOutputPort("device"):
        fault, _, waits = shown_first(arm, "device")
        before |= {"telerobot_fault": np.array([fault]), "telerobot_waits": np.array([waits])}
    return before
