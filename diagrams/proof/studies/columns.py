"""Columns of a study's cases, each declared once: its key in the document and its column of the table."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from mmt_drake.analysis.table import Cell, Table

T = TypeVar("T")


@dataclass(frozen=True)
class Column(Generic[T]):
    """One column.

    Attributes:
        value: of a case, in SI units: a plain value.
        key: in the document; empty where it is shown alone.
        title: above the table's column; empty where it is in the document alone.
        shown: the value as the table has it.
    """

    value: Callable[[T], Any]
    key: str = ""
    title: str = ""
    shown: Callable[[Any], Cell] = lambda value: value


def documents(cases: Iterable[T], columns: Sequence[Column[T]]) -> list[dict[str, Any]]:
    """The entries of `cases`."""
    return [{column.key: column.value(case) for column in columns if column.key} for case in cases]


def tabled(cases: Iterable[T], columns: Sequence[Column[T]], caption: str = "") -> Table:
    """One row a case."""
    titled = [column for column in columns if column.title]
    rows = [[column.shown(column.value(case)) for column in titled] for case in cases]
    return Table([column.title for column in titled], rows, caption)
