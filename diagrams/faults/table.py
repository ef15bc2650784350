"""The fault table: one line a kind of fault, place by place."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

_NONE = math.nan


@dataclass(frozen=True)
class Row:
    """What came of one kind of fault; NaN where a column does not apply.

    Attributes:
        kind: of the fault.
        where: what was on trial.
        moments: at how many random moments it was brought about.
        greatest_force: that reached the hand from the moments on [N],
        force_limit: and the supervisor's limit for it [N].
        zero_after: the longest that it took until the force was zero, or the arm at rest [s],
        allowed: and how long it may take, being seen included [s]; NaN where the run goes on.
        unreadable: the longest end of a recording that was lost [s].
        ended: the run itself is what ended.
        wrong: what was not as it must be, a line each.
    """

    kind: str
    where: str
    moments: int
    greatest_force: float = _NONE
    force_limit: float = _NONE
    zero_after: float = _NONE
    allowed: float = _NONE
    unreadable: float = _NONE
    ended: bool = False
    wrong: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The same as data, with null for what does not apply."""
        numbers = {
            "greatest_force_n": self.greatest_force,
            "force_limit_n": self.force_limit,
            "zero_after_s": self.zero_after,
            "allowed_s": self.allowed,
            "unreadable_s": self.unreadable,
        }
        return {
            "kind": self.kind,
            "where": self.where,
            "moments": self.moments,
            **{name: None if math.isnan(value) else value for name, value in numbers.items()},
            "ended": self.ended,
            "wrong": list(self.wrong),
        }


PLACES: dict[str, str] = {
    "supervisor": "supervisor",
    "omega": "omega",
    "franka": "franka",
    "network": "network",
    "recording": "recording",
    "camera": "camera",
    "viewer": "viewer",
    "worker": "worker",
    "process": "processes",
}
"""What is on trial -> the module here that tries it, in a function `try_PLACE(moments, folder)`."""


def fault_table(moments: int = 50, places: tuple[str, ...] = tuple(PLACES)) -> Iterator[Row]:
    """Bring about every kind of fault, and give what came of it as it comes.

    Args:
        moments: at how many random moments each.
        places: which of `PLACES`.

    Raises:
        MissingDependency: an extra, or the C compiler, that an emulator needs is not installed.
    """
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        for place in places:
            # Imported late: the first row should not wait for what the last one needs.
            module = import_module(f"mmt_drake.diagrams.faults.{PLACES[place]}")
            rows: Callable[[int, Path], Iterator[Row]] = getattr(module, f"try_{place}")
            yield from rows(moments, Path(folder))
