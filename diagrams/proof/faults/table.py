"""The fault table: one line a kind of fault."""

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Final

from mmt_drake.diagrams.proof.studies.columns import Column, documents, tabled
from mmt_drake.diagrams.proof.studies.measurement import Measurement, figures_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Report, Study

_NONE = math.nan


@dataclass(frozen=True)
class Row:
    """What came of one kind of fault; NaN where a column does not apply.

    Attributes:
        kind: of the fault.
        where: into what it was injected.
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


def _number(name: str, key: str) -> Column[Row]:
    """An attribute in the document alone, None for NaN."""
    return Column(lambda row: None if math.isnan(getattr(row, name)) else getattr(row, name), key)


def _zero(row: Row) -> str:
    if row.ended:
        return "–"
    return "goes on" if math.isnan(row.allowed) else f"{1e3 * row.zero_after:.0f}/{1e3 * row.allowed:.0f}"


def _force(row: Row) -> str:
    return "–" if math.isnan(row.greatest_force) else f"{row.greatest_force:.2f}/{row.force_limit:g}"


COLUMNS: Final[tuple[Column[Row], ...]] = (
    Column(lambda row: row.kind, "kind", "fault"),
    Column(lambda row: row.where, "where", "where"),
    Column(lambda row: row.moments, "moments", "moments"),
    _number("greatest_force", "greatest_force_n"),
    _number("force_limit", "force_limit_n"),
    Column(_force, "", "most [N]"),
    _number("zero_after", "zero_after_s"),
    _number("allowed", "allowed_s"),
    Column(_zero, "", "zero after [ms]"),
    _number("unreadable", "unreadable_s"),
    Column(lambda row: "–" if math.isnan(row.unreadable) else f"{abs(row.unreadable):.2f}", "", "lost at end [s]"),
    Column(lambda row: row.ended, "ended"),
    Column(lambda row: list(row.wrong), "wrong", "wrong", len),
)
"""Behind a stroke each figure's bound."""
_LINE: Final = "{:34}{:>11}{:>9}{:>14}{:>17}{:>16}{:>7}"
_KINDS: Final = 20  # of fault, there are at least


WHERE: Final = ("supervisor", "omega", "franka", "network", "recording", "camera", "viewer", "worker", "process")
"""Into what faults are injected: modules here, each with a function `rows(moments, folder)` that does so."""


def fault_table(moments: int = 50, where: tuple[str, ...] = WHERE) -> Iterator[Row]:
    """Bring about every kind of fault, and give what came of it as it comes.

    Args:
        moments: at how many random moments each.
        where: which of `WHERE`.

    Raises:
        MissingDependency: an extra, or the C compiler, that an emulator needs is not installed.
    """
    with tempfile.TemporaryDirectory(prefix="faults-") as folder:
        for name in where:
            # Imported late: the first row should not wait for what the last one needs.
            module = import_module(f"mmt_drake.diagrams.proof.faults.{name}")
            yield from module.rows(moments, Path(folder))


def faults_study(moments: int = 50, where: tuple[str, ...] = WHERE) -> Study:
    """The study that brings about every kind of fault; each row is said as it comes. Arguments are `fault_table`'s."""

    def run(asked: Asked, progress: Progress) -> Report:
        rows = list[Row]()
        asked.say(_LINE.format(*tabled(rows, COLUMNS).headers))
        for row in fault_table(moments, where):
            rows.append(row)
            (cells,) = tabled([row], COLUMNS).rows
            asked.say("\n    ".join((_LINE.format(*cells), *row.wrong)))
            progress(where.index(row.where))
        wrong, tried = sum(len(row.wrong) for row in rows), sum(row.moments for row in rows)
        figures = [
            Measurement("kinds of fault", len(rows), "", _KINDS, at_least=True),
            Measurement("outcomes that were not as they must be", wrong, "", 0),
        ]
        command = "mmt-drake bench faults"
        return Report(
            {"figures": figures_of(figures, command), "faults": documents(rows, COLUMNS)},
            title="Faults of every kind",
            lead=f"Each at {moments} random moments: the greatest force that reached the hand, and after how long it "
            "was zero (or the arm at rest), each over its limit; how much of a recording's end was lost.",
            heading="",
            own_tables=[tabled(rows, COLUMNS)],
            sentences=[f"{len(rows)} kinds of fault, {tried} times: {wrong or 'nothing'} not as it must be"],
        )

    return Study("faults, places", (), lambda asked: len(where), run)
