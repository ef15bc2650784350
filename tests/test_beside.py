"""Work beside a run."""

import copy
import os
import signal
from collections.abc import Iterator

import pytest

from mmt_drake.beside import Later, WorkProcess, at_once
from mmt_drake.errors import BadInput


def added(a: float, b: float) -> tuple[float, int]:
    """What is asked for, and by whom it was done."""
    if a < 0.0:
        raise BadInput("sum", found=a, expected="0 or more")
    return a + b, os.getpid()


@pytest.fixture
def beside() -> Iterator[WorkProcess[tuple[float, int]]]:
    with WorkProcess(added, in_real_time=True) as process:
        yield process


def test_another_process_gives_what_the_work_gives(beside: WorkProcess[tuple[float, int]]) -> None:
    (here, us), (there, other) = at_once(added)(1.0, 2.0).value, beside.later(1.0, 2.0).value
    assert here == there == 3.0
    assert us == os.getpid() != other == beside.process.pid


def test_an_answer_waits_until_it_is_asked_for_and_its_copies_keep_it(beside: WorkProcess[tuple[float, int]]) -> None:
    laters = [beside.later(float(k), 0.0) for k in range(5)]
    assert [copy.deepcopy(each).value[0] for each in reversed(laters)] == [4.0, 3.0, 2.0, 1.0, 0.0]
    assert copy.deepcopy(laters[0]) is laters[0]


def test_work_that_fails_there_fails_where_it_is_asked_for(beside: WorkProcess[tuple[float, int]]) -> None:
    failing = beside.later(-1.0, 0.0)
    with pytest.raises(BadInput, match="sum: found -1"):
        _ = failing.value
    assert beside.later(1.0, 1.0).value[0] == 2.0


def test_the_run_goes_on_where_the_process_is_gone(beside: WorkProcess[tuple[float, int]]) -> None:
    asked = beside.later(1.0, 1.0).value
    beside.process.send_signal(signal.SIGKILL)
    beside.process.wait()
    assert beside.later(1.0, 1.0).value == (asked[0], os.getpid())


def test_nobody_waits_for_a_process_that_has_no_processor_however_long_the_message() -> None:
    with WorkProcess(doubled, in_real_time=True) as process:
        assert process.later(b"").value == b""
        process.process.send_signal(signal.SIGSTOP)
        asked = process.later(bytes(1_000_000))  # would wait here for a line that is full
        assert not asked.is_there
        process.process.send_signal(signal.SIGCONT)
        assert asked.value == bytes(2_000_000)


def doubled(what: bytes) -> bytes:
    return what + what


@pytest.mark.skipif(not hasattr(os, "SCHED_IDLE"), reason="Linux alone has it")
def test_in_real_time_it_works_only_when_a_processor_is_free(beside: WorkProcess[tuple[float, int]]) -> None:
    assert os.sched_getscheduler(beside.process.pid) == os.SCHED_IDLE
    with WorkProcess(added) as patient:
        patient.wait_until_ready()
        assert os.sched_getscheduler(patient.process.pid) == os.SCHED_OTHER
        assert os.getpriority(os.PRIO_PROCESS, patient.process.pid) >= 10


def test_its_memory_is_given_back(beside: WorkProcess[tuple[float, int]]) -> None:
    before = len(os.listdir("/proc/self/fd"))
    with WorkProcess(added, in_real_time=True) as process:
        assert process.later(1.0, 1.0).value[0] == 2.0
    del process
    assert len(os.listdir("/proc/self/fd")) == before


def test_what_is_known_needs_nobody() -> None:
    assert Later.known("here").value == "here"
