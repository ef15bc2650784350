"""The output-error estimator as a system: the same numbers as over a recording, at a latency that is stated."""

import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from estimated_contact import OUTPUTS, STEP, TICKS, contact, wired
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram

from mmt_drake.estimation.output_error.beside import FitProcess
from mmt_drake.estimation.output_error.offline import estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.model.theta import adopt_theta
from mmt_drake.realtime import ProcessOptions, real_time_process
from mmt_drake.systems.output_error_estimator import OutputErrorEstimator

KILLED = """import os
from mmt_drake.estimation.output_error.beside import FitProcess, OutputErrorOptions
fits = FitProcess(OutputErrorOptions())
print(fits.process.pid, flush=True)
os.kill(os.getpid(), 9)"""
PERIOD = round(OutputErrorOptions(step=STEP).latency / STEP)


def told_of_strokes(worker: bool = False) -> tuple[Diagram, OutputErrorEstimator]:
    return wired(OutputErrorEstimator(OutputErrorOptions(step=STEP), worker=worker), *contact(), STEP)


def keep_up(fits: FitProcess) -> None:
    ends = time.monotonic() + 60.0
    fits.wait_until_ready()
    while fits.under_way and not fits.is_done():
        assert time.monotonic() < ends, "a fit took a minute"
        time.sleep(1e-3)


def watched(diagram: Diagram, estimator: OutputErrorEstimator) -> dict[str, np.ndarray]:
    """Every output as it is half a tick after each; a worker has the time that it takes before each fit."""
    simulator = Simulator(diagram)
    own = estimator.GetMyContextFromRoot(simulator.get_context())
    seen: dict[str, list[np.ndarray]] = {name: [] for name in OUTPUTS}
    for k in range(TICKS - 1):
        if estimator.fits is not None and k % PERIOD == 0:
            keep_up(estimator.fits)
        simulator.AdvanceTo((k + 0.5) * STEP)
        for name, values in seen.items():
            values.append(estimator.GetOutputPort(name).Eval(own).copy())
    return {name: np.array(values) for name, values in seen.items()}


@pytest.fixture(scope="module")
def simulated() -> dict[str, np.ndarray]:
    return watched(*told_of_strokes())


def test_every_output_is_the_offline_estimate_of_the_samples_so_far_bit_for_bit(simulated) -> None:
    trace = estimate_output_error(*contact(), OutputErrorOptions(step=STEP))
    for name in OUTPUTS:
        expected = np.asarray(getattr(trace, name)).reshape(TICKS, -1)[: TICKS - 1]
        np.testing.assert_array_equal(simulated[name], expected, err_msg=name)


def test_a_fit_is_put_out_at_its_latency_and_only_then(simulated) -> None:
    changes = np.flatnonzero((np.diff(simulated["theta"], axis=0) != 0.0).any(axis=1)) + 1
    assert len(changes) > 5
    assert set(changes % PERIOD) == {0}


def test_a_worker_that_keeps_up_gives_the_same_numbers(simulated) -> None:
    station, known = told_of_strokes(worker=True), list(adopt_theta.signatures)
    beside = watched(*station)
    np.testing.assert_array_equal(beside["theta"], simulated["theta"])
    assert adopt_theta.signatures == known, "nothing is compiled in the loop"


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor is all there is")
def test_a_worker_stays_off_the_processor_that_the_loop_has_for_itself() -> None:
    before = os.sched_getaffinity(0)
    diagram, estimator = told_of_strokes(worker=True)
    simulator = Simulator(diagram)
    with real_time_process(ProcessOptions(cpu=min(before))):
        simulator.AdvanceTo(2.5 * PERIOD * STEP)
    assert estimator.fits is not None and os.sched_getaffinity(estimator.fits.process.pid) == before


def test_the_process_of_the_fits_ends_with_the_estimator_and_with_the_program() -> None:
    fits = FitProcess(OutputErrorOptions(step=STEP))
    process = fits.process
    assert process.poll() is None
    del fits
    gc.collect()
    assert process.wait(5.0) in (0, -signal.SIGKILL)  # by itself, or by force where a busy machine takes it too long
    killed = subprocess.run([sys.executable, "-c", KILLED], capture_output=True, text=True, check=False)
    pid, until = int(killed.stdout), time.monotonic() + 5.0
    while runs(pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert not runs(pid)


def runs(pid: int) -> bool:
    """Whether there is a process that has not ended, be it that nobody has asked how."""
    stat = Path(f"/proc/{pid}/stat")
    return stat.exists() and stat.read_text().rpartition(")")[2].split()[0] != "Z"
