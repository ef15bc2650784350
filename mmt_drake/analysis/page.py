"""One HTML page that holds everything it shows: text, tables and figures, nothing fetched from elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import jinja2
from matplotlib.figure import Figure

from mmt_drake.analysis.plotting import png, write_whole
from mmt_drake.analysis.table import Table


@dataclass(frozen=True)
class Picture:
    """A figure and the sentence below it."""

    figure: Figure
    caption: str

    def base64(self) -> str:
        """The figure as a PNG file in base64."""
        return base64.b64encode(png(self.figure)).decode("ascii")


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
    page = environment.get_template("page.html.j2").render(title=title, lead=_paragraphs(lead), sections=sections)
    write_whole(path, page.encode())
    return path


def _paragraphs(text: str) -> list[str]:
    return [" ".join(paragraph.split()) for paragraph in text.split("\n\n") if paragraph.strip()]
