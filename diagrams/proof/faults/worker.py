"""The process of the estimator's fits dies in a run: the hand goes on with what was known, and a person hears of it."""

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
    """It is killed between fits or in one."""
    yield try_dead_worker(emulated_omega(folder), moments, folder / "worker.mcap")


def try_dead_worker(omega: EmulatedOmega, moments: int, record: Path) -> Row:
    """A run each."""
    rng, tally = np.random.default_rng(0), Tally(FORCE)
    for moment in range(moments):
        with Session(omega, record, worker=True) as session:
            tally.armed(session, moment)
            session.go(int(rng.integers(0, 300)))
            time.sleep(float(rng.uniform(0.0, 0.01)))  # wherever the process is by then
            start = session.tick
            tally.begin(session)
            fits = session.station.diagram.GetSubsystemByName("estimator").fits
            fits.process.kill()
            session.go(round(_SEEN_AFTER / PERIOD))
            tally.goes_on(session, moment)
        tally.recorded(session, record)
        recorded = load(record)
        if Status.NO_FIT not in recorded["estimator_status"][start:]:
            tally.wrong.append(f"{moment}: nothing was reported")
        theta = np.array([recorded[f"theta_{name}"][-1] for name in ("m", "k2", "b2")])
        if not (np.isfinite(theta).all() and (theta > 0.0).all()):
            tally.wrong.append(f"{moment}: theta is {theta}")
    return tally.row("estimator's worker dead", "worker", moments)
