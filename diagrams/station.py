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
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, OutputPort, System
from pydrake.systems.primitives import Demultiplexer, Multiplexer

from diagrams import scenario as options
from diagrams.scenario import Scenario
from mmt_drake.cloud import Cloud, ProxySettings, contact_offset, plane
from mmt_drake.cloud.files import read_cloud, thinned
from mmt_drake.errors import BadInput
from mmt_drake.estimation import thesis as rls
from mmt_drake.motion.placement import place
from mmt_drake.motion.sampled import SampledMotion
from mmt_drake.motion.scripted import scripted_motion
from mmt_drake.network.config import ChannelConfig
from mmt_drake.realtime import Pace, advance_paced, warm
from mmt_drake.recording import Recording, load
from mmt_drake.systems.contact_detector import ContactDetector
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.impedance_reflection import ImpedanceReflection
from mmt_drake.systems.interactive_operator import InteractiveOperator
from mmt_drake.systems.network_channel import network_channel
from mmt_drake.systems.proxy_spring import ProxySpring
from mmt_drake.systems.recorded_operator import RecordedOperator
from mmt_drake.systems.recorder import McapRecorder
from mmt_drake.systems.rls_estimator import RlsEstimator
from mmt_drake.systems.scripted_operator import ScriptedOperator

_BUILTIN = "builtin:"
_ORIGIN = (0.0, 0.0)
_ENDLESS_DURATION = 60.0  # [s] of a run whose operator has no end

# Seeds of the scenario's random streams lie apart, so that no two streams share numbers.
_NOISE_SEED, _TO_TELEROBOT_SEED, _TO_OPERATOR_SEED, _CLOUD_SEED = 101, 211, 307, 401


@dataclass(frozen=True)
class Station:
    """A scenario, built.

    Every part can be fetched from the diagram by name: `operator`, `to_telerobot`, `environment`, `detector`,
    `estimator`, `to_operator`, `renderer`, `recorder`.

    Attributes:
        scenario: what it was built from.
        diagram: the wired diagram; its outputs are `motion` (6), `measurement` (9), `theta` (8), `stable` (1),
            `in_contact` (1) and `rendered_force` (3).
        duration: of a run unless told otherwise [s].
        recorder: writes the recording, if there is one.
    """

    scenario: Scenario
    diagram: Diagram
    duration: float
    recorder: McapRecorder | None

    def simulate(
        self,
        seconds: float | None = None,
        *,
        progress: Callable[[float], None] | None = None,
        pace: Pace | None = None,
    ) -> Simulator:
        """Run from time 0 and close the recording.

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
        if self.recorder is not None:
            self.recorder.close()


def build_station(
    scenario: Scenario,
    *,
    record: str | Path | None = None,
    operator: Recording | None = None,
    meshcat: Meshcat | None = None,
) -> Station:
    """Build the diagram that a scenario describes.

    Args:
        scenario: what to build.
        record: file for the recording, `.mcap`; none is made by default.
        operator: replaces the scenario's hand by this recording's motion, placed automatically.
        meshcat: for the sliders of an interactive hand.

    Raises:
        BadInput: something that the scenario names cannot be read or built.
    """
    parts, duration = station_parts(scenario, operator=operator, meshcat=meshcat)
    builder = DiagramBuilder()
    for name, system in parts.items():
        builder.AddNamedSystem(name, system)
    hand, box, detector = parts["operator"], parts["environment"], parts["detector"]
    estimator, renderer = parts["estimator"], parts["renderer"]

    motion = hand.GetOutputPort("motion")
    builder.Connect(motion, parts["to_telerobot"].GetInputPort("sent"))
    probe = parts["to_telerobot"].GetOutputPort("received")
    builder.Connect(probe, box.GetInputPort("motion"))
    # Of the body only the displacement, which comes before its rate.
    measurement, true_force, in_contact, body = _split(builder, box.GetOutputPort("readout"), (9, 3, 1, 2))

    builder.Connect(_split(builder, probe, (3,))[0], detector.GetInputPort("position"))
    builder.Connect(box.GetOutputPort("point_cloud"), detector.GetInputPort("point_cloud"))
    detected, proxy = _split(builder, detector.GetOutputPort("readout"), (1, 3))

    builder.Connect(measurement, estimator.GetInputPort("measurement"))
    builder.Connect(detected, estimator.GetInputPort("in_contact"))
    theta, _, stable, estimated, filtered = _split(
        builder, estimator.GetOutputPort("readout"), tuple(rls.PORT_SIZES.values())
    )

    builder.Connect(_join(builder, (theta, stable, detected)), parts["to_operator"].GetInputPort("sent"))
    model = _split(builder, parts["to_operator"].GetOutputPort("received"), (8, 1, 1))
    for port, name in zip((motion, *model), ("motion", "theta", "stable", "in_contact"), strict=True):
        builder.Connect(port, renderer.GetInputPort(name))
    if "clouds_to_operator" in parts:
        builder.Connect(box.GetOutputPort("point_cloud"), parts["clouds_to_operator"].GetInputPort("sent"))
        builder.Connect(parts["clouds_to_operator"].GetOutputPort("received"), renderer.GetInputPort("point_cloud"))
    rendered = renderer.GetOutputPort("force")
    if renderer.HasOutputPort("readout"):
        (rendered,) = _split(builder, renderer.GetOutputPort("readout"), (3,))
    builder.Connect(rendered, hand.GetInputPort("force"))

    recorder = None
    if record is not None:
        # Columns and the ports they come from; some ports carry several signals.
        signals: tuple[tuple[OutputPort, tuple[str, ...]], ...] = (
            (motion, ("master_position", "master_velocity")),
            (measurement, ("position", "velocity", "force")),
            (true_force, ("true_force",)),
            (in_contact, ("in_contact",)),
            (body, ("body_position",)),
            (detected, ("detected_contact",)),
            (proxy, ("proxy_position",)),
            (theta, ("theta",)),
            (stable, ("theta_stable",)),
            (estimated, ("estimated_force",)),
            (filtered, ("filtered_force",)),
            (rendered, ("rendered_force",)),
        )
        columns = [(name, port.size() // len(names)) for port, names in signals for name in names]
        recorder = McapRecorder(record, columns, scenario.step, scenario.clouds)
        builder.AddNamedSystem("recorder", recorder)
        everything = _join(builder, tuple(port for port, _ in signals))
        builder.Connect(everything, recorder.GetInputPort("signals"))
        builder.Connect(box.GetOutputPort("point_cloud"), recorder.GetInputPort("point_cloud"))

    for port, name in (
        (motion, "motion"),
        (measurement, "measurement"),
        (theta, "theta"),
        (stable, "stable"),
        (in_contact, "in_contact"),
        (rendered, "rendered_force"),
    ):
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name(scenario.name)
    return Station(scenario, diagram, duration, recorder)


def station_parts(
    scenario: Scenario, *, operator: Recording | None = None, meshcat: Meshcat | None = None
) -> tuple[dict[str, System], float]:
    """The systems of a scenario by name, not yet wired, and how long a run lasts [s].

    Arguments and errors are those of `build_station`.
    """
    dt, world = scenario.step, scenario.environment
    with _told_of(scenario, "operator"):
        hand, length, middle = _operator(scenario, operator, meshcat)
    start = hand.GetOutputPort("motion").Eval(hand.CreateDefaultContext())
    with _told_of(scenario, "environment.cloud"):
        surface = _surface(scenario, middle)
    proxy = replace(scenario.detector, period=dt)
    if proxy.surface_offset is None and world.cloud.noise > 0.0 and len(surface):
        proxy = replace(proxy, surface_offset=contact_offset(proxy.r2, surface.spacing, world.cloud.noise))
    make: dict[str, Callable[[], System]] = {
        "to_telerobot": lambda: network_channel(
            _seeded(scenario.to_telerobot, scenario.seed + _TO_TELEROBOT_SEED),
            6,
            dt,
            # Until the first packet arrives the telerobot waits where the hand starts.
            initial=np.concatenate([start[:3], np.zeros(3)]),
            interpolation="motion",
        ),
        "environment": lambda: FlexibleBox(
            world.object,
            period=dt,
            noise=replace(world.noise, seed=world.noise.seed + scenario.seed + _NOISE_SEED),
            surface=surface,
            cloud_period=1.0 / world.cloud.rate,
            cloud_noise=world.cloud.noise,
        ),
        "detector": lambda: ContactDetector(proxy),
        "estimator": lambda: RlsEstimator(replace(scenario.estimator, step=dt)),
        "to_operator": lambda: network_channel(
            _seeded(scenario.to_operator, scenario.seed + _TO_OPERATOR_SEED), 10, dt
        ),
        "renderer": lambda: _renderer(scenario, proxy),
    }
    if isinstance(scenario.renderer, options.ProxySpring):
        # The only renderer that wants to see; a cloud crosses the network like everything else.
        make["clouds_to_operator"] = lambda: network_channel(
            _seeded(scenario.to_operator, scenario.seed + _CLOUD_SEED),
            AbstractValue.Make(Cloud.empty()),
            1.0 / world.cloud.rate,
        )
    parts: dict[str, System] = {"operator": hand}
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
    return InteractiveOperator(meshcat, period=scenario.step, bandwidth=hand.bandwidth), None, _ORIGIN


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


def _surface(scenario: Scenario, middle: tuple[float, float]) -> Cloud:
    """The undisplaced surface, from a file, or drawn about the middle (x, y) [m] of what the hand covers."""
    cloud = scenario.environment.cloud
    if cloud.file is None:
        centre = (*middle, 0.0)
        return plane(cloud.points, (cloud.size,) * 2, centre=centre, layout=cloud.layout, seed=scenario.seed)
    surface = read_cloud(cloud.file)
    return surface if cloud.voxel is None else thinned(surface, cloud.voxel)


def _renderer(scenario: Scenario, proxy: ProxySettings) -> LeafSystem:
    if isinstance(scenario.renderer, options.ProxySpring):
        return ProxySpring(scenario.renderer.k, proxy)
    return ImpedanceReflection(period=scenario.step, substeps=scenario.renderer.substeps)


def _seeded(config: ChannelConfig, seed: int) -> ChannelConfig:
    return replace(config, seed=config.seed + seed)


def _split(builder: DiagramBuilder, port: OutputPort, sizes: tuple[int, ...]) -> list[OutputPort]:
    """Ports for the first parts of a vector; what is left of it has none."""
    rest = port.size() - sum(sizes)
    parts: System = builder.AddSystem(Demultiplexer([*sizes, rest] if rest else list(sizes)))
    builder.Connect(port, parts.get_input_port(0))
    return [parts.get_output_port(i) for i in range(len(sizes))]


def _join(builder: DiagramBuilder, ports: tuple[OutputPort, ...]) -> OutputPort:
    whole = builder.AddSystem(Multiplexer([port.size() for port in ports]))
    for i, port in enumerate(ports):
        builder.Connect(port, whole.get_input_port(i))
    return whole.get_output_port(0)
