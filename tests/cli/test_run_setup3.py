"""`run setup3 --hardware` on an emulated hand and an emulated arm: only the library's folder and the address differ."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_samples import PATIENT
from test_run_hardware import wait_for

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.omega.emulator.build import build_library
from mmt_drake.recording import Recording, load

ON_DEVICES = ("--hardware", "--loosened-limits")
FORCE = 3.0  # [N] the most that the hand may feel
BIAS = (0.4, -0.7, 1.1)  # [N] of the robot's estimate
FLOOR = 800.0  # [N/m]
SECONDS = 5.0
HAND = "soft_start=0.5 target_z=-0.03 hand_stiffness=1500 hand_damping=30 swing_y=0.015 swing_hz=0.7"


@dataclass
class Bench:
    """Both devices, emulated, and where they are.

    Attributes:
        folder: of the vendor's library, and for recordings.
        franka: the arm.
        table: origin of the table frame in its base frame [m]: 2 cm below where its tip begins, on a floor.
    """

    folder: Path
    franka: EmulatedFranka
    table: list[float]

    def command(self, record: Path, seconds: float, **changes: object) -> list[str]:
        # What a busy machine would stop: pauses of the program.
        settings: dict[str, object] = {
            "operator_device.library": self.folder,
            "operator_device.watchdog": "null",
            "operator_device.limits.force": FORCE,
            "telerobot_device.address": self.franka.address,
            "telerobot_device.realtime": "ignore",
            "telerobot_device.table": self.table,
            "telerobot_device.gap": 0.4,
            "telerobot_device.hold_after": 0.1,
            "telerobot_device.compensation": "{}",  # the emulated arm holds no probe
            "step": 0.002,
        }
        line = [sys.executable, "-c", PATIENT, "run", "setup3", *ON_DEVICES, "--realtime", "--json"]
        line += ["--record", str(record), "--seconds", f"{seconds:g}"]
        for key, value in {**settings, **changes}.items():
            line += ["--set", f"{key}={value}"]
        return line

    def start(self, record: Path, seconds: float) -> subprocess.Popen[str]:
        pipe = subprocess.PIPE
        # Whoever started the tests may ignore SIGINT, and children inherit that.
        heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
        return subprocess.Popen(
            self.command(record, seconds),
            preexec_fn=heard,
            env={**os.environ, "EMULATED_OMEGA": HAND},
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            text=True,
        )


def press(run: subprocess.Popen[str], key: str) -> None:
    assert run.stdin
    run.stdin.write(f"{key}\n")
    run.stdin.flush()


def later(franka: EmulatedFranka, ticks: int) -> dict[str, Any]:
    """What the arm does after so many milliseconds of its own."""
    end = franka.get()["ticks"] + ticks
    while (seen := franka.get())["ticks"] < end:
        time.sleep(0.01)
    return seen


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("devices")
    try:
        if importlib.util.find_spec("forcedimension_core") is None:
            pytest.skip("the extra `omega` is not installed")
        load_franky()
        build_library(folder)
        emulated = EmulatedFranka()
    except MissingDependency as error:
        pytest.skip(str(error))
    with emulated as franka:
        x, y, z = franka.get()["position"]
        yield Bench(folder, franka, [x, y, z - 0.02])


@dataclass
class Outcome:
    """Of a run: what it told, and recorded, and what the arm did after it."""

    told: dict[str, Any]
    recording: Recording
    arm: dict[str, Any]


@pytest.fixture(scope="module")
def outcome(bench: Bench) -> Outcome:
    """A person arms both with one press, stops both, releases and arms again; then the robot stops by itself."""
    franka = bench.franka
    franka.reset()
    franka.set(bias=BIAS, wall_height=bench.table[2], wall_stiffness=FLOOR)
    with bench.start(bench.folder / "out.mcap", SECONDS) as run:
        assert run.stderr
        try:
            wait_for(run.stderr, "arm: not in control")
            press(run, "a")
            wait_for(run.stderr, ": armed")  # which it is once the arm is in control
            assert later(franka, 1700)["moving"], "the arm follows"
            press(run, "")
            wait_for(run.stderr, "emergency")
            press(run, "r")
            wait_for(run.stderr, "; now arm is stale")
            press(run, "a")
            wait_for(run.stderr, ": armed")
            franka.set(reflex=6)
            wait_for(run.stderr, "arm is stale or lost")
            out, err = run.communicate(timeout=100)
        finally:
            run.kill()
    assert run.returncode == 0, err
    return Outcome(json.loads(out), load(bench.folder / "out.mcap"), franka.get())


def test_the_arm_follows_the_hand_and_presses_on_what_is_there(outcome: Outcome) -> None:
    columns = outcome.recording.columns
    follows = (columns["telerobot_fault"] == 0.0) & (columns["telerobot_waits"] == 0.0)
    assert follows.sum() > 200
    # A busy machine holds the loop up now and then, and the hand goes on meanwhile: where it was of late counts.
    tip, hand = outcome.recording.vector("position"), outcome.recording.vector("master_position")
    wall = outcome.recording.time + columns["lateness"]
    earlier = np.minimum(np.searchsorted(wall, wall - 0.2), np.arange(len(wall)) - 1)
    away = [np.abs(tip[k] - hand[max(0, earlier[k]) : k + 1])[:, :2].max(axis=1).min() for k in np.flatnonzero(follows)]
    assert max(away) < 0.012  # 60 mm/s, 1500 N/m, and joints that stick
    assert np.ptp(columns["position_y"][follows]) > 0.01
    assert columns["position_z"].min() < -0.002


def test_what_is_measured_is_the_floor_s_force_without_the_robot_s_bias(outcome: Outcome) -> None:
    columns = outcome.recording.columns
    depth = -columns["position_z"]
    pressed = (depth > 0.002) & (columns["telerobot_fault"] == 0.0)
    assert pressed.sum() > 100 and FLOOR * depth[pressed].max() > 3.0
    assert columns["detected_contact"][pressed].all()
    np.testing.assert_allclose(columns["force_z"][pressed], FLOOR * depth[pressed], atol=0.6)
    for axis in "xy":
        assert np.abs(columns[f"force_{axis}"][pressed]).max() < 0.05


def test_the_hand_feels_the_object_within_the_limits_and_nothing_while_the_arm_is_stopped(outcome: Outcome) -> None:
    columns, told = outcome.recording.columns, outcome.told
    force = np.linalg.norm([columns[f"applied_force_{axis}"] for axis in "xyz"], axis=0)
    armed = columns["safety_armed"] == 1.0
    # How deep the hand gets while the arm is armed goes by the wall clock: as little as 0.37 N was seen.
    assert 0.2 < force.max() <= FORCE * (1 + 1e-9)
    ramp = np.convolve(armed, np.ones(10), mode="full")[: len(armed)] > 0  # 20 ms, the supervisor's promise
    assert not force[~ramp].any()
    assert not (armed & (columns["telerobot_fault"] != 0.0)).any()
    assert told["device"]["stops"] == {"emergency stop": 1, "arm is stale or lost": 1}
    arm = told["arm"]
    assert arm["steps"] == len(armed) and arm["followed_steps"] > 200
    assert arm["stops"] == {"emergency stop": 1, "stopped by a reflex or an error of the robot": 1}


def test_at_the_end_the_arm_is_at_rest(outcome: Outcome) -> None:
    assert not outcome.arm["moving"] and np.abs(outcome.arm["dq"]).max() < 0.02
    assert outcome.told["overruns"]["steps"] == round(SECONDS / 0.002)


def test_interrupted_it_brings_the_arm_to_rest_and_keeps_the_recording(bench: Bench) -> None:
    bench.franka.reset()
    file = bench.folder / "cut.mcap"
    with bench.start(file, 60.0) as run:
        assert run.stderr
        try:
            wait_for(run.stderr, "arm: not in control")
            press(run, "a")
            wait_for(run.stderr, ": armed")
            later(bench.franka, 200)
            run.send_signal(signal.SIGINT)
            _, err = run.communicate(timeout=60)
        finally:
            run.kill()
    assert run.returncode == 130 and "Traceback" not in err, err
    told = bench.franka.get()
    assert not told["moving"] and np.abs(told["dq"]).max() < 0.02
    assert len(load(file).time) > 10


def test_an_arm_that_is_not_there_is_told_in_one_line(bench: Bench, tmp_path: Path) -> None:
    line = bench.command(tmp_path / "out.mcap", 1.0, **{"telerobot_device.address": "127.0.0.99"})
    done = subprocess.run(line, capture_output=True, text=True, timeout=100, check=False)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("limit: ")]
    assert done.returncode == 2 and done.stdout == "" and len(lines) == 1
    assert "franka: cannot reach the robot at 127.0.0.99" in done.stderr
    assert not (tmp_path / "out.mcap").exists()


def test_on_the_other_machine_the_arm_holds_and_stops_when_the_operator_is_gone(bench: Bench, tmp_path: Path) -> None:
    """The hand is simulated here; it is killed once the arm follows it."""
    link = pytest.importorskip("mmt_drake.hw.link.keys", reason="the extra `link` is not installed")
    pytest.importorskip("cryptography", reason="the extra `link` is not installed")
    link.write_key(tmp_path / "link.key")
    bench.franka.reset()

    def side(name: str, mine: int, theirs: int, seconds: float, *hardware: str) -> subprocess.Popen[str]:
        line = [part for part in bench.command(tmp_path / f"{name}.mcap", seconds) if part not in ON_DEVICES]
        line += [*hardware, "--side", name, "--key", str(tmp_path / "link.key")]
        line += ["--listen", f"127.0.0.1:{mine}", "--peer", f"127.0.0.1:{theirs}"]
        pipe = subprocess.PIPE
        return subprocess.Popen(line, stdin=pipe, stdout=pipe, stderr=pipe, text=True)

    with (
        side("telerobot", 47331, 47330, 5.0, *ON_DEVICES) as telerobot,
        side("operator", 47330, 47331, 60.0) as operator,
    ):
        assert telerobot.stderr
        try:
            wait_for(telerobot.stderr, "arm: not in control")
            press(telerobot, "a")
            wait_for(telerobot.stderr, "arm: well")
            assert later(bench.franka, 1000)["moving"]
            operator.kill()
            wait_for(telerobot.stderr, "arm: no set-points")
            out, err = telerobot.communicate(timeout=60)
        finally:
            operator.kill()
            telerobot.kill()
    assert telerobot.returncode == 0, err
    told = json.loads(out)
    assert told["arm"]["followed_steps"] > 50 and told["arm"]["stops"] == {"no set-points": 1}
    assert not bench.franka.get()["moving"]
    columns = load(tmp_path / "telerobot.mcap").columns
    stopped = np.flatnonzero(columns["telerobot_fault"] == 10.0)
    assert len(stopped) and np.ptp(columns["position_z"][: stopped[0]]) > 0.001
