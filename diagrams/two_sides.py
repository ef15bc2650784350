"""A scenario on two machines: the operator's side and the telerobot's side, a diagram each, and a link between.

The parts are those of `station`; a network that the scenario simulates stays where its packets are sent, before the
real one. What crosses the link is what crosses that network, with a stamp of the operator's clock where an
estimator tells with it where friction holds the body.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, System

from mmt_drake.ceilings import Bound, Option, looser_options
from mmt_drake.diagrams.camera_options import DepthCamera
from mmt_drake.diagrams.devices import Devices
from mmt_drake.diagrams.ports import join, shown_first, split
from mmt_drake.diagrams.scenario import Interactive, Scenario
from mmt_drake.diagrams.station import Station, station_parts
from mmt_drake.diagrams.station_cloud import camera_columns, cloud_port, wire_camera
from mmt_drake.diagrams.station_live import Columns, hand_age, live_signals, wire_arm
from mmt_drake.diagrams.station_record import RETURNED, estimator_columns, wire_recorder
from mmt_drake.diagrams.station_return import (
    clock_source,
    returned,
    tells_held_body,
    wire_clouds,
    wire_sent,
    wire_stamps,
)
from mmt_drake.diagrams.telerobots import wire_estimator, wire_remote
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, Role, Signal
from mmt_drake.hw.link.systems import CloudFromLink, CloudToLink, LinkEnd
from mmt_drake.hw.realsense.age import CameraAge
from mmt_drake.hw.safety.rate_limiter import MotionRateLimiter
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording
from mmt_drake.viewer.viewer import Viewer

# What each side is made of, where the scenario has it.
_AT_OPERATOR = (
    *("operator", "to_telerobot", "stamps_to_telerobot", "to_renderer", "renderer"),
    *("operator_detector", "energy_to_telerobot"),
)
_AT_TELEROBOT = (
    *("telerobot", "environment", "camera", "arm", "compensation", "detector", "estimator", "high_band"),
    *("to_operator", "clouds_to_operator"),
)

_KEPT = ("theta", "remote_energy")  # of what comes back, while the telerobot is lost; the rest falls to zero

_CAMERA = "camera_age"

SLIDERS_MOVE_HARDWARE = Option("sliders_move_hardware", Bound(order=("no", "yes")), "yes", "no")
"""What a side tells whose arm follows a hand that can jump."""

OpenLink = Callable[[Role, Mapping[Role, Signal], str], Link]
"""Makes a link from a role, what each role sends, and what else both sides must agree on."""


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

    def __exit__(self, kind: type[BaseException] | None = None, *_: object) -> None:
        try:
            self.link.close()  # first: the other side need not wait for its timeout; it takes no time
        finally:
            super().__exit__(kind)


def build_side(
    scenario: Scenario,
    side: Role,
    open_link: OpenLink,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Viewer | None = None,
    worker: bool = False,
    devices: Devices = Devices(),
    pace: Pace | None = None,
    tell: Callable[[str], None] | None = None,
    wait: float | None = None,
    sliders_move_hardware: bool = False,
) -> Side:
    """Build one side's diagram.

    Its systems keep their names in `build_station`; `link` is the `LinkEnd`. Outputs are the link's `alive` (1) and
    `status` (12), at the operator's side `motion` (6) and `rendered_force` (3), at the telerobot's `measurement` (9).

    Args:
        scenario: the same on both sides.
        side: which one.
        open_link: makes the link.
        record: file for this side's recording, `.mcap`.
        operator: as for `build_station`; of no use at the telerobot's side but for where the hand starts.
        meshcat: as for `build_station`, which shows what is known at this side.
        worker, pace, tell: as for `build_station`.
        devices: likewise; the operator's side has the hand, which watches the ages of `peer` and, where there is one,
            `camera`, the telerobot's the camera, and an arm with switches of its own.
        wait: how long to wait for the other side before the run [s].
        sliders_move_hardware: an arm here follows a hand on sliders too, slowly (`MotionRateLimiter`); else the link
            takes no such peer.

    Raises:
        BadInput: as `build_station`.
    """
    everything, duration = station_parts(scenario, operator=operator, meshcat=meshcat, worker=worker, devices=devices)
    on_sliders = devices.hand is None and operator is None and isinstance(scenario.operator, Interactive)
    jumps = on_sliders if side == OPERATOR else devices.arm is None or sliders_move_hardware
    signals = _signals(scenario, everything, jumps)
    here = _AT_OPERATOR if side == OPERATOR else _AT_TELEROBOT
    link = open_link(side, signals, f"{scenario.name}, step {scenario.step:g} s")
    try:
        builder = DiagramBuilder()
        other = TELEROBOT if side == OPERATOR else OPERATOR
        end = LinkEnd(link, signals[side], signals[other], scenario.step, aged=devices.hand is not None)
        builder.AddNamedSystem("link", end)
        parts = {name: builder.AddNamedSystem(name, everything[name]) for name in here if name in everything}
        clouds = "clouds_to_operator" in everything
        frame = 1.0 / scenario.environment.cloud.rate
        if side == OPERATOR:
            surface = builder.AddNamedSystem("clouds", CloudFromLink(link, frame)) if clouds else None
            watched = () if devices.hand is None else tuple(devices.hand.watched)
            columns = _wire_operator(builder, scenario, parts, end, surface, watched)
        else:
            limited = devices.arm is not None and sliders_move_hardware
            columns = _wire_telerobot(builder, scenario, parts, end, limited)
            if (arm := devices.arm) is not None:
                wire_arm(builder, arm, end.GetOutputPort("age"))
            if clouds:
                sender = builder.AddNamedSystem("clouds", CloudToLink(link, frame))
                builder.Connect(parts["clouds_to_operator"].GetOutputPort("received"), sender.GetInputPort("sent"))
        if meshcat is not None:
            from mmt_drake.diagrams.station_view import wire_view_of_columns

            wire_view_of_columns(builder, meshcat, columns, parts, proxy=scenario.detector)
        columns += ((end.GetOutputPort("alive"), ("peer_alive",)),)
        live = live_signals(builder, devices, pace, tell)
        recorder = None
        if record is not None:
            seen = None if side == OPERATOR else cloud_port(scenario, parts)
            looser = looser_options(link.options, "link") + (SLIDERS_MOVE_HARDWARE,) * sliders_move_hardware
            recorder = wire_recorder(
                builder, scenario, record, parts, columns, live=live, surface=seen, tell=tell, looser_link=looser
            )
        for name in ("alive", "status"):
            builder.ExportOutput(end.GetOutputPort(name), name)
        diagram = builder.Build()
    except BaseException:
        link.close()
        raise
    diagram.set_name(f"{scenario.name}-{side}")
    return Side(scenario, diagram, duration, recorder, devices, link, wait)


def _signals(scenario: Scenario, parts: Mapping[str, System], may_jump: bool) -> dict[Role, Signal]:
    """What crosses the link. A lost operator's probe stands still; of a lost telerobot's object nothing is felt."""
    start = shown_first(parts["operator"], "motion")
    keep, zero = np.nan, 0.0
    more = 3 if "energy_to_telerobot" in parts else int(tells_held_body(scenario))  # energy, or a stamp
    motion = Signal(
        "motion",
        np.concatenate([start[:3], np.zeros(3 + more)]),
        when_lost=np.array([keep] * 3 + [zero] * 3 + [keep] * more),
        motion=6,
        may_jump=may_jump,
    )
    back = _back(scenario)
    kept = np.concatenate([np.full(n, name in _KEPT) for name, n in back.items()])
    model = Signal(
        " ".join(back),
        np.zeros(kept.size),
        when_lost=np.where(kept, keep, zero),
        may_be_nan=np.concatenate([np.full(n, name == "theta") for name, n in back.items()]),
    )
    return {OPERATOR: motion, TELEROBOT: model}


def _back(scenario: Scenario) -> dict[str, int]:
    """What crosses to the operator, and sizes: what the renderer needs, and for a hand's supervisor a camera's age."""
    seen = isinstance(scenario.environment.cloud, DepthCamera)
    return {**returned(scenario), **({_CAMERA: 1} if seen else {})}


def _wire_operator(
    builder: DiagramBuilder,
    scenario: Scenario,
    parts: Mapping[str, System],
    end: LinkEnd,
    clouds: CloudFromLink | None,
    watched: Collection[str],
) -> Columns:
    hand, renderer = parts["operator"], parts["renderer"]
    motion = hand.GetOutputPort("motion")
    builder.Connect(motion, parts["to_telerobot"].GetInputPort("sent"))
    sent = [parts["to_telerobot"].GetOutputPort("received")]
    if "energy_to_telerobot" in parts:
        builder.Connect(renderer.GetOutputPort("energy_in"), parts["energy_to_telerobot"].GetInputPort("sent"))
        sent.append(parts["energy_to_telerobot"].GetOutputPort("received"))
    if tells_held_body(scenario):
        stamps = parts.get("stamps_to_telerobot") or builder.AddNamedSystem("clock", clock_source())
        sent.append(stamps.get_output_port(0))
    builder.Connect(join(builder, tuple(sent)), end.GetInputPort("sent"))
    felt = motion
    if "to_renderer" in parts:
        builder.Connect(motion, parts["to_renderer"].GetInputPort("sent"))
        felt = parts["to_renderer"].GetOutputPort("received")
    builder.Connect(felt, renderer.GetInputPort("motion"))
    back = _back(scenario)
    arrived = dict(zip(back, split(builder, end.GetOutputPort("received"), tuple(back.values())), strict=True))
    ages = {"peer": end.GetOutputPort("age")}
    if _CAMERA in arrived:
        ages["camera"] = arrived.pop(_CAMERA)
    for name, port in arrived.items():
        builder.Connect(port, renderer.GetInputPort(name))
    if clouds is not None:
        wire_clouds(builder, parts, felt, clouds.GetOutputPort("received"))
    rendered = renderer.GetOutputPort("force")
    builder.Connect(rendered, hand.GetInputPort("force"))
    if watched:
        builder.Connect(join(builder, tuple(ages[name] for name in watched)), hand.GetInputPort("ages"))
    if end.HasInputPort("sent_age"):  # of a supervised device, whose motion is not always to be believed
        builder.Connect(hand_age(builder, hand), end.GetInputPort("sent_age"))
    builder.ExportOutput(motion, "motion")
    builder.ExportOutput(rendered, "rendered_force")
    columns: Columns = (
        (motion, ("master_position", "master_velocity")),
        (motion, ("position", "velocity")),  # the only probe that is known here is the one in the local model
        (rendered, ("rendered_force",)),
    )
    columns += tuple((arrived[name], (column,)) for name, column in RETURNED.items() if name in arrived)
    if "operator_detector" in parts:
        columns += ((parts["operator_detector"].GetOutputPort("in_contact"), ("operator_contact",)),)
    return columns


def _wire_telerobot(
    builder: DiagramBuilder, scenario: Scenario, parts: Mapping[str, System], end: LinkEnd, limited: bool
) -> Columns:
    probe = end.GetOutputPort("received")
    if limited:
        limiter = builder.AddNamedSystem(
            "limiter", MotionRateLimiter(shown_first(end, "received")[:3], period=scenario.step)
        )
        motion, *rest = split(builder, probe, (6, probe.size() - 6) if probe.size() > 6 else (6,))
        builder.Connect(motion, limiter.GetInputPort("commanded"))
        probe = join(builder, (limiter.GetOutputPort("motion"), *rest))
    if "telerobot" in parts:
        commanded, energy = split(builder, probe, (6, 3))
        builder.Connect(commanded, parts["telerobot"].GetInputPort("commanded"))
        builder.Connect(energy, parts["telerobot"].GetInputPort("remote_energy"))
        probe = parts["telerobot"].GetOutputPort("motion")
    if tells_held_body(scenario):
        probe, stamp = split(builder, probe, (6, 1))
        wire_stamps(builder, scenario, parts, stamp)
    simulated = scenario.telerobot if parts["environment"].HasInputPort("motion") else None
    pulls = None if simulated is None else simulated.impedance
    wire_camera(builder, parts)
    surface = cloud_port(scenario, parts)
    remote = wire_remote(builder, parts, probe, surface, pulls)
    measurement = remote.measurement
    told = wire_estimator(builder, remote, parts["estimator"])
    contact = {"in_contact": remote.detected, "measured_contact": remote.in_contact}
    wire_sent(builder, scenario, parts, {**told, **contact, "measurement": measurement})
    sent = [parts["to_operator"].GetOutputPort("received")]
    if _CAMERA in _back(scenario):
        age = builder.AddNamedSystem("camera_age", CameraAge())
        builder.Connect(parts["camera"].GetOutputPort("camera"), age.GetInputPort("camera"))
        sent.append(age.GetOutputPort("age"))
    builder.Connect(join(builder, tuple(sent)), end.GetInputPort("sent"))
    if "clouds_to_operator" in parts:
        builder.Connect(surface, parts["clouds_to_operator"].GetInputPort("sent"))
    builder.ExportOutput(measurement, "measurement")
    return (
        (measurement, ("position", "velocity", "force")),
        *remote.truth,
        (remote.in_contact, ("detected_contact",)),
        (remote.proxy, ("proxy_position",)),
        *remote.zeroing,
        *estimator_columns(scenario, told),
        *camera_columns(builder, parts),
    )
