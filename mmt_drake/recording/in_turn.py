"""Tasks done by a thread, one after the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

_MOST = 64


class InTurn:
    """Does tasks in a thread of its own, in the order in which they come; who adds them waits only for a backlog.

    What a task raises is raised by the next call here; the tasks behind it are not done.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="recorder")
        self._pending: deque[Future[None]] = deque()
        self._thread.submit(lambda: None).result()  # starts it now

    def add(self, task: Callable[[], None]) -> Future[None]:
        """Have a task done; what it uses must stay as it is until then."""
        while self._pending and (len(self._pending) >= _MOST or self._pending[0].done()):
            self._settle()
        self._pending.append(self._thread.submit(task))
        return self._pending[-1]

    def close(self) -> None:
        """Wait for all of them. A second call does nothing."""
        try:
            while self._pending:
                self._settle()
        finally:
            self._thread.shutdown()

    def _settle(self) -> None:
        try:
            self._pending.popleft().result()
        except BaseException:
            while self._pending:
                self._pending.popleft().cancel()
            raise
