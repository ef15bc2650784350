"""What a learner has seen of a contact, what it has asked, and what it tells."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np

from mmt_drake.learning.answer import ROW, LearnerStatus, LookResult
from mmt_drake.learning.beside import Question
from mmt_drake.learning.options import Learning
from mmt_drake.model_message import UNKNOWN_THETA, ModelMessage, ToldEffect
from mmt_drake.numeric.arrays import Array

_MOST: Final = 3
"""Windows that are looked at together at most."""
_LONGEST: Final = 4.0
"""Times as long as its contact what is kept may last."""
_EARNS: Final = 0.5
"""A law leaves again if with it more than this part is left of what was left without, and that is in doubt."""
_CONTACT: Final = ROW - 1


@dataclass(frozen=True)
class Piece:
    """A piece of what was seen.

    Attributes:
        rows: (n, ROW) samples.
        left: what the estimator left of the latest contact then, over its noise.
        touching: how many of them are of contact.
    """

    rows: Array
    left: float
    touching: int

    @classmethod
    def of(cls, rows: Array, left: float) -> Self:
        """Of samples (n, ROW)."""
        return cls(rows, left, int(np.count_nonzero(rows[:, _CONTACT] > 0.5)))


@dataclass(frozen=True)
class Watched:
    """The state of a learner; never changed.

    Attributes:
        pieces: of a contact without a gap, with one object.
        windows: that are looked at together the next time.
        question: that is not answered yet.
        message: that was told last; None: none was.
        status: what the learner is about.
        before: what was left when the laws that are told were asked for; NaN: that has been looked into.
    """

    pieces: tuple[Piece, ...] = ()
    windows: int = 1
    question: Question | None = None
    message: ModelMessage | None = None
    status: LearnerStatus = LearnerStatus.WATCHING
    before: float = math.nan

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def seeing(self, piece: Piece, sample: float, options: Learning) -> Self:
        """With a further piece."""
        most, kept = _LONGEST * _MOST * options.window / sample, (*self.pieces, piece)
        while sum(len(one.rows) for one in kept) > most:
            kept = kept[1:]
        return replace(self, pieces=kept)

    def anew(self) -> Self:
        """Without what was seen: it was of another object, or time broke off."""
        return replace(self, pieces=())

    def window(self, sample: float, options: Learning) -> tuple[Piece, ...]:
        """The latest pieces that hold as much contact as is to be looked at; none: there is not so much."""
        wanted = round(self.windows * options.window / sample)
        touching = 0
        for start in range(len(self.pieces) - 1, -1, -1):
            touching += self.pieces[start].touching
            if touching >= wanted:
                return self.pieces[start:]
        return ()

    def asking(self, question: Question) -> Self:
        """While a question is looked into."""
        return replace(self, question=question, status=LearnerStatus.LOOKING)

    def answered(self, answer: LookResult | None, doubtful: bool) -> Self:
        """With an answer to its question, None for none.

        Laws enter only where the latest contact is doubtful still: it may be another object's.
        """
        question = self.question
        assert question is not None  # which was answered
        more = replace(self, question=None, windows=min(self.windows + 1, _MOST))
        if answer is None:
            return replace(more, status=LearnerStatus.FAILED).anew()
        if not answer.settled:  # what was seen meanwhile counts the next time
            return replace(more, status=answer.status)
        if not (answer.laws or self.laws) or (answer.laws and not doubtful):
            return replace(more, status=self.standing).anew()
        message = ModelMessage(answer.theta, answer.laws, number=self._number)
        before = question.left if answer.laws else math.nan
        return replace(more, windows=1, before=before, message=message, status=answer.status).anew()

    def judged(self, left: float, options: Learning) -> Self:
        """After a window of contact with the laws that are told: they leave again if they do not earn their place."""
        if math.isnan(self.before) or not self.laws:
            return self
        if left > options.doubt and left > _EARNS * self.before:
            message = ModelMessage(UNKNOWN_THETA, number=self._number)
            gone = replace(self, message=message, windows=min(self.windows + 1, _MOST))
            return replace(gone, before=math.nan, status=LearnerStatus.CANNOT_TELL).anew()
        return replace(self, before=math.nan)

    @property
    def laws(self) -> tuple[ToldEffect, ...]:
        """That are told."""
        return () if self.message is None else self.message.effects

    @property
    def standing(self) -> LearnerStatus:
        """What it is about where nothing is new."""
        return LearnerStatus.TOLD if self.laws else LearnerStatus.WATCHING

    @property
    def _number(self) -> int:
        return 1 if self.message is None else self.message.number + 1


def left_of(window: Sequence[Piece]) -> float:
    """What the estimator leaves of the later half of the contact in a window, over its noise: the median."""
    of_contact = np.repeat([piece.left for piece in window], [piece.touching for piece in window])
    return float(np.median(of_contact[len(of_contact) // 2 :]))
