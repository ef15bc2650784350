"""A disk that refuses in the midst of a run: the hand goes on, and what was complete can be read."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from diagrams.faults.emulated import emulated_omega
from diagrams.faults.row import Row
from diagrams.faults.session import FORCE, PERIOD, Session
from hw.omega.emulator import EmulatedOmega
from mmt_drake.errors import BadInput
from mmt_drake.recording import load
from mmt_drake.systems.recorder import BLOCK

_TICKS = round(BLOCK / PERIOD)
_ROOM = 400_000  # bytes that the disk takes at most after the moment


def try_recording(moments: int, folder: Path) -> Iterator[Row]:
    """A full disk, at whatever byte."""
    yield try_full_disk(emulated_omega(folder), moments, folder / "full.mcap")


def try_full_disk(omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """A run each; from its moment on the kernel lets the file grow by so many bytes more and refuses the next one.

    It does so by a limit on this process (RLIMIT_FSIZE), which takes a part of a write as a full disk does, and which
    needs no disk to be filled.
    """
    rng = np.random.default_rng(0)
    greatest, lost, wrong = 0.0, 0.0, []
    for moment in range(moments):
        told: list[str] = []
        with Session(omega, record, tell=told.append) as session:
            armed = session.arm()
            session.go(int(rng.integers(_TICKS, 2 * _TICKS)) - session.tick)
            recorder = session.station.recorder
            if recorder is None or not armed:
                wrong.append(f"{moment}: no recording, or {session.told()}")
                break
            recorder.settle()
            session.begin_moment()
            with _no_room_beyond(record.stat().st_size + int(rng.integers(0, _ROOM))):
                for _ in range(8):  # more than there is room for
                    session.go(_TICKS - session.tick % _TICKS)
                    recorder.settle()
                    if recorder.trouble is not None:
                        break
                refused_at = session.tick * PERIOD
                session.go(100)
            force = omega.get("greatest_force")
            greatest = max(greatest, force)
            if not (session.armed and 0.0 < force <= FORCE * (1 + 1e-9)):
                wrong.append(f"{moment}: {session.told()}, {force:.3g} N")
        if recorder.trouble is None or not any("recording has ended" in line for line in told):
            wrong.append(f"{moment}: nobody was told")
        unreadable = _unreadable(record, refused_at)
        lost = max(lost, unreadable)
        if unreadable > BLOCK + 2 * PERIOD:
            wrong.append(f"{moment}: {unreadable:.2f} s of the recording are lost")
    return Row("disk full", "recording", moments, greatest, FORCE, unreadable=lost, wrong=tuple(wrong))


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
