"""Work of one kind, done by several processes at the same time."""

import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import closing, contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import TypeVar

from mmt_drake.diagrams.proof.studies.study import Progress, unheard
from mmt_drake.errors import Interrupted
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
        Interrupted: with the results by then.
    """
    found = dict[int, T]()
    try:
        with closing(_results(tasks, jobs, compile_first)) as results:
            for number, result in results:
                found[number] = result
                progress(len(found))
    except KeyboardInterrupt:
        known = {"of": len(tasks), "results": [found[number] for number in sorted(found)]}
        raise Interrupted(f"{len(found)} of {len(tasks)} done", known if found else None) from None
    return [found[number] for number in range(len(tasks))]


def _results(tasks: Sequence[Callable[[], T]], jobs: int, compile_first: bool) -> Generator[tuple[int, T]]:
    """The number of each task and what it returns, as they come."""
    alone = len(tasks) if jobs == 1 else int(compile_first)
    for number, task in enumerate(tasks[:alone]):
        yield number, task()
    rest = tasks[alone:]
    if not rest:
        return
    with processes(min(jobs, len(rest))) as pool:
        numbers = {pool.submit(task): number for number, task in enumerate(rest, alone)}
        for future in as_completed(numbers):
            yield numbers[future], future.result()


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
        except (KeyboardInterrupt, GeneratorExit):
            ours.close()
            raise
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _begin(pipe: Connection) -> None:
    """Of a worker: the parent decides what Ctrl-C ends; without it nobody does."""
    end_with_parent(pipe)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
