"""What commands print: a JSON document, or text and tables."""

from __future__ import annotations

import argparse
import json
import sys

from rich import table as rich_table
from rich.console import Console
from rich.markup import escape

from mmt_drake.analysis.table import Table

WIDTH = 120
"""Columns of what goes into a pipe, where no terminal says how many there are."""


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add `--json`, which asks for what `print_json` prints."""
    parser.add_argument("--json", action="store_true", help="print one JSON document and nothing else")


def print_json(document: object) -> None:
    """Print plain numbers, strings, None, lists and dicts.

    Raises:
        ValueError: a number that JSON does not have, NaN or infinity.
    """
    print(json.dumps(document, indent=2, allow_nan=False))


def console() -> Console:
    """Standard output, as wide as the terminal or `WIDTH`; numbers get no colours."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else WIDTH)


def on_terminal(table: Table) -> rich_table.Table:
    """A table as it is printed: the caption above it, the first column in one line, numbers to the right."""
    made = rich_table.Table(title=escape(table.caption), title_justify="left", box=None, pad_edge=False)
    for column, header in enumerate(table.headers):
        numeric = table.is_numeric(column)
        made.add_column(escape(header), justify="right" if numeric else "left", no_wrap=column == 0, vertical="bottom")
    for row in table.texts():
        made.add_row(*map(escape, row))
    return made
