"""One direction of a network that carries things: they travel like vectors, whole, and are forgotten in time."""

import copy
import dataclasses

import numpy as np
import pytest
from channels import WILD, H, tick, transmitted
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from mmt_drake.network.config import ChannelConfig
from mmt_drake.systems.network_channel import network_channel


class Frame:
    """An immutable thing, like a cloud."""

    def __init__(self, number):
        self.number = number

    def __deepcopy__(self, memo):
        return self


class FrameSource(LeafSystem):
    def __init__(self):
        super().__init__()
        self.DeclareAbstractOutputPort(
            "value",
            lambda: Value(Frame(0)),
            lambda context, out: out.set_value(Frame(int(tick(context.get_time())[0]))),
            {self.time_ticket()},
        )


@pytest.mark.parametrize(
    "config",
    [
        ChannelConfig(),
        ChannelConfig(delay=0.003),
        ChannelConfig(loss=0.4),
        WILD,
        dataclasses.replace(WILD, playout=0.04),
        dataclasses.replace(WILD, delay=0.0),
    ],
    ids=["wire", "delay", "lossy", "wild", "playout", "at once"],
)
def test_abstract_packets_travel_like_vectors(config):
    builder = DiagramBuilder()
    sender = builder.AddSystem(FrameSource())
    channel = builder.AddSystem(network_channel(config, Value(Frame(0)), H))
    builder.Connect(sender.get_output_port(), channel.GetInputPort("sent"))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.Initialize()
    seen = []
    for k in range(200):
        if k > 0:
            simulator.AdvanceTo(k * H)
        mine = channel.GetMyContextFromRoot(simulator.get_context())
        seen.append(channel.GetOutputPort("received").Eval(mine).number)
    np.testing.assert_array_equal(seen, transmitted(config, 200)[:, 0])


def test_packets_that_will_never_be_shown_are_forgotten():
    channel = network_channel(ChannelConfig(delay=0.004, loss=1.0), Value(0.0), H)
    simulator = Simulator(channel)
    channel.GetInputPort("sent").FixValue(simulator.get_mutable_context(), 1.0)
    simulator.AdvanceTo(1.0)
    assert len(simulator.get_context().get_abstract_state(0).get_value().content) < 10


def test_mutable_abstract_values_are_received_as_they_were_sent():
    channel = network_channel(ChannelConfig(delay=0.002, loss=0.0, jitter=0.001), Value([0]), H)
    simulator = Simulator(channel)
    thing = [1]
    channel.GetInputPort("sent").FixValue(simulator.get_mutable_context(), AbstractValue.Make(copy.copy(thing)))
    simulator.AdvanceTo(0.0005)
    thing.append(2)
    simulator.AdvanceTo(0.0095)
    assert channel.GetOutputPort("received").Eval(simulator.get_context()) == [1]
