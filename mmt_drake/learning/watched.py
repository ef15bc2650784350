"""What a learner has seen of a contact, what it has asked, and what it tells."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np

from mmt_drake.effects import LIBRARY
from mmt_drake.errors import attempt
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.learning.answer import FREE_S, ROW, LookResult
from mmt_drake.learning.beside import Question
from mmt_drake.learning.left import Left
from mmt_drake.learning.options import Learning
from mmt_drake.model_message import NO_ERROR, UNKNOWN_THETA, ModelMessage, SensorError, ToldEffect
from mmt_drake.numeric.arrays import Array

_MOST: Final = 3
"""Windows that are looked at together at most."""
_LONGEST: Final = 4.0
"""Times as long as its contact what is kept may last."""
_SINCE_TOUCH: Final = 0.25
"""Of a window: so much longer is looked at where it then begins with the touch."""
_CONTACT: Final = ROW - 1


@dataclass(frozen=True)
class Piece:
    """A piece of what was seen.

    Attributes:
        rows: (n, ROW) samples.
        left: what the estimator left of the latest contact then, over its noise [1].
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
        pieces: of a contact without a gap. An object whose law nobody knows is taken for another one now and then, so
            they are kept then.
        windows: that are looked at together the next time.
        question: that is not answered yet.
        message: that was told last; None: none was.
        status: what the learner is about.
        before: what was left when the laws that are told were asked for; None: that has been looked into.
        thing: the object that is touched; a later one has a greater number.
        changed: whether the estimator says that it is another one.
        kept: samples in the pieces, counted along: a sum over hundreds of them costs the 1 kHz loop too much.
    """

    pieces: tuple[Piece, ...] = ()
    windows: int = 1
    question: Question | None = None
    message: ModelMessage | None = None
    status: LearnerStatus = LearnerStatus.WATCHING
    before: Left | None = None
    thing: int = 0
    changed: bool = False
    kept: int = 0

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def seeing(self, piece: Piece, sample: float, options: Learning) -> Self:
        """With a further piece."""
        pieces, kept = (*self.pieces, piece), self.kept + len(piece.rows)
        while kept > _LONGEST * _MOST * options.window / sample:
            pieces, kept = pieces[1:], kept - len(pieces[0].rows)
        return replace(self, pieces=pieces, kept=kept)

    def anew(self) -> Self:
        """Without what was seen: time broke off, or it has been looked into."""
        return replace(self, pieces=(), kept=0)

    def touching(self, changed: bool) -> Self:
        """Where the estimator says that the object is another one, or does not (any more).

        Laws stay, with which the estimator knows it again, if they are passive whatever its numbers are.
        """
        if not changed or self.changed:
            return replace(self, changed=changed)
        other = replace(self, thing=self.thing + 1, changed=True)
        return other if self.message is None else other._keeping(self.laws, self.message.sensor)

    def window(self, sample: float, options: Learning) -> tuple[Piece, ...]:
        """The latest pieces that hold as much contact as is to be looked at, and what comes right before it.

        None: there is not so much.
        """
        wanted = round(self.windows * options.window / sample)
        touching = 0
        for start in range(len(self.pieces) - 1, -1, -1):
            touching += self.pieces[start].touching
            if touching >= wanted:
                reach = round(_SINCE_TOUCH * options.window / sample)
                return (*self._before(start, reach, round(FREE_S / sample)), *self.pieces[start:])
        return ()

    def _before(self, start: int, reach: int, wanted: int) -> tuple[Piece, ...]:
        """What comes right before a piece: its contact from the touch on, and free space before that.

        What a law remembers is known from a touch on.

        Args:
            start: number of the piece.
            reach: so many samples ago it may have touched.
            wanted: so many samples of free space are worth while, those that the piece begins with among them.
        """
        earlier, count = start, 0
        while earlier > 0 and count < reach + wanted:
            earlier -= 1
            count += len(self.pieces[earlier].rows)
        if not count:
            return ()
        rows = np.concatenate([piece.rows for piece in self.pieces[earlier:start]])
        contact = rows[:, _CONTACT] > 0.5
        touch = len(rows)
        if self.pieces[start].rows[0, _CONTACT] > 0.5:
            free = np.flatnonzero(~contact)
            if not len(free) or touch - free[-1] - 1 > reach:
                return ()
            touch = int(free[-1]) + 1
        else:
            wanted -= int(np.argmax(self.pieces[start].rows[:, _CONTACT] > 0.5))
        others = np.flatnonzero(contact[:touch])
        release = int(others[-1]) + 1 if len(others) else 0
        first = release if touch - release >= wanted else touch
        return (Piece.of(rows[first:], self.pieces[start].left),) if first < len(rows) else ()

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
        if answer.tells and not doubtful:  # what was seen counts as soon as there is doubt again
            return replace(more, windows=1, status=self.standing)
        if not (answer.tells or self.tells):
            return replace(more, status=self.standing).anew()
        told = more._telling(answer.theta, answer.laws, answer.sensor)
        before = question.left if answer.tells else None
        return replace(told, windows=1, before=before, status=answer.status).anew()

    def judged(self, left: Left, options: Learning) -> Self:
        """After a window of contact with the laws that are told: each that does not earn its place leaves again.

        What of the force is the sensor's is told along the surface, and judged there.
        """
        if self.before is None or self.message is None:
            return self
        on_surface, along = left.earned(self.before, options.doubt)
        laws = tuple(law for law in self.laws if (along if LIBRARY[law.name].axis else on_surface))
        sensor = self.message.sensor if on_surface else NO_ERROR
        if (laws, sensor) == (self.laws, self.message.sensor):
            return replace(self, before=None)
        told = self._keeping(laws, sensor)
        status = LearnerStatus.TOLD if told.tells else LearnerStatus.CANNOT_TELL
        return replace(told, windows=min(self.windows + 1, _MOST), before=None, status=status).anew()

    @property
    def laws(self) -> tuple[ToldEffect, ...]:
        """That are told."""
        return () if self.message is None else self.message.effects

    @property
    def tells(self) -> bool:
        """Whether laws, or what the force sensor adds, are told."""
        return self.message is not None and bool(self.laws or any(self.message.sensor))

    @property
    def standing(self) -> LearnerStatus:
        """What it is about where nothing is new."""
        return LearnerStatus.TOLD if self.tells else LearnerStatus.WATCHING

    def _keeping(self, laws: tuple[ToldEffect, ...], sensor: SensorError) -> Self:
        """With the next message, of no numbers, and of those laws that may be felt with any."""
        kept: tuple[ToldEffect, ...] = ()
        for law in laws:
            if attempt(ModelMessage, UNKNOWN_THETA, (*kept, law)) is not None:
                kept = (*kept, law)
        return self._telling(UNKNOWN_THETA, kept, sensor)

    def _telling(
        self, theta: tuple[float, ...], laws: tuple[ToldEffect, ...] = (), sensor: SensorError = NO_ERROR
    ) -> Self:
        """With the next message."""
        number = 1 if self.message is None else self.message.number + 1
        return replace(self, message=ModelMessage(theta, laws, self.thing, number, sensor))


def left_of(window: Sequence[Piece]) -> float:
    """What the estimator leaves of the later half of the contact in a window, over its noise: the median."""
    of_contact = np.repeat([piece.left for piece in window], [piece.touching for piece in window])
    return float(np.median(of_contact[len(of_contact) // 2 :]))
