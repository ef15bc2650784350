"""`mmt-drake bench`: the performance figures, measured here and now.

examples:
  mmt-drake bench
  mmt-drake bench --json > bench.json
  mmt-drake bench diagnosis
  mmt-drake bench arms
  mmt-drake bench pacing --minutes 10
  mmt-drake bench haptics
  mmt-drake bench learning --minutes 10
  mmt-drake bench faults --moments 5
  mmt-drake bench faults --fuzz 30

`quick`: the station, its kernels, how accurate and repeatable they are; less than a minute on a calm machine.
`diagnosis`: how long `diagnose` takes on all processors, what twice the recording costs, and whether a dask cluster
finds the same; some minutes. `pacing`: set-up 1 at 1 kHz by the wall clock, in turns with a loop that does nothing and
with itself under a live view; less than a minute, or `--minutes` and half as long again. `haptics`: set-up 1
with an emulated device in the hand at 1 kHz; half a minute. `learning`: what a learner beside set-up 1 costs, whether a
run repeats, energy with laws that come and go, and whether anything is told of an object without a law; five minutes
and `--minutes`. Other work on the machine shows:
a figure with a peer was measured beside it in the same minute, and their ratio holds where single figures do not.

`faults`: every kind of fault, each at random moments: the greatest force that reached the hand and its limit, after how
long it was zero (or the arm at rest) and after how long it must be, how much of a recording's end was lost, and what
was not as it must be, a line each. Half an hour with 50 moments each; a few minutes with 2. The exit status is 1 if
anything was wrong. `--fuzz`: damaged files for every command that reads one, and packets, as many as the time allows:
none may end in anything but success, or status 2 and one line, take more than 20 s (a diagnosis 120 s) or 2 GB, or
leave anything behind.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from mmt_drake.cli.output import add_json, print_json
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.diagrams.proof.studies import Report, Study

QUICK, FAULTS = "quick", "faults"
_OPTIONS = {"moments": (FAULTS,), "where": (FAULTS,), "fuzz": (FAULTS,), "minutes": ("pacing", "learning")}
"""Options of some groups alone."""
_EACH = 50  # random times of each kind of fault
_FUZZED = "{:20}{:>9}{:>9}{:>13}{:>7}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    text = f"which figures: {QUICK} (default), diagnosis, pacing, haptics, learning or faults"
    parser.add_argument("group", nargs="?", default=QUICK, metavar="GROUP", help=text)
    text = "pacing: how long set-up 1 runs in all (default 0.4); learning: how long nothing may be told (default 1)"
    parser.add_argument("--minutes", type=float, metavar="M", help=text)
    text = f"faults: at how many random moments of each kind (default: {_EACH})"
    parser.add_argument("--moments", type=int, metavar="N", help=text)
    text = "faults: of one place alone, as the table names it; may be given again"
    parser.add_argument("--where", action="append", metavar="PLACE", help=text)
    text = "faults: strange files and packets instead, for so many minutes, thousands of them"
    parser.add_argument("--fuzz", type=float, metavar="MINUTES", help=text)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Measure and print; a missed target is shown, and is no error. Faults that went wrong are exit status 1."""
    for name, groups in _OPTIONS.items():
        if getattr(arguments, name) is not None and arguments.group not in groups:
            raise BadInput(f"--{name}", found=f"bench {arguments.group}", expected=f"bench {' or '.join(groups)}")
    if arguments.fuzz is not None:
        if not 0.0 < arguments.fuzz < math.inf:
            raise BadInput("--fuzz", found=arguments.fuzz, expected="more than 0 minutes")
        for name in ("moments", "where"):
            if getattr(arguments, name) is not None:
                raise BadInput(f"--{name}", found="--fuzz beside it", expected="one of both")
        return _fuzz(60.0 * arguments.fuzz, arguments.json)
    if arguments.group == FAULTS:
        report = _run(_faults(arguments), "places done", arguments.json)
    else:
        report = _run(_figures(arguments), "figures measured", arguments.json)
    print_json(report.document) if arguments.json else print(report.sentences[-1])
    return 1 if any(row["wrong"] for row in report.document.get("faults", ())) else 0


def _figures(arguments: argparse.Namespace) -> Study:
    from mmt_drake.diagrams.proof.bench import GROUPS, bench_study

    if arguments.group not in GROUPS:
        raise BadInput("bench", at="GROUP", found=arguments.group, expected=" or ".join([*GROUPS, FAULTS]))
    if arguments.minutes is None:
        return bench_study(arguments.group)
    if not 0.0 < arguments.minutes < math.inf:
        raise BadInput("--minutes", found=arguments.minutes, expected="more than 0")
    return bench_study(arguments.group, minutes=arguments.minutes)


def _faults(arguments: argparse.Namespace) -> Study:
    from mmt_drake.diagrams.proof.faults.table import WHERE, faults_study

    count = _EACH if arguments.moments is None else arguments.moments
    if count < 1:
        raise BadInput("--moments", found=count, expected="1 or more")
    for where in arguments.where or ():
        if where not in WHERE:
            raise BadInput("--where", found=where, expected=" or ".join(WHERE))
    return faults_study(count, tuple(arguments.where or WHERE))


def _run(study: Study, steps: str, json: bool) -> Report:
    """Run a study, each of its lines printed as it comes; a terminal also shows how many of how many.

    No bar: its thread would show in what is measured.
    """
    from mmt_drake.diagrams.proof.studies import Asked

    asked = Asked(Path(), say=(lambda line: None) if json else partial(print, flush=True))
    total = study.steps(asked)

    def count(done: float) -> None:
        if sys.stderr.isatty():
            print(f"{done:g} of {total:g} {steps}", end="\r", file=sys.stderr, flush=True)

    count(0)
    return study.run(asked, count)


def _fuzz(seconds: float, json: bool) -> int:
    """Strange inputs for a while: a line each that was not answered as it must be, then a line each target."""
    from mmt_drake.cli.main import main as program
    from mmt_drake.diagrams.proof.faults.fuzz.harness import Answer
    from mmt_drake.diagrams.proof.faults.fuzz.targets import fuzz
    from mmt_drake.diagrams.proof.studies.measurement import Measurement, figures_of

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
        print_json({"figures": figures_of(figures, f"mmt-drake bench {FAULTS} --fuzz")})
        return 1 if wrong else 0
    print(_FUZZED.format("target", "inputs", "refused", "slowest [s]", "wrong"))
    for target in dict.fromkeys(o.target for o in answers):
        own = [o for o in answers if o.target == target]
        refused, amiss = sum(o.status == 2 for o in own), sum(bool(o.wrong) for o in own)
        print(_FUZZED.format(target, len(own), refused, f"{max(o.seconds for o in own):.2f}", amiss))
    print(f"{len(answers)} inputs, {slowest:.1f} s and {most:.2f} GB at most: {wrong or 'nothing'} not as it must be")
    return 1 if wrong else 0
