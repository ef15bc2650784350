"""Fits beside the clock, in a process of their own: a thread would hold the interpreter's lock against the loop.

What is known stays there. To it go samples, as they are taken; back comes what a fit hands over.
"""

import os
import select
import signal
import subprocess
import sys
import weakref
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.effects.library import SOURCES, register_file
from mmt_drake.errors import MmtError
from mmt_drake.estimation.output_error.knowledge import Told
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.window import SAMPLE_SIZE
from mmt_drake.numeric.arrays import Array

_READY = "ready"
_PROGRAM = "from mmt_drake.estimation.output_error.beside import serve; serve({})"
_BEGINS_WITHIN, _ENDS_WITHIN = 300.0, 1.0  # [s], of which most is for what has yet to be compiled


class FitProcess(Closing):
    """A learner in a process of its own, begun and compiled when this is made; one that has ended is not begun again.

    Attributes:
        process: of the fits.
        under_way: whether a fit has been asked for and not been taken.

    Args:
        options: of the estimator.

    Raises:
        MmtError: the process cannot be begun.
    """

    def __init__(self, options: OutputErrorOptions) -> None:
        self._line, there = Pipe()
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        program = [sys.executable, "-c", _PROGRAM.format(there.fileno())]
        self.process = subprocess.Popen(program, pass_fds=[there.fileno()], env=environment, stdin=subprocess.DEVNULL)
        there.close()
        self._finalizer = weakref.finalize(self, _end, self._line, self.process)
        self._news = select.poll()  # made once: `Connection.poll` takes as long as a fit's news
        self._news.register(self._line.fileno(), select.POLLIN)
        self.under_way = False
        try:
            files = {SOURCES[effect.name] for effect in options.effects if effect.name in SOURCES}
            self._line.send((sorted(files), options))
            told = self._line.recv() if self._line.poll(_BEGINS_WITHIN) else f"nothing in {_BEGINS_WITHIN:g} s"
        except (OSError, EOFError):
            told = "it ended"
        if told != _READY:
            self.close()
            raise MmtError(f"estimator: the process for its fits did not begin: {told}")

    def close(self) -> None:
        """End the process; may be called again."""
        self._finalizer()

    def submit(self, samples: Array, broken: bool) -> bool:
        """Ask for a fit with new samples, as of `Learner.learned`; False: the process has ended."""
        try:
            self._line.send_bytes(np.concatenate([[broken], samples.ravel()]).tobytes())
        except OSError:
            return False
        self.under_way = True
        return True

    def is_done(self) -> bool:
        """Whether the fit that is under way has ended, or the process; never waits."""
        return bool(self._news.poll(0))

    def result(self) -> Told | None:
        """What the fit hands over; None: it failed, and its samples are gone."""
        self.under_way = False
        try:
            told = self._line.recv_bytes()
        except (OSError, EOFError):
            return None
        return Told.from_vector(np.frombuffer(told).copy()) if told else None


def _end(line: Connection, process: subprocess.Popen[bytes]) -> None:
    """The process ends by itself once its line does."""
    line.close()
    try:
        process.wait(_ENDS_WITHIN)
    except subprocess.TimeoutExpired:  # in a long fit
        process.kill()
        process.wait()


def serve(handle: int) -> None:
    """Learn until the line at a file handle ends: the main function of the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a person's Ctrl-C is the loop's
    with suppress(OSError, EOFError), Connection(handle) as line:
        files, options = line.recv()
        try:
            for file in files:
                register_file(file)
            learner = Learner(options)
            learner.compile()
            known = learner.beginning()
        except Exception as error:
            line.send(str(error) or repr(error))
            return
        line.send(_READY)
        said: set[str] = set()
        while True:
            broken, *_ = asked = np.frombuffer(line.recv_bytes())
            told = b""
            try:
                known = learner.learned(known, asked[1:].reshape(-1, SAMPLE_SIZE), bool(broken))
                told = known.told.vector().tobytes()
            except Exception as error:  # whatever it was, the run goes on
                _say(f"estimator: a fit failed: {error!r}", said)
            line.send_bytes(told)


def _say(line: str, said: set[str]) -> None:
    """Write a line once, if there is anyone to read it."""
    if line not in said:
        said.add(line)
        with suppress(OSError):
            print(line, file=sys.stderr, flush=True)
