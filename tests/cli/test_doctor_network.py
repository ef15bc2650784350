"""`doctor` on the network: what would hold the link up, on a machine made of files and with a ping made of a script."""

from pathlib import Path

import pytest
from test_doctor import machine, named, write

from mmt_drake.cli import network as subject
from mmt_drake.cli.machine import Machine
from mmt_drake.cli.network import network


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "_loopback", lambda: [30.0] * 99 + [300.0])


@pytest.mark.parametrize(
    ("files", "name", "status", "advice"),
    [
        ({"eth0/operstate": "up", "eth0/mtu": "1500"}, "eth0", "ok", ""),
        ({"wg0/operstate": "up", "wg0/mtu": "1200"}, "wg0", "gap", "ip link set wg0 mtu 1500"),
        ({"wlan0/operstate": "up", "wlan0/mtu": "1500", "wlan0/wireless/x": ""}, "wlan0", "optional", "use a cable"),
        ({"eth0/operstate": "down", "lo/operstate": "up"}, "interfaces", "optional", "connect a cable"),
    ],
)
def test_each_interface_is_judged(tmp_path: Path, files: dict[str, str], name: str, status: str, advice: str) -> None:
    write(tmp_path, {f"sys/class/net/{file}": text for file, text in files.items()})
    check = named(network(machine(tmp_path)), name)
    assert check.status == status and advice in check.advice and bool(check.advice) == (status != "ok")


@pytest.mark.parametrize(
    ("files", "name", "status"),
    [
        ({"proc/sys/net/core/rmem_max": "212992"}, "receive buffer", "optional"),
        ({"proc/sys/net/core/rmem_max": "262144"}, "receive buffer", "ok"),
        ({}, "receive buffer", "optional"),
        ({"proc/modules": "ext4 1 2 - Live\nnf_tables 3 4 - Live"}, "firewall", "optional"),
        ({"proc/modules": "ext4 1 2 - Live"}, "firewall", "ok"),
        ({}, "round trip on loopback", "ok"),
    ],
)
def test_buffers_and_filters_are_read_from_the_kernel(
    tmp_path: Path, files: dict[str, str], name: str, status: str
) -> None:
    write(tmp_path, files)
    assert named(network(machine(tmp_path)), name).status == status


def test_a_busy_machine_is_told_by_its_loopback(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subject, "_loopback", lambda: [30.0] * 90 + [5000.0] * 10)
    check = named(network(machine(tmp_path)), "round trip on loopback")
    assert (check.status, check.found) == ("optional", "median 30 us, 99th percentile 5000 us")


def with_ping(folder: Path, script: str) -> Machine:
    """A machine whose `ping` is this script."""
    folder.joinpath("ping").write_text(f"#!/bin/sh\n{script}\n")
    folder.joinpath("ping").chmod(0o755)
    return machine(folder, PATH=f"{folder}:/bin:/usr/bin")


def answers(times: list[float]) -> str:
    return "\n".join(f"echo '1260 bytes from 10.0.0.2: icmp_seq=1 ttl=64 time={time} ms'" for time in times)


@pytest.mark.parametrize(
    ("times", "status", "found"),
    [
        ([0.3] * 100, "ok", "median 0.30 ms, 99th percentile 0.30 ms, 0 % lost of 1280 bytes"),
        ([0.3] * 90 + [30.3] * 10, "optional", "median 0.30 ms, 99th percentile 30.30 ms"),
        ([0.3] * 90, "gap", "10 % lost"),
        ([150.0] * 100, "gap", "99th percentile 150.00 ms"),
    ],
)
def test_the_way_to_a_peer_is_judged_by_delay_jitter_and_loss(
    tmp_path: Path, times: list[float], status: str, found: str
) -> None:
    check = named(network(with_ping(tmp_path, answers(times)), "10.0.0.2"), "round trip to 10.0.0.2")
    assert check.status == status and found in check.found
    assert bool(check.advice) == (status != "ok")


def test_jitter_is_answered_with_a_playout_that_covers_it(tmp_path: Path) -> None:
    times = answers([0.3] * 90 + [30.3] * 10)
    assert named(network(with_ping(tmp_path, times), "far"), "round trip to far").advice.endswith("playout=0.030")


@pytest.mark.parametrize(("times", "seconds"), [([0.3] * 90, 0.2), ([150.0] * 100, 0.6)])
def test_loss_and_delay_are_answered_with_a_timeout_longer_than_the_link_s_own(
    tmp_path: Path, times: list[float], seconds: float
) -> None:
    from mmt_drake.hw.link.options import LinkOptions

    advice = named(network(with_ping(tmp_path, answers(times)), "far"), "round trip to far").advice
    assert advice.endswith(f"timeout={seconds}") and seconds > LinkOptions().timeout


def test_a_peer_that_does_not_answer_or_is_unknown_is_told_in_pings_own_words(tmp_path: Path) -> None:
    unknown = with_ping(tmp_path, "echo 'ping: nowhere: Name or service not known' >&2; exit 2")
    check = named(network(unknown, "nowhere"), "round trip to nowhere")
    assert (check.status, check.found) == ("gap", "ping: nowhere: Name or service not known")


def test_no_ping_is_told(tmp_path: Path) -> None:
    check = named(network(machine(tmp_path, PATH=str(tmp_path)), "far"), "round trip to far")
    assert check.status == "gap" and "iputils-ping" in check.advice


def test_loopback_is_really_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    times = subject._loopback(20)
    assert len(times) == 20 and min(times) > 0.0
