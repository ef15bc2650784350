"""Looks at a contact beside the clock, in a process of their own, which gives way to whoever else works."""

import pickle
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock, Thread
from typing import Any, Self
from weakref import WeakKeyDictionary

import numpy as np

from mmt_drake.closing import Closing
from mmt_drake.diagnosis.fit.workers import workers
from mmt_drake.effects import LIBRARY
from mmt_drake.effects.library import own_files, register_file
from mmt_drake.learning.answer import LookResult, look
from mmt_drake.learning.left import Left
from mmt_drake.numeric.arrays import Array
from mmt_drake.own_process import OwnProcess, give_way, served


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked of a contact; never changed.

    Attributes:
        pieces: (n, ROW) samples each, one after the other (`mmt_drake.learning.answer`).
        sample: time between them [s].
        theta: (10,) numbers of the estimator.
        asked: when [s].
        left: what was left of the contact, see `Learning.doubt`.
    """

    pieces: tuple[Array, ...]
    sample: float
    theta: Array
    asked: float
    left: Left

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def wording(self) -> tuple[tuple[Array, ...], float, Array, float]:
        """As another process is asked: the pieces, between samples, theta, and when the first sample was taken [s]."""
        count = sum(map(len, self.pieces))
        return self.pieces, self.sample, self.theta, self.asked - count * self.sample


class Looks(Closing):
    """A process that answers questions in their order; it is begun when this is made.

    Args:
        idle: for a run in real time: it works when nobody else does, where the system can say so.

    Raises:
        MmtError: the process cannot be begun.
    """

    def __init__(self, *, idle: bool = False) -> None:
        self._own = OwnProcess(__name__, (own_files(LIBRARY), idle), "learner: the process for its looks")
        self._waiting: deque[Question] = deque()
        self._turn = Lock()
        self._answers: WeakKeyDictionary[Question, LookResult | None] = WeakKeyDictionary()

    def close(self) -> None:
        """End the process; may be called again."""
        self._own.close()

    def ask(self, question: Question) -> None:
        """Have it answered; does not wait until the process has read it all."""
        self._waiting.append(question)
        Thread(target=self._send, args=(question,), daemon=True).start()

    def _send(self, question: Question) -> None:
        with self._turn:
            self._own.send(pickle.dumps(question.wording))

    def is_answered(self, question: Question) -> bool:
        """Whether `answer` has not to wait."""
        while self._waiting and self._own.is_done():
            self._take()
        return question in self._answers or question not in self._waiting

    def answer(self, question: Question, *, here: bool) -> LookResult | None:
        """The answer, for which it waits; None: the look failed.

        Args:
            question: that was asked, be it of another process.
            here: look here for what the process knows nothing of; else that has failed.
        """
        while question in self._waiting:
            self._take()
        if question not in self._answers and here:
            self._answers[question] = _answered(*question.wording)
        return self._answers.get(question)

    def _take(self) -> None:
        told = self._own.answer()  # nothing where the process has ended
        self._answers[self._waiting.popleft()] = pickle.loads(told) if told else None


def _answered(pieces: Sequence[Array], sample: float, theta: Array, begun: float) -> LookResult | None:
    with workers(1) as executor:
        return look(np.concatenate(pieces), sample, theta, begun, executor)


def serve(handle: int) -> None:
    """Look until the line at a file handle ends: the main function of the process."""
    served(handle, _begin, "learner: a look")


def _begin(first: tuple[list[Path], bool]) -> Callable[[bytes], bytes]:
    files, idle = first
    give_way(idle=idle)
    for file in files:
        register_file(file)
    return lambda asked: pickle.dumps(_answered(*pickle.loads(asked)))
