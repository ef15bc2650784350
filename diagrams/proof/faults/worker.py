"""The estimator's thread dies in the midst of a run: the hand goes on with what was known, and a person hears of it."""

import ctypes
import logging
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mmt_drake.diagrams.proof.faults.injection import PERIOD, Tally, emulated_omega
from mmt_drake.diagrams.proof.faults.session import FORCE, Session
from mmt_drake.diagrams.proof.faults.table import Row
from mmt_drake.estimation.output_error.layout import Status
from mmt_drake.hw.omega.emulator import EmulatedOmega
from mmt_drake.recording import load

_SEEN_AFTER = 1.2  # [s] of the run until it must be known


def rows(moments: int, folder: Path) -> Iterator[Row]:
    """An error out of the blue in the thread, between fits or in one."""
    log = logging.getLogger("concurrent.futures")  # which tells of every thread that it loses
    log.disabled = True
    try:
        yield try_dead_worker(emulated_omega(folder), moments, folder / "worker.mcap")
    finally:
        log.disabled = False


def try_dead_worker(omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """A run each. An error in a fit ends that fit, one between two fits ends the thread."""
    rng, tally = np.random.default_rng(0), Tally(FORCE)
    for moment in range(moments):
        before = set(threading.enumerate())
        with Session(omega, record) as session:
            tally.armed(session, moment)
            session.go(int(rng.integers(0, 300)))
            time.sleep(float(rng.uniform(0.0, 0.01)))  # wherever the thread is by then
            start = session.tick
            tally.begin(session)
            hit = sum(_strike(thread) for thread in threading.enumerate() if _is_worker(thread, before))
            session.go(round(_SEEN_AFTER / PERIOD))
            tally.goes_on(session, moment)
        if not hit:
            tally.wrong.append(f"{moment}: no thread was struck")
        tally.recorded(session, record)
        recorded = load(record)
        if Status.NO_FIT not in recorded["estimator_status"][start:]:
            tally.wrong.append(f"{moment}: nothing was reported")
        theta = np.array([recorded[f"theta_{name}"][-1] for name in ("m", "k2", "b2")])
        if not (np.isfinite(theta).all() and (theta > 0.0).all()):
            tally.wrong.append(f"{moment}: theta is {theta}")
    return tally.row("estimator's worker dead", "worker", moments)


def _is_worker(thread: threading.Thread, before: set[threading.Thread]) -> bool:
    return thread.name.startswith("estimator") and thread not in before


def _strike(thread: threading.Thread) -> int:
    """Have Python raise an error in a thread, at whatever it does next."""
    return ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(MemoryError))
