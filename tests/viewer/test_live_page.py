"""The page beside the scene comes from this machine alone, fetches nothing from elsewhere, and ends with the run."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from urllib.parse import urlsplit

import pytest
from pydrake.geometry import Meshcat

from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import THETA_UNITS
from mmt_drake.viewer import charts
from mmt_drake.viewer.page_server import PageServer
from mmt_drake.viewer.viewer import open_viewer


def answers(url: str) -> bool:
    at = urlsplit(url)
    try:
        socket.create_connection((at.hostname, at.port), timeout=5.0).close()
    except ConnectionError:
        return False
    return True


def test_the_page_names_no_address_but_meshcat_s_own() -> None:
    page = charts.page("http://localhost:7123")
    without_comments = re.sub(r"(?m)(^|\s)// .*$", "", page)
    addresses = set(re.findall(r"\b(?:https?|wss?)://[^\s\"'`<>)]+", without_comments))
    assert addresses == {"http://localhost:7123", "ws://localhost:7123"}
    assert 'src="http://localhost:7123"' in page and 'new WebSocket("ws://localhost:7123")' in page


def test_there_is_a_chart_with_unit_for_both_forces_and_every_parameter() -> None:
    shown = {charts.COLUMNS[trace.column]: chart.title for chart in charts.charts() for trace in chart.traces}
    for axis in "xyz":
        assert shown[f"force_{axis}"] == shown[f"rendered_force_{axis}"] == f"force {axis} [N]"
    for symbol, unit in THETA_UNITS.items():
        assert shown[f"theta_{symbol}"] == f"{symbol} [{unit}]"


def test_the_server_gives_the_page_and_nothing_else_to_this_machine_alone_until_it_is_closed() -> None:
    with PageServer("<p>force [N] – größer</p>") as server:
        with urllib.request.urlopen(server.url, timeout=10.0) as answer:
            assert answer.read().decode() == "<p>force [N] – größer</p>"
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(f"{server.url}etc/passwd", timeout=10.0)
        port = urlsplit(server.url).port
        listening = subprocess.run(["cat", "/proc/net/tcp"], capture_output=True, text=True, check=False).stdout
        bound = [line.split()[1] for line in listening.splitlines()[1:] if line.split()[3] == "0A"]
        if bound:  # Linux
            assert f"0100007F:{port:04X}" in bound and f"00000000:{port:04X}" not in bound
    assert not answers(server.url)
    server.close()  # a second time


def test_the_server_ends_when_the_run_is_killed() -> None:
    program = (
        "import time; from mmt_drake.viewer.page_server import PageServer; "
        "print(PageServer('page').url, flush=True); time.sleep(60)"
    )
    run = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    url = run.stdout.readline().strip()
    assert answers(url)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    deadline = time.monotonic() + 10.0
    while answers(url) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not answers(url)
    run.stdout.close()


def test_a_page_that_cannot_be_served_leaves_the_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.viewer.page_server.sys.executable", "/bin/false")
    with open_viewer() as viewer:
        assert viewer.url == viewer.meshcat.web_url()
        assert viewer.missing is not None and "status 1" in viewer.missing


def test_a_port_that_is_taken_is_said_in_one_line(meshcat: Meshcat) -> None:
    with pytest.raises(BadInput, match=rf"port {meshcat.port()}\b"), open_viewer(meshcat.port()):
        pass
