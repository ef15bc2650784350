"""What channels are tested with: a wild network, and what arrives over one, tick by tick."""

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import LogVectorOutput

from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.packets import STATISTICS
from mmt_drake.systems.network_channel import NetworkChannel, network_channel

H = 0.001

WILD = ChannelConfig(
    delay=0.02,
    jitter=0.006,
    jitter_law="normal",
    loss=0.1,
    duplication=0.2,
    reordering=0.1,
    reordering_delay=0.015,
    seed=7,
)


class Source(LeafSystem):
    """A vector-valued function of time."""

    def __init__(self, function, size):
        super().__init__()
        self.DeclareVectorOutputPort(
            "value", size, lambda context, out: out.SetFromVector(function(context.get_time())), {self.time_ticket()}
        )


def tick(t):
    """1 at the first tick, 2 at the second, ..."""
    return [1.0 + round(t / H)]


def transmitted(config, ticks, *, source=tick, size=1, counts=False, **options):
    """What a channel shows at ticks 0, 1, ..., (ticks, size), and its counts if asked for."""
    builder = DiagramBuilder()
    sender = builder.AddSystem(Source(source, size))
    channel = builder.AddSystem((NetworkChannel if counts else network_channel)(config, size, H, **options))
    builder.Connect(sender.get_output_port(), channel.GetInputPort("sent"))
    log = LogVectorOutput(channel.GetOutputPort("received"), builder, publish_period=H)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo((ticks - 1) * H)
    data = log.FindLog(simulator.get_context()).data().T
    assert len(data) == ticks
    if not counts:
        return data
    memory = channel.GetMyContextFromRoot(simulator.get_context()).get_discrete_state(1).value()
    return data, dict(zip(STATISTICS, memory, strict=False))
