"""A disk that refuses, or hangs, in the midst of a run: the hand goes on, and what was complete can be read."""

import math
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.faults.hanging_disk import HangingDisk
from mmt_drake.diagrams.proof.faults.injection import PERIOD, Tally, emulated_omega
from mmt_drake.diagrams.proof.faults.session import FORCE, Session
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.errors import BadInput
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.recording import load
from mmt_drake.systems.recorder import BLOCK, BLOCKS, McapRecorder

_TICKS = round(BLOCK / PERIOD)
_ROOM = 400_000  # bytes that the disk takes at most after the moment
_LITTLE = 20_000  # bytes that a disk takes at most before it hangs, less than a block
_PATIENCE = 1.0  # [s] of the recorder with a disk that hangs
_A_TICK = 1.0  # [s] that a tick may take on a busy machine; one that waited for the disk would wait for ever
_ENDS_WITHIN = 5.0  # [s]
_MOST_LOST = BLOCK + 2 * PERIOD  # [s]

HANGS: dict[str, float] = {"disk hangs for 3 s": 3.0, "disk hangs for good": math.inf}
"""Kind of fault -> for how long [s]."""


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """A full disk, and one that hangs, at whatever byte."""
    yield try_full_disk(emulated_omega(folder), moments, folder / "full.mcap")
    for kind in HANGS:
        yield try_hanging_disk(kind, emulated_omega(folder), moments, folder / "hangs.mcap")


def try_full_disk(omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """A run each; from its moment on the kernel lets the file grow by so many bytes more and refuses the next one.

    It does so by a limit on this process (RLIMIT_FSIZE), which takes a part of a write as a full disk does, and which
    needs no disk to be filled.
    """
    rng, tally = np.random.default_rng(0), Tally(FORCE, unreadable=0.0)
    for moment in range(moments):
        said: list[str] = []
        with Session(omega, record, tell=said.append) as session:
            recorder = _on_the_disk(session, rng, tally, moment)
            tally.begin(session)
            with _no_room_beyond(recorder.file.path.stat().st_size + int(rng.integers(0, _ROOM))):
                for _ in range(8):  # more than there is room for
                    session.go(_TICKS - session.tick % _TICKS)
                    recorder.settle()
                    if recorder.trouble is not None:
                        break
                refused_at = session.tick * PERIOD
                session.go(100)
            tally.goes_on(session, moment)
        if recorder.trouble is None or not any("recording has ended" in line for line in said):
            tally.wrong.append(f"{moment}: nothing was reported")
        _lose(tally, moment, _unreadable(recorder.file.path, refused_at), _MOST_LOST)
    return tally.row("disk full", "recording", moments)


def try_hanging_disk(kind: str, omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """A run each; from its moment on the disk takes so many bytes more, and then nothing, for a while or for good.

    While the blocks in memory last it leaves no trace in the recording. Of a disk that hangs for good a person hears
    twice, of the gap and at the end of the run, which does not wait for it.
    """
    rng, tally, for_good = np.random.default_rng(0), Tally(FORCE, unreadable=0.0), HANGS[kind] == math.inf
    ticks = round(min(HANGS[kind], (BLOCKS + 1) * BLOCK) / PERIOD)
    for moment in range(moments):
        said: list[str] = []
        session = Session(omega, record, tell=said.append)
        recorder = _on_the_disk(session, rng, tally, moment)
        recorder.patience = _PATIENCE
        with HangingDisk(recorder.file.path) as disk:
            tally.begin(session)
            until = session.tick * PERIOD
            disk.hang(int(rng.integers(0, _LITTLE)))
            slowest = max(_seconds(partial(session.go, 1)) for _ in range(ticks))
            tally.goes_on(session, moment)
            if not for_good:
                disk.go_on()
                until = (session.tick - 1) * PERIOD
            closing = _seconds(session.close)
            # Of a disk that hangs for good, before it is itself again.
            unreadable = _unreadable(recorder.file.path, until)
        if not for_good:
            unreadable = _unreadable(recorder.file.path, until)
        _lose(tally, moment, unreadable, _MOST_LOST if for_good else 1e-6)
        if slowest > _A_TICK or closing > _PATIENCE + _ENDS_WITHIN:
            tally.wrong.append(f"{moment}: a tick took {slowest:.2f} s, the end of the run {closing:.2f} s")
        about = " ".join(line for line in said if str(record) in line)
        lost_rows = recorder.dropped > 0, recorder.trouble is not None
        if {*lost_rows, "a gap" in about, "the end of the recording is lost" in about} != {for_good}:
            tally.wrong.append(f"{moment}: of {recorder.dropped} rows lost this was reported: {about or 'nothing'}")
    return tally.row(kind, "recording", moments)


def _on_the_disk(session: Session, rng: np.random.Generator, tally: Tally, moment: int) -> McapRecorder:
    """The recorder of an armed session somewhere in its second block, the first one on the disk."""
    tally.armed(session, moment)
    session.go(int(rng.integers(_TICKS, 2 * _TICKS)) - session.tick)
    recorder = session.station.recorder
    assert recorder is not None  # a session records
    recorder.settle()
    return recorder


def _lose(tally: Tally, moment: int, seconds: float, most: float) -> None:
    """So much of a recording is lost [s], of which there may be so much."""
    tally.unreadable = max(tally.unreadable, seconds)
    if seconds > most:
        tally.wrong.append(f"{moment}: {seconds:.2f} s of the recording are lost")


def _seconds(task: Callable[[], object]) -> float:
    """That it takes, by the wall's clock."""
    began = time.monotonic()
    task()
    return time.monotonic() - began


def _unreadable(record: Path, until: float) -> float:
    """How long before a time a recording ends [s]; all of it where it cannot be read."""
    try:
        return until - float(load(record, forces=False).time[-1])
    except BadInput:
        return until


@contextmanager
def _no_room_beyond(size: int) -> Iterator[None]:
    """Meanwhile no file of this process can become larger [bytes]."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
