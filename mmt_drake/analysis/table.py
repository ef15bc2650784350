"""Tables of numbers, apart from where they are shown: on a page or on a terminal."""

from collections.abc import Sequence
from dataclasses import dataclass

from mmt_drake.analysis.wording import significant
from mmt_drake.errors import BadInput

Cell = str | int | float | None


@dataclass(frozen=True)
class Table:
    """Headers and rows; numbers are printed to so many digits and set to the right, None is a dash.

    Raises:
        BadInput: a row of another length than the headers.
    """

    headers: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    digits: int = 4

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.headers):
                raise BadInput("table", at=f"row {number}", found=f"{len(row)} cells", expected=f"{len(self.headers)}")

    def is_numeric(self, column: int) -> bool:
        """True if a column holds numbers and dashes alone."""
        return not any(isinstance(row[column], str) for row in self.rows)

    def texts(self) -> list[list[str]]:
        """The rows as they are printed."""
        return [[_text(cell, self.digits) for cell in row] for row in self.rows]

    @property
    def wordy(self) -> bool:
        """True if a cell holds a sentence: on a narrow screen the cells of a row then stand below one another."""
        return any(isinstance(cell, str) and len(cell) > 40 for row in self.rows for cell in row)

    def markdown(self) -> str:
        """The table, and its caption below, as Markdown."""
        lines = [self.headers, ["---"] * len(self.headers), *self.texts()]
        table = "\n".join(f"| {' | '.join(cell.replace('|', '&#124;') for cell in line)} |" for line in lines)
        return f"{table}\n\n{self.caption}".rstrip()


def _text(cell: Cell, digits: int) -> str:
    if cell is None:
        return "–"
    return significant(cell, digits) if isinstance(cell, float) else str(cell)
