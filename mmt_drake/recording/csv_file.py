"""Recordings as CSV: one header line of column names, one line per sample."""

import io
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import BinaryIO, TextIO

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.recording.bounds import MOST_COLUMNS, check_size
from mmt_drake.recording.check import completed
from mmt_drake.recording.growing import GrowingColumns
from mmt_drake.recording.recording import Array, Recording
from mmt_drake.recording.signals import SIGNALS
from mmt_drake.recording.stored import LongColumns, as_array

_FLAGS = {signal.name for signal in SIGNALS if signal.quantity == "flag"}
_ROWS_AT_ONCE = 10_000
_PIECE = 2**22  # bytes that are read at a time
_LONGEST = 2**20  # bytes of a line


def load_csv(path: Path, forces: bool) -> Recording:
    """Read a recording from comma-separated text in UTF-8.

    Row numbers in messages count samples from 1; lines count the header too. The text is read piece by piece: at its
    peak reading takes the columns and little more.

    A last row without its line end may be cut in the middle of its last number and still read well. It is taken for
    whole, and a note says so, if that number is written as far as those above it (in the last pieces): with at least
    as many decimals (without any: digits) as half of them have, and an exponent if half of them have one. An exponent
    of one digit may be cut too.

    Raises:
        BadInput: another separator, a name twice, a ragged row, a cell that is no number, a last row that may be
            cut, more than ``bounds`` allows, or what ``check.completed`` finds.
    """
    source = str(path)
    with path.open("rb") as file:
        pieces = _pieces(file, source)
        head, _, first = next(pieces, "").partition("\n")
        names = _names(head, source)
        columns, rows, lines, above, end = GrowingColumns(len(names)), 0, 2, "", ""
        for piece in chain([first], pieces):
            table = _table(piece, names, rows + 1, lines, source)
            rows, lines = rows + len(table), lines + piece.count("\n")
            check_size(source, 8 * rows * len(names))
            columns.add(table)
            above, end = end, piece
    if rows == 0:
        raise BadInput(source, found="a header and no rows", expected="one row per sample")
    notes = _check_end(above + end, rows, lines, names[-1], source)
    named = dict(zip(names, columns.take(), strict=True))
    return completed(as_array(named.pop("time")), LongColumns(named), source, forces=forces, notes=notes)


def _pieces(file: BinaryIO, source: str) -> Iterator[str]:
    """The text, some whole lines at a time; only the last line may have no end."""
    rest, position = b"", 0
    while block := file.read(_PIECE):
        whole, end, rest = (rest + block).rpartition(b"\n")
        if len(rest) > _LONGEST:
            found = f"more than {_LONGEST} bytes without a line end at {position + len(whole + end)}"
            raise BadInput(source, found=found, expected="one row per line")
        if end:
            yield _text(whole + end, position, source)
            position += len(whole + end)
    if rest:
        yield _text(rest, position, source)


def _text(piece: bytes, position: int, source: str) -> str:
    try:
        return piece.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        found = f"bytes that are no text at {position + error.start}"
        raise BadInput(source, found=found, expected="CSV in UTF-8") from error


def _names(head: str, source: str) -> list[str]:
    names = [name.strip().strip('"').strip() for name in head.split(",")]
    for separator in (";", "\t"):
        if len(names) == 1 and separator in head:
            raise BadInput(source, at="header", found=f"columns separated by {separator!r}", expected="commas")
    if len(names) > MOST_COLUMNS:
        raise BadInput(source, at="header", found=f"{len(names)} columns", expected=f"at most {MOST_COLUMNS}")
    if all(_is_number(name) for name in names):
        raise BadInput(source, at="header", found="a row of numbers", expected="column names")
    if "time" not in names:
        found = f"columns {', '.join(names)}"
        raise BadInput(source, at="header", found=found, expected="column names, 'time' among them")
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise BadInput(source, at="header", found=f"column {twice[0]!r} twice", expected="each column once")
    return names


def _table(text: str, names: list[str], row: int, line: int, source: str) -> Array:
    """The numbers of some lines, the first of which is this row and line: (n, k)."""
    if not text.strip("\n"):
        return np.empty((0, len(names)))
    try:
        table = np.loadtxt(io.StringIO(text), delimiter=",", ndmin=2, comments=None, dtype=np.float64)
    except ValueError:
        table = None
    if table is None or table.shape[1] != len(names):
        raise _first_fault(text, names, row, line, source)
    return table


def _first_fault(text: str, names: list[str], row: int, line: int, source: str) -> BadInput:
    """The error of the first row that does not read."""
    for number, written in enumerate(text.split("\n"), line):
        if not written:
            continue
        at, cells = f"row {row} (line {number})", written.split(",")
        row += 1
        for name, cell in zip(names, cells, strict=False):
            if not _is_number(cell):
                return BadInput(source, at=f"{at}, column {name!r}", found=repr(cell), expected="a number")
        if len(cells) != len(names):
            return BadInput(source, at=at, found=f"{len(cells)} cells", expected=f"{len(names)}, one per column")
    return BadInput(source, found="text that does not read as a table", expected="comma-separated numbers")


def _check_end(end: str, rows: int, lines: int, name: str, source: str) -> list[str]:
    """Notes of the last row's missing line end; refuses a row whose last number may be cut."""
    if not end.rpartition("\n")[2].strip():
        return []
    cells = [line.rpartition(",")[2].strip() for line in end.split("\n") if line and not line.isspace()]
    last = _written(cells.pop())
    usual = [int(np.median(counts)) for counts in zip(*map(_written, cells or [end[-1:]]), strict=True)]
    digits, decimals, exponent = (own - others for own, others in zip(last, usual, strict=True))
    whole = decimals >= 0 if usual[1] >= 0 else digits >= 0
    if not whole or exponent < 0 or last[2] == 1:
        at = f"row {rows} (line {lines}), column {name!r}"
        found = f"{end.rpartition(',')[2].strip()!r} without a line end, shorter than above: a file cut off"
        raise BadInput(source, at=at, found=found, expected="a whole last row (if it is whole, end its line)")
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
