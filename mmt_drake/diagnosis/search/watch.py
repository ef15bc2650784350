"""A search's clock and log: how long it may take, what it has found so far, and what it had no time for."""

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace

from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.effects.effect import Effect, Scales
from mmt_drake.errors import Interrupted

NOTHING = "nothing"
"""The name of no effect at all."""
_BEST_SHOWN = 5


@dataclass(frozen=True)
class Stage:
    """Where long work is.

    Attributes:
        name: what is being done.
        now: which of it was last; empty at its beginning.
        done, total: how many of these have been done, and how many there are; 0 and 0 where nobody knows.
        then: stages that may come after it, in their order; a search that has found enough leaves some out.
    """

    name: str
    now: str = ""
    done: int = 0
    total: int = 0
    then: tuple[str, ...] = ()

    def __str__(self) -> str:
        """It in words."""
        share = f", {self.done} of {self.total}" if self.total else ""
        now = f": {self.now}" if self.now else ""
        return f"{self.name}{share}{now}"


OnStage = Callable[[Stage], None]
OnAnswer = Callable[[str], None]


class Watch:
    """The clock of a search.

    Args:
        stages: of the work, in their order.
        on_stage: called with each stage as it begins, and with what of it has been done.
        seconds: after so long nothing new is begun.
        on_answer: called once, with what is known when the first effects have been fitted.
    """

    def __init__(
        self,
        stages: Sequence[str] = (),
        on_stage: OnStage = lambda _: None,
        seconds: float = math.inf,
        on_answer: OnAnswer = lambda _: None,
    ) -> None:
        self._stages, self._on_stage, self._stage = tuple(stages), on_stage, Stage("")
        self._on_answer: OnAnswer | None = on_answer
        self._seconds = seconds
        self._end = time.monotonic() + seconds
        self._missed: dict[str, None] = {}
        self._left: dict[str, float] = {}

    def begin(self, stage: str) -> None:
        """Say that a stage begins."""
        then = self._stages[self._stages.index(stage) + 1 :] if stage in self._stages else ()
        self._stage = Stage(stage, then=then)
        self._on_stage(self._stage)

    def did(self, what: str, done: int, total: int) -> None:
        """Say what has been done of the stage, as the latest of how many."""
        self._stage = replace(self._stage, now=what, done=done, total=total)
        self._on_stage(self._stage)

    def is_late(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() > self._end

    def has_left(self, share: float) -> bool:
        """Whether this share of all the time that there was is left."""
        return self._end - time.monotonic() >= share * self._seconds

    @contextmanager
    def within(self, share: float) -> Iterator[None]:
        """What goes on inside has this share of the time that is left: the rest is for what comes after it."""
        end, now = self._end, time.monotonic()
        self._end = now + share * max(end - now, 0.0)
        try:
            yield
        finally:
            self._end = end

    def saw(self, names: str, left: float) -> None:
        """Note that with these effects (`NOTHING`, say) this many times the noise is left."""
        self._left[names] = min(left, self._left.get(names, math.inf))

    def answer(self) -> None:
        """Tell what is known so far, if that has not been done."""
        tell, self._on_answer = self._on_answer, None
        if tell is not None:
            tell(self.so_far)

    @property
    def so_far(self) -> str:
        """What is known in the midst of a search, in a sentence; nothing before its first fit."""
        if not self._left:
            return ""
        least = [*self._least_first().items()][:_BEST_SHOWN]
        said = [f"{left:.3g} with {names}{' added' if i == 0 else ''}" for i, (names, left) in enumerate(least)]
        end = "; no effect has been fitted yet" if [*self._left] == [NOTHING] else ""
        return f"so far the error over the noise is {', '.join(said)}{end}"

    def interrupted(self) -> Interrupted:
        """What is known, for who interrupts."""
        left = {names: left for names, left in self._least_first().items() if math.isfinite(left)}
        return Interrupted(self.so_far, {"error_over_noise": left, "untried": self.missed} if left else None)

    def _least_first(self) -> dict[str, float]:
        return dict(sorted(self._left.items(), key=lambda item: item[1]))

    def miss(self, what: Iterable[str]) -> None:
        """Note what there was no time for."""
        self._missed.update(dict.fromkeys(what))

    def took_up(self) -> tuple[str, ...]:
        """What there was no time for, and is tried now."""
        missed = self.missed
        self._missed.clear()
        return missed

    @property
    def missed(self) -> tuple[str, ...]:
        """What there was no time for: effects, sets of them in words."""
        return tuple(self._missed)


@dataclass(frozen=True)
class SearchSetup:
    """What every step of a search works with.

    Attributes:
        problem: what is fitted.
        library: effects to try.
        scales: of the recordings.
        executor: runs the fits.
        watch: the clock; it hears what has been tried, and what there was no time for.
        friction_unsaid: whether friction is a vector in the plane, or one for each axis, as fitted better without any
            effect; nobody said which.
    """

    problem: Problem
    library: Sequence[Effect]
    scales: Scales
    executor: Executor
    watch: Watch
    friction_unsaid: bool = False
