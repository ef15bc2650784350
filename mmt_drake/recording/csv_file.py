"""Recordings as CSV: one header line of column names, one line per sample."""

import io
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import BinaryIO, Literal, TextIO

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.bounds import MOST_COLUMNS, check_size
from mmt_drake.recording.check import completed
from mmt_drake.recording.column_map import ColumnMap, Taken, left_out, units_of
from mmt_drake.recording.foreign_table import hint
from mmt_drake.recording.growing import GrowingColumns
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import FLAGS
from mmt_drake.recording.stored import Column, LongColumns, as_array

_ROWS_AT_ONCE = 10_000
_PIECE = 2**22  # bytes that are read at a time
_LONGEST = 2**20  # bytes of a line
_SEPARATORS = (",", ";", "\t")


@dataclass(frozen=True)
class CsvFormat:
    """How the rows of a file are to be read.

    Attributes:
        headers: of all its columns.
        separator: between cells: comma, semicolon, tab, or a blank where there is none of these.
        taken: the columns that are read.
        decimal: mark of its numbers; empty: no row has told it yet.
    """

    headers: tuple[str, ...]
    separator: str
    taken: tuple[Taken, ...] = ()
    decimal: Literal["", ".", ","] = ""

    @classmethod
    def of(cls, head: str, source: str) -> "CsvFormat":
        """What a header line tells.

        Raises:
            BadInput: too many columns, numbers in the place of names, a name twice.
        """
        separator = max(_SEPARATORS, key=head.count)
        if separator not in head and " " in head.strip():
            separator = " "
        headers = tuple(header.strip().strip('"').strip() for header in head.split(separator))
        if len(headers) > MOST_COLUMNS:
            raise BadInput(source, at="header", found=f"{len(headers)} columns", expected=f"at most {MOST_COLUMNS}")
        if all(_is_number(header.replace(",", ".")) for header in headers):
            raise BadInput(source, at="header", found="a row of numbers", expected="column names")
        twice = [header for header in headers if header and headers.count(header) > 1]
        if twice:
            raise BadInput(source, at="header", found=f"column {twice[0]!r} twice", expected="each column once")
        return cls(headers, separator)

    @property
    def used(self) -> list[int]:
        """Numbers of the columns that are read, from 0."""
        return [self.headers.index(taken.column) for taken in self.taken]

    def plain(self, text: str, line: int, source: str) -> tuple["CsvFormat", str]:
        """Some lines with decimal points, and the format with the mark that they have.

        Only where cells are not separated by commas may numbers have them; both marks in one file would leave open
        which of them is for thousands.

        Raises:
            BadInput: both marks.
        """
        if self.separator == "," or not (marks := set(re.findall(r"(?<=\d)[.,](?=\d)", text)) | {*self.decimal}):
            return self, text
        if len(marks) > 1:
            found, expected = f"numbers with a comma and with a point in lines from {line} on", "one decimal mark"
            raise BadInput(source, found=found, expected=expected)
        (mark,) = marks
        return replace(self, decimal=mark), text.replace(",", ".") if mark == "," else text


def load_csv(path: Path, forces: bool, columns: ColumnMap) -> Recording:
    """Read a recording from text, see `read_table`.

    Raises:
        BadInput: what ``columns`` asks for and is not there, what `read_table` refuses, or what ``check.completed``
            finds.
    """
    source = str(path)

    def taken(headers: tuple[str, ...]) -> list[Taken]:
        found = list(columns.taken(headers, source))
        if "time" not in {each.name for each in found}:
            named = f"columns {', '.join(headers)}"
            expected = f"column names, 'time' among them{hint(headers, path.name)}"
            raise BadInput(source, at="header", found=named, expected=expected)
        return found

    form, read, notes = read_table(path, taken)
    notes += left_out(form.headers, form.taken)
    time = as_array(read.pop("time"))
    return completed(time, LongColumns(read), source, forces=forces, notes=notes, units=units_of(form.taken))


def read_table(
    path: Path, taken: Callable[[tuple[str, ...]], Sequence[Taken]]
) -> tuple[CsvFormat, dict[str, Column], list[str]]:
    """Read columns of text in UTF-8, its cells separated by commas, semicolons, tabs or blanks.

    Row numbers in messages count samples from 1; lines count the header too. The text is read piece by piece: at its
    peak reading takes the columns and little more.

    A last row without its line end may be cut in the middle of its last number and still read well. It is taken for
    whole, and a note says so, if that number is written as far as those above it (in the last pieces): with at least
    as many decimals (without any: digits) as half of them have, and an exponent if half of them have one. An exponent
    of one digit may be cut too.

    Args:
        path: of the file.
        taken: from its headers to the columns that are wanted.

    Returns:
        How the file is written, the columns by the names that ``taken`` gives them, and notes.

    Raises:
        BadInput: a name twice, a ragged row, a cell that is no number, a last row that may be cut, no row, more than
            ``bounds`` allows.
    """
    source = str(path)
    with path.open("rb") as file:
        pieces = _pieces(file, source)
        head, _, first = next(pieces, "").partition("\n")
        form = CsvFormat.of(head, source)
        form = replace(form, taken=tuple(taken(form.headers)))
        growing, rows, lines, above, end = GrowingColumns(len(form.taken)), 0, 2, "", ""
        for piece in chain([first], pieces):
            form, plain = form.plain(piece, lines, source)
            table = _table(plain, form, rows + 1, lines, source)
            rows, lines = rows + len(table), lines + piece.count("\n")
            check_size(source, 8 * rows * len(form.taken))
            growing.add(table * [each.factor for each in form.taken])
            above, end = end, plain
    if rows == 0:
        raise BadInput(source, found="a header and no rows", expected="one row per sample")
    notes = _check_end(above + end, rows, lines, form, source)
    return form, dict(zip((each.name for each in form.taken), growing.take(), strict=True)), notes


def headers_of(path: Path) -> tuple[str, ...]:
    """The headers of a file.

    Raises:
        BadInput: it has none, see ``CsvFormat.of``.
    """
    with path.open("rb") as file:
        return CsvFormat.of(next(_pieces(file, str(path)), "").partition("\n")[0], str(path)).headers


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


def _table(text: str, form: CsvFormat, row: int, line: int, source: str) -> Array:
    """The numbers of some lines, the first of which is this row and line: (n, k)."""
    used = form.used
    if not text.strip("\n"):
        return np.empty((0, len(used)))
    all_used = used == list(range(len(form.headers)))
    others = len(form.headers) - 1
    if not all_used and any(cells and cells.count(form.separator) != others for cells in text.split("\n")):
        raise _first_fault(text, form, row, line, source)  # `loadtxt` looks at the used cells alone
    try:
        table = np.loadtxt(
            io.StringIO(text),
            delimiter=form.separator,
            ndmin=2,
            comments=None,
            dtype=np.float64,
            usecols=None if all_used else used,
        )
    except ValueError:
        table = None
    if table is None or table.shape[1] != len(used):
        raise _first_fault(text, form, row, line, source)
    return table


def _first_fault(text: str, form: CsvFormat, row: int, line: int, source: str) -> BadInput:
    """The error of the first row that does not read."""
    used = set(form.used)
    for number, written in enumerate(text.split("\n"), line):
        if not written:
            continue
        at, cells = f"row {row} (line {number})", written.split(form.separator)
        row += 1
        for column, (name, cell) in enumerate(zip(form.headers, cells, strict=False)):
            if column in used and not _is_number(cell):
                return BadInput(source, at=f"{at}, column {name!r}", found=repr(cell), expected="a number")
        if len(cells) != len(form.headers):
            return BadInput(source, at=at, found=f"{len(cells)} cells", expected=f"{len(form.headers)}, one per column")
    return BadInput(source, found="text that does not read as a table", expected="numbers between separators")


def _check_end(end: str, rows: int, lines: int, form: CsvFormat, source: str) -> list[str]:
    """Notes of the last row's missing line end; refuses a row whose last number may be cut."""
    if not end.rpartition("\n")[2].strip():
        return []
    separator, name = form.separator, form.headers[-1]
    cells = [line.rpartition(separator)[2].strip() for line in end.split("\n") if line and not line.isspace()]
    last = _written(cells.pop())
    usual = [int(np.median(counts)) for counts in zip(*map(_written, cells or [end[-1:]]), strict=True)]
    digits, decimals, exponent = (own - others for own, others in zip(last, usual, strict=True))
    whole = decimals >= 0 if usual[1] >= 0 else digits >= 0
    if not whole or exponent < 0 or last[2] == 1:
        at = f"row {rows} (line {lines}), column {name!r}"
        found = f"{end.rpartition(separator)[2].strip()!r} without a line end, shorter than above: a file cut off"
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
    cells = [(values.astype(int) if name in FLAGS else values).tolist() for name, values in columns.items()]
    file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*cells, strict=True))
