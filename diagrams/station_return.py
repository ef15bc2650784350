"""The station's way back: what the network carries to the operator, and what it drives there."""

from __future__ import annotations

from collections.abc import Mapping

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.diagrams.ports import join, split
from mmt_drake.diagrams.scenario import DirectForce, FusedReflection, ImpedanceReflection, Scenario
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.parameters import THETA
from mmt_drake.network.config import ChannelConfig
from mmt_drake.systems.network_channel import network_channel

Ports = Mapping[str, OutputPort]

_END = 2.0**30  # [s] of the clock's trajectory, 34 years


def tells_held_body(scenario: Scenario) -> bool:
    """Whether the estimator knows where friction holds the body, and the renderer has use for it."""
    return knows_held_body(scenario) and isinstance(scenario.renderer, ImpedanceReflection | FusedReflection)


def knows_held_body(scenario: Scenario) -> bool:
    """Whether the estimator does."""
    return isinstance(scenario.estimator, OutputErrorOptions)


def clock_source() -> TrajectorySource:
    """The time of the diagram that it is in [s]."""
    return TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, _END], [[0.0, _END]]))


def stamps_to_telerobot(config: ChannelConfig, period: float) -> Diagram:
    """`received` (1): when the operator sent what the telerobot receives now [s].

    Args:
        config: of the network to the telerobot, its seed too: stamps travel in the packets that carry the motion.
        period: of its ticks [s].
    """
    builder = DiagramBuilder()
    clock = builder.AddSystem(clock_source())
    channel = builder.AddSystem(network_channel(config, 1, period, interpolation="linear"))
    builder.Connect(clock.get_output_port(), channel.GetInputPort("sent"))
    builder.ExportOutput(channel.GetOutputPort("received"), "received")
    return builder.Build()


def wire_stamps(
    builder: DiagramBuilder, scenario: Scenario, parts: Mapping[str, System], stamps: OutputPort | None
) -> None:
    """Tell an estimator that has use for it when the motion that it sees was sent.

    Args:
        builder, scenario, parts: as for `wire_return`.
        stamps: (1) when what the telerobot receives now was sent [s]; None: now.
    """
    if not tells_held_body(scenario):
        return
    if "compensation" in parts:  # through which the measurement comes late
        late = ChannelConfig(delay=parts["compensation"].ticks_late * scenario.step)
        now = stamps or builder.AddNamedSystem("clock", clock_source()).get_output_port()
        wait = builder.AddNamedSystem("measured_stamps", network_channel(late, 1, scenario.step))
        builder.Connect(now, wait.GetInputPort("sent"))
        stamps = wait.GetOutputPort("received")
    if stamps is not None:
        builder.Connect(stamps, parts["estimator"].GetInputPort("stamp"))


def returned(scenario: Scenario) -> dict[str, int]:
    """What crosses the network to the operator but clouds: what the renderer needs, by its ports' names, and sizes."""
    renderer = scenario.renderer
    if isinstance(renderer, DirectForce):
        return {"remote_force": 3} if renderer.passivity is None else {"remote_force": 3, "remote_energy": 3}
    sizes = {"theta": len(THETA), "stable": 1}
    if scenario.switching == "telerobot":
        sizes["in_contact"] = 1
    if isinstance(renderer, FusedReflection):
        sizes["high_band"] = 3
    if tells_held_body(scenario):
        sizes["held_body"] = HELD_SIZE
    return sizes


def wire_return(builder: DiagramBuilder, scenario: Scenario, parts: Mapping[str, System], ports: Ports) -> None:
    """Connect everything from the telerobot's signals to the renderer's inputs.

    Args:
        builder: of the station, with all parts in it.
        scenario: that they were made for.
        parts: the station's, by name.
        ports: as for `wire_sent`, and `motion` of the hand and `point_cloud`.
    """
    renderer = parts["renderer"]
    builder.Connect(ports["motion"], renderer.GetInputPort("motion"))
    wire_sent(builder, scenario, parts, ports)
    sizes = returned(scenario)
    arrived = split(builder, parts["to_operator"].GetOutputPort("received"), tuple(sizes.values()))
    for port, name in zip(arrived, sizes, strict=True):
        builder.Connect(port, renderer.GetInputPort(name))
    if "telerobot" in parts:
        energy = parts["energy_to_telerobot"]
        builder.Connect(renderer.GetOutputPort("energy_in"), energy.GetInputPort("sent"))
        builder.Connect(energy.GetOutputPort("received"), parts["telerobot"].GetInputPort("remote_energy"))
    if "clouds_to_operator" in parts:
        builder.Connect(ports["point_cloud"], parts["clouds_to_operator"].GetInputPort("sent"))
        wire_clouds(builder, parts, ports["motion"], parts["clouds_to_operator"].GetOutputPort("received"))


def wire_sent(builder: DiagramBuilder, scenario: Scenario, parts: Mapping[str, System], ports: Ports) -> None:
    """Connect the telerobot's signals to the network that carries them to the operator.

    Args:
        builder, scenario, parts: as for `wire_return`.
        ports: `measurement`, `in_contact` (of the detector, now), `measured_contact` (of the instant of the
            measurement), `theta` and `stable` of the telerobot, and `held_body` where its estimator tells it.
    """
    sizes, source = returned(scenario), dict(ports)
    if "remote_force" in sizes:
        source["remote_force"] = split(builder, ports["measurement"], (6, 3))[1]
    if "telerobot" in parts:
        # The telerobot's end of a passivity control: its energy travels with the force.
        source["remote_energy"] = parts["telerobot"].GetOutputPort("energy_in")
        builder.Connect(source["remote_force"], parts["telerobot"].GetInputPort("force"))
    if "high_band" in parts:
        source["high_band"] = parts["high_band"].GetOutputPort("high_band")
        for name in ("measurement", "theta", "stable"):
            builder.Connect(ports[name], parts["high_band"].GetInputPort(name))
        builder.Connect(ports["measured_contact"], parts["high_band"].GetInputPort("in_contact"))
    builder.Connect(join(builder, tuple(source[name] for name in sizes)), parts["to_operator"].GetInputPort("sent"))


def wire_clouds(builder: DiagramBuilder, parts: Mapping[str, System], motion: OutputPort, clouds: OutputPort) -> None:
    """Connect the clouds that have come to the operator to the renderer, and to the detector there if there is one."""
    renderer = parts["renderer"]
    builder.Connect(clouds, renderer.GetInputPort("point_cloud"))
    if "operator_detector" in parts:
        second = parts["operator_detector"]
        builder.Connect(clouds, second.GetInputPort("point_cloud"))
        builder.Connect(split(builder, motion, (3,))[0], second.GetInputPort("position"))
        builder.Connect(second.GetOutputPort("in_contact"), renderer.GetInputPort("in_contact"))
