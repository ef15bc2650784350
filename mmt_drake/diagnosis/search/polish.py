"""Fits of a search taken on on the accurate clock, none of them twice."""

from collections.abc import Sequence
from concurrent.futures import Executor

from mmt_drake.diagnosis.fit.comparison import fit_widening
from mmt_drake.diagnosis.fit.event_times import at_best_times
from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.errors import attempt

STEPS = 6


class Polish:
    """Takes fits on where a search left them, and remembers what became of them.

    Args:
        executor: runs the fits.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._done: list[tuple[Problem, Fitted, Fitted | None]] = []

    def __call__(self, problem: Problem, fits: Sequence[Fitted]) -> list[Fitted | None]:
        """The fits taken on; None where accurate integration diverges."""

        def known(fitted: Fitted) -> list[Fitted | None]:
            return [after for where, before, after in self._done if where is problem and before is fitted]

        new = [f for f in fits if not known(f)]
        found = self._executor.map(_taken_on, [problem] * len(new), new)
        self._done.extend((problem, before, after) for before, after in zip(new, found, strict=True))
        return [known(f)[0] for f in fits]


def _taken_on(problem: Problem, fitted: Fitted) -> Fitted | None:
    """A fit taken on where the search left it; None where accurate integration diverges there."""
    start = at_best_times(problem, fitted.hypothesis, fitted.x)
    return attempt(fit_widening, problem, fitted.hypothesis, start, steps=STEPS)
