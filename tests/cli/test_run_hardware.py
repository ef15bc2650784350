"""`run --hardware` on the emulated vendor library: what would run on a device, only the library differs."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any, cast

import numpy as np
import pytest
from cli_samples import PATIENT, Program

from mmt_drake.cli.hardware import Console, ended_as_by_ctrl_c
from mmt_drake.errors import MissingDependency
from mmt_drake.hw.omega.emulator.build import build_library
from mmt_drake.recording import Recording, load

needs_bindings = pytest.mark.skipif(
    importlib.util.find_spec("forcedimension_core") is None, reason="the extra `omega` is not installed"
)
FORCE = 2.5  # [N] the most that the supervisor may let through
HAND = "soft_start=0.5 target_z=-0.035 hand_stiffness=1500 hand_damping=30 swing_y=0.02 swing_hz=0.7"


def command(library: Path, record: Path) -> list[str]:
    # What a busy machine would stop: pauses of the program.
    patient = {"watchdog": "null", "limits.force": FORCE, "library": library}
    line = [sys.executable, "-c", PATIENT, "run", "setup1", "--hardware", "--record", str(record), "--json"]
    line += ["--loosened-limits"]
    line += ["--set", "step=0.002", "--set", "estimator=!OutputErrorOptions {}", "--seconds", "4"]
    for key, value in patient.items():
        line += ["--set", f"operator_device.{key}={value}"]
    return line


def wait_for(stream: IO[str], words: str) -> str:
    """The next line with these words."""
    for line in stream:
        if words in line:
            return line
    pytest.fail(f"never told: {words}")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sdk")
    try:
        build_library(folder)
    except MissingDependency as error:
        pytest.skip(str(error))
    return folder


@pytest.fixture(scope="module")
def outcome(library: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[dict[str, object], Recording]]:
    """A run in which a person arms, presses the stop, releases it and arms again; what it told and recorded."""
    folder = tmp_path_factory.mktemp("run")
    with subprocess.Popen(
        command(library, folder / "out.mcap"),
        env={**os.environ, "EMULATED_OMEGA": HAND},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stdin and run.stdout and run.stderr
        try:
            for heard, pressed in (("not armed yet", "a"), ("armed", ""), ("emergency", "r"), ("ready to arm", "a")):
                wait_for(run.stderr, heard)
                run.stdin.write(f"{pressed}\n")
                run.stdin.flush()
            wait_for(run.stderr, ": armed")
            out, err = run.stdout.read(), run.stderr.read()  # its input stays open: the end of it would be a stop
            run.wait(100)
        finally:
            run.kill()
    assert run.returncode == 0, err
    yield json.loads(out), load(folder / "out.mcap")


@needs_bindings
def test_the_hand_on_the_device_feels_the_object_within_the_limits_and_only_while_armed(
    outcome: tuple[dict[str, object], Recording],
) -> None:
    told, recording = outcome
    columns, ticks = recording.columns, len(recording.time)
    assert told["operator"] == "emulated omega.7" and told["simulated_s"] == 4.0 and ticks == 2000
    assert np.ptp(columns["master_position_y"]) > 0.02, "the emulated hand swings"
    assert columns["in_contact"].mean() > 0.3
    force = np.linalg.norm([columns[f"applied_force_{axis}"] for axis in "xyz"], axis=0)
    armed = columns["safety_armed"] == 1.0
    assert 1.0 < force.max() <= FORCE * (1 + 1e-9)
    # Ramps end 15 ms after the supervisor no longer is armed.
    ramp = np.convolve(armed, np.ones(10), mode="full")[:ticks] > 0
    assert not force[~ramp].any()
    device = told["device"]
    assert isinstance(device, dict)
    assert device["armed_ticks"] == armed.sum() and device["greatest_force_n"] == force.max()
    assert device["stops"] == {"emergency stop": 1} and device["stale_ticks"] == 0


@needs_bindings
def test_lateness_and_overruns_of_every_tick_are_in_the_recording(outcome: tuple[dict[str, object], Recording]) -> None:
    told, recording = outcome
    late, overruns = recording.columns["lateness"], recording.columns["overruns"]
    pacing = told["overruns"]
    assert isinstance(pacing, dict)
    assert pacing["steps"] == len(late)
    for name, quantile in (("median", 0.5), ("p99", 0.99), ("worst", 1.0)):
        assert pacing[f"late_{name}_s"] == pytest.approx(np.quantile(late, quantile), abs=1e-9)
    assert np.all(np.diff(overruns) >= 0) and 0 <= pacing["overruns"] - overruns[-1] <= 1


@needs_bindings
@pytest.mark.parametrize(
    ("there", "emulated", "told"),
    [
        (False, "", "omega: Force Dimension SDK 3.16 or newer not found in "),
        (True, "connected=0", "omega: cannot open the device: no device found"),
    ],
)
def test_a_library_or_a_device_that_is_not_there_is_told_in_one_line(
    library: Path, tmp_path: Path, there: bool, emulated: str, told: str
) -> None:
    line = command(library if there else tmp_path / "nowhere", tmp_path / "out.mcap")
    environ = {**os.environ, "EMULATED_OMEGA": emulated}
    done = subprocess.run(line, env=environ, capture_output=True, text=True, timeout=100, check=False)
    loosened, *lines = done.stderr.splitlines()
    assert done.returncode == 2 and done.stdout == "" and len(lines) == 1, done.stderr
    assert loosened.startswith("limit: operator_device.watchdog = null")
    assert told in done.stderr and not (tmp_path / "out.mcap").exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--operator", "builtin:hand_reaching"], "--operator: found --hardware"),
        (["--set", "operator_device.scale=0"], "operator_device.scale: found 0"),
        (["--set", "operator_device.limits.ramp=0.5"], "operator_device.limits.ramp: found 0.5"),
        (["--set", "operator_device=!Franka {}"], "operator_device: found !Franka, expected !Omega"),
        (["--side", "telerobot", "--realtime", "--peer", "a", "--key", "b"], "--hardware: found --side telerobot"),
    ],
)
def test_what_does_not_fit_a_device_is_refused(program: Program, options: list[str], told: str) -> None:
    outcome = program("run", "setup1", "--hardware", *options)
    assert outcome.status == 2 and outcome.out == "" and outcome.err.count("\n") == 1
    assert told in outcome.err


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_program_that_is_told_to_end_goes_the_way_of_ctrl_c(number: signal.Signals) -> None:
    before = signal.signal(number, signal.SIG_DFL)
    try:
        with pytest.raises(KeyboardInterrupt), ended_as_by_ctrl_c():
            signal.raise_signal(number)
        assert signal.getsignal(number) is signal.SIG_DFL
        signal.signal(number, signal.SIG_IGN)
        with ended_as_by_ctrl_c():  # a program that was started so as to outlive its terminal
            signal.raise_signal(number)
    finally:
        signal.signal(number, before)


class Typed:
    """Standard input, and a device whose switches take down how they were pressed."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.pressed: list[str] = []
        names = ("arm", "release", "stop")
        switch = SimpleNamespace(**{name: partial(self.pressed.append, name) for name in names})
        self.device = cast(Any, SimpleNamespace(name="device", switch=switch))
        reading, self.writing = os.pipe()
        monkeypatch.setattr("sys.stdin", os.fdopen(reading))

    def until(self, presses: int) -> list[str]:
        until = time.monotonic() + 10.0
        while len(self.pressed) < presses and time.monotonic() < until:
            time.sleep(0.01)
        return self.pressed


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Iterator[Typed]:
    typed = Typed(monkeypatch)
    yield typed
    sys.stdin.close()


def test_the_end_of_input_is_an_emergency_stop(typed: Typed) -> None:
    with Console() as console, console.switching(typed.device):
        os.write(typed.writing, b"a\n")
        os.close(typed.writing)
        assert typed.until(2) == ["arm", "stop"]


def test_what_was_typed_ahead_is_obeyed_before_the_run_where_no_press_arms(typed: Typed) -> None:
    os.write(typed.writing, b"r\na\n")
    with Console() as console, console.switching(typed.device):
        assert typed.pressed == ["release", "arm"]
    os.close(typed.writing)


def test_an_emergency_stop_does_not_wait_for_a_terminal_that_takes_no_lines(
    typed: Typed, monkeypatch: pytest.MonkeyPatch
) -> None:
    takes = threading.Event()
    monkeypatch.setattr("sys.stderr", SimpleNamespace(write=lambda _: takes.wait(10.0), flush=lambda: None))
    with Console() as console, console.switching(typed.device):
        console.tell("what nobody reads")
        os.write(typed.writing, b"\n")
        assert typed.until(1) == ["stop"] and not takes.is_set()
        takes.set()
    os.close(typed.writing)


def test_switches_that_fail_are_an_emergency_stop(typed: Typed, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError("Input/output error")

    with Console() as console:
        monkeypatch.setattr("select.select", fail)
        with console.switching(typed.device):
            assert typed.until(1) == ["stop"]
    os.close(typed.writing)


def test_lines_are_printed_without_a_device(capsys: pytest.CaptureFixture[str]) -> None:
    with Console() as console:
        console.tell("the recording has ended")
    assert capsys.readouterr().err == "the recording has ended\n"
