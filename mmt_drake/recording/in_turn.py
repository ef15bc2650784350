"""Tasks done by a thread, one after the other."""

from collections.abc import Callable
from queue import Full, Queue
from threading import Thread


class InTurn:
    """Does tasks in a thread of its own, in the order in which they come; who offers one never waits.

    The thread does not keep the process from ending.

    Args:
        most: how many may wait to be done.
        name: of the thread.
    """

    def __init__(self, most: int, name: str) -> None:
        self._waiting: Queue[Callable[[], object] | None] = Queue(most)
        self._done = 0
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

    def close(self, last: Callable[[], object] | None = None, patience: float | None = None) -> bool:
        """Wait for all of them, and end the thread. A second call does nothing.

        Args:
            last: one more task, done after all others.
            patience: how long to wait without any of them getting done [s]; None: for ever.

        Returns:
            Whether all is done; if not, the thread goes on with it.
        """
        tasks = [None] if last is None else [last, None]
        while self._thread.is_alive():
            before = self._done
            try:
                while tasks:
                    self._waiting.put(tasks[0], timeout=patience)
                    tasks.pop(0)
                self._thread.join(patience)
            except Full:
                pass
            if self._thread.is_alive() and self._done == before:
                return False
        return True

    def _run(self) -> None:
        while (task := self._waiting.get()) is not None:
            task()
            del task  # and what it holds
            self._done += 1
            self._waiting.task_done()
        self._waiting.task_done()
