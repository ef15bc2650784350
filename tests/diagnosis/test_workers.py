"""Who does the work hears that it is over."""

import threading
import time

import pytest

from mmt_drake.diagnosis.fit.workers import check_stop, workers


def test_what_interrupts_the_caller_ends_the_fits_that_run_and_those_that_wait():
    begun, ended = threading.Semaphore(0), []

    def fit() -> None:
        begun.release()
        try:
            while True:
                check_stop()
                time.sleep(0.001)
        except KeyboardInterrupt:
            ended.append(True)
            raise

    with pytest.raises(KeyboardInterrupt), workers(2) as executor:
        waiting = [executor.submit(fit) for _ in range(4)]
        assert all(begun.acquire(timeout=20.0) for _ in range(2))
        raise KeyboardInterrupt
    assert len(ended) == 2
    assert [future.cancelled() for future in waiting] == [False, False, True, True]


def test_elsewhere_nobody_is_stopped():
    check_stop()
