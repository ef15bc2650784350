"""`run --side`: what does not fit is refused in one line, and a side whose peer dies ends well."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cli_samples import Program

from mmt_drake.hw.link.keys import write_key
from mmt_drake.recording import load

pytest.importorskip("cryptography", reason="the extra `link` is not installed")

REALTIME = ["run", "setup1", "--realtime", "--seconds", "2"]


def refused(program: Program, *arguments: str) -> str:
    """The one line with which the program refuses."""
    outcome = program(*arguments)
    assert outcome.status == 2 and outcome.out == "" and outcome.err.count("\n") == 1, outcome
    return outcome.err


@pytest.fixture
def key(tmp_path: Path) -> Path:
    write_key(tmp_path / "link.key")
    return tmp_path / "link.key"


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--peer", "127.0.0.1"], "--peer: found no --side"),
        (["--key", "x"], "--key: found no --side"),
        (["--link", "timeout=1"], "--link: found no --side"),
        (["--side", "operator", "--key", "x"], "--side: found no --peer"),
        (["--side", "operator", "--peer", "127.0.0.1"], "--side: found no --key"),
        (["--side", "both", "--peer", "127.0.0.1", "--key", "x"], "--side"),
        (["--side", "operator", "--peer", "127.0.0.1", "--key", "missing.key"], "missing.key: found No such file"),
    ],
)
def test_options_that_do_not_fit_together_are_refused(program: Program, options: list[str], told: str) -> None:
    assert told in refused(program, *REALTIME, *options)


def test_a_side_that_is_not_paced_is_refused(program: Program, key: Path) -> None:
    line = refused(program, "run", "setup1", "--side", "operator", "--peer", "127.0.0.1", "--key", str(key))
    assert "no --realtime" in line


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--peer", "192.0.2.7"], "--listen: found 127.0.0.1:47310, this machine alone"),
        (["--peer", "127.0.0.1:0"], "--peer: found 127.0.0.1:0"),
        (["--peer", "127.0.0.1:port"], "--peer: found 127.0.0.1:port"),
        (["--peer", "127.0.0.1", "--link", "timeout=0"], "timeout: found 0"),
        (["--peer", "127.0.0.1", "--link", "colour=red"], "colour"),
    ],
)
def test_addresses_and_limits_that_are_of_no_use_are_refused(
    program: Program, key: Path, options: list[str], told: str
) -> None:
    assert told in refused(program, *REALTIME, "--side", "operator", "--key", str(key), *options)


def test_a_key_that_others_can_read_is_refused(program: Program, key: Path) -> None:
    key.chmod(0o644)
    line = refused(program, *REALTIME, "--side", "operator", "--peer", "127.0.0.1", "--key", str(key))
    assert "0644" in line and "chmod 600" in line


def test_without_a_peer_the_wait_ends_in_one_line_and_leaves_nothing_behind(
    program: Program, key: Path, tmp_path: Path
) -> None:
    options = ["--side", "operator", "--peer", "127.0.0.1:47399", "--listen", "127.0.0.1:0", "--key", str(key)]
    out = tmp_path / "out.mcap"
    line = refused(program, *REALTIME, *options, "--wait", "0.2", "--record", str(out))
    assert "within 0.2 s" in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link.key"]


def test_the_telerobot_outlives_an_operator_that_is_killed_and_says_so(key: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mmt_drake", "run", "setup1", "--realtime", "--json", "--key", str(key)]
    command += ["--set", "step=0.002", "--set", "environment.cloud.points=2000"]
    sides = {
        side: subprocess.Popen(
            [*command, "--side", side, "--seconds", seconds, "--listen", f"127.0.0.1:{mine}", "--peer",
             f"127.0.0.1:{theirs}", "--record", str(tmp_path / f"{side}.mcap")],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )
        for side, seconds, mine, theirs in (("operator", "60", 47320, 47321), ("telerobot", "6", 47321, 47320))
    }  # fmt: skip
    try:
        end = time.monotonic() + 60.0
        while time.monotonic() < end and not any(
            path.name != key.name and path.stat().st_size > 20_000 for path in tmp_path.iterdir()
        ):
            time.sleep(0.05)
        sides["operator"].send_signal(signal.SIGKILL)
        out, error = sides["telerobot"].communicate(timeout=60)
    finally:
        for process in sides.values():
            process.kill()
    assert sides["telerobot"].returncode == 0, error
    link = json.loads(out)["link"]
    assert link["alive"] == 0.0 and not link["ended"] and link["received"] > 100
    recording = load(tmp_path / "telerobot.mcap")
    assert recording.time[-1] == pytest.approx(6.0 - 0.002)
    assert 0 < link["lost_ticks"] < len(recording.time)
    assert abs(recording.columns["velocity_y"][-1]) < 1e-9  # the probe stands still
