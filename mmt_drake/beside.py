"""Work that other processes do while a simulation goes on: it gives the same numbers, sooner."""

from __future__ import annotations

import os
import pickle
import weakref
from collections.abc import Callable
from tempfile import TemporaryFile
from typing import Any, Generic, Protocol, TypeVar

from mmt_drake.own_process import OwnProcess, give_way, served

T = TypeVar("T")


class Apart(Protocol):
    """How work is done: `at_once`, or in a process of its own, as by `WorkProcess`."""

    def __call__(self, work: Callable[..., T], prepare: Callable[[], object] | None = None) -> Callable[..., Later[T]]:
        """What does it later; `prepare` is called before it is done for the first time."""


class Later(Generic[T]):
    """A value that is there, or that somebody computes, for the state of a system that shows it some time later.

    Whoever asks for it waits until it is there, so a run gives the same numbers however long it takes; a run in real
    time asks first whether it is there. A copy is the same value.

    Args:
        compute: waits for it.
        is_done: whether `compute` would not have to wait.
    """

    def __init__(self, compute: Callable[[], T], is_done: Callable[[], bool] = lambda: True) -> None:
        self._compute: Callable[[], T] | None = compute
        self._is_done = is_done
        self._value: T
        self._error: Exception | None = None

    @classmethod
    def known(cls, value: T) -> Later[T]:
        """One that is there."""
        later = cls(lambda: value)
        later.wait()
        return later

    @property
    def is_there(self) -> bool:
        """Whether it can be had without waiting."""
        return self._compute is None or self._is_done()

    def wait(self) -> None:
        """Wait until it is there, or has failed."""
        if self._compute is None:
            return
        compute, self._compute = self._compute, None
        try:
            self._value = compute()
        except Exception as error:
            self._error = error

    @property
    def value(self) -> T:
        """It; what its computation raised is raised."""
        self.wait()
        if self._error is not None:
            raise self._error
        return self._value

    def __deepcopy__(self, memo: object) -> Later[T]:
        return self


def at_once(work: Callable[..., T], prepare: Callable[[], object] | None = None) -> Callable[..., Later[T]]:
    """The same work, done when it is asked for; see `Apart`."""
    if prepare is not None:
        prepare()
    return lambda *given: Later.known(work(*given))


class WorkProcess(OwnProcess, Generic[T]):
    """A process that does one work again and again; it begins when this is made.

    What it is given and what it answers stand in memory that both have; the line between them only says how much. So
    nobody waits for the other to write or to read it.

    Args:
        work: what it does; it, what it is given and what it returns can be pickled.
        prepare: is called first, in both processes.
        in_real_time: wait until it is ready; it then works only when the loop leaves a processor to it.

    Raises:
        MmtError: of `later`: the process cannot be begun.
    """

    def __init__(
        self, work: Callable[..., T], prepare: Callable[[], object] | None = None, *, in_real_time: bool = False
    ) -> None:
        first, files = (work, prepare, in_real_time), (_memory(), _memory())
        self._given, self._told = files
        self._files = weakref.finalize(self, _close, files)
        super().__init__(__name__, first, "the process beside the run", ready=in_real_time, files=files)
        if prepare is not None:
            prepare()
        self._work = work
        self._asked: Later[T] | None = None

    def later(self, *given: Any) -> Later[T]:
        """Have it done with these; what was asked for before is waited for first.

        As long as the process is not ready, and once it is closed, it is done here.
        """
        if not (self._files.alive and self.is_ready()):
            return Later.known(self._work(*given))
        if self._asked is not None:
            self._asked.wait()
        self._asked = later = Later(lambda: self._answered(given), self.is_done)
        self.send(_written(self._given, given))
        return later

    def close(self) -> None:
        """End the process; may be called again."""
        super().close()
        self._files()

    def _answered(self, given: tuple[Any, ...]) -> T:
        answer = self.answer()
        # It failed there, or the process is gone: what is wrong shows here.
        result: T = _read(self._told, answer) if answer else self._work(*given)
        return result


def serve(handle: int, given: int, told: int) -> None:
    """Work until the line at a file handle ends: the main function of the process."""

    def begin(first: tuple[Callable[..., object], Callable[[], object] | None, bool]) -> Callable[[bytes], bytes]:
        work, prepare, in_real_time = first
        if prepare is not None:
            prepare()
        give_way(idle=in_real_time)
        return lambda asked: _written(told, work(*_read(given, asked)))

    served(handle, begin, "work beside the run")


def _memory() -> int:
    """A handle of a file that is nowhere but in memory, where the system has such."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("beside")
    with TemporaryFile() as file:
        return os.dup(file.fileno())


def _close(files: tuple[int, ...]) -> None:
    for file in files:
        os.close(file)


def _written(file: int, value: object) -> bytes:
    """Put a value into a file; its size."""
    packed = pickle.dumps(value, pickle.HIGHEST_PROTOCOL)
    os.pwrite(file, packed, 0)
    return len(packed).to_bytes(8)


def _read(file: int, size: bytes) -> Any:
    return pickle.loads(os.pread(file, int.from_bytes(size), 0))
