"""The one door: a scenario in, a Drake diagram out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, System
from pydrake.systems.primitives import ZeroOrderHold

from diagrams import scenario as options
from diagrams.devices import Devices
from diagrams.ports import join, split
from diagrams.scenario import Scenario
from diagrams.station_cloud import Surface, camera_columns, cloud_port, surface_of, wire_camera
from diagrams.station_live import Columns, live_signals, wire_devices
from diagrams.station_return import (
    knows_held_body,
    returned,
    stamps_to_telerobot,
    tells_held_body,
    wire_return,
    wire_stamps,
)
from diagrams.telerobots import (
    of_one_instant,
    rests_at,
    shown_first,
    simulated_telerobot,
    still_surface,
    wire_estimator,
    wire_remote,
)
from mmt_drake.cloud import Cloud, ProxySettings, contact_offset
from mmt_drake.errors import BadInput
from mmt_drake.estimation import thesis as rls
from mmt_drake.estimation.kinds import EstimatorOptions
from mmt_drake.estimation.options import RlsOptions
from mmt_drake.estimation.output_error import gate as output_error
from mmt_drake.estimation.recursive.options import InstrumentalOptions, KalmanOptions
from mmt_drake.motion.placement import place
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.network.config import ChannelConfig
from mmt_drake.realtime import Pace, advance_paced, warm
from mmt_drake.recording import Recording, load
from mmt_drake.rendering import impedance
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.direct_force import DirectForce
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.fused_reflection import FusedReflection
from mmt_drake.systems.high_band_estimator import HighBandEstimator
from mmt_drake.systems.impedance_reflection import ImpedanceReflection
from mmt_drake.systems.instrumental_estimator import InstrumentalEstimator
from mmt_drake.systems.interactive_operator import InteractiveOperator
from mmt_drake.systems.kalman_estimator import KalmanEstimator
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator
from mmt_drake.systems.passivity_controlled_force import PassivityControlledForce
from mmt_drake.systems.passivity_controlled_motion import PassivityControlledMotion
from mmt_drake.systems.probe_compensation import ProbeCompensation
from mmt_drake.systems.proxy_spring import ProxySpring
from mmt_drake.systems.recorded_operator import RecordedOperator
from mmt_drake.systems.recorder import McapRecorder
from mmt_drake.systems.rls_estimator import RlsEstimator
from mmt_drake.systems.scripted_operator import ScriptedOperator
from mmt_drake.systems.surface_contact_detector import SurfaceContactDetector
from mmt_drake.systems.yielding_hand import YieldingHand

_BUILTIN = "builtin:"
_ORIGIN = (0.0, 0.0)
_ENDLESS_DURATION = 60.0  # [s] of a run whose operator has no end

# Seeds of the scenario's random streams lie apart, so that no two streams share numbers.
_NOISE_SEED, _TO_TELEROBOT_SEED, _TO_OPERATOR_SEED, _CLOUD_SEED, _TO_RENDERER_SEED = 101, 211, 307, 401, 503
_WRIST_SEED = 601


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

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.devices.close()  # first: nothing moves, and no force stays on, while a file is completed
        if self.recorder is not None:
            self.recorder.close()


def build_station(
    scenario: Scenario,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Meshcat | None = None,
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
    estimator, renderer = parts["estimator"], parts["renderer"]

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

    wire_estimator(builder, remote, estimator)
    told = output_error.PORT_SIZES if estimator.HasOutputPort("deviation") else rls.PORT_SIZES
    theta, _, stable, estimated, filtered, *doubt = split(
        builder, estimator.GetOutputPort("readout"), tuple(told.values())
    )

    told_ports = {"theta": theta, "stable": stable}
    if tells_held_body(scenario):
        told_ports["held_body"] = doubt[-1]
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
            "motion": felt,
            "measurement": measurement,
            "point_cloud": surface,
            "in_contact": remote.detected,
            "measured_contact": remote.in_contact,
            **told_ports,
        },
    )
    rendered = renderer.GetOutputPort("force")
    if renderer.HasOutputPort("stored_energy"):
        readout = renderer.GetOutputPort("readout")
        rendered, status, jump, stored = split(builder, readout, tuple(impedance.PORT_SIZES.values()))
    builder.Connect(rendered, parts["operator"].GetInputPort("force"))
    if arm is not None:
        if hand is None:
            raise BadInput(scenario.name, found="an arm", expected="a hand on a device to move it, with its switches")
        wire_devices(builder, hand, arm)
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
            (theta, ("theta",)),
            (stable, ("theta_stable",)),
            (estimated, ("estimated_force",)),
            (filtered, ("filtered_force",)),
            (rendered, ("rendered_force",)),
        )
        if doubt:
            deviation, condition, held = doubt
            signals += ((deviation, ("theta_deviation",)), (condition, ("estimator_status",)))
            if knows_held_body(scenario):
                signals += ((held, ("held_body",)),)
        if renderer.HasOutputPort("stored_energy"):
            signals += ((status, ("renderer_status",)), (jump, ("update_jump",)), (stored, ("stored_energy",)))
        if "operator_detector" in parts:
            signals += ((parts["operator_detector"].GetOutputPort("in_contact"), ("operator_contact",)),)
        signals += camera_columns(builder, parts) + live
        if "compensation" in parts:
            before = {
                "master_position": shown_first(parts["operator"], "motion"),
                "proxy_position": rests_at(parts["arm"]),
            }
            if "camera" in parts:
                before["camera_fault"] = shown_first(parts["camera"], "camera")[:1]
            if arm is not None:
                fault, _, waits = shown_first(arm.system, "device")
                before |= {"telerobot_fault": np.array([fault]), "telerobot_waits": np.array([waits])}
            signals = of_one_instant(builder, signals, parts["compensation"].ticks_late, scenario.step, before)
        columns = [(name, port.size() // len(names)) for port, names in signals for name in names]
        recorder = McapRecorder(record, columns, scenario.step, scenario.clouds, realtime=bool(live), tell=tell)
        builder.AddNamedSystem("recorder", recorder)
        everything = join(builder, tuple(port for port, _ in signals))
        builder.Connect(everything, recorder.GetInputPort("signals"))
        builder.Connect(surface, recorder.GetInputPort("point_cloud"))

    if meshcat is not None:
        from diagrams.station_view import wire_view

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


def station_parts(
    scenario: Scenario,
    *,
    operator: Recording | None = None,
    meshcat: Meshcat | None = None,
    worker: bool = False,
    devices: Devices = Devices(),
) -> tuple[dict[str, System], float]:
    """The systems of a scenario by name, not yet wired, and how long a run lasts [s].

    Arguments and errors are those of `build_station`.
    """
    dt, world = scenario.step, scenario.environment
    hand, arm = devices.hand, devices.arm
    person, length, middle = _person(scenario, operator, meshcat) if hand is None else (hand.system, None, _ORIGIN)
    start = person.GetOutputPort("motion").Eval(person.CreateDefaultContext())
    with _told_of(scenario, "environment.cloud"):
        surface = surface_of(scenario, middle, devices)
    proxy = replace(scenario.detector, period=dt)
    if proxy.surface_offset is None:
        proxy = replace(proxy, surface_offset=surface.offset)
    make: dict[str, Callable[[], System]] = {
        "to_telerobot": lambda: network_channel(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED),
            6,
            dt,
            # Until the first packet arrives the telerobot waits where the hand starts.
            initial=np.concatenate([start[:3], np.zeros(3)]),
            interpolation="motion",
        ),
        "to_renderer": lambda: network_channel(
            _seeded(scenario.to_renderer, scenario.seed + _TO_RENDERER_SEED),
            6,
            dt,
            initial=np.concatenate([start[:3], np.zeros(3)]),
            interpolation="motion",
        ),
        "environment": lambda: (
            still_surface(surface.shown)
            if arm is not None
            else FlexibleBox(
                world.object,
                period=dt,
                noise=replace(world.noise, seed=world.noise.seed + scenario.seed + _NOISE_SEED),
                surface=surface.shown,
                cloud_period=1.0 / world.cloud.rate,
                cloud_noise=surface.noise,
            )
        ),
        "detector": lambda: ContactDetector(proxy),
        "estimator": lambda: _estimator(replace(scenario.estimator, step=dt), worker),
        "to_operator": lambda: _to_operator(scenario),
        "renderer": lambda: _renderer(scenario, proxy),
    }
    if scenario.to_renderer == ChannelConfig():
        del make["to_renderer"]
    if tells_held_body(scenario) and scenario.to_telerobot != ChannelConfig():
        make["stamps_to_telerobot"] = lambda: stamps_to_telerobot(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED), dt
        )
    if isinstance(scenario.renderer, options.FusedReflection):
        second_model = scenario.renderer.high_band
        make["high_band"] = lambda: HighBandEstimator(second_model, period=dt)
    if scenario.switching == "operator":
        make["operator_detector"] = lambda: SurfaceContactDetector(_looking_ahead(proxy, surface))
    if isinstance(scenario.renderer, options.ProxySpring) or scenario.switching == "operator":
        make["clouds_to_operator"] = lambda: _clouds_to_operator(scenario)
    if isinstance(scenario.renderer, options.DirectForce) and scenario.renderer.passivity is not None:
        control = scenario.renderer.passivity
        make["telerobot"] = lambda: PassivityControlledMotion(period=dt, control=control)
        # The same seed: it travels in the packets that carry the motion.
        make["energy_to_telerobot"] = lambda: network_channel(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED), 3, dt
        )
    known, wrist = None, scenario.seed + _WRIST_SEED
    if arm is not None:
        make["arm"], known = (lambda: arm.system), arm.compensation
    elif (held := scenario.telerobot) is not None:
        make["arm"], known = (lambda: simulated_telerobot(held, start[:3], dt, wrist)), held.compensation
    if known is not None:
        of_probe = replace(known, step=dt)
        make["compensation"] = lambda: ProbeCompensation(of_probe, rests_at(parts["arm"]))
    parts: dict[str, System] = {"operator": person}
    if surface.camera is not None:
        parts["camera"] = surface.camera
    for name, build in make.items():
        with _told_of(scenario, name):
            parts[name] = build()
    return parts, scenario.duration or length or _ENDLESS_DURATION


def load_operator(file: str | Path) -> Recording:
    """A recording of a hand; `builtin:NAME` is one that the package ships.

    Raises:
        BadInput: there is none, or it cannot be read.
    """
    name = str(file)
    if not name.startswith(_BUILTIN):
        return load(file, forces=False)
    shipped = resources.files("mmt_drake") / "data" / f"{name.removeprefix(_BUILTIN)}.npz"
    with resources.as_file(shipped) as path:
        if not path.exists():
            raise BadInput("operator", found=name, expected="builtin:hand_reaching or a file")
        return replace(load(path, forces=False), source=name)


def _person(
    scenario: Scenario, recording: Recording | None, meshcat: Meshcat | None
) -> tuple[System, float | None, tuple[float, float]]:
    """As `_operator`, and the hand yields if it is to."""
    with _told_of(scenario, "operator"):
        hand, length, middle = _operator(scenario, recording, meshcat)
        if scenario.hand is None:
            return hand, length, middle
        return _yielding(hand, YieldingHand(scenario.hand, period=scenario.step)), length, middle


def _operator(
    scenario: Scenario, recording: Recording | None, meshcat: Meshcat | None
) -> tuple[LeafSystem, float | None, tuple[float, float]]:
    """The hand, how long its motion is [s] if it ends, and the middle (x, y) of what it covers [m]."""
    hand = scenario.operator
    if recording is not None:
        return _repeating(place(recording))
    if isinstance(hand, options.Recorded):
        return _repeating(place(load_operator(hand.file), hand.placement))
    if isinstance(hand, options.Scripted):
        scripted = scripted_motion(hand.motion, **hand.parameters)
        return ScriptedOperator(scripted), scripted.cycle, _ORIGIN
    if meshcat is None:
        raise BadInput("operator", found="!Interactive", expected="a viewer: run with --meshcat")
    sliders = InteractiveOperator(
        meshcat, period=scenario.step, bandwidth=hand.bandwidth, greatest_speed=hand.greatest_speed
    )
    return sliders, None, _ORIGIN


@contextmanager
def _told_of(scenario: Scenario, part: str) -> Iterator[None]:
    """Lets what a part refuses be told with the scenario and the part's place in it."""
    try:
        yield
    except BadInput as error:
        if isinstance(error.source, Path) or Path(str(error.source)).suffix:
            raise  # a file that the scenario names: that is the place
        at = part if error.at is None else f"{part}.{error.at}"
        raise BadInput(scenario.name, at=at, found=error.found, expected=error.expected) from None


def _repeating(motion: SampledMotion) -> tuple[LeafSystem, float, tuple[float, float]]:
    x, y = 0.5 * (motion.position[:, :2].min(axis=0) + motion.position[:, :2].max(axis=0))
    operator = RecordedOperator(motion.time, motion.position, motion.velocity)
    return operator, motion.duration, (float(x), float(y))


def _estimator(chosen: EstimatorOptions, worker: bool) -> LeafSystem:
    if isinstance(chosen, RlsOptions):
        return RlsEstimator(chosen)
    if isinstance(chosen, KalmanOptions):
        return KalmanEstimator(chosen, worker=worker)
    if isinstance(chosen, InstrumentalOptions):
        return InstrumentalEstimator(chosen, worker=worker)
    return OutputErrorEstimator(chosen, worker=worker)


def _renderer(scenario: Scenario, proxy: ProxySettings) -> LeafSystem:
    chosen, dt = scenario.renderer, scenario.step
    if isinstance(chosen, options.ProxySpring):
        return ProxySpring(chosen.k, proxy)
    if isinstance(chosen, options.ImpedanceReflection):
        return ImpedanceReflection(period=dt, substeps=chosen.substeps, updates=chosen.updates, probe=chosen.probe)
    if isinstance(chosen, options.FusedReflection):
        return FusedReflection(chosen.high_band, period=dt, substeps=chosen.substeps, updates=chosen.updates)
    if chosen.passivity is None:
        return DirectForce(period=dt)
    return PassivityControlledForce(period=dt, control=chosen.passivity)


def _to_operator(scenario: Scenario) -> System:
    """The network back. Flags and parameters keep their value between packets, a force moves on."""
    config = _seeded(scenario.to_operator, scenario.seed + _TO_OPERATOR_SEED)
    interpolation = "linear" if isinstance(scenario.renderer, options.DirectForce) else "hold"
    return network_channel(config, sum(returned(scenario).values()), scenario.step, interpolation=interpolation)


def _clouds_to_operator(scenario: Scenario) -> System:
    """The network back as clouds see it, which cross it like everything else.

    Between two of its ticks a channel shows what is due at the second. Who looks a thousand times a second would see a
    cloud a frame too early, so it is read shortly before each of the channel's ticks: not at the tick, in the midst of
    which a flag that depends on the cloud would then change.
    """
    config = _seeded(scenario.to_operator, scenario.seed + _CLOUD_SEED)
    frame, empty = 1.0 / scenario.environment.cloud.rate, AbstractValue.Make(Cloud.empty())
    channel = network_channel(config, empty, frame)
    if frame <= scenario.step or (config.is_constant and config.delay == 0.0):
        return channel
    builder = DiagramBuilder()
    builder.AddSystem(channel)
    shown = builder.AddSystem(ZeroOrderHold(frame, empty, frame - 0.5 * scenario.step))
    builder.Connect(channel.GetOutputPort("received"), shown.get_input_port())
    builder.ExportInput(channel.GetInputPort("sent"), "sent")
    builder.ExportOutput(shown.get_output_port(), "received")
    return builder.Build()


def _yielding(intention: LeafSystem, hand: YieldingHand) -> Diagram:
    """An operator whose hand yields."""
    builder = DiagramBuilder()
    for system in (intention, hand):
        builder.AddSystem(system)
    builder.Connect(intention.GetOutputPort("motion"), hand.GetInputPort("intended"))
    builder.ExportInput(hand.GetInputPort("force"), "force")
    builder.ExportOutput(hand.GetOutputPort("motion"), "motion")
    return builder.Build()


def _looking_ahead(proxy: ProxySettings, surface: Surface) -> ProxySettings:
    """Settings of a proxy that touches before the hand does, wherever between the points it comes down.

    On a square lattice a sphere of radius r comes down spacing²/(4 r) lower in a gap than on a point; noise lifts it.
    """
    if surface.spacing == 0.0:
        return proxy
    ahead = surface.spacing**2 / (4.0 * proxy.r2) + 3.0 * surface.noise
    offset = proxy.surface_offset
    if offset is None:
        offset = contact_offset(proxy.r2, surface.spacing, surface.noise)
    return replace(proxy, surface_offset=offset - ahead)


def _seeded(config: ChannelConfig, seed: int) -> ChannelConfig:
    return replace(config, seed=config.seed + seed)
