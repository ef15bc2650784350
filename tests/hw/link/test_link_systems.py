"""The LeafSystems of a link: the ports of the simulated channels, and the same behaviour where both do the same."""

import re

import numpy as np
import yaml
from link_samples import SIGNALS, Pair
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantValueSource, TrajectorySource, VectorLogSink
from pydrake.trajectories import PiecewisePolynomial

from mmt_drake.cloud import Cloud, plane
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions
from mmt_drake.hw.link.systems import CloudFromLink, CloudToLink, LinkEnd
from mmt_drake.network.config import ChannelConfig
from mmt_drake.systems.network_channel import network_channel

STEP = 1e-3


def names(system: System) -> tuple[list[str], list[str]]:
    return (
        [system.get_input_port(i).get_name() for i in range(system.num_input_ports())],
        [system.get_output_port(i).get_name() for i in range(system.num_output_ports())],
    )


def end(pair: Pair, role: str, *, aged: bool = False) -> LinkEnd:
    if role == OPERATOR:
        return LinkEnd(pair.operator, SIGNALS[OPERATOR], SIGNALS[TELEROBOT], STEP, aged=aged)
    return LinkEnd(pair.telerobot, SIGNALS[TELEROBOT], SIGNALS[OPERATOR], STEP)


def test_ports_are_those_of_the_simulated_channels_and_of_the_docstrings() -> None:
    pair = Pair()
    systems = [end(pair, OPERATOR, aged=True), CloudToLink(pair.telerobot, 0.03), CloudFromLink(pair.operator, 0.03)]
    for system in systems:
        doc = type(system).__doc__ or ""
        block = re.search(r"\.\. pydrake_system::\n\n(.*?)\n\n", doc, re.S)
        assert block
        told = yaml.safe_load(block[1])
        assert told["name"] == type(system).__name__
        assert (told.get("input_ports") or [], told.get("output_ports") or []) == names(system)
        for name in (*names(system)[0], *names(system)[1]):
            assert re.search(rf"- `{name}` \((size|abstract|\d+)", doc)
    channel = network_channel(ChannelConfig(delay=0.1), 6, STEP)
    for name in names(channel)[0]:
        assert systems[0].GetInputPort(name).size() == channel.GetInputPort(name).size()
    clouds = network_channel(ChannelConfig(), AbstractValue.Make(Cloud.empty()), 0.03)
    assert set(names(clouds)[0]) == set(names(systems[1])[0]) and set(names(clouds)[1]) == set(names(systems[2])[1])


def motion() -> PiecewisePolynomial:
    times = np.linspace(0.0, 1.0, 60)
    return PiecewisePolynomial.FirstOrderHold(times, np.sin(np.outer(np.arange(1.0, 7.0), 9.0 * times)))


def logged(system: System, port: str, source: System) -> tuple[Diagram, VectorLogSink]:
    builder = DiagramBuilder()
    for item in (system, source):
        builder.AddSystem(item)
    builder.Connect(source.get_output_port(), system.GetInputPort("sent"))
    log = builder.AddSystem(VectorLogSink(system.GetOutputPort(port).size(), STEP))
    builder.Connect(system.GetOutputPort(port), log.get_input_port())
    return builder.Build(), log


def test_a_link_in_step_is_the_simulated_channel_with_one_tick_of_delay_to_the_bit(pair: Pair) -> None:
    sender, _ = logged(end(pair, OPERATOR), "status", TrajectorySource(motion()))
    builder = DiagramBuilder()
    receiver = builder.AddSystem(end(pair, TELEROBOT))
    model = builder.AddSystem(TrajectorySource(PiecewisePolynomial(np.ones((4, 1)))))
    builder.Connect(model.get_output_port(), receiver.GetInputPort("sent"))
    log = builder.AddSystem(VectorLogSink(6, STEP))
    builder.Connect(receiver.GetOutputPort("received"), log.get_input_port())
    diagrams = [sender, builder.Build()]
    simulators = [Simulator(diagram) for diagram in diagrams]
    for tick in range(1, 801):
        for simulator in simulators:
            simulator.AdvanceTo(tick * STEP)
        pair.now += 1_000_000
    shown = log.FindLog(simulators[1].get_context()).data()
    twin, twin_log = logged(network_channel(ChannelConfig(delay=STEP), 6, STEP), "received", TrajectorySource(motion()))
    simulator = Simulator(twin)
    simulator.AdvanceTo(0.8)
    expected = twin_log.FindLog(simulator.get_context()).data()
    assert shown.shape == expected.shape and np.array_equal(shown[:, 2:], expected[:, 2:])


def test_a_lost_peer_is_told_on_the_ports() -> None:
    pair = Pair(LinkOptions(timeout=0.05))
    pair.connect()
    system = end(pair, TELEROBOT)
    diagram, log = logged(system, "received", TrajectorySource(PiecewisePolynomial(np.ones((4, 1)))))
    simulator = Simulator(diagram)
    alive, age = [], []
    for tick in range(1, 101):
        simulator.AdvanceTo(tick * STEP)
        pair.now += 1_000_000
        context = system.GetMyContextFromRoot(simulator.get_context())
        alive.append(system.GetOutputPort("alive").Eval(context)[0])
        age.append(system.GetOutputPort("age").Eval(context)[0])
        assert system.GetOutputPort("status").Eval(context)[0] == alive[-1]
    assert alive[0] == 1.0 and alive[-1] == 0.0 and sorted(alive, reverse=True) == alive
    assert np.allclose(np.diff(age), STEP)  # what a supervisor watches grows from tick to tick
    shown = log.FindLog(simulator.get_context()).data()
    assert not shown[3:, -1].any() and shown[:3, -1].any()


def test_a_surface_crosses_the_link_from_port_to_port(pair: Pair) -> None:
    surface = plane(200, (0.1, 0.1)).moved((0.0, 0.0, -0.01), 2.0)
    builder = DiagramBuilder()
    source = builder.AddSystem(ConstantValueSource(AbstractValue.Make(surface)))
    sender = builder.AddSystem(CloudToLink(pair.telerobot, 0.01))
    shown = builder.AddNamedSystem("shown", CloudFromLink(pair.operator, 0.01))
    builder.Connect(source.get_output_port(), sender.GetInputPort("sent"))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    for tick in range(1, 31):
        simulator.AdvanceTo(tick * STEP)
        pair.tick()
    received = shown.GetOutputPort("received").Eval(shown.GetMyContextFromRoot(simulator.get_context()))
    np.testing.assert_allclose(received.points(), surface.points(), atol=2e-8)
    assert received.stamp == 2.0
