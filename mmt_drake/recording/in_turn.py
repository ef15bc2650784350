"""Tasks done by a thread, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from queue import Full, Queue
from threading import Thread


class InTurn:
    """Does tasks in a thread of its own, in the order in which they come; who offers one never waits.

    Args:
        most: how many may wait to be done.
        name: of the thread.
    """

    def __init__(self, most: int, name: str) -> None:
        self._waiting: Queue[Callable[[], object] | None] = Queue(most)
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def offer(self, task: Callable[[], object]) -> bool:
        """Have a task done, which deals with its own errors; False if too many are waiting: then it is not taken."""
        try:
            self._waiting.put_nowait(task)
        except Full:
            return False
        return True

    def wait(self) -> None:
        """Until all that was offered is done."""
        self._waiting.join()

    def close(self) -> None:
        """Wait for all of them. A second call does nothing."""
        if self._thread.is_alive():
            self._waiting.put(None)
            self._thread.join()

    def _run(self) -> None:
        while (task := self._waiting.get()) is not None:
            task()
            self._waiting.task_done()
        self._waiting.task_done()
