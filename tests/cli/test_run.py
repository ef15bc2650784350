"""`run`: the summary is what the recording says, whatever the hand, the form of the recording, or how the run ends."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from cli_samples import Program, write_bag
from table_samples import TIME, good
from terminal import Terminal

from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.passivity import passivity
from mmt_drake.cli.main import main
from mmt_drake.effects import LIBRARY
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.recording import Recording, load, save
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator

CONTRACT = [f"{name}_{axis}" for name in ("position", "force", "velocity", "master_position", "rendered_force")
            for axis in "xyz"] + ["in_contact", "detected_contact"]  # fmt: skip
CONTRACT += [f"theta_{name}" for name in ("m", "k1", "k2", "b1", "b2", "Fc")]

REAL = [
    *(f"panda_comanipulation/symbol17_rec{number}.npz" for number in (0, 3, 4)),
    *(
        f"dvrk_palpation/{name}.npz"
        for name in ("ContPalpRAL18T1", "Hamlyn_Zone2_T1", "zone1_wrist_fixed", "zone3_adp_wrist_cdp")
    ),
]


def hovering(path: Path, seconds: float, height: float) -> Path:
    """A hand that stays above the table, or presses by a millimetre, and moves along it."""
    time = np.arange(0.0, seconds, 0.01)
    zero = np.zeros(len(time))
    columns = {"position_x": 0.02 * np.sin(3.0 * time), "position_y": zero, "position_z": zero + height}
    save(Recording(time, columns), path)
    return path


@pytest.fixture(scope="module")
def delayed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object]]:
    """A run with delay through the program itself: its recording and its summary."""
    path = tmp_path_factory.mktemp("run") / "out.mcap"
    command = ["run", "setup1-delay", "--seconds", "12", "--seed", "3", "--record", str(path), "--json"]
    command += ["--set", "environment.noise.force=0.02"]
    done = subprocess.run([sys.executable, "-m", "mmt_drake", *command], capture_output=True, text=True, check=True)
    assert done.stderr == ""  # no progress bar in a pipe
    return path, json.loads(done.stdout)


def test_the_summary_can_be_computed_again_from_the_recording(delayed: tuple[Path, dict[str, object]]) -> None:
    path, told = delayed
    recording = load(path)
    assert told["errors"] == json.loads(json.dumps(measure(recording, delay_s=0.4).to_json()))
    assert told["energy"] == passivity(recording).to_json()
    assert (told["scenario"], told["seed"], told["operator"]) == ("setup1-delay", 3, "strokes")
    assert (told["simulated_s"], told["overruns"], told["recording"]) == (12.0, None, str(path))
    assert len(recording) == 12001 and not told["missing"]
    assert set(CONTRACT) <= set(recording.columns) and len(recording.clouds) == 13  # at 0, 1 ... 12 s


@pytest.mark.parametrize("name", REAL)
def test_real_hands_and_probes_drive_the_station(name: str, recordings: Path, program: Program, tmp_path: Path) -> None:
    target = tmp_path / "out.npz"
    status, out, err = program("run", "setup1", "--operator", recordings / name, "--seconds", "3", "--record", target)
    assert (status, err) == (0, "")
    recording = load(target)
    assert recording.time[-1] == 3.0
    assert np.ptp(recording["position_x"]) > 1e-4 and recording["in_contact"].any()
    assert recording["force_z"].max() > 0.1  # it pressed
    for label in (name, "force errors", "energy at the operator's port", "overruns: not paced", f"recording: {target}"):
        assert label in out


def test_an_operator_s_recording_sets_the_length_unless_told(program: Program, tmp_path: Path) -> None:
    hand = hovering(tmp_path / "hand.csv", 2.01, -0.001)
    for extra, seconds in (([], 2.0), (["--seconds", "1"], 1.0), (["--set", "duration=1.5"], 1.5)):
        told = json.loads(program("run", "setup1", "--operator", hand, "--json", *extra).out)
        assert told["simulated_s"] == pytest.approx(seconds, abs=1e-9)
        assert told["operator"] == str(hand) and told["recording"] is None


@pytest.mark.parametrize(("height", "contact"), [(0.02, "found 0 s of contact"), (-0.001, "found 2.001 s of contact")])
def test_little_contact_or_none_is_said_and_is_no_error(
    height: float, contact: str, program: Program, tmp_path: Path
) -> None:
    hand = hovering(tmp_path / "hand.csv", 2.01, height)
    status, out, _ = program("run", "setup1", "--operator", hand)
    assert status == 0 and contact in out and "expected more than the 5 s" in out
    told = json.loads(program("run", "setup1", "--operator", hand, "--json").out)
    assert told["errors"] is None and contact in told["missing"]["errors"] and told["energy"]


def test_a_run_too_short_for_any_figure_still_ends_well(program: Program) -> None:
    status, out, _ = program("run", "setup1", "--seconds", "0.001")
    assert status == 0 and "found 2 samples, expected at least 3" in out


def test_topics_name_the_hand_in_a_bag(program: Program, tmp_path: Path) -> None:
    source = write_bag(tmp_path / "hand.bag", good(), "/hand")
    assert "no message on any known topic" in program("run", "setup1", "--operator", source).err
    target = tmp_path / "out.npz"
    arguments = ["run", "setup1", "--operator", source, "--topic", "position=/hand", "--record", target]
    assert program(*arguments).status == 0
    recording = load(target)
    assert recording.time[-1] == pytest.approx(TIME[-1])
    at = np.searchsorted(recording.time, TIME + 1e-9) - 1
    for axis in "xyz":
        np.testing.assert_allclose(recording[f"master_position_{axis}"][at], good()[f"position_{axis}"], atol=1e-9)


@pytest.mark.parametrize("options", [(), ("--realtime",)])
def test_fits_are_made_beside_the_clock_in_real_time_and_only_then(
    program: Program, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
):
    made, init = [], OutputErrorEstimator.__init__

    def watched(self: OutputErrorEstimator, chosen: OutputErrorOptions, *, worker: bool, waits: bool) -> None:
        made.append(worker)
        init(self, chosen, worker=worker, waits=waits)

    monkeypatch.setattr(OutputErrorEstimator, "__init__", watched)
    assert program("run", "setup1-free-running", "--seconds", "0.5", *options, "--json").status == 0
    assert made == [bool(options)]


def test_a_paced_run_takes_as_long_as_it_says_and_counts_what_was_late(program: Program) -> None:
    start = time.perf_counter()
    told = json.loads(program("run", "setup1", "--seconds", "1", "--realtime", "--json").out)
    assert 1.0 - 1e-3 <= told["wall_s"] <= time.perf_counter() - start
    assert "garbage collection off" in told["process"]
    pace = told["overruns"]
    assert pace["steps"] >= 1000 and 0 <= pace["overruns"] <= pace["steps"]
    # Whatever else the machine does, no step is done before the one before it was due.
    assert -1e-3 < pace["behind_median_s"] <= pace["behind_p99_s"] <= pace["behind_worst_s"]


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor is all there is")
def test_what_shows_progress_stays_off_the_processor_that_the_loop_has_for_itself(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, seen = os.sched_getaffinity(0), []

    @contextmanager
    def bar(*_: object, **__: object) -> Iterator[Callable[[float], None]]:
        with ThreadPoolExecutor(1) as thread:
            seen.append(thread.submit(os.sched_getaffinity, 0).result())
            yield lambda now: None

    monkeypatch.setattr("mmt_drake.cli.run.progress", bar)
    assert program("run", "setup1", "--realtime", "--seconds", "0.01", "--cpu", str(min(before))).status == 0
    assert seen == [before]


@pytest.mark.parametrize("beside", [[], ["--hardware"], ["--operator", "sliders", "--meshcat"]])
def test_sliders_are_let_move_only_an_arm_that_is_there(program: Program, beside: list[str]) -> None:
    outcome = program("run", "setup3", "--sliders-move-hardware", *beside)
    assert outcome.status == 2 and outcome.err.count("\n") == 1
    assert "--sliders-move-hardware: found no arm" in outcome.err


@pytest.mark.parametrize("option", [["--priority", "5"], ["--cpu", "0"], ["--lock-memory"]])
def test_what_only_a_paced_run_needs_is_refused_without_one(program: Program, option: list[str]) -> None:
    outcome = program("run", "setup1", "--seconds", "1", *option)
    assert outcome.status == 2 and "no --realtime" in outcome.err


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_run_that_is_ended_leaves_a_recording_that_can_be_read(how: signal.Signals, tmp_path: Path) -> None:
    path, part = tmp_path / "out.mcap", tmp_path / "out.part.mcap"
    path.write_text("older")
    command = [sys.executable, "-m", "mmt_drake", "run", "setup1", "--seconds", "100000", "--record", str(path)]
    # Whoever started the tests may ignore SIGINT (a shell does for a job in the background), and children inherit that.
    heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heard)
    try:
        patience = time.monotonic() + 60.0
        while not (part.exists() and part.stat().st_size > 1_000_000):
            assert running.poll() is None and time.monotonic() < patience
            time.sleep(0.02)
        running.send_signal(how)
        out, err = running.communicate(timeout=30)
    finally:
        running.kill()
        running.wait()
    recording = load(path if how == signal.SIGINT else part)
    assert len(recording) > 1000 and np.allclose(np.diff(recording.time), 1e-3)
    cut_off = any(note.startswith("cut off") for note in recording.notes)
    if how == signal.SIGINT:
        assert (running.returncode, out) == (130, "") and not cut_off
        assert err.startswith("mmt-drake: interrupted after ") and err.endswith(f"; {path} is kept\n")
    else:
        assert running.returncode == -signal.SIGKILL and cut_off and path.read_text() == "older"
    assert set(os.listdir(tmp_path)) == {"out.mcap"} | ({"out.part.mcap"} if how == signal.SIGKILL else set())


def test_an_effect_of_the_user_s_own_acts_in_a_plant(tmp_path: Path, program: Program) -> None:
    (tmp_path / "own.py").write_text((Path(__file__).parents[1] / "effects" / "own_effect.py").read_text())
    stiffer = "environment.object.effects=[{name: quintic_stiffness, parameters: {k5: 1.0e10}}]"
    command = ("run", "setup1", "--seconds", "1.5", "--record", tmp_path / "out.mcap")
    unknown = program(*command, "--set", stiffer)
    assert unknown.status == 2 and unknown.err.count("\n") == 1
    assert "environment.object.effects[0].name: found 'quintic_stiffness'" in unknown.err
    forces = []
    try:
        for changes in ((), ("--effects", tmp_path / "own.py", "--set", stiffer)):
            told = program(*command, *changes)
            assert told.status == 0, told.err
            forces.append(load(tmp_path / "out.mcap").vector("force"))
    finally:
        LIBRARY.pop("quintic_stiffness", None)
    assert np.abs(forces[1] - forces[0]).max() > 0.1


def test_on_a_terminal_it_says_at_once_that_it_gets_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    assert main(["run", "setup1", "--seconds", "0.1"]) == 0
    assert "setup1: getting ready" in screen.getvalue().partition("of 0.1 s")[0], "before the first step"
