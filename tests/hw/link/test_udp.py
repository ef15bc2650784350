"""The link over real sockets: on loopback, and across network namespaces."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from link_samples import KEY, SIGNALS, free_ports

from mmt_drake.errors import BadInput
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import OPERATOR, TELEROBOT, LinkOptions
from mmt_drake.hw.link.udp import Address, UdpSocket

HERE = "127.0.0.1"
OPTIONS = LinkOptions(timeout=0.3)


def open_link(role: str, port: int, peer: int) -> Link:
    return Link(role, SIGNALS, KEY, UdpSocket(Address(HERE, port), Address(HERE, peer)), OPTIONS)  # type: ignore[arg-type]


def test_over_sockets_the_newest_is_shown_and_silence_is_told_and_healed() -> None:
    ports = free_ports(2)
    with open_link(OPERATOR, *ports) as operator, open_link(TELEROBOT, ports[1], ports[0]) as telerobot:
        model, motion, n, shown = np.zeros(4), np.zeros(6), 0, list[tuple[float, float]]()

        def until(so: Callable[[], bool], *, silent: bool = False) -> float:
            """Exchange every 2 ms, or as fast as the machine does, until something is so; how long that took [s]."""
            nonlocal n
            began = time.monotonic()
            while not so():
                assert time.monotonic() < began + 10.0
                n += 1
                if not silent:
                    operator.exchange(2e-3 * n, np.full(6, float(n)), model)
                telerobot.exchange(2e-3 * n, np.full(4, float(n)), motion)
                shown.append((motion[0], model[1]))
                time.sleep(2e-3)
            return time.monotonic() - began

        until(lambda: operator.alive and telerobot.alive)
        shown.clear()
        until(lambda: len(shown) == 100)
        for numbers in np.array(shown).T:
            assert np.all(np.diff(numbers) >= 0) and n - 100 < numbers[-1] <= n  # numbers that were sent, in order
        assert until(lambda: not telerobot.alive, silent=True) >= OPTIONS.timeout - 0.01
        until(lambda: operator.alive and telerobot.alive)


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
from mmt_drake.hw.link.link import Link
from mmt_drake.hw.link.options import LinkOptions
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
