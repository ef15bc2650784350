"""A disk that is full, a folder that is closed: status 2, one line, and nothing half-written."""

import errno
import os
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from cli_samples import MODEL, Program, disk_of, listing, text, write
from table_samples import good

from mmt_drake.errors import BadInput
from mmt_drake.recording import McapWriter, load

PART = "made.part.mcap"


@pytest.mark.parametrize("target", ["made.mcap", "made.csv"])
def test_a_disk_that_fills_up_during_a_run(
    target: str, tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = 200_000
    write_for_real = os.write

    def write_while_there_is_room(file: int, data: bytes) -> int:
        nonlocal free
        if free <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write_for_real(file, data[:free])  # a disk takes what it can
        free -= written
        return written

    monkeypatch.setattr(os, "write", write_while_there_is_room)
    status, out, err = program("run", "setup1", "--seconds", "5", "--record", tmp_path / target)
    monkeypatch.undo()
    assert (status, out) == (2, "")
    assert f"{target}: found No space left on device, expected room for the recording" in err and err.count("\n") == 1
    assert listing(tmp_path) == []


def test_a_run_that_cannot_be_built_leaves_an_older_recording_as_it_was(tmp_path: Path, program: Program) -> None:
    older = text(tmp_path / "made.mcap", "precious")
    assert program("run", "setup1", "--set", "operator.motion=wave", "--record", older).status == 2
    assert older.read_text() == "precious" and listing(tmp_path) == ["made.mcap"]


@pytest.mark.parametrize(
    ("error", "left"), [(BadInput("plant", found="a", expected="b"), []), (OSError("gone"), [PART])]
)
def test_an_older_recording_survives_a_run_that_fails(
    error: Exception, left: list[str], tmp_path: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    older = text(tmp_path / "made.mcap", "precious")
    monkeypatch.setattr("mmt_drake.cli.run.progress", lambda *_, **__: nullcontext(Mock(side_effect=error)))
    status, _, err = program("run", "setup1", "--seconds", "2", "--record", older)
    assert status == 2 and older.read_text() == "precious" and listing(tmp_path) == ["made.mcap", *left]
    assert (
        err.count("\n") == 1 and [name for name in [PART] if f"recorded until then: {tmp_path / name}" in err] == left
    )
    if left:
        assert len(load(tmp_path / PART)) > 100, "it is findable, and can be read"


def test_two_runs_into_one_file(tmp_path: Path, program: Program) -> None:
    target = tmp_path / "made.mcap"
    with McapWriter(target, [("position", 3)]):
        status, out, err = program("run", "setup1", "--seconds", "1", "--record", target)
        assert (status, out) == (2, "") and "found another run that is recording to it" in err and err.count("\n") == 1
    assert listing(tmp_path) == ["made.mcap"]


@pytest.mark.parametrize("ending", [".csv", ".npz", ".mcap"])
def test_a_file_that_may_not_grow_is_not_left_half_written(ending: str, tmp_path: Path) -> None:
    """The limit on a process's files is a refusal in mid-write that needs no special disk."""
    rng = np.random.default_rng(0)
    many = {name: np.resize(values, 5000) + 1e-4 * rng.random(5000) for name, values in good().items()}
    source = write(tmp_path / "in.npz", many | {"time": np.arange(5000) * 0.01})
    (tmp_path / "out").mkdir()
    limit = 100_000
    done = subprocess.run(
        [sys.executable, "-m", "mmt_drake", "convert", source, tmp_path / "out" / f"made{ending}"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},  # or its cache would meet the limit
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert f"made{ending}: found File too large" in done.stderr and done.stderr.count("\n") == 1
    assert listing(tmp_path) == ["in.npz", "out"]


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 kB, made of memory."""
    with disk_of("64k", tmp_path / "disk") as disk:
        yield disk


@pytest.mark.parametrize("command", ["run", "convert", "simulate"])
def test_a_disk_that_is_really_full(command: str, full_disk: Path, tmp_path: Path, program: Program) -> None:
    rng = np.random.default_rng(0)
    many = {name: np.resize(values, 5000) + 1e-4 * rng.random(5000) for name, values in good().items()}
    source = write(tmp_path / "in.npz", many | {"time": np.arange(5000) * 0.01})
    arguments: dict[str, list[object]] = {
        "run": ["run", "setup1", "--seconds", "5", "--record", full_disk / "made.mcap"],
        "convert": ["convert", source, full_disk / "made.csv"],
        "simulate": [
            "simulate", "--operator", source, "--out", full_disk / "made.csv",
            "--model", text(tmp_path / "model.yaml", MODEL),
        ],
    }  # fmt: skip
    status, out, err = program(*arguments[command])
    assert (status, out) == (2, "") and "found No space left on device" in err and err.count("\n") == 1
    assert listing(full_disk) == []


def test_in_real_time_a_disk_that_fills_up_ends_the_recording_and_not_the_run(tmp_path: Path, program: Program) -> None:
    with disk_of("1500k", tmp_path / "disk") as disk:
        target = disk / "made.mcap"
        status, out, err = program("run", "setup1", "--realtime", "--seconds", "4.5", "--record", target)
        last = err.splitlines()[-1]
        assert status == 2 and "4.500 s simulated" in out and "overruns:" in out
        assert "found No space left on device" in last and "is kept" in last
        assert listing(disk) == ["made.part.mcap"] and "made.part.mcap" in last and "recording: " in out
        kept = load(disk / "made.part.mcap")
    assert 1.0 <= kept.time[-1] + 1e-3 < 4.5 and len(kept) == round(kept.time[-1] * 1e3) + 1


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written_to(tmp_path: Path, program: Program) -> None:
    source = write(tmp_path / "in.csv", good())
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o500)
    status, _, err = program("convert", source, closed / "made.npz")
    assert status == 2 and "made.npz: found Permission denied" in err
