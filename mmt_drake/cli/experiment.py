"""`mmt-drake experiment`: the thesis's experiments, as figures, tables and one page."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from rich.markup import escape

from mmt_drake.cli.options import seconds, seed
from mmt_drake.cli.output import add_json, console, on_terminal, print_json
from mmt_drake.cli.progress import progress

if TYPE_CHECKING:
    from diagrams.experiments import ExperimentResult

EPILOG = """\
examples:
  mmt-drake experiment 1
  mmt-drake experiment 3 --json
  mmt-drake experiment 1 --operator hand.csv --out out/my_hand

One case per way of solving eq. 30 of the thesis, and one that learns nothing for 0.5 s after each touch
(settled_0.5s); in experiment 1 also one whose parameters stand still after 5 s of contact (frozen_5s). --out
(out/experiment1 by default) receives every case's recording, the thesis's figures and index.html."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    # The numbers of diagrams.experiments.PLANS, which may not be there when help is asked for.
    parser.add_argument("number", type=int, choices=(1, 3), help="experiment 1 (no delay) or 3 (400 ms each way)")
    parser.add_argument("--operator", metavar="REC", help="replay the probe motion of a recording in place of strokes")
    parser.add_argument("--out", metavar="DIR", help="folder for recordings, figures and the page")
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time of each case")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of everything random (default 0)")
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run an experiment."""
    from diagrams.experiments import PLANS, run_experiment, write_report

    out = Path(arguments.out or f"out/experiment{arguments.number}")
    with progress(f"experiment {arguments.number}, cases", len(PLANS[arguments.number].cases())) as update:
        result = run_experiment(
            arguments.number,
            out=out,
            operator=arguments.operator,
            seed=arguments.seed,
            seconds=arguments.seconds,
            jobs=os.cpu_count() or 1,
            progress=update,
        )
    page = write_report(result, out)
    if arguments.json:
        print_json(result.to_json())
    else:
        _tell(result, page)
    return 0


def _tell(result: ExperimentResult, page: Path) -> None:
    from diagrams.experiments import findings, parameter_table
    from mmt_drake.analysis.summary import error_table

    target = console()
    target.print(f"Experiment {result.number}: scenario {result.scenario}, operator {escape(result.operator)}")
    for table in (error_table(result.metrics, result.settled), parameter_table(result)):
        target.print()
        target.print(on_terminal(table))
    target.print()
    for sentence in findings(result):
        target.print(f"– {escape(sentence)}")
    target.print()
    target.print(f"page: {escape(str(page))} (figures and recordings beside it)", soft_wrap=True)
