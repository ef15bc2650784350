"""One direction of a network: what arrives, when, and that nothing stale is ever applied."""

import copy
import dataclasses
import math

import numpy as np
import pytest
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import DiscreteTimeDelay, LogVectorOutput, PassThrough
from scipy import stats

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig, load_trace
from mmt_drake.network.packets import STATISTICS
from mmt_drake.network.parameters import channel_parameters
from mmt_drake.network.transit import transit
from mmt_drake.random import splitmix64
from mmt_drake.systems.abstract_network_channel import AbstractNetworkChannel
from mmt_drake.systems.network_channel import NetworkChannel, network_channel
from mmt_drake.typed_yaml import fill, parse

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


def transmitted(config, ticks, *, source=tick, size=1, statistics=False, **options):
    """What a channel shows at ticks 0, 1, ..., (ticks, size), and its statistics if asked for."""
    builder = DiagramBuilder()
    sender = builder.AddSystem(Source(source, size))
    channel = builder.AddSystem(network_channel(config, size, H, statistics=statistics, **options))
    builder.Connect(sender.get_output_port(), channel.GetInputPort("sent"))
    log = LogVectorOutput(channel.GetOutputPort("received"), builder, publish_period=H)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    simulator.AdvanceTo((ticks - 1) * H)
    data = log.FindLog(simulator.get_context()).data().T
    assert len(data) == ticks
    if not statistics:
        return data
    counts = channel.GetOutputPort("statistics").Eval(channel.GetMyContextFromRoot(simulator.get_context()))
    return data, dict(zip(STATISTICS, counts, strict=True))


# Constant delay


@pytest.mark.parametrize("n", [1, 2, 7, 400])
@pytest.mark.parametrize(
    "options", [{}, {"initial": [-5.0]}, {"statistics": True}], ids=["drake", "initial", "counting"]
)
def test_delay_of_n_ticks_is_exact_to_the_tick(n, options):
    received = transmitted(ChannelConfig(delay=n * H), n + 20, **options)
    received = received[0] if "statistics" in options else received
    first = options.get("initial", [0.0])[0]
    np.testing.assert_array_equal(received[:, 0], [first] * n + list(range(1, 21)))


@pytest.mark.parametrize("options", [{}, {"statistics": True}], ids=["drake", "counting"])
def test_no_delay_is_a_wire(options):
    channel = network_channel(ChannelConfig(), 1, H, **options)
    assert channel.HasAnyDirectFeedthrough()
    received = transmitted(ChannelConfig(), 10, **options)
    received = received[0] if options else received
    np.testing.assert_array_equal(received[:, 0], np.arange(1, 11))


@pytest.mark.parametrize(
    ("delay", "period", "ticks"),
    [(0.0023, 0.001, 3), (1e-7, 0.001, 1), (0.3, 0.1, 3), (0.4, 1 / 30, 12), (0.41, 1 / 30, 13)],
)
def test_delay_between_ticks_is_rounded_up(delay, period, ticks):
    for options in ({}, {"statistics": True}):
        channel = network_channel(ChannelConfig(delay=delay), 1, period, **options)
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


# Random networks


def by_brute_force(config, ticks):
    """What is shown at each tick: the newest packet that has arrived, from one list of all arrivals."""
    p, trace = channel_parameters(config, H)
    gap = 0.0 if config.rate_limit is None else 1.0 / (config.rate_limit * H)
    copies = copied_packets(config, ticks)
    arrivals, free = [], 0.0
    for k in range(ticks):
        wait = max(0.0, free - k)
        if gap and wait > config.queue * gap + 1e-6:
            continue
        free = k + wait + gap
        for copy_number in range(1 + (k in copies)):
            ticks_in_network = transit(k, copy_number, p, trace)
            if ticks_in_network >= 0.0:
                arrivals.append((math.ceil(k + wait + ticks_in_network - 1e-6), k))
    return np.array([max([k for at, k in arrivals if at <= now], default=-1) + 1.0 for now in range(ticks)])


def copied_packets(config, ticks):
    """Packets that the network duplicates: found by a channel that does nothing else, from its counts."""
    if config.duplication == 0.0:
        return set()
    channel = NetworkChannel(ChannelConfig(duplication=config.duplication, seed=config.seed), 1, H)
    simulator = Simulator(channel)
    channel.GetInputPort("sent").FixValue(simulator.get_mutable_context(), [0.0])
    port, found, before = channel.GetOutputPort("statistics"), set(), 0.0
    for k in range(ticks):
        simulator.AdvanceTo((k + 0.5) * H)
        count = port.Eval(simulator.get_context())[2]
        if count > before:
            found.add(k)
        before = count
    return found


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
    received, counts = transmitted(config, ticks, statistics=True)
    np.testing.assert_array_equal(received[:, 0], by_brute_force(config, ticks))
    assert np.all(np.diff(received[:, 0]) >= 0.0)  # never stale over newer
    assert counts["sent"] == ticks - 1  # the last tick's packet leaves as time goes on


def test_counts_are_those_of_what_happened():
    ticks = 600
    received, counts = transmitted(WILD, ticks, statistics=True)
    # The last update, at tick `ticks - 2`, sent the packet of that number and took in what arrives a tick later.
    copies = copied_packets(WILD, ticks - 1)
    p, trace = channel_parameters(WILD, H)
    arrivals = [
        (math.ceil(k + transit(k, c, p, trace) - 1e-6), k, c) if transit(k, c, p, trace) >= 0.0 else None
        for k in range(ticks - 1)
        for c in range(1 + (k in copies))
    ]
    arrived = sorted((a for a in arrivals if a is not None and a[0] <= ticks - 1), key=lambda a: (a[0], -a[1]))
    newest, stale = -1, 0
    for _, k, _ in arrived:
        stale += k <= newest
        newest = max(newest, k)
    expected = {
        "sent": ticks - 1,
        "lost": arrivals.count(None),
        "duplicated": len(copies),
        "received": len(arrived),
        "stale": stale,
    }
    assert counts == expected
    assert counts["received"] - counts["stale"] == np.sum(np.diff(received[:, 0]) > 0.0)
    assert min(expected.values()) > 10  # each of these did happen


def test_delays_follow_their_laws():
    def drawn(law):
        p, trace = channel_parameters(ChannelConfig(delay=0.2, jitter=0.03, jitter_law=law), H)
        return np.array([transit(k, 0, p, trace) for k in range(20000)]) * H

    uniform, normal, gamma = (drawn(law) for law in ("uniform", "normal", "gamma"))
    for sample, law in (
        (uniform, stats.uniform(0.17, 0.06)),
        (normal, stats.norm(0.2, 0.03)),
        (gamma, stats.gamma(2.0, loc=0.2, scale=0.03 / math.sqrt(2.0))),
    ):
        assert stats.kstest(sample, law.cdf).pvalue > 0.01
        assert abs(np.corrcoef(sample[1:], sample[:-1])[0, 1]) < 0.02
    assert gamma.std() == pytest.approx(0.03, rel=0.03)


@pytest.mark.parametrize("field", ["loss", "duplication", "reordering"])
def test_chances_come_out_as_asked(field):
    config = ChannelConfig(delay=0.005, reordering_delay=0.05, seed=3, **{field: 0.2})
    ticks = 8000
    _, counts = transmitted(config, ticks, statistics=True)
    happened = {
        "loss": counts["lost"],
        "duplication": counts["duplicated"],
        # Held back by 50 ms, a packet is overtaken unless all of the next 50 are held back, too.
        "reordering": counts["stale"],
    }[field]
    assert abs(happened - 0.2 * ticks) < 4.0 * math.sqrt(0.16 * ticks) + 60


@pytest.mark.filterwarnings("ignore:overflow")  # numpy warns of the wrap-around that is meant
def test_random_words_are_those_of_the_published_generator():
    found = [int(splitmix64.py_func(np.uint64(1234567), np.uint64(k))) for k in range(5)]
    assert found == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


def test_same_seed_same_network_other_seed_other_network():
    first, again = transmitted(WILD, 300), transmitted(WILD, 300)
    np.testing.assert_array_equal(first, again)
    other = transmitted(dataclasses.replace(WILD, seed=8), 300)
    assert np.mean(first == other) < 0.5


def test_clone_goes_on_with_the_same_packets():
    for channel, value in (
        (NetworkChannel(WILD, 1, H), lambda t: tick(t)),
        (AbstractNetworkChannel(WILD, Value(0.0), H), lambda t: tick(t)[0]),
    ):
        runs = []
        simulator = Simulator(channel)
        for start, end in ((0, 150), (150, 400)):
            if start:
                clone = Simulator(channel, simulator.get_context().Clone())
            for each in [simulator] if not start else [simulator, clone]:
                seen = []
                for k in range(start, end):
                    port = channel.GetInputPort("sent")
                    port.FixValue(each.get_mutable_context(), value(k * H))
                    each.AdvanceTo((k + 0.5) * H)
                    seen.append(np.ravel(channel.GetOutputPort("received").Eval(each.get_context()))[0])
                runs.append(seen)
        assert runs[1] == runs[2]
        assert runs[1][-1] > 350.0


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


# Abstract signals


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


# Play-out buffer

JITTERY = ChannelConfig(delay=0.12, jitter=0.04, playout=0.16, seed=5)


def sine(t):
    w = 2.0 * math.pi * 1.5
    return [0.03 * math.sin(w * t), 0.03 * w * math.cos(w * t)]


def test_playout_turns_jitter_into_a_constant_delay():
    received = transmitted(JITTERY, 500)[:, 0]
    np.testing.assert_array_equal(received, [0.0] * 160 + list(range(1, 341)))


def test_jitter_hurts_without_a_playout_buffer_and_not_with_one():
    sent = np.array([sine(k * H) for k in range(1500)])
    errors = {}
    for playout, delay in ((0.0, 120), (0.16, 160)):
        config = dataclasses.replace(JITTERY, playout=playout)
        received = transmitted(config, 1500, source=sine, size=2, interpolation="motion")
        error = received[500:] - sent[500 - delay : 1500 - delay]
        errors[playout] = error.std(axis=0) / sent.std(axis=0)
    assert errors[0.0].min() > 0.03
    assert errors[0.16].max() < 1e-12


def test_playout_bridges_losses_as_asked():
    def cubic(t):
        return [5.0 * t**3 - t + 1.0, 15.0 * t**2 - 1.0]

    config = dataclasses.replace(JITTERY, loss=0.4)
    times = np.arange(600) * H
    for interpolation, source, size in (
        ("linear", lambda t: [3.0 * t - 1.0, 2.0 - t], 2),
        ("motion", cubic, 2),
    ):
        received = transmitted(config, 600, source=source, size=size, interpolation=interpolation)
        expected = np.array([source(t - 0.16) for t in times])
        np.testing.assert_allclose(received[200:], expected[200:], atol=1e-9)
    held = transmitted(config, 600)[:, 0]
    behind = np.arange(1, 601) - 160 - held
    assert np.all(behind[200:] >= 0) and behind[200:].max() >= 2
    p, trace = channel_parameters(config, H)
    arrived = np.array([transit(k, 0, p, trace) >= 0.0 for k in range(600)])
    np.testing.assert_array_equal(behind[200:] == 0, arrived[40:440])


def test_packets_too_late_for_playout_never_turn_it_back():
    config = ChannelConfig(delay=0.02, jitter=0.02, jitter_law="gamma", loss=0.2, playout=0.03, seed=2)
    received, counts = transmitted(config, 3000, statistics=True)
    assert np.all(np.diff(received[:, 0]) >= 0.0)
    assert counts["stale"] > 100
    assert np.all(received[:, 0] <= np.maximum(np.arange(3000) - 30 + 1, 0))


def test_playout_shorter_than_the_delay_is_bad_input():
    with pytest.raises(BadInput, match="playout"):
        ChannelConfig(delay=0.1, playout=0.05)


# Traces


def written(tmp_path, text):
    path = tmp_path / "trace.csv"
    path.write_text(text)
    return path


def test_trace_gives_each_packet_its_delay(tmp_path):
    path = written(tmp_path, "time,delay\n100.0,0.003\n100.010,nan\n100.015,0.001\n100.020,0.005\n")
    received = transmitted(ChannelConfig(trace=str(path)), 60)[:, 0]
    arrivals = {}
    for k in range(60):  # the trace lasts 25 ms and begins again
        phase = k % 25
        delay = 3 if phase < 10 else None if phase < 15 else 1 if phase < 20 else 5
        if delay is not None:
            arrivals.setdefault(k + delay, []).append(k)
    newest, expected = -1, []
    for k in range(60):
        newest = max([newest, *arrivals.get(k, [])])
        expected.append(newest + 1.0)
    np.testing.assert_array_equal(received, expected)


def test_trace_without_delay_passes_at_once(tmp_path):
    path = written(tmp_path, "time,delay\n0,0\n0.01,\n")
    received = transmitted(ChannelConfig(trace=str(path)), 40)[:, 0]
    expected = [k + 1 if k % 20 < 10 else k // 20 * 20 + 10 for k in range(40)]
    np.testing.assert_array_equal(received, expected)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "row 1: found nothing"),
        ("t,d\n0,1\n1,1\n", "header time,delay"),
        ("time,delay\n0,0.1\n", "1 rows"),
        ("time,delay\n0,0.1\n0,0.1\n", "row 3: found time 0"),
        ("time,delay\n0,0.1\n1,-0.1\n", "row 3: found delay -0.1"),
        ("time,delay\n0,0.1\n1,inf\n", "row 3: found delay inf"),
        ("time,delay\n0,0.1\n1,soon\n", "row 3: found 1,soon"),
        ("time,delay\n0,0.1\n1\n", "row 3"),
        ("time,delay\nnan,0.1\n1,0.1\n", "row 2: found time nan"),
        ("time,delay\n0,nan\n1,nan\n", "losses alone"),
    ],
)
def test_bad_trace_is_bad_input(tmp_path, text, words):
    with pytest.raises(BadInput, match=words):
        load_trace(written(tmp_path, text))


def test_missing_or_binary_trace_is_bad_input(tmp_path):
    with pytest.raises(BadInput, match=r"none\.csv"):
        network_channel(ChannelConfig(trace=str(tmp_path / "none.csv")), 1, H)
    path = tmp_path / "binary.csv"
    path.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(BadInput, match=r"binary\.csv"):
        load_trace(path)


# Configuration


@pytest.mark.parametrize(
    "change",
    [
        {"delay": -0.1},
        {"delay": float("nan")},
        {"delay": float("inf")},
        {"delay": "0.4"},
        {"delay": True},
        {"delay": None},
        {"jitter": -1.0},
        {"jitter_law": "cauchy"},
        {"loss": 1.5},
        {"loss": -0.1},
        {"duplication": 2.0},
        {"reordering": float("nan")},
        {"reordering_delay": -1.0},
        {"rate_limit": 0.0},
        {"rate_limit": "fast"},
        {"queue": -1},
        {"queue": 1.5},
        {"seed": -1},
        {"seed": 1.0},
        {"trace": 5},
        {"trace": "delays.csv", "delay": 0.1},
        {"playout": -1.0},
    ],
    ids=str,
)
def test_impossible_networks_are_bad_input(change):
    with pytest.raises(BadInput, match=f"network channel: {next(iter(change))}"):
        ChannelConfig(**change)


@pytest.mark.parametrize("change", [{}, {"loss": 0.1}, {"rate_limit": 1e-6, "queue": 10}], ids=str)
def test_delay_too_long_to_remember_is_bad_input(change):
    with pytest.raises(BadInput, match="100000 ticks"):
        network_channel(ChannelConfig(delay=101.0, **change), 6, H)


def test_config_is_read_from_yaml():
    data = parse("{delay: 0.4, jitter: 0.02, jitter_law: gamma, rate_limit: 500, seed: 3}", "net.yaml")
    config = fill(ChannelConfig, data, "net.yaml")
    assert config == ChannelConfig(delay=0.4, jitter=0.02, jitter_law="gamma", rate_limit=500.0, seed=3)
    with pytest.raises(BadInput, match=r"net\.yaml: loss: found 3"):
        fill(ChannelConfig, {"loss": 3.0}, "net.yaml")


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
