"""Work beside the clock, in a process of its own: a thread would hold the interpreter's lock against the loop."""

import os
import pickle
import select
import signal
import subprocess
import sys
import weakref
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

from mmt_drake.closing import Closing
from mmt_drake.errors import MmtError

_READY = "ready"
# Threads of libraries wait for work by keeping a processor busy, and those of a renderer take the loop's.
_THREADS = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "LP_NUM_THREADS": "0"}
_GIVES_WAY = 10  # to the loop, which is what the others wait for: of priority, as of `nice`
_BEGINS_WITHIN, _ENDS_WITHIN = 300.0, 1.0  # [s], of which most is for what has yet to be compiled


class OwnProcess(Closing):
    """A process that answers in its turn, begun when this is made; one that has ended is not begun again.

    Attributes:
        process: the process.

    Args:
        module: that has a function `serve(handle, *files)`, its main function, which is to use `served`.
        first: what that is given first.
        what: it does, for a message: "the process for its fits".
        ready: wait until it is; else that is due with `wait_until_ready`, before anything is asked.
        files: open ones, which it is given, too.

    Raises:
        MmtError: the process cannot be begun.
    """

    def __init__(self, module: str, first: object, what: str, *, ready: bool = True, files: Sequence[int] = ()) -> None:
        self._line, there = Pipe()
        handles = (there.fileno(), *files)
        paths = os.pathsep.join(filter(None, sys.path))
        environment = os.environ | {"PYTHONPATH": paths} | _THREADS
        # It ends at once: what an interpreter gives back first takes longer than whoever closes it should wait.
        work = f"import os; from {module} import serve; serve{handles}; os._exit(0)"
        program = [sys.executable, "-c", work]
        self.process = subprocess.Popen(program, pass_fds=handles, env=environment, stdin=subprocess.DEVNULL)
        there.close()
        self._finalizer = weakref.finalize(self, _end, self._line, self.process)
        self._news = select.poll()  # made once: `Connection.poll` takes as long as the news
        self._news.register(self._line.fileno(), select.POLLIN)
        self._begins: str | None = what
        packed = pickle.dumps(first, pickle.HIGHEST_PROTOCOL)
        if ready:
            self._tell(packed)
            self.wait_until_ready()
        else:  # by a thread: as long as it has not begun nobody reads
            Thread(target=self._tell, args=(packed,), daemon=True).start()

    def is_ready(self) -> bool:
        """Whether it can be asked, without a wait for that.

        Raises:
            MmtError: it cannot be begun.
        """
        if self._begins is not None and self._news.poll(0):
            self.wait_until_ready()
        return self._begins is None

    def wait_until_ready(self) -> None:
        """Wait until it can be asked.

        Raises:
            MmtError: it cannot be begun.
        """
        if self._begins is None:
            return
        what, self._begins = self._begins, None
        try:
            told = self._line.recv() if self._line.poll(_BEGINS_WITHIN) else f"nothing in {_BEGINS_WITHIN:g} s"
        except (OSError, EOFError):
            told = "it ended"
        if told != _READY:
            self.close()
            raise MmtError(f"{what} did not begin: {told}")

    def _tell(self, first: bytes) -> None:
        with suppress(OSError):  # it has ended, which shows where it is waited for
            self._line.send_bytes(first)

    def close(self) -> None:
        """End the process; may be called again."""
        self._finalizer()

    def send(self, asked: bytes) -> bool:
        """Ask it; False: the process has ended."""
        try:
            self._line.send_bytes(asked)
        except OSError:
            return False
        return True

    def is_done(self) -> bool:
        """Whether there is an answer, or the process has ended; never waits. Of a long one it may be the beginning."""
        return bool(self._news.poll(0))

    def answer(self) -> bytes:
        """Its answer, for which it waits; nothing: the process has ended, or could not answer."""
        try:
            return self._line.recv_bytes()
        except (OSError, EOFError):
            return b""


def _end(line: Connection, process: subprocess.Popen[bytes]) -> None:
    """The process ends by itself once its line does."""
    line.close()
    try:
        process.wait(_ENDS_WITHIN)
    except subprocess.TimeoutExpired:  # in long work
        process.kill()
        process.wait()


def give_way(nice: int = _GIVES_WAY, *, idle: bool = False) -> None:
    """Lower the priority of this process.

    Args:
        nice: by so much, as of `nice`.
        idle: it works only when all others leave time for it, and never keeps one that wakes up waiting; on Linux.
    """
    os.nice(nice)
    if idle and hasattr(os, "SCHED_IDLE"):
        for thread in os.listdir("/proc/self/task"):
            with suppress(OSError):  # where it is forbidden it is nice
                os.sched_setscheduler(int(thread), os.SCHED_IDLE, os.sched_param(0))


def served(handle: int, begin: Callable[[Any], Callable[[bytes], bytes | None]], what: str) -> None:
    """Answer until the line at a file handle ends: what a main function of such a process does.

    Args:
        handle: of the line.
        begin: called with what is given first; makes what is called with what is asked and answers, with None for
            nothing. One that raises has answered with no bytes, and says why once.
        what: it does, for that line.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a person's Ctrl-C is the loop's
    said: set[str] = set()
    with suppress(OSError, EOFError), Connection(handle) as line:
        first = line.recv()
        try:
            answer = begin(first)
        except Exception as error:
            line.send(str(error) or repr(error))
            return
        line.send(_READY)
        while True:
            told: bytes | None = b""
            asked = line.recv_bytes()
            try:
                told = answer(asked)
            except Exception as error:  # whatever it was, the run goes on
                _say(f"{what} failed: {error!r}", said)
            if told is not None:
                line.send_bytes(told)


def _say(line: str, said: set[str]) -> None:
    """Write a line to standard error if it is not among those `said`, and if there is anyone to read it."""
    if line not in said:
        said.add(line)
        with suppress(OSError):
            print(line, file=sys.stderr, flush=True)
