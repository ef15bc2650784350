"""The page comes from this machine alone, fetches nothing from elsewhere, ends with the run, and obeys nobody else."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import pytest
from browsers import Address, connect, head, move, status, stream

from mmt_drake.errors import BadInput
from mmt_drake.estimation.carried import GONE, SLIPS
from mmt_drake.learning.answer import LearnerStatus
from mmt_drake.model.parameters import THETA_UNITS
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect
from mmt_drake.viewer import charts, serve
from mmt_drake.viewer.viewer import Viewer

NAME = "hand x [m]"
FRAMES = {
    "an empty binary frame": b"\x82\x80\0\0\0\0",
    "no MessagePack": b"\x82\x81\0\0\0\0\xc1",
    "an oversized frame": b"\x82\xff" + b"\xff" * 8 + b"\0" * 4,
}


@pytest.fixture
def slider(viewer: Viewer) -> Viewer:
    """A viewer with a slider, which a page has taken up."""
    viewer.add_slider(NAME, -0.1, 0.1, 0.0005, 0.0)
    viewer.flush()
    deadline = time.monotonic() + 20.0
    while status(viewer.url, move(viewer.url, NAME, 0.0)) != 204 and time.monotonic() < deadline:
        time.sleep(0.01)
    return viewer


def stands(viewer: Viewer, value: float) -> bool:
    """Whether a move that follows is obeyed, and what came before it was not: the run hears of nothing else."""
    heard = []
    assert status(viewer.url, move(viewer.url, NAME, value)) == 204
    deadline = time.monotonic() + 20.0
    while viewer.hear()[NAME] != value and time.monotonic() < deadline:
        heard.append(viewer.values[NAME])
        time.sleep(0.005)
    return viewer.values[NAME] == value and set(heard) <= {0.0}


def listens(url: str) -> bool:
    try:
        connect(url).close()
    except ConnectionError:
        return False
    return True


def test_the_page_names_no_address() -> None:
    without_comments = re.sub(r"(?m)(^|\s)// .*$", "", charts.page())
    assert not re.findall(r"\b(?:https?|wss?)://", without_comments)


def test_there_is_a_chart_with_unit_for_both_forces_and_every_parameter() -> None:
    shown = {
        charts.COLUMNS[trace.column]: chart.title for chart in charts.station_panels().charts for trace in chart.traces
    }
    for axis in "xyz":
        assert shown[f"force_{axis}"] == shown[f"rendered_force_{axis}"] == f"force {axis} [N]"
    for symbol, unit in THETA_UNITS.items():
        assert shown[f"theta_{symbol}"] == f"{symbol} [{unit}]"


def test_the_server_gives_its_page_to_this_machine_alone_until_it_is_closed() -> None:
    with Viewer("<p>force [N] – größer</p>") as viewer:
        with connect(viewer.url) as page:
            page.sendall(head(viewer.url, f"GET {Address(viewer.url).path}"))
            assert b"".join(iter(lambda: page.recv(4096), b"")).endswith("<p>force [N] – größer</p>".encode())
        at = Address(viewer.url)
        for place in ("etc/passwd", "../etc/passwd", "%2e%2e/etc/passwd", "serve.py", "events/", "//"):
            assert status(viewer.url, head(viewer.url, f"GET {at.path}{place}")) == 404
        table = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
        bound = [row[1] for row in table if row[3] == "0A" and row[1].endswith(f":{at.port:04X}")]
        assert bound == [f"0100007F:{at.port:04X}"]
    assert not listens(viewer.url)
    viewer.close()  # a second time


@pytest.mark.parametrize(
    ("forged", "fields"),
    [
        ("a foreign page", {"Origin": "http://evil.example"}),
        ("a page of another server here", {"Origin": "http://127.0.0.1:8888"}),
        ("the same by another name", {"Origin": "http://localhost:{port}"}),
        ("a page in a sandbox", {"Origin": "null"}),
        ("two origins", {"Origin": "http://127.0.0.1:{port}\r\nOrigin: http://evil.example"}),
        ("a name that an attacker's DNS points here", {"Host": "evil.example:{port}"}),
        ("the same throughout", {"Host": "evil.example:{port}", "Origin": "http://evil.example:{port}"}),
        ("another port", {"Host": "127.0.0.1:1", "Origin": "http://127.0.0.1:1"}),
    ],
)
def test_who_is_not_its_page_moves_no_slider_and_sees_nothing(
    slider: Viewer, forged: str, fields: dict[str, str]
) -> None:
    at = Address(slider.url)
    fields = {name: value.format(port=at.port) for name, value in fields.items()}
    assert status(slider.url, move(slider.url, NAME, 0.08, **fields)) in (400, 403, 421)
    for page in ("", "events", "meshcat.js"):
        assert status(slider.url, head(slider.url, f"GET {at.path}{page}", **fields)) in (400, 403, 421)
    assert stands(slider, 0.05)
    slider.close()
    assert sum(slider.refused.values()) >= 4


@pytest.mark.parametrize("path", ["/", "//", "/sliders", "/{wrong}/sliders", "/{short}/sliders", "/{token}", "/%00/é/"])
def test_without_the_token_nobody_moves_a_slider_or_sees_anything(slider: Viewer, path: str) -> None:
    token = Address(slider.url).path.strip("/")
    path = path.format(wrong="A" * len(token), short=token[:-1], token=token)
    sent = move(slider.url, NAME, 0.08).replace(f"/{token}/sliders".encode(), path.encode())
    assert status(slider.url, sent) == 404
    assert status(slider.url, head(slider.url, f"GET {path}")) == 404
    assert stands(slider, 0.05)


def test_a_page_must_say_where_it_is_from_to_move_a_slider(slider: Viewer) -> None:
    origin = f"Origin: http://{Address(slider.url).host}\r\n".encode()
    assert status(slider.url, move(slider.url, NAME, 0.08).replace(origin, b"")) == 403
    assert stands(slider, 0.05)


@pytest.mark.parametrize(
    "body",
    [b"", b"\xc1", b"\xff\xfe", b"null", b"[]", b"{}", b"[" * 1000, b'{"name": "hand x [m]"}',
     b'{"name": "hand x [m]", "value": NaN}', b'{"name": "hand x [m]", "value": 0.11}',
     b'{"name": "hand x [m]", "value": "0.05"}', b'{"name": "hand x [m]", "value": true}',
     b'{"name": "hand x [m]", "value": 1e999}', b'{"name": ["hand x [m]"], "value": 0.05}',
     b'{"name": "stop", "value": 0.05}', b'{"name": "hand x [m]", "value": 1' + b"0" * 900 + b"}"],
)  # fmt: skip
def test_what_is_no_slider_s_value_is_dropped_and_counted(slider: Viewer, body: bytes) -> None:
    sent = move(slider.url, NAME, 0.08).partition(b"\r\n\r\n")[0]
    sent = re.sub(rb"Content-Length: \d+", b"Content-Length: %d" % len(body), sent)
    assert status(slider.url, sent + b"\r\n\r\n" + body) == 400
    assert stands(slider, 0.05)
    slider.close()
    assert slider.refused["no slider's value"] == 1


@pytest.mark.parametrize(
    ("sent", "answer"),
    [
        *((head("http://127.0.0.1:1/", "GET /", Upgrade="websocket", Connection="Upgrade") + frame, 421)
          for frame in FRAMES.values()),
        *((frame, 400) for frame in FRAMES.values()),
        (b"\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03", 400),  # TLS
        (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", 400),
        (b"\r\n\r\n", 400),
        (b"GET /\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost : x\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n", 413),
        (b"GET / HTTP/1.1\r\nCookie: " + b"x" * (2 * serve.LARGEST_HEAD) + b"\r\n\r\n", 431),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_dropped_and_takes_the_view_from_nobody(
    slider: Viewer, sent: bytes, answer: int
) -> None:
    with stream(slider.url) as other:
        assert status(slider.url, sent) in (answer, 0)  # 0: it has sent more than was read
        assert stands(slider, 0.05)
        slider.add_samples([1.0] * len(charts.COLUMNS))
        slider.flush()
        seen = b""
        while b"samples" not in seen:
            seen += other.recv(1 << 16)
        assert b'"value": 0.05' in seen
    slider.close()
    assert sum(slider.refused.values()) == 1


def test_half_open_and_slow_connections_are_ended_and_hold_up_nobody(slider: Viewer) -> None:
    with ExitStack() as opened:
        idle = [opened.enter_context(connect(slider.url)) for _ in range(40)]
        slow = [opened.enter_context(connect(slider.url)) for _ in range(40)]
        for connection in slow:
            connection.sendall(b"GET / HT")
        start = time.monotonic()
        assert stands(slider, 0.05)
        assert time.monotonic() - start < serve.PATIENCE
        for connection in slow:
            connection.sendall(b"T")  # another byte gains no time
        for connection in idle:
            assert connection.recv(1) == b""
        for connection in slow:
            assert connection.recv(16).startswith(b"HTTP/1.1 408")
    slider.close()
    assert slider.refused == {"too slow": 40}


def test_more_connections_than_can_be_had_cost_no_view(slider: Viewer) -> None:
    with ExitStack() as opened:
        streams = [opened.enter_context(stream(slider.url)) for _ in range(serve.MOST_STREAMS + 1)]
        answers = [connection.recv(12) for connection in streams]
        assert answers == [b"HTTP/1.1 200"] * serve.MOST_STREAMS + [b"HTTP/1.1 503"]
        flood = [opened.enter_context(connect(slider.url)) for _ in range(serve.MOST_CONNECTIONS)]
        assert flood[-1].recv(1) == b""  # at once
        slider.add_samples([1.0] * len(charts.COLUMNS))
        slider.flush()
        seen = b""
        while b"samples" not in seen:
            seen += streams[0].recv(1 << 16)


def test_the_server_holds_little_for_a_reader_that_is_stuck(slider: Viewer) -> None:
    def memory() -> int:
        """Of the server [kB]."""
        told = Path(f"/proc/{slider._process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", told)[1])

    with stream(slider.url, window=4096):
        before = memory()
        for i in range(3000):  # 90 s of a run
            slider.add_samples([float(i)] * len(charts.COLUMNS) * 3)
            slider.set_transform("/station/hand", [[float(i)] * 4] * 4)
            slider.flush()
            time.sleep(0.0005)
        assert memory() - before < 20_000


def test_a_moved_slider_is_seen_by_every_page(slider: Viewer) -> None:
    with stream(slider.url) as other:
        assert stands(slider, -0.02)
        seen = b""
        while b'"value": -0.02' not in seen:
            seen += other.recv(4096)


def test_the_server_ends_when_the_run_is_killed() -> None:
    program = (
        "import time; from mmt_drake.viewer.viewer import Viewer; viewer = Viewer('page'); "
        "print(viewer.url, flush=True); time.sleep(60)"
    )
    run = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    url = run.stdout.readline().strip()
    assert listens(url)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    deadline = time.monotonic() + 10.0
    while listens(url) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not listens(url)
    run.stdout.close()


def test_a_server_that_cannot_be_started_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mmt_drake.viewer.viewer.sys.executable", "/bin/false")
    with pytest.raises(BadInput, match="status 1"):
        Viewer("page")


def test_nothing_else_listens(slider: Viewer) -> None:
    """No port of Meshcat's own, which would obey any page: of this process and its server, one socket listens."""
    links = set()
    for pid in (os.getpid(), slider._process.pid):
        for descriptor in Path(f"/proc/{pid}/fd").iterdir():
            try:
                links.add(os.readlink(descriptor))
            except OSError:
                continue
    tables = [Path(f"/proc/net/{kind}").read_text().splitlines()[1:] for kind in ("tcp", "tcp6")]
    ours = [row.split() for table in tables for row in table if f"socket:[{row.split()[9]}]" in links]
    assert [row[1].split(":")[1] for row in ours if row[3] == "0A"] == [f"{Address(slider.url).port:04X}"]


def test_a_law_that_is_told_stands_in_words_behind_its_code() -> None:
    law = ToldEffect("nonlinear_stiffness", {"k3": 3e6})
    told = ModelMessage(UNKNOWN_THETA, (law,), sensor=SensorError(bias=0.3))
    row = dict(zip(charts.COLUMNS, charts.sample(1.0, {"model": told.vector().tolist()}), strict=True))
    settings = json.loads(re.search(r"const settings = (\{.*\});", charts.page()).group(1))
    assert [charts.COLUMNS[at] for at in settings["laws"]] == ["model_effect1", "model_effect2"]
    assert settings["effects"][f"{row['model_effect1']:.0f}"] == ["nonlinear stiffness", "k3 = # N/m^3"]
    sensor = {charts.COLUMNS[int(at)]: words for at, words in settings["sensor"].items()}
    assert sensor["model_force_bias"] == ["force bias", "bias = # N"] and len(sensor) == 4
    assert (row["model_force_bias"], row["model_force_lag"]) == (0.3, 0.0)
    assert row["model_effect1_1"] == 3e6 and row["model_effect2"] == 0.0
    assert len(settings["learners"]) == len(LearnerStatus)


def test_what_is_carried_stands_in_words_with_its_mass() -> None:
    row = dict(zip(charts.COLUMNS, charts.sample(1.0, {"carried": [float(SLIPS), 0.3, 0.05, 0.1, 8.0]}), strict=True))
    settings = json.loads(re.search(r"const settings = (\{.*\});", charts.page()).group(1))
    assert [charts.COLUMNS[at] for at in settings["carried"]] == ["carried_state", "carried_m"]
    assert "slips" in settings["grips"][int(row["carried_state"])] and row["carried_m"] == 0.3
    assert len(settings["grips"]) == GONE + 1
