"""Recordings as CSV: one header line of column names, one line per sample."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TextIO

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording.check import completed
from mmt_drake.recording.recording import Array, Recording
from mmt_drake.recording.signals import SIGNALS

_FLAGS = {signal.name for signal in SIGNALS if signal.quantity == "flag"}
_ROWS_AT_ONCE = 10_000


def load_csv(path: Path, forces: bool) -> Recording:
    """Read a recording from comma-separated text in UTF-8.

    Row numbers in messages count samples from 1; lines count the header too.

    A last row without its line end may be cut in the middle of its last number and still read well. It is taken for
    whole, and a note says so, if that number is written as far as those above it: with at least as many decimals
    (without any: digits) as half of them have, and an exponent if half of them have one. An exponent of one digit may
    be cut too.

    Raises:
        BadInput: another separator, a name twice, a ragged row, a cell that is no number, a last row that may be
            cut, or what ``check.completed`` finds.
    """
    source = str(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise BadInput(source, found=f"bytes that are no text at {error.start}", expected="CSV in UTF-8") from error
    head, _, body = text.partition("\n")
    names = _names(head, source)
    if not body.strip():
        raise BadInput(source, found="a header and no rows", expected="one row per sample")
    try:
        table = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2, comments=None, dtype=np.float64)
    except ValueError:
        table = None
    if table is None or table.shape[1] != len(names):
        raise _first_fault(body, names, source)
    notes = _check_end(body, len(table), names[-1], source)
    columns = {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(names)}
    return completed(columns.pop("time"), columns, source, forces=forces, notes=notes)


def _names(head: str, source: str) -> list[str]:
    names = [name.strip() for name in next(csv.reader([head]), [])]
    for separator in (";", "\t"):
        if len(names) == 1 and separator in head:
            raise BadInput(source, at="header", found=f"columns separated by {separator!r}", expected="commas")
    if all(_is_number(name) for name in names):
        raise BadInput(source, at="header", found="a row of numbers", expected="column names")
    if "time" not in names:
        found = f"columns {', '.join(names)}"
        raise BadInput(source, at="header", found=found, expected="column names, 'time' among them")
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise BadInput(source, at="header", found=f"column {twice[0]!r} twice", expected="each column once")
    return names


def _first_fault(body: str, names: list[str], source: str) -> BadInput:
    """Which row it is that does not read, and why."""
    row = 0
    for line, cells in enumerate(csv.reader(io.StringIO(body)), 2):
        if not cells:
            continue
        row += 1
        at = f"row {row} (line {line})"
        for name, cell in zip(names, cells, strict=False):
            if not _is_number(cell):
                return BadInput(source, at=f"{at}, column {name!r}", found=repr(cell), expected="a number")
        if len(cells) != len(names):
            return BadInput(source, at=at, found=f"{len(cells)} cells", expected=f"{len(names)}, one per column")
    return BadInput(source, found="text that does not read as a table", expected="comma-separated numbers")


def _check_end(body: str, rows: int, name: str, source: str) -> list[str]:
    """What to note of the last row's missing line end; refuses a row whose last number may be cut."""
    if not body.rpartition("\n")[2].strip():
        return []
    cells = [line.rpartition(",")[2].strip() for line in io.StringIO(body) if not line.isspace()]
    last = _written(cells.pop())
    usual = [int(np.median(counts)) for counts in zip(*map(_written, cells), strict=True)]
    digits, decimals, exponent = (own - others for own, others in zip(last, usual, strict=True))
    whole = decimals >= 0 if usual[1] >= 0 else digits >= 0
    if not whole or exponent < 0 or last[2] == 1:
        line, cell = body.count("\n") + 2, body.rpartition(",")[2].strip()
        raise BadInput(
            source,
            at=f"row {rows} (line {line}), column {name!r}",
            found=f"{cell!r} without a line end, shorter than above: a file cut off",
            expected="a whole last row (if it is whole, end its line)",
        )
    return [f"row {rows}, the last, has no line end; it is as long as the others and was taken for whole"]


def _written(cell: str) -> tuple[int, int, int]:
    """Digits before the decimal point, after it (-1: there is no point), and of the exponent."""
    mantissa, _, exponent = cell.lower().partition("e")
    before, point, after = mantissa.partition(".")
    return len(before.lstrip("+-")), len(after) if point else -1, len(exponent.lstrip("+-"))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell  # Python reads 1_000, the format does not


def write_csv(recording: Recording, path: Path) -> None:
    """Write every column, each number in the shortest form that reads back the same; clouds are left out.

    Args:
        path: where to write; whoever calls renames it when it is whole.
    """
    columns = {"time": recording.time, **recording.columns}
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(",".join(columns) + "\n")
        for start in range(0, len(recording), _ROWS_AT_ONCE):
            _write_rows({name: values[start : start + _ROWS_AT_ONCE] for name, values in columns.items()}, file)


def _write_rows(columns: dict[str, Array], file: TextIO) -> None:
    cells = [(values.astype(int) if name in _FLAGS else values).tolist() for name, values in columns.items()]
    file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*cells, strict=True))
