"""One HTML page that holds everything it shows: text, tables, bars and figures, nothing fetched from elsewhere."""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import jinja2
from matplotlib.figure import Figure

from mmt_drake.analysis.interactive import Plot, packed
from mmt_drake.analysis.plotting import DPI, png, write_whole
from mmt_drake.analysis.table import Table


@dataclass(frozen=True)
class Picture:
    """A figure, the sentence below it, and how finely it is drawn [dots per inch].

    One with a name is left beside the page too, as a PNG file of that name.
    """

    figure: Figure
    caption: str
    dpi: int = DPI
    name: str = ""

    @cached_property
    def png(self) -> bytes:
        """The figure as a PNG file's bytes, drawn when they are asked for first."""
        return png(self.figure, self.dpi)

    def base64(self) -> str:
        """The figure as a PNG file in base64."""
        return base64.b64encode(self.png).decode("ascii")


Tone = Literal["good", "fair", "bad", "open", "neutral"]
"""How a banner is to be taken."""


@dataclass(frozen=True)
class Banner:
    """A coloured strip below the title: a word or two, and how they are to be taken."""

    text: str
    tone: Tone


@dataclass(frozen=True)
class Bar:
    """A number as a bar: its name, its length (0 to 1 of the width there is), how it is told, colour, and a remark."""

    name: str
    length: float
    told: str
    color: str
    note: str = ""


@dataclass(frozen=True)
class Section:
    """A part of a page.

    In this order: title, text (an empty line ends a paragraph), formula, bars, a list of items, facts (what, and what
    about it), table, figures, and a remark in small letters.

    A formula is an equation or a command, set apart as it is written. A part of another one (`inner`) has a smaller
    title and no link at the top of the page.
    """

    title: str
    text: str = ""
    figures: Sequence[Picture | Plot] = ()
    table: Table | None = None
    formula: str = ""
    inner: bool = False
    bars: Sequence[Bar] = ()
    items: Sequence[str] = ()
    facts: Sequence[tuple[str, str]] = ()
    remark: str = ""

    @property
    def pictures(self) -> list[Picture]:
        """The figures that are pictures."""
        return [figure for figure in self.figures if isinstance(figure, Picture)]

    @property
    def plots(self) -> list[Plot]:
        """The figures that a browser draws."""
        return [figure for figure in self.figures if isinstance(figure, Plot)]

    @property
    def paragraphs(self) -> list[str]:
        """The text's paragraphs."""
        return _paragraphs(self.text)


def write_page(
    path: str | Path,
    title: str,
    sections: Sequence[Section],
    lead: str = "",
    banner: Banner | None = None,
    first: Sequence[Section] = (),
) -> Path:
    """Write the page in one move, and its pictures that have names; the folder is made if need be. All text is escaped.

    Args:
        path: the `.html` file.
        title: the page's title.
        sections: its parts; with more than two the page opens with links to them.
        lead: text between title and sections.
        banner: above the title.
        first: what must be seen first, without figures: cards between lead and links, the first of them the widest.

    Raises:
        BadInput: the file cannot be written.
    """
    path = Path(path)
    for picture in (picture for section in sections for picture in section.pictures if picture.name):
        write_whole(path.parent / f"{picture.name}.png", picture.png)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("mmt_drake.analysis"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    template = environment.get_template("page.html.j2")
    plots = [plot for section in sections for plot in section.plots]
    page = template.render(
        title=title,
        lead=_paragraphs(lead),
        sections=sections,
        banner=banner,
        first=first,
        packed=packed(plots) if plots else "",
    )
    write_whole(path, page.encode())
    return path


def _paragraphs(text: str) -> list[str]:
    return [" ".join(paragraph.split()) for paragraph in text.split("\n\n") if paragraph.strip()]
