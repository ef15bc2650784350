"""`mmt-drake bench faults`: every kind of fault at random moments, a line each."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING, Any

from mmt_drake.cli.output import print_json
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.diagrams.faults import Row

GROUP = "faults"
_MOMENTS, _KINDS = 50, 20  # random moments of each kind; kinds of fault there are at least
_COLUMNS = "{:34}{:>11}{:>9}{:>14}{:>17}{:>16}{:>7}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this group."""
    told = f"faults: at how many random moments of each kind (default: {_MOMENTS})"
    parser.add_argument("--moments", type=int, metavar="N", help=told)
    told = "faults: of one place alone, as the table names it; may be given again"
    parser.add_argument("--where", action="append", metavar="PLACE", help=told)


def check(arguments: argparse.Namespace) -> None:
    """Refuse the options of this group with another one.

    Raises:
        BadInput: there is one.
    """
    for name in ("moments", "where"):
        if arguments.group != GROUP and getattr(arguments, name) is not None:
            raise BadInput(f"--{name}", found=f"bench {arguments.group}", expected=f"bench {GROUP}")


def main(arguments: argparse.Namespace) -> int:
    """Print the table; the exit status is 1 if anything was not as it must be."""
    from mmt_drake.diagrams.faults import PLACES, fault_table

    moments = _MOMENTS if arguments.moments is None else arguments.moments
    if moments < 1:
        raise BadInput("--moments", found=moments, expected="1 or more")
    for place in arguments.where or ():
        if place not in PLACES:
            raise BadInput("--where", found=place, expected=" or ".join(PLACES))
    rows = []
    if not arguments.json:
        print(_COLUMNS.format("fault", "where", "moments", "most [N]", "zero after [ms]", "lost at end [s]", "wrong"))
    for row in fault_table(moments, tuple(arguments.where or PLACES)):
        rows.append(row)
        if not arguments.json:
            print("\n    ".join((_line(row), *row.wrong)), flush=True)
        elif sys.stderr.isatty():
            print(f"{len(rows)} kinds tried", end="\r", file=sys.stderr)
    wrong = sum(len(row.wrong) for row in rows)
    if arguments.json:
        print_json({"figures": _figures(rows, wrong), "faults": [row.to_json() for row in rows]})
    else:
        tried = sum(row.moments for row in rows)
        print(f"{len(rows)} kinds of fault, {tried} times: {wrong or 'nothing'} not as it must be")
    return 1 if wrong else 0


def _line(row: Row) -> str:
    """A row: each figure and, after a slash, what it may be."""
    force = "–" if math.isnan(row.greatest_force) else f"{row.greatest_force:.2f}/{row.force_limit:g}"
    zero = "goes on" if math.isnan(row.allowed) else f"{1e3 * row.zero_after:.0f}/{1e3 * row.allowed:.0f}"
    zero = "–" if row.ended else zero
    lost = "–" if math.isnan(row.unreadable) else f"{abs(row.unreadable):.2f}"
    return _COLUMNS.format(row.kind, row.where, row.moments, force, zero, lost, len(row.wrong))


def _figures(rows: list[Row], wrong: int) -> list[dict[str, Any]]:
    """Two figures as `bench` has them."""
    from mmt_drake.diagrams.bench import Measurement

    kinds = Measurement("kinds of fault", len(rows), "", _KINDS, at_least=True)
    outcomes = Measurement("outcomes that were not as they must be", wrong, "", 0)
    return [figure.to_json(f"mmt-drake bench {GROUP}") for figure in (kinds, outcomes)]
