"""`mmt-drake bench`: the performance figures, measured here and now."""

from __future__ import annotations

import argparse
import json
import sys
from typing import TYPE_CHECKING, Any

from mmt_drake.errors import MissingDependency

if TYPE_CHECKING:
    from diagrams.bench import Figure

EPILOG = """\
examples:
  mmt-drake bench
  mmt-drake bench --json > bench.json

Takes about two minutes. Other work on the machine shows: a figure with a peer was measured beside it in the same
minute, and their ratio holds where single figures do not."""

COMMAND = "mmt-drake bench"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--json", action="store_true", help="print one JSON document and nothing else")


def main(arguments: argparse.Namespace) -> int:
    """Measure and print; a missed target is told, and is no error."""
    try:
        from diagrams.bench import figures
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "diagrams":
            raise
        raise MissingDependency("bench needs the folder diagrams/ of a checkout; see the README") from None
    measured = []
    for figure in figures():
        measured.append(figure)
        if not arguments.json:
            print(_line(figure), flush=True)
        elif sys.stderr.isatty():
            print(f"{len(measured)} figures measured", end="\r", file=sys.stderr)
    if arguments.json:
        print(json.dumps({"figures": [_data(figure) for figure in measured]}, indent=2, allow_nan=False))
    else:
        missed = [figure.name for figure in measured if figure.met is False]
        print(f"targets missed: {', '.join(missed)}" if missed else "all targets reached")
    return 0


def _data(figure: Figure) -> dict[str, Any]:
    """A figure as the contract has it; `met` beside it."""
    return {
        "name": figure.name,
        "value": float(figure.value),
        "unit": figure.unit,
        "target": figure.target,
        "command": COMMAND,
        "met": figure.met,
    }


def _line(figure: Figure) -> str:
    text = f"{figure.name}: {figure.value:.3g} {figure.unit}".rstrip()
    if figure.target is None:
        return text
    bound = "at least" if figure.at_least else "at most"
    return f"{text} (target: {bound} {figure.target:.3g}; {'reached' if figure.met else 'MISSED'})"
