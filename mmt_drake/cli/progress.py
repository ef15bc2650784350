"""A progress bar on a terminal, nothing in a pipe."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from mmt_drake.errors import printable

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn

    from mmt_drake.diagnosis.search.watch import Stage


@contextmanager
def progress(
    description: str, total: float, *, simulated: bool = False, note: Callable[[], str] = lambda: ""
) -> Iterator[Callable[[float], None]]:
    """Shows on stderr how far a piece of long work has come, if stderr is a terminal.

    Args:
        description: what is being done.
        total: amount of work, in any unit.
        simulated: the amount is simulated time [s]; the bar then also says how fast it passes against real time.
        note: what else is to be shown each time.

    Yields:
        `update(completed)`, to be called now and then with the amount done so far.
    """
    if not sys.stderr.isatty():
        yield lambda completed: None
        return
    # Imported where needed, so that a short command does not wait for it.
    from rich.markup import escape
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn

    start = time.perf_counter()
    amounts = TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[amount]}")
    with _bar(*amounts, TimeRemainingColumn()) as bar:
        task = bar.add_task(escape(printable(description)), total=total, amount="")

        def update(completed: float) -> None:
            amount = f"{completed:g} of {total:g}"
            if simulated:
                speed = completed / max(time.perf_counter() - start, 1e-9)
                amount = f"{completed:.1f} of {total:.1f} s, {speed:.1f} x real time"
            amount += note()
            bar.update(task, completed=completed, amount=amount)

        yield update


class Stages:
    """The stages of long work, as `working` shows them.

    Args:
        bar: where they are shown; None: nowhere.
    """

    def __init__(self, bar: Progress | None) -> None:
        self._bar, self._begun = bar, time.perf_counter()
        self._name, self._task = "", None if bar is None else bar.add_task("", total=None, then="")

    def __call__(self, stage: Stage) -> None:
        """Show what is being done now, how far it is, and what may come after it."""
        if self._bar is None or self._task is None:
            return
        then = f"{len(stage.then)} more stages at most" if len(stage.then) > 1 else "".join(stage.then)
        then = f"(then {then})" if then else ""
        if stage.name != self._name:  # a bar forgets no total
            self._bar.remove_task(self._task)
            self._name, self._task = stage.name, self._bar.add_task("", total=None, then="")
        self._bar.update(self._task, description=str(stage), completed=stage.done, total=stage.total or None, then=then)

    def tell(self, what: str) -> None:
        """Write a line that stays, with the time since the work began."""
        if self._bar is not None:
            seconds = time.perf_counter() - self._begun
            self._bar.console.print(f"after {seconds:.0f} s: {what}", markup=False, highlight=False)


@contextmanager
def working(description: str, seconds: float = math.inf) -> Iterator[Stages]:
    """Shows on stderr what is being done, of work whose stages are known and not their length, if stderr is a terminal.

    Args:
        description: what all of it is.
        seconds: that it has; infinite: as long as it takes.

    Yields:
        `show(stage)`, to be called with what is being done now; `show.tell(what)` writes a line that stays.
    """
    if not sys.stderr.isatty():
        yield Stages(None)
        return
    from rich.progress import BarColumn, ProgressColumn, TextColumn
    from rich.text import Text

    begun, limit = time.perf_counter(), "" if math.isinf(seconds) else f" of {seconds:g}"

    class Elapsed(ProgressColumn):
        """Of all stages."""

        def render(self, task: object) -> Text:
            return Text(f"{time.perf_counter() - begun:.0f}{limit} s")

    stage = BarColumn(20), TextColumn("{task.description}", markup=False), TextColumn("{task.fields[then]}")
    with _bar(TextColumn(description), Elapsed(), *stage) as bar:
        yield Stages(bar)


def _bar(*columns: ProgressColumn) -> Progress:
    """A bar on standard error that goes with the work."""
    from rich.console import Console
    from rich.progress import Progress

    to_screen = sys.stdout.isatty()  # else what belongs into a file would be shown beside the bar
    return Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=to_screen)
