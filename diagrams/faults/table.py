"""All rows, place by place."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path

from mmt_drake.diagrams.faults.row import Row

PLACES: dict[str, str] = {
    "supervisor": "supervisor.run",
    "omega": "omega.run",
    "franka": "franka.run",
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
