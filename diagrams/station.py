"""The one door: a scenario in, a Drake diagram out."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from mmt_drake.diagrams.devices import Devices
from mmt_drake.diagrams.ports import split
from mmt_drake.diagrams.scenario import Scenario
from mmt_drake.diagrams.station_cloud import camera_columns, cloud_port, wire_camera
from mmt_drake.diagrams.station_live import Columns, live_signals, wire_devices
from mmt_drake.diagrams.station_parts import station_parts
from mmt_drake.diagrams.station_person import load_operator
from mmt_drake.diagrams.station_record import estimator_columns, wire_recorder
from mmt_drake.diagrams.station_return import wire_return, wire_stamps
from mmt_drake.diagrams.telerobots import wire_estimator, wire_remote
from mmt_drake.errors import BadInput
from mmt_drake.realtime import Pace, advance_paced, warm
from mmt_drake.recording import Recording
from mmt_drake.rendering import impedance
from mmt_drake.systems.recorder import McapRecorder
from mmt_drake.viewer.viewer import Viewer

__all__ = ["Station", "build_station", "load_operator", "station_parts"]


@dataclass(frozen=True)
class Station:
    """A scenario, built.

    Every part can be fetched from the diagram by name: `operator`, `to_telerobot`, `environment`, `detector`,
    `estimator`, `to_operator`, `renderer`, `recorder`, and where the scenario asks for them `camera`,
    `operator_detector`, `clouds_to_operator`, `stamps_to_telerobot`, `high_band`, `telerobot` and
    `energy_to_telerobot` (the other end of a passivity control), `arm` and `compensation` (what holds the probe, and
    clears its force of it).

    Attributes:
        scenario: what it was built from.
        diagram: the wired diagram; its outputs are `motion` (6), `measurement` (9), `theta` (10), `stable` (1),
            `in_contact` (1; not of a real object) and `rendered_force` (3).
        duration: of a run unless told otherwise [s].
        recorder: writes the recording, if there is one.
        devices: in place of what would simulate them.
    """

    scenario: Scenario
    diagram: Diagram
    duration: float
    recorder: McapRecorder | None
    devices: Devices

    def simulate(
        self,
        seconds: float | None = None,
        *,
        progress: Callable[[float], None] | None = None,
        pace: Pace | None = None,
    ) -> Simulator:
        """Run from time 0, bring devices to rest and close the recording.

        Args:
            seconds: how long; the scenario's duration by default.
            progress: called now and then with the simulation time [s].
            pace: keep to the wall clock, and take every tick down here.
        """
        simulator = Simulator(self.diagram)
        end = self.duration if seconds is None else seconds
        with self:
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

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None = None, *_: object) -> None:
        with ExitStack() as closing:  # from the last to the first, whatever becomes of one of them
            if self.recorder is not None:  # a person may end a run; an error leaves an older recording as it was
                closing.callback(self.recorder.close, whole=kind in (None, KeyboardInterrupt))
            closing.callback(self.devices.close)  # nothing moves, and no force stays on, while a file is completed


def build_station(
    scenario: Scenario,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Viewer | None = None,
    worker: bool = False,
    devices: Devices = Devices(),
    pace: Pace | None = None,
    tell: Callable[[str], None] | None = None,
) -> Station:
    """Build the diagram that a scenario describes.

    Args:
        scenario: what to build.
        record: file for the recording, `.mcap`; none is made by default.
        operator: replaces the scenario's hand by this recording's motion, placed automatically.
        meshcat: shows the run, and has the sliders of an interactive hand.
        worker: let an estimator that can do so work beside the clock, for a run in real time.
        devices: in place of what the scenario simulates: a camera where the scenario names a real one, an arm for
            telerobot and environment; it is moved by a hand on a device alone.
        pace: of the run to come, to be recorded.
        tell: called with a line for a person whenever the supervisor of a device has something new, and when a
            recording in real time ends early or has a gap.

    Raises:
        BadInput: something that the scenario names cannot be read or built.
    """
    parts, duration = station_parts(scenario, operator=operator, meshcat=meshcat, worker=worker, devices=devices)
    hand, arm = devices.hand, devices.arm
    builder = DiagramBuilder()
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    renderer = parts["renderer"]

    motion = parts["operator"].GetOutputPort("motion")
    builder.Connect(motion, parts["to_telerobot"].GetInputPort("sent"))
    probe = parts["to_telerobot"].GetOutputPort("received")
    if "telerobot" in parts:
        builder.Connect(probe, parts["telerobot"].GetInputPort("commanded"))
        probe = parts["telerobot"].GetOutputPort("motion")
    pulls = None if arm is not None or scenario.telerobot is None else scenario.telerobot.impedance
    wire_camera(builder, parts)
    surface = cloud_port(scenario, parts)
    remote = wire_remote(builder, parts, probe, surface, pulls)
    measurement = remote.measurement

    told = wire_estimator(builder, remote, parts["estimator"])
    theta, stable = told["theta"], told["stable"]
    sent = parts.get("stamps_to_telerobot")
    wire_stamps(builder, scenario, parts, None if sent is None else sent.GetOutputPort("received"))

    felt = motion
    if "to_renderer" in parts:
        builder.Connect(motion, parts["to_renderer"].GetInputPort("sent"))
        felt = parts["to_renderer"].GetOutputPort("received")
    wire_return(
        builder,
        scenario,
        parts,
        {
            **told,
            "motion": felt,
            "measurement": measurement,
            "point_cloud": surface,
            "in_contact": remote.detected,
            "measured_contact": remote.in_contact,
        },
    )
    rendered = renderer.GetOutputPort("force")
    if renderer.HasOutputPort("stored_energy"):
        readout = renderer.GetOutputPort("readout")
        rendered, status, jump, stored = split(builder, readout, tuple(impedance.PORT_SIZES.values()))
    builder.Connect(rendered, parts["operator"].GetInputPort("force"))
    if arm is not None and hand is None:
        raise BadInput(scenario.name, found="an arm", expected="a hand on a device to move it, with its switches")
    if hand is not None:
        wire_devices(builder, hand, arm, devices.camera)
    live = live_signals(builder, devices, pace, tell)

    recorder = None
    if record is not None:
        # Columns and the ports they come from; some ports carry several signals.
        signals: Columns = (
            (motion, ("master_position", "master_velocity")),
            (measurement, ("position", "velocity", "force")),
            *remote.truth,
            (remote.in_contact, ("detected_contact",)),
            (remote.proxy, ("proxy_position",)),
            *remote.zeroing,
            *estimator_columns(scenario, told),
            (rendered, ("rendered_force",)),
        )
        if renderer.HasOutputPort("stored_energy"):
            signals += ((status, ("renderer_status",)), (jump, ("update_jump",)), (stored, ("stored_energy",)))
        if "operator_detector" in parts:
            signals += ((parts["operator_detector"].GetOutputPort("in_contact"), ("operator_contact",)),)
        signals += camera_columns(builder, parts)
        recorder = wire_recorder(builder, scenario, record, parts, signals, live=live, surface=surface, tell=tell)

    if meshcat is not None:
        from mmt_drake.diagrams.station_view import wire_view

        seen = {"motion": motion, "measurement": measurement, "rendered_force": rendered}
        seen |= {name: port for port, (name, *_) in remote.truth if name == "body_position"}
        seen |= {"theta": theta, "stable": stable, "point_cloud": surface}
        readout = parts["detector"].GetOutputPort("readout")
        wire_view(builder, meshcat, seen, detector=readout, proxy=scenario.detector)

    for port, name in (
        (motion, "motion"),
        (measurement, "measurement"),
        (theta, "theta"),
        (stable, "stable"),
        (rendered, "rendered_force"),
        *((port, name) for port, (name, *_) in remote.truth if name == "in_contact"),
    ):
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name(scenario.name)
    return Station(scenario, diagram, duration, recorder, devices)
