"""Options that several commands share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.recording import Recording
    from mmt_drake.recording.column_map import ColumnMap

TIME_BUDGET_S = 300.0
"""Of one diagnosis of recordings."""


def add_repeated(
    parser: argparse._ActionsContainer, option: str, metavar: str, text: str, kind: Callable[[str], Any] = str
) -> None:
    """Add an option that may be given again; the parsed value is a list of what `kind` makes of each."""
    text = f"{text}; may be given again"
    parser.add_argument(option, type=kind, action="append", default=[], metavar=metavar, help=text)


class Reading(TypedDict):
    """How recordings are to be read: what `recording.load` takes."""

    topics: dict[str, str]
    columns: ColumnMap


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Add `--topic`, `--map` and `--axis`, of which `reading` makes what `recording.load` takes."""
    text = (
        "where a bag calls a topic otherwise: a signal (force) or its usual topic (/telerobot/wrench), "
        "and what it is called there"
    )
    add_repeated(parser, "--topic", "NAME=/OTHER", text, topic)
    text = (
        "what a column of a file of your own is, in which unit, with - before it for the other sign "
        "(force=-load:mN), or a .yaml file of such lines (`mmt-drake init` writes one)"
    )
    add_repeated(parser, "--map", "NAME=COLUMN:UNIT", text)
    parser.add_argument("--axis", choices=("x", "y", "z"), help="read one axis of three, as a recording of one axis")


def reading(arguments: argparse.Namespace) -> Reading:
    """How recordings are to be read, as the options of `add_reading` say.

    Raises:
        BadInput: a mapping that is none.
    """
    from mmt_drake.recording.column_map import ColumnMap  # so that help comes at once

    return {"topics": dict(arguments.topic), "columns": ColumnMap.of(arguments.map, arguments.axis)}


def recordings_of(arguments: argparse.Namespace) -> list[Recording]:
    """Every recording of the files that `recordings` names, read as the options of `add_reading` say.

    Raises:
        BadInput: as `reading`, and as `recording.load_all`.
    """
    from mmt_drake.recording import load_all

    how = reading(arguments)
    return [recording for file in arguments.recordings for recording in load_all(file, **how)]


def folder_to_write(name: str) -> Path:
    """The folder that `--out` names, which need not be there yet.

    Raises:
        BadInput: it is a file.
    """
    folder = Path(name)
    if folder.exists() and not folder.is_dir():
        raise BadInput(folder, found="a file", expected="a folder, or a name for one")
    return folder


def add_effects(parser: argparse.ArgumentParser) -> None:
    """Add `--effects`; the parsed value is a list of files for `mmt_drake.effects.register_file`."""
    text = (
        "a Python file with an effect of your own, to be known beside those of the library; it is run, so give "
        "none that you would not run"
    )
    add_repeated(parser, "--effects", "FILE", text)


def add_port(parser: argparse.ArgumentParser) -> None:
    """Add `--port`; None: any."""
    parser.add_argument("--port", type=port, metavar="N", help="of the live view on this machine (default: a free one)")


def add_trust(parser: argparse.ArgumentParser) -> None:
    """Add `--trust-library`, of `mmt_drake.diagrams.stations.scenario.load_scenario`."""
    text = "let the scenario's file name code that runs here: operator_device.library, estimator.code, renderer.code"
    parser.add_argument("--trust-library", action="store_true", help=text)


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Add `--jobs` and `--cluster`."""
    text = "do so much at once (default: MMT_JOBS or all processors)"
    parser.add_argument("--jobs", type=count, metavar="N", help=text)
    parser.add_argument("--cluster", metavar="ADDRESS", help="spread the work over a dask cluster: its scheduler")


def add_time_budget(parser: argparse.ArgumentParser, default: float | None, what: str) -> None:
    """Add `--time-budget` [s] with its default; `what` says of what."""
    text = f"look for effects for so long, and say what there was no time for ({what})"
    parser.add_argument("--time-budget", type=seconds, default=default, metavar="SECONDS", help=text)


def count(text: str) -> int:
    """A whole number above 0.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    return _whole(text, 1, "a whole number above 0")


def seed(text: str) -> int:
    """A seed of random numbers.

    Raises:
        argparse.ArgumentTypeError: it is no whole number, or negative.
    """
    return _whole(text, 0, "a whole number, 0 or more")


def port(text: str) -> int:
    """A port of this machine.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    return _whole(text, 1, "a port, 1 to 65535", 65535)


def _whole(text: str, least: int, expected: str, most: float = math.inf) -> int:
    if not (text.isascii() and text.isdigit() and least <= int(text) <= most):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected {expected}")
    return int(text)


def topic(text: str) -> tuple[str, str]:
    """A pair from `name=/other`.

    Raises:
        argparse.ArgumentTypeError: it has another form.
    """
    name, equals, other = text.partition("=")
    if not (name and equals and other):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected name=/other")
    return name, other


def seconds(text: str) -> float:
    """A time above 0 s.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    return _number(text, lambda value: 0.0 < value < math.inf, "a number of seconds above 0")


def share(text: str) -> float:
    """A part of something, 0 to 1.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    return _number(text, lambda value: 0.0 <= value <= 1.0, "a number from 0 to 1")


def _number(text: str, allowed: Callable[[float], bool], expected: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not allowed(value):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected {expected}")
    return value
