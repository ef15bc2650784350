"""`mmt-drake bench`: the performance figures, measured here and now.

examples:
  mmt-drake bench
  mmt-drake bench --json > bench.json
  mmt-drake bench diagnosis
  mmt-drake bench pacing --minutes 10
  mmt-drake bench haptics
  mmt-drake bench faults --moments 5
  mmt-drake bench faults --fuzz 30

`quick`: the station, its kernels, how accurate and repeatable they are; less than a minute on a calm machine.
`diagnosis`: how long `diagnose` takes on all processors, what twice the recording costs, and whether a dask cluster
finds the same; some minutes. `pacing`: set-up 1 at 1 kHz by the wall clock, in turns with a loop that does nothing and
with itself under a live view; less than a minute, or `--minutes` and half as long again. `haptics`: set-up 1
with an emulated device in the hand at 1 kHz; half a minute. Other work on the machine shows:
a figure with a peer was measured beside it in the same minute, and their ratio holds where single figures do not.

`faults`: every kind of fault, each at random moments: the greatest force that reached the hand and its limit, after how
long it was zero (or the arm at rest) and after how long it must be, how much of a recording's end was lost, and what
was not as it must be, a line each. Half an hour with 50 moments each; a few minutes with 2. The exit status is 1 if
anything was wrong. `--fuzz`: damaged files for every command that reads one, and packets, as many as the time allows:
none may end in anything but success, or status 2 and one line, take more than 20 s (a diagnosis 120 s) or 2 GB, or
leave anything behind.
"""

import argparse
import math

from mmt_drake.cli import bench_faults
from mmt_drake.cli.bench_faults import run_printed
from mmt_drake.cli.output import add_json, print_json
from mmt_drake.errors import BadInput

QUICK, PACING = "quick", "pacing"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    text = f"which figures: {QUICK} (default), diagnosis, pacing, haptics or faults"
    parser.add_argument("group", nargs="?", default=QUICK, metavar="GROUP", help=text)
    text = "pacing: how long set-up 1 runs in all (default 0.4)"
    parser.add_argument("--minutes", type=float, metavar="M", help=text)
    bench_faults.add_arguments(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Measure and print; a missed target is told, and is no error."""
    from mmt_drake.diagrams.bench import GROUPS, bench_study

    bench_faults.check(arguments)
    options = _options(arguments)
    if arguments.group == bench_faults.GROUP:
        return bench_faults.main(arguments)
    if arguments.group not in GROUPS:
        expected = " or ".join([*GROUPS, bench_faults.GROUP])
        raise BadInput("bench", at="GROUP", found=arguments.group, expected=expected)
    report = run_printed(bench_study(arguments.group, **options), "figures measured", arguments.json)
    print_json(report.document) if arguments.json else print(report.sentences[-1])
    return 0


def _options(arguments: argparse.Namespace) -> dict[str, float]:
    """What the group is to be measured with, as it was asked for."""
    if arguments.minutes is None:
        return {}
    if arguments.group != PACING:
        raise BadInput("--minutes", found=f"bench {arguments.group}", expected=f"bench {PACING}")
    if not 0.0 < arguments.minutes < math.inf:
        raise BadInput("--minutes", found=arguments.minutes, expected="more than 0")
    return {"minutes": arguments.minutes}
