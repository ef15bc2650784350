"""One direction of a network: what arrives, when, and that nothing stale is ever applied."""

import dataclasses
import math

import numpy as np
import pytest
from channels import WILD, H, transmitted
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import DiscreteTimeDelay, PassThrough

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.parameters import channel_parameters
from mmt_drake.network.transit import is_copied, transit
from mmt_drake.systems.abstract_network_channel import AbstractNetworkChannel
from mmt_drake.systems.network_channel import NetworkChannel, network_channel


@pytest.mark.parametrize("n", [1, 2, 7, 400])
@pytest.mark.parametrize("options", [{}, {"initial": [-5.0]}], ids=["drake", "ours"])
def test_delay_of_n_ticks_is_exact_to_the_tick(n, options):
    received = transmitted(ChannelConfig(delay=n * H), n + 20, **options)
    first = options.get("initial", [0.0])[0]
    np.testing.assert_array_equal(received[:, 0], [first] * n + list(range(1, 21)))


@pytest.mark.parametrize("channel", [network_channel, NetworkChannel])
def test_no_delay_is_a_wire(channel):
    assert channel(ChannelConfig(), 1, H).HasAnyDirectFeedthrough()
    received = transmitted(ChannelConfig(), 10, counts=channel is NetworkChannel)
    received = received[0] if channel is NetworkChannel else received
    np.testing.assert_array_equal(received[:, 0], np.arange(1, 11))


@pytest.mark.parametrize(
    ("delay", "period", "ticks"),
    [(0.0023, 0.001, 3), (1e-7, 0.001, 1), (0.3, 0.1, 3), (0.4, 1 / 30, 12), (0.41, 1 / 30, 13)],
)
def test_delay_between_ticks_is_rounded_up(delay, period, ticks):
    channel = network_channel(ChannelConfig(delay=delay), 1, period)
    assert not channel.HasAnyDirectFeedthrough()
    simulator = Simulator(channel)
    channel.GetInputPort("sent").FixValue(simulator.get_mutable_context(), [1.0])
    port = channel.GetOutputPort("received")
    seen = []
    simulator.Initialize()
    for k in range(ticks + 1):
        if k > 0:  # to advance to the start would already take its update
            simulator.AdvanceTo(k * period)
        seen.append(port.Eval(simulator.get_context())[0])
    assert seen == [0.0] * ticks + [1.0]


def test_drakes_own_systems_are_used_where_they_do():
    def inside(channel):
        return channel.GetSystems()[0]

    assert isinstance(inside(network_channel(ChannelConfig(), 3, H)), PassThrough)
    assert isinstance(inside(network_channel(ChannelConfig(delay=0.4), 3, H)), DiscreteTimeDelay)
    assert isinstance(inside(network_channel(ChannelConfig(delay=0.4), Value("model"), H)), DiscreteTimeDelay)
    assert isinstance(network_channel(ChannelConfig(delay=0.4, loss=0.1), 3, H), NetworkChannel)
    assert isinstance(network_channel(ChannelConfig(delay=0.4, loss=0.1), Value("model"), H), AbstractNetworkChannel)


def by_brute_force(config, ticks):
    """What is shown at each tick: the newest packet that has arrived, from one list of all arrivals."""
    p, trace = channel_parameters(config, H)
    gap = 0.0 if config.rate_limit is None else 1.0 / (config.rate_limit * H)
    arrivals, free = [], 0.0
    for k in range(ticks):
        wait = max(0.0, free - k)
        if gap and wait > config.queue * gap + 1e-6:
            continue
        free = k + wait + gap
        for copy_number in range(1 + is_copied(k, p)):
            ticks_in_network = transit(k, copy_number, p, trace)
            if ticks_in_network >= 0.0:
                arrivals.append((math.ceil(k + wait + ticks_in_network - 1e-6), k))
    return np.array([max([k for at, k in arrivals if at <= now], default=-1) + 1.0 for now in range(ticks)])


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"jitter_law": "uniform"},
        {"jitter_law": "gamma", "loss": 0.5},
        {"delay": 0.0, "jitter": 0.004},
        {"delay": 0.0, "jitter": 0.0},
        {"delay": 0.0, "jitter": 0.002, "jitter_law": "gamma", "duplication": 0.9},
        {"rate_limit": 300.0, "queue": 3},
        {"rate_limit": 437.0, "queue": 0, "delay": 0.0, "jitter": 0.0, "reordering": 0.0},
        {"loss": 1.0},
    ],
    ids=str,
)
def test_newest_packet_that_has_arrived_is_what_is_shown(change):
    config, ticks = dataclasses.replace(WILD, **change), 400
    received, counts = transmitted(config, ticks, counts=True)
    np.testing.assert_array_equal(received[:, 0], by_brute_force(config, ticks))
    assert np.all(np.diff(received[:, 0]) >= 0.0)  # never stale over newer
    assert counts["sent"] == ticks - 1  # the last tick's packet leaves as time goes on


def test_counts_are_those_of_what_happened():
    ticks = 600
    received, counts = transmitted(WILD, ticks, counts=True)
    # The last update, at tick `ticks - 2`, sent the packet of that number and took in what arrives a tick later.
    p, trace = channel_parameters(WILD, H)
    arrivals = [
        (math.ceil(k + transit(k, c, p, trace) - 1e-6), k, c) if transit(k, c, p, trace) >= 0.0 else None
        for k in range(ticks - 1)
        for c in range(1 + is_copied(k, p))
    ]
    arrived = sorted((a for a in arrivals if a is not None and a[0] <= ticks - 1), key=lambda a: (a[0], -a[1]))
    newest, stale = -1, 0
    for _, k, _ in arrived:
        stale += k <= newest
        newest = max(newest, k)
    expected = {
        "sent": ticks - 1,
        "lost": arrivals.count(None),
        "duplicated": sum(is_copied(k, p) for k in range(ticks - 1)),
        "received": len(arrived),
        "stale": stale,
    }
    assert counts == expected
    assert counts["received"] - counts["stale"] == np.sum(np.diff(received[:, 0]) > 0.0)
    assert min(expected.values()) > 10  # each of these did happen


def test_rate_limit_lets_through_what_the_link_takes():
    received = transmitted(ChannelConfig(rate_limit=100.0), 200)[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(np.diff(received)) + 1, np.arange(10, 200, 10))
    np.testing.assert_array_equal(received[10:20], 11.0)  # fresh: sent at the tick at which the link is free
    # A queue of two fills up, and then everything waits for two packets to go.
    queued = transmitted(ChannelConfig(rate_limit=100.0, queue=2), 400)[:, 0]
    changes = np.flatnonzero(np.diff(queued)) + 1
    assert np.all(np.diff(changes)[-20:] == 10)
    assert changes[-1] + 1 - queued[changes[-1]] == 20


def test_between_ticks_nothing_arrives():
    channel = NetworkChannel(ChannelConfig(loss=0.3, seed=1), 1, H)
    simulator = Simulator(channel)
    port = channel.GetInputPort("sent")
    for k in range(30):
        port.FixValue(simulator.get_mutable_context(), [float(k)])
        simulator.AdvanceTo(k * H)
        at_tick = channel.GetOutputPort("received").Eval(simulator.get_context())[0]
        simulator.AdvanceTo((k + 0.5) * H)
        port.FixValue(simulator.get_mutable_context(), [-1.0])
        assert channel.GetOutputPort("received").Eval(simulator.get_context())[0] == at_tick


@pytest.mark.parametrize("change", [{}, {"loss": 0.1}, {"rate_limit": 1e-6, "queue": 10}], ids=str)
def test_delay_too_long_to_remember_is_bad_input(change):
    with pytest.raises(BadInput, match="100000 ticks"):
        network_channel(ChannelConfig(delay=101.0, **change), 6, H)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"period": 0.0}, "period"),
        ({"period": float("nan")}, "period"),
        ({"initial": [1.0]}, "initial"),
        ({"initial": [1.0, float("nan")]}, "initial"),
        ({"interpolation": "cubic"}, "interpolation"),
        ({"signal": 3, "interpolation": "motion"}, "interpolation"),
        pytest.param({"signal": Value("model"), "initial": [1.0]}, "abstract", id="initial of a value"),
        ({"signal": 0}, "signal"),
        ({"signal": "cloud"}, "signal"),
    ],
    ids=str,
)
def test_signals_that_do_not_fit_are_bad_input(options, word):
    arguments = {"signal": 2, "period": H, **options}
    for config in (ChannelConfig(), ChannelConfig(delay=0.1), ChannelConfig(loss=0.1)):
        with pytest.raises(BadInput, match=word):
            network_channel(config, arguments.pop("signal", 2), arguments.pop("period", H), **arguments)
        arguments = {"signal": 2, "period": H, **options}
