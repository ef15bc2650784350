"""Output of commands: a JSON document, or text and tables."""

from __future__ import annotations

import argparse
import json
import sys
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from mmt_drake.errors import printable

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table as RichTable
    from rich.text import Text

    from mmt_drake.analysis.table import Table


class RunFigure(NamedTuple):
    """Something that came of a run: as data, and in a line for a terminal."""

    data: Mapping[str, Any]
    line: str


WIDTH = 200
"""Columns of what goes into a pipe: wide enough for a row to stay the one line that grep finds."""
_NARROWEST = 7  # columns of a table's column


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`, which asks for what `print_json` prints."""
    parser.add_argument("--json", action="store_true", help="print one JSON document and nothing else")


def say(text: str, *, stderr: bool = False) -> None:
    """Print lines for a person, whatever a file has put into them (see `errors.printable`)."""
    print(printable(text), file=sys.stderr if stderr else sys.stdout, flush=stderr)


def print_json(document: object) -> None:
    """Print plain numbers, strings, None, lists and dicts.

    Raises:
        ValueError: a number that JSON does not have, NaN or infinity.
    """
    print(json.dumps(document, indent=2, allow_nan=False))


def console(*, stderr: bool = False) -> Console:
    """Standard output, or error, as wide as the terminal or `WIDTH`; numbers get no colours."""
    from rich.console import Console  # so that help comes at once

    class Plain(Console):
        """Prints strings as `say` does, and leaves it to the program what a reader means that has seen enough."""

        def render_str(self, text: str, **options: Any) -> Text:
            return super().render_str(printable(text), **options)

        def on_broken_pipe(self) -> None:
            raise  # what it is called for

    stream = sys.stderr if stderr else sys.stdout
    return Plain(highlight=False, stderr=stderr, width=None if stream.isatty() else WIDTH)


def on_terminal(table: Table) -> RichTable:
    """A table as it is printed: caption above, headers broken to the width of the cells, numbers to the right."""
    from rich.markup import escape
    from rich.table import Table as RichTable

    made = RichTable(title=escape(table.caption), title_justify="left", box=None, pad_edge=False)
    rows = table.texts()
    for column, header in enumerate(table.headers):
        width = max(_NARROWEST, *map(len, [*header.split(), *(row[column] for row in rows)]))
        name, bracket, unit = header.partition(" [")
        made.add_column(
            escape("\n".join([*textwrap.wrap(name, width), *([f"[{unit}"] if bracket else [])])),
            justify="right" if table.is_numeric(column) else "left",
            vertical="bottom",
            overflow="fold",  # too narrow a terminal breaks a number, but does not cut it
        )
    for row in rows:
        made.add_row(*map(escape, row))
    return made
