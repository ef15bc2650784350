"""Options that several commands share."""

import argparse
import math

TIME_BUDGET_S = 300.0
"""Of one diagnosis of recordings."""


def add_topics(parser: argparse.ArgumentParser) -> None:
    """Add `--topic`; the parsed value is a list of (name, topic), of which `dict` makes what `recording.load` takes."""
    parser.add_argument(
        "--topic",
        type=topic,
        action="append",
        default=[],
        metavar="NAME=/OTHER",
        help="where a bag calls a topic otherwise: a signal (force) or its usual topic (/telerobot/wrench), "
        "and what it is called there; may be given again",
    )


def add_effects(parser: argparse.ArgumentParser) -> None:
    """Add `--effects`; the parsed value is a list of files for `mmt_drake.effects.register_file`."""
    parser.add_argument(
        "--effects",
        action="append",
        default=[],
        metavar="FILE",
        help="a Python file with an effect of your own, to be known beside those of the library; it is run, so give "
        "none that you would not run; may be given again",
    )


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Add `--jobs` and `--cluster`."""
    parser.add_argument(
        "--jobs", type=count, metavar="N", help="do so much at once (default: MMT_JOBS or all processors)"
    )
    parser.add_argument("--cluster", metavar="ADDRESS", help="spread the work over a dask cluster: its scheduler")


def add_time_budget(parser: argparse.ArgumentParser, default: float | None, told: str) -> None:
    """Add `--time-budget` [s] with its default; `told` says of what."""
    parser.add_argument(
        "--time-budget",
        type=seconds,
        default=default,
        metavar="SECONDS",
        help=f"look for effects for so long, and say what there was no time for ({told})",
    )


def count(text: str) -> int:
    """A whole number above 0.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    if not (text.isascii() and text.isdigit() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number above 0")
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
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number of seconds above 0")
    return value


def share(text: str) -> float:
    """A part of something, 0 to 1.

    Raises:
        argparse.ArgumentTypeError: it is none.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a number from 0 to 1")
    return value


def seed(text: str) -> int:
    """A seed of random numbers.

    Raises:
        argparse.ArgumentTypeError: it is no whole number, or negative.
    """
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number, 0 or more")
    return int(text)
