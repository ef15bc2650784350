"""`mmt-drake bench faults`: every kind of fault at random moments, a line each."""

from __future__ import annotations

import argparse
import math
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from mmt_drake.cli.output import print_json
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.diagrams.studies import Report, Study

GROUP = "faults"
_MOMENTS = 50
_FUZZED = "{:20}{:>9}{:>9}{:>13}{:>7}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of this group."""
    text = f"faults: at how many random moments of each kind (default: {_MOMENTS})"
    parser.add_argument("--moments", type=int, metavar="N", help=text)
    text = "faults: of one place alone, as the table names it; may be given again"
    parser.add_argument("--where", action="append", metavar="PLACE", help=text)
    text = "faults: strange files and packets instead, for so many minutes, thousands of them"
    parser.add_argument("--fuzz", type=float, metavar="MINUTES", help=text)


def check(arguments: argparse.Namespace) -> None:
    """Refuse the options of this group with another one.

    Raises:
        BadInput: there is one.
    """
    for name in ("moments", "where", "fuzz"):
        if arguments.group != GROUP and getattr(arguments, name) is not None:
            raise BadInput(f"--{name}", found=f"bench {arguments.group}", expected=f"bench {GROUP}")
    if arguments.fuzz is not None:
        if not 0.0 < arguments.fuzz < math.inf:
            raise BadInput("--fuzz", found=arguments.fuzz, expected="more than 0 minutes")
        for name in ("moments", "where"):
            if getattr(arguments, name) is not None:
                raise BadInput(f"--{name}", found="--fuzz beside it", expected="one of both")


def main(arguments: argparse.Namespace) -> int:
    """Print the table; the exit status is 1 if anything was not as it must be."""
    if arguments.fuzz is not None:
        return _fuzz(60.0 * arguments.fuzz, arguments.json)
    from mmt_drake.diagrams.faults.table import PLACES, faults_study

    moments = _MOMENTS if arguments.moments is None else arguments.moments
    if moments < 1:
        raise BadInput("--moments", found=moments, expected="1 or more")
    for place in arguments.where or ():
        if place not in PLACES:
            raise BadInput("--where", found=place, expected=" or ".join(PLACES))
    report = run_printed(faults_study(moments, tuple(arguments.where or PLACES)), "kinds tried", arguments.json)
    print_json(report.document) if arguments.json else print(report.sentences[-1])
    return 1 if any(row["wrong"] for row in report.document["faults"]) else 0


def run_printed(study: Study, steps: str, json: bool) -> Report:
    """Run a study, each of its lines printed as it comes; where a document follows, how many on a terminal's stderr."""
    from mmt_drake.diagrams.studies import Asked

    def count(done: float) -> None:
        if json and sys.stderr.isatty():
            print(f"{done:g} {steps}", end="\r", file=sys.stderr)

    say = (lambda line: None) if json else partial(print, flush=True)
    return study.run(Asked(Path(), say=say), count)


def _fuzz(seconds: float, json: bool) -> int:
    """Strange inputs for a while: a line each that was not answered as it must be, then a line each target."""
    from mmt_drake.cli.main import main as program
    from mmt_drake.diagrams.faults.fuzz.harness import Answer
    from mmt_drake.diagrams.faults.fuzz.targets import fuzz
    from mmt_drake.diagrams.studies.measurement import Measurement, figures_of

    answers, tried = list[Answer](), fuzz(program)
    with progress("strange inputs", seconds, note=lambda: f" s, {len(answers)} inputs") as update:
        start = time.monotonic()
        for answer in tried.answers():
            answers.append(answer)
            if answer.wrong and not json:
                print(f"{answer.number} {answer.target}: {answer.wrong}", flush=True)
            update(round(time.monotonic() - start))
            if time.monotonic() - start > seconds:
                break
    wrong, most = sum(bool(o.wrong) for o in answers), max(o.memory for o in answers)
    slowest = max(o.seconds for o in answers)
    figures = [
        Measurement("inputs", len(answers), "", None),
        Measurement("inputs that were not answered as they must be", wrong, "", 0),
        Measurement("slowest input", slowest, "s", None),
        Measurement("most memory", most, "GB", tried.memory),
    ]
    if json:
        print_json({"figures": figures_of(figures, f"mmt-drake bench {GROUP} --fuzz")})
        return 1 if wrong else 0
    print(_FUZZED.format("target", "inputs", "refused", "slowest [s]", "wrong"))
    for target in dict.fromkeys(o.target for o in answers):
        own = [o for o in answers if o.target == target]
        refused, amiss = sum(o.status == 2 for o in own), sum(bool(o.wrong) for o in own)
        print(_FUZZED.format(target, len(own), refused, f"{max(o.seconds for o in own):.2f}", amiss))
    print(f"{len(answers)} inputs, {slowest:.1f} s and {most:.2f} GB at most: {wrong or 'nothing'} not as it must be")
    return 1 if wrong else 0
