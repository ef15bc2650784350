"""Tasks beside each other give what they give one after the other, and an error keeps the rest from beginning."""

import math
import time
from collections.abc import Callable
from functools import partial

import pytest

from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.errors import Interrupted


@pytest.mark.parametrize(("jobs", "compile_first"), [(1, False), (2, False), (2, True)])
def test_results_come_in_the_order_of_the_tasks_and_each_is_counted(jobs: int, compile_first: bool) -> None:
    told: list[float] = []
    tasks = [partial(math.factorial, number) for number in (9, 2, 5)]
    assert results_of(tasks, jobs, told.append, compile_first=compile_first) == [362880, 2, 120]
    assert told == [1, 2, 3]


def test_an_error_keeps_what_has_not_begun_from_beginning() -> None:
    waits: list[Callable[[], object]] = [partial(time.sleep, 0.3) for _ in range(200)]
    start = time.monotonic()
    with pytest.raises(ValueError, match="math domain error"):
        results_of([partial(math.sqrt, -1.0), *waits], 2)
    assert time.monotonic() - start < 15.0  # half of what all would take


def test_ctrl_c_does_not_wait_for_what_has_begun() -> None:
    def interrupted(_: float) -> None:
        raise KeyboardInterrupt

    waits: list[Callable[[], object]] = [partial(time.sleep, 60.0) for _ in range(3)]
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        results_of([partial(math.factorial, 3), *waits], 2, interrupted)
    assert time.monotonic() - start < 30.0  # most of it until the workers have begun


@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_hands_over_what_is_done(jobs: int) -> None:
    def interrupted(done: float) -> None:
        if done == 2:
            raise KeyboardInterrupt

    tasks = [partial(math.factorial, number) for number in (9, 2, 5)]
    with pytest.raises(Interrupted, match="2 of 3 done") as raised:
        results_of(tasks, jobs, interrupted)
    assert raised.value.known["of"] == 3
    done = raised.value.known["results"]
    assert isinstance(done, list) and len(done) == 2 and set(done) <= {362880, 2, 120}


def test_without_tasks_there_are_no_results() -> None:
    assert results_of([], 4) == []
