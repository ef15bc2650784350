"""The network that `doctor` looks at: this machine's interfaces and buffers, and the way to another machine."""

import re
import shutil
import socket
import statistics
import subprocess
import threading
import time
from collections.abc import Iterator

from mmt_drake.cli.machine import Check, Machine, judged, percentile_99
from mmt_drake.hw.link.udp import BUFFER, DEFAULT_PORTS
from mmt_drake.hw.link.wire import LARGEST_SIZE

GROUP = "network"

_EXCHANGES = 200
_LOOPBACK_US = 1000.0  # 99th percentile of a round trip on this machine up to which it counts as calm
_PINGS, _EVERY = 100, 0.02  # [s]
_HEADERS = 28  # of IPv4 and ICMP [bytes]
_TIMEOUT_MS = 100.0  # of the link; a peer that is silent for longer counts as lost
_JITTER_MS = 5.0  # beyond it the hand should be shown a little late and evenly
_LOSS = 0.01


def network(machine: Machine, peer: str | None = None) -> Iterator[Check]:
    """Interfaces, buffers, firewall and loopback; given a peer, how long packets take to it and whether all arrive.

    Args:
        machine: where to look.
        peer: name or address of the other machine.
    """
    yield from _interfaces(machine)
    most = int(machine.read("proc/sys/net/core/rmem_max") or 0)
    asked = "" if most >= BUFFER else f", the link asks for {BUFFER / 1024:.0f} KiB"
    found = f"up to {most / 1024:.0f} KiB{asked}" if most else "unknown"
    advice = "for bursts of clouds, run --side: sysctl -w net.core.rmem_max=1048576, and keep it in /etc/sysctl.d"
    yield judged(most >= BUFFER, GROUP, "receive buffer", found, advice)
    yield _firewall(machine)
    times = _loopback()
    found = f"median {statistics.median(times):.0f} us, 99th percentile {percentile_99(times):.0f} us"
    advice = "close what else is running: packets wait for this machine, not for the network"
    yield judged(percentile_99(times) <= _LOOPBACK_US, GROUP, "round trip on loopback", found, advice)
    if peer is not None:
        yield from _way_to(peer, machine)


def _interfaces(machine: Machine) -> Iterator[Check]:
    up = machine.interfaces()
    if not up:
        advice = "connect a cable, if another machine is to take part (run --side)"
        yield Check(GROUP, "interfaces", "optional", "none is up", advice)
    for entry in up:
        name, wireless = entry.name, (entry / "wireless").exists()
        mtu = int(machine.read(f"{entry}/mtu") or 0)
        found = f"{'wireless' if wireless else 'wired'}, packets up to {mtu} bytes"
        if mtu < LARGEST_SIZE:
            advice = f"the link's largest packets are cut up or lost: ip link set {name} mtu 1500"
            yield Check(GROUP, name, "gap", found, advice)
        else:
            advice = "wireless delays packets by tens of ms now and then: use a cable, or run with --link playout=0.05"
            yield judged(not wireless, GROUP, name, found, advice)


def _firewall(machine: Machine) -> Check:
    modules = (machine.read("proc/modules") or "").splitlines()
    filters = sorted({line.split()[0] for line in modules} & {"nf_tables", "ip_tables", "ip6_tables"})
    found = f"{' and '.join(filters) or 'no packet filter is'} loaded"
    first, last = DEFAULT_PORTS.values()
    advice = f"should the sides not find each other: ufw allow {first}:{last}/udp, or the like"
    return judged(not filters, GROUP, "firewall", found, advice)


def _loopback(count: int = _EXCHANGES) -> list[float]:
    """Round trips of small packets through this machine's own network [us]."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as echo,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker,
    ):
        echo.bind(("127.0.0.1", 0))
        asker.settimeout(1.0)

        def answer() -> None:
            for _ in range(count):
                echo.sendto(*echo.recvfrom(64))

        threading.Thread(target=answer, daemon=True).start()
        times = []
        for _ in range(count):
            start = time.perf_counter()
            asker.sendto(bytes(64), echo.getsockname())
            asker.recv(64)
            times.append((time.perf_counter() - start) * 1e6)
    return times


def _way_to(peer: str, machine: Machine) -> Iterator[Check]:
    name = f"round trip to {peer}"
    ping = shutil.which("ping", path=machine.environ.get("PATH"))
    if ping is None:
        yield Check(GROUP, name, "gap", "no program to measure it", "apt-get install iputils-ping")
        return
    size = str(LARGEST_SIZE - _HEADERS)
    command = [ping, "-n", "-c", str(_PINGS), "-i", str(_EVERY), "-W", "1", "-M", "do", "-s", size]
    done = subprocess.run([*command, "--", peer], capture_output=True, text=True, timeout=60, check=False)
    times = [float(number) for number in re.findall(r"time=([\d.]+) ms", done.stdout)]
    if not times:
        said = (done.stderr or done.stdout).strip().splitlines()
        advice = "check cable and address; a machine that answers no ping may be there all the same"
        yield Check(GROUP, name, "gap", said[-1] if said else "no answer", advice)
        return
    median, p99, loss = statistics.median(times), percentile_99(times), 1.0 - len(times) / _PINGS
    found = f"median {median:.2f} ms, 99th percentile {p99:.2f} ms, {100.0 * loss:.0f} % lost of {LARGEST_SIZE} bytes"
    if loss > _LOSS or p99 > _TIMEOUT_MS:
        enough = 1e-3 * max(4.0 * p99, 2.0 * _TIMEOUT_MS)
        advice = f"the peer would count as lost now and then: use a cable, or run with --link timeout={enough:.1g}"
        yield Check(GROUP, name, "gap", found, advice)
    else:
        advice = f"even it out: run with --link playout={(p99 - median) * 1e-3:.3f}"
        yield judged(p99 - median <= _JITTER_MS, GROUP, name, found, advice)
