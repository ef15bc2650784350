"""The link over real sockets: through a proxy that does everything to packets, and across network namespaces."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from link_samples import KEY, SIGNALS, free_ports, status
from udp_proxy import Everything, Proxy

from mmt_drake.errors import BadInput
from mmt_drake.hw.link import OPERATOR, TELEROBOT, Link, LinkOptions
from mmt_drake.hw.link.udp import Address, UdpSocket

HERE = "127.0.0.1"
OPTIONS = LinkOptions(timeout=0.3)


def open_link(role: str, port: int, peer: int) -> Link:
    return Link(role, SIGNALS, KEY, UdpSocket(Address(HERE, port), Address(HERE, peer)), OPTIONS)  # type: ignore[arg-type]


class Ends:
    """Both ends in one process, a tick of both every 2 ms or as fast as the machine does."""

    def __init__(self, operator: Link, telerobot: Link) -> None:
        self.operator, self.telerobot = operator, telerobot
        self.n = 0
        self.shown: list[tuple[float, float]] = []

    def tick(self, ticks: int) -> None:
        model, motion = np.zeros(4), np.zeros(6)
        for _ in range(ticks):
            self.n += 1
            self.operator.exchange(2e-3 * self.n, np.full(6, float(self.n)), model)
            self.telerobot.exchange(2e-3 * self.n, np.full(4, float(self.n)), motion)
            self.shown.append((motion[0], model[1]))
            time.sleep(2e-3)


@pytest.fixture
def ends() -> Iterator[tuple[Ends, Proxy, Everything]]:
    ports = free_ports(2)
    everything = Everything(seed=4)
    with Proxy(ports, everything) as proxy, ExitStack() as stack:
        operator = stack.enter_context(open_link(OPERATOR, ports[0], proxy.ports[0]))
        telerobot = stack.enter_context(open_link(TELEROBOT, ports[1], proxy.ports[1]))
        made = Ends(operator, telerobot)
        end = time.monotonic() + 10.0
        while not (operator.alive and telerobot.alive):
            made.tick(10)
            assert time.monotonic() < end, "the ends did not find each other"
        made.shown.clear()
        yield made, proxy, everything


def test_over_sockets_the_newest_is_shown_through_everything_at_once(ends: tuple[Ends, Proxy, Everything]) -> None:
    made, _, everything = ends
    before = status(made.telerobot)["refused"] + status(made.operator)["refused"]
    start, spoiled = made.n, everything.corrupted
    made.tick(500)
    for shown in np.array(made.shown).T:
        assert np.all(shown == np.round(shown)) and np.all(np.diff(shown) >= 0)  # numbers that were sent, in order
        assert start < shown[-1] <= made.n and shown[-1] > made.n - 100
    told = [status(link) for link in (made.operator, made.telerobot)]
    assert all(side["alive"] == 1.0 and side["sessions"] == 1.0 and side["repeated"] > 0.0 for side in told)
    refused = sum(side["refused"] for side in told) - before
    # Corruption in the number of a packet may make it look like one that has been taken.
    assert 0.5 * (everything.corrupted - spoiled) < refused <= everything.corrupted + everything.copied


def test_over_sockets_forged_and_replayed_packets_are_never_applied(ends: tuple[Ends, Proxy, Everything]) -> None:
    made, proxy, _ = ends
    old = [packet for packet in proxy.passed if len(packet) > 100]
    made.tick(5)  # each of them has arrived by now, or a later one has
    proxy.fault = lambda packet, end: []  # nothing true comes through any more
    time.sleep(0.05)
    made.tick(1)
    held = made.shown[-1]
    for n in range(200):
        proxy.inject(old[n % len(old)], 1)
        proxy.inject(old[n % len(old)][:16] + os.urandom(80), 0)
        if n % 20 == 19:
            made.tick(1)
            assert made.shown[-1][0] == held[0]


def test_over_sockets_a_cut_cable_is_told_and_healed(ends: tuple[Ends, Proxy, Everything]) -> None:
    made, proxy, everything = ends
    made.tick(20)
    proxy.fault = lambda packet, end: []
    cut = time.monotonic()
    while made.telerobot.alive or made.operator.alive:
        made.tick(1)
        assert time.monotonic() < cut + 5.0
    assert time.monotonic() - cut >= OPTIONS.timeout - 0.01
    proxy.fault = everything
    made.tick(100)
    assert made.telerobot.alive and made.operator.alive


def test_packets_from_another_address_are_not_even_read() -> None:
    ports = free_ports(3)
    end = UdpSocket(Address(HERE, ports[0]), Address(HERE, ports[1]))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind((HERE, ports[2]))
        stranger.sendto(b"x", (HERE, ports[0]))
    time.sleep(0.01)
    assert end.receive() is None
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind((HERE, ports[1]))
        peer.sendto(b"y", (HERE, ports[0]))
        time.sleep(0.01)
    assert end.receive() == b"y"
    end.close()


def test_a_peer_that_does_not_listen_is_no_error_until_the_wait_is_over() -> None:
    ports = free_ports(2)
    with open_link(OPERATOR, *ports) as link, pytest.raises(BadInput, match="nobody with this key"):
        link.connect(0.1)


@pytest.mark.parametrize(
    ("text", "host", "port"),
    [("10.0.0.1", "10.0.0.1", 7), ("host:80", "host", 80), ("[::1]:9", "::1", 9), ("[fe80::1]", "fe80::1", 7)],
)
def test_addresses_are_read(text: str, host: str, port: int) -> None:
    assert Address.parse(text, "--peer", 7) == Address(host, port)


@pytest.mark.parametrize("text", ["", ":80", "host:", "host:port", "host:70000", "[::1]80", "[::1"])
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(BadInput, match="--listen"):
        UdpSocket(Address.parse(text, "--listen", 7), Address(HERE, 8))


def test_listening_on_this_machine_alone_does_not_go_with_a_peer_elsewhere() -> None:
    with pytest.raises(BadInput, match="--listen HOST:PORT"):
        UdpSocket(Address(HERE, 0), Address("192.0.2.1", 47311))


def test_a_taken_address_is_refused() -> None:
    ports = free_ports(2)
    first = UdpSocket(Address(HERE, ports[0]), Address(HERE, ports[1]))
    with pytest.raises(BadInput, match="a free address"):
        UdpSocket(Address(HERE, ports[0]), Address(HERE, ports[1]))
    first.close()


_END = """
import sys, time
import numpy as np
from link_samples import KEY, SIGNALS
from mmt_drake.hw.link import Link, LinkOptions
from mmt_drake.hw.link.udp import Address, UdpSocket
role, here, there = sys.argv[1:]
link = Link(role, SIGNALS, KEY, UdpSocket(Address(here, 47310), Address(there, 47310)), LinkOptions(timeout=0.3))
link.connect(20.0)
size, shown = SIGNALS[role].size, np.zeros(10 - SIGNALS[role].size)
seen, alive = [], []
start = time.monotonic()
n = 0
while time.monotonic() - start < 4.0:
    n += 1
    link.exchange(n * 2e-3, np.full(size, float(n)), shown)
    seen.append(shown[1]); alive.append(link.alive)
    time.sleep(2e-3)
lost = sum(a and not b for a, b in zip(alive, alive[1:]))
print(len(set(seen)), int(all(a <= b for a, b in zip(seen, seen[1:]))), lost, int(alive[-1]), link.status[2], link.status[4])
"""  # noqa: E501


def _run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def namespaces() -> Iterator[tuple[str, str]]:
    """Two network namespaces with a cable between them: 10.213.7.1 and 10.213.7.2."""
    if shutil.which("ip") is None:
        pytest.skip("no `ip` command")
    one, two = names = f"mmt{os.getpid()}a", f"mmt{os.getpid()}b"
    steps = [["ip", "netns", "add", name] for name in names]
    steps.append(["ip", "link", "add", one, "netns", one, "type", "veth", "peer", "name", two, "netns", two])
    for k, name in enumerate(names):
        steps.append(["ip", "-n", name, "addr", "add", f"10.213.7.{k + 1}/24", "dev", name])
        steps.append(["ip", "-n", name, "link", "set", name, "up"])
    try:
        for step in steps:
            done = _run(*step)
            if done.returncode:
                pytest.skip(f"no network namespaces here: {done.stderr.strip()}")
        yield names
    finally:
        for name in names:
            _run("ip", "netns", "del", name)


def test_across_two_network_namespaces_with_delay_loss_and_a_cut_cable(namespaces: tuple[str, str]) -> None:
    paths = [str(Path(__file__).parent), *filter(None, sys.path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    shaped = all(
        _run("ip", "netns", "exec", name, "tc", "qdisc", "add", "dev", name, "root", "netem",
             "delay", "10ms", "3ms", "loss", "5%", "duplicate", "2%", "reorder", "5%").returncode == 0
        for name in namespaces
    )  # fmt: skip
    started = [
        subprocess.Popen(
            ["ip", "netns", "exec", name, sys.executable, "-c", _END, role, f"10.213.7.{k + 1}", f"10.213.7.{2 - k}"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment,
        )
        for k, (name, role) in enumerate(zip(namespaces, ("operator", "telerobot"), strict=True))
    ]  # fmt: skip
    try:
        end = time.monotonic() + 60.0
        while time.monotonic() < end and not _run("ip", "-n", namespaces[0], "neigh").stdout:
            time.sleep(0.05)
        time.sleep(2.0)
        _run("ip", "-n", namespaces[0], "link", "set", namespaces[0], "down")
        time.sleep(0.6)
        _run("ip", "-n", namespaces[0], "link", "set", namespaces[0], "up")
        told = [process.communicate(timeout=60) for process in started]
    finally:
        for process in started:
            process.kill()
    for out, error in told:
        assert out, error
        different, ordered, losses, alive, round_trip, lost = (float(word) for word in out.split())
        assert different > 100 and ordered == 1 and losses >= 1 and alive == 1, out
        if shaped:
            assert round_trip > 0.013 and lost > 0
