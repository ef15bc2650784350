"""`mmt-drake demo`: the main job end to end, in simulation, on one page.

examples:
  mmt-drake demo
  mmt-drake demo --out out/look

A recorded hand that comes with the package drives set-up 1, without a delay and with 400 ms each way. Leaves two
recordings (.mcap), figures (.png) and index.html, which shows them; opens no window.
"""

import argparse

from mmt_drake.cli.output import say
from mmt_drake.cli.progress import progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--out", default="out/demo", metavar="DIR", help="folder for all of it (default out/demo)")


def main(arguments: argparse.Namespace) -> int:
    """Run the demo."""
    from mmt_drake.diagrams.proof.experiments.demo import run_demo

    with progress("demo, runs", 2) as update:
        outcome = run_demo(arguments.out, update)
    say("\n".join(outcome.lines()))
    return 0
