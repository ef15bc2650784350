"""Work of one kind, done by several processes at the same time."""

import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import TypeVar

from mmt_drake.diagrams.proof.studies.study import Progress, unheard
from mmt_drake.with_parent import end_with_parent

T = TypeVar("T")


def results_of(
    tasks: Sequence[Callable[[], T]], jobs: int, progress: Progress = unheard, *, compile_first: bool = False
) -> list[T]:
    """What each task returns, in their order.

    Args:
        tasks: that can be pickled, and their results too.
        jobs: processes at work at the same time; 1: this one does all of it. More than one need a script whose entry
            stands under `if __name__ == "__main__"`.
        progress: called with the number of tasks done.
        compile_first: this process does the first task, so that the others find its kernels compiled.

    Raises:
        Exception: whatever a task raises; those that have not begun by then are not begun.
    """
    if jobs == 1 or not tasks:
        found = []
        for task in tasks:
            found.append(task())
            progress(len(found))
        return found
    if compile_first:
        first = results_of(tasks[:1], 1, progress)
        return first + results_of(tasks[1:], jobs, lambda done: progress(done + 1))
    with processes(min(jobs, len(tasks))) as pool:
        futures = [pool.submit(task) for task in tasks]
        for done, future in enumerate(as_completed(futures), 1):
            future.result()
            progress(done)
        return [future.result() for future in futures]


@contextmanager
def processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """So many processes to work with. After an error what has begun is brought to an end; Ctrl-C ends it at once.

    What a worker writes is whole or not there (`mmt_drake.recording.atomic`), so nothing is lost but the work.

    Args:
        jobs: processes.
    """
    # Spawned, not forked: libraries below have threads of their own by now.
    context = get_context("spawn")
    theirs, ours = context.Pipe(duplex=False)
    with theirs, ours, ProcessPoolExecutor(jobs, context, _begin, (theirs,)) as pool:
        try:
            yield pool
        except KeyboardInterrupt:
            ours.close()
            raise
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _begin(pipe: Connection) -> None:
    """Of a worker: the parent decides what Ctrl-C ends; without it nobody does."""
    end_with_parent(pipe)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
