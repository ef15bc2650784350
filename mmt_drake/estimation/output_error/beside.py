"""Fits beside the clock, in a process of their own.

What is known stays there. To it go samples, as they are taken, and model messages; back comes what a fit hands over.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from mmt_drake.effects.library import own_files, register_file
from mmt_drake.errors import BadInput
from mmt_drake.estimation.output_error.knowledge import Told
from mmt_drake.estimation.output_error.learn import Learner
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.window import SAMPLE_SIZE
from mmt_drake.numeric.arrays import Array
from mmt_drake.own_process import OwnProcess, give_way, served

_MODEL = 2.0  # in the place of `broken`: a model message, which is not answered
_MET = 3.0  # an object that the probe is at, likewise
_GIVES_WAY = 19  # as of `nice`, to a run by simulated time, which waits for a fit a whole period later


class FitProcess(OwnProcess):
    """A learner in a process of its own, begun and compiled when this is made; one that has ended is not begun again.

    Attributes:
        under_way: whether a fit has been asked for and not been taken.

    Args:
        options: of the estimator.
        waits: for a run by simulated time, which waits for each fit and for each object that is met, so that its
            numbers are those of a run without this process. It is not waited for until something is asked.

    Raises:
        MmtError: the process cannot be begun.
    """

    def __init__(self, options: OutputErrorOptions, *, waits: bool = False) -> None:
        first = own_files(effect.name for effect in options.effects), options, waits
        super().__init__(__name__, first, "estimator: the process for its fits", ready=not waits)
        self.under_way, self._waits = False, waits

    def is_done(self) -> bool:
        """Whether there is an answer, or the process has ended; with `waits` there will be one."""
        return self._waits or super().is_done()

    def submit(self, samples: Array, broken: bool) -> bool:
        """Ask for a fit with new samples, as of `Learner.learned`; False: the process has ended."""
        self.under_way = self.send(np.concatenate([[broken], samples.ravel()]).tobytes())
        return self.under_way

    def retell(self, model: Array) -> bool:
        """Tell it a message (MESSAGE_SIZE,), as of `Learner.retold`; False: the process has ended."""
        return self.send(np.concatenate([[_MODEL], model]).tobytes())

    def met(self, thing: int, looks: Sequence[float]) -> bool:
        """Tell it an object that the probe is at, as of `Learner.met`; False: the process has ended.

        With `waits` what is handed over of that object is the next `result`.
        """
        return self.send(np.array([_MET, thing, *looks]).tobytes())

    def result(self) -> Told | None:
        """What the fit hands over; None: it failed, and its samples are gone."""
        self.under_way = False
        told = self.answer()
        return Told.from_vector(np.frombuffer(told).copy()) if told else None


def serve(handle: int) -> None:
    """Learn until the line at a file handle ends: the main function of the process."""
    served(handle, _begin, "estimator: a fit")


def _begin(first: tuple[list[Path], OutputErrorOptions, bool]) -> Callable[[bytes], bytes | None]:
    files, options, waits = first
    if waits:
        give_way(_GIVES_WAY)
    else:
        give_way()
    for file in files:
        register_file(file)
    learner = Learner(options)
    learner.compile()
    known = learner.beginning()

    def answer(asked: bytes) -> bytes | None:
        nonlocal known
        what, *_ = numbers = np.frombuffer(asked)
        if what == _MET:
            known = learner.met(known, int(numbers[1]), tuple(numbers[2:].tolist()))
            return known.told.vector().tobytes() if waits else None
        if what != _MODEL:
            known = learner.learned(known, numbers[1:].reshape(-1, SAMPLE_SIZE), bool(what))
            return known.told.vector().tobytes()
        with suppress(BadInput):  # the loop has seen that before, and says so
            known = learner.retold(known, numbers[1:].copy())
        return None

    return answer
