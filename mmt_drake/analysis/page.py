"""One HTML page that holds everything it shows: text, tables and figures, nothing fetched from elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import png, write_whole
from mmt_drake.errors import BadInput

Cell = str | int | float | None


@dataclass(frozen=True)
class Picture:
    """A figure and the sentence below it."""

    figure: Figure
    caption: str

    def base64(self) -> str:
        """The figure as a PNG file in base64."""
        return base64.b64encode(png(self.figure)).decode("ascii")


@dataclass(frozen=True)
class Table:
    """Headers and rows; numbers are printed to four digits and set to the right, None is a dash.

    Raises:
        BadInput: a row of another length than the headers.
    """

    headers: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""

    def __post_init__(self) -> None:
        for number, row in enumerate(self.rows):
            if len(row) != len(self.headers):
                raise BadInput("table", at=f"row {number}", found=f"{len(row)} cells", expected=f"{len(self.headers)}")

    def is_numeric(self, column: int) -> bool:
        """Whether a column holds numbers (and dashes) alone."""
        cells = [row[column] for row in self.rows if row[column] is not None]
        return bool(cells) and all(isinstance(cell, int | float) for cell in cells)


@dataclass(frozen=True)
class Section:
    """A part of a page, in this order: title, text (an empty line ends a paragraph), table, figures."""

    title: str
    text: str = ""
    figures: Sequence[Picture] = ()
    table: Table | None = None

    @property
    def paragraphs(self) -> list[str]:
        """The text's paragraphs."""
        return _paragraphs(self.text)


def write_page(path: str | Path, title: str, sections: Sequence[Section], lead: str = "") -> Path:
    """Write the page in one move; the folder is made if need be. All text is escaped.

    Args:
        path: the `.html` file.
        title: the page's title.
        sections: its parts; with more than two the page opens with links to them.
        lead: text between title and sections.

    Raises:
        BadInput: the file cannot be written.
    """
    path = Path(path)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mmt_drake.analysis"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    environment.filters["cell"] = _cell
    page = environment.get_template("page.html.j2").render(title=title, lead=_paragraphs(lead), sections=sections)
    write_whole(path, page.encode())
    return path


def _paragraphs(text: str) -> list[str]:
    return [" ".join(paragraph.split()) for paragraph in text.split("\n\n") if paragraph.strip()]


def _cell(value: Cell) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
