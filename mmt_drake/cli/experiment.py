"""`mmt-drake experiment`: the thesis's experiments, as figures, tables and one page."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from mmt_drake.cli.options import seconds, seed
from mmt_drake.cli.progress import progress

if TYPE_CHECKING:
    from diagrams.experiments import Case, ExperimentResult
    from mmt_drake.analysis.page import Cell

EPILOG = """\
examples:
  mmt-drake experiment 1
  mmt-drake experiment 3 --json
  mmt-drake experiment 1 --operator hand.csv --out out/my_hand

One case per way of solving eq. 30 of the thesis; in experiment 1 also one whose parameters stand still after 5 s of
contact. --out (out/experiment1 by default) receives every case's recording, the thesis's figures and index.html."""

WIDTH = 120
"""Columns of the printed tables where no terminal says how many there are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    # The numbers of diagrams.experiments.PLANS, which may not be there when help is asked for.
    parser.add_argument("number", type=int, choices=(1, 3), help="experiment 1 (no delay) or 3 (400 ms each way)")
    parser.add_argument("--operator", metavar="REC", help="replay the probe motion of a recording in place of strokes")
    parser.add_argument("--out", metavar="DIR", help="folder for recordings, figures and the page")
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time of each case")
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of everything random (default 0)")
    parser.add_argument("--json", action="store_true", help="print the figures as one JSON document and nothing else")


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
        print(json.dumps(result.to_json(), indent=2, allow_nan=False))
    else:
        _tell(result, page)
    return 0


def _tell(result: ExperimentResult, page: Path) -> None:
    from diagrams.experiments import findings, parameter_table

    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = WIDTH
    console.print(f"Experiment {result.number}: scenario {result.scenario}, operator {escape(result.operator)}")
    console.print()
    console.print(_errors(result))
    parameters = parameter_table(result)
    table = _table("parameters at the end of the run", *parameters.headers)
    for row in parameters.rows:
        table.add_row(*map(_text, row))
    console.print(table)
    for sentence in findings(result):
        console.print(f"– {escape(sentence)}")
    console.print()
    console.print(f"page: {escape(str(page))} (figures and recordings beside it)", soft_wrap=True)


def _errors(result: ExperimentResult) -> Table:
    bands = ("all", "<0.3 Hz", "0.3–3 Hz", "3–10 Hz")
    title = "rendered force: RMS(rendered - measured) / RMS(measured) in percent, by band; lags in ms"
    table = _table(title, "case", *bands, "2nd half", "z", "estimated", "stable after", "touch", "release")
    for case in result.cases:
        table.add_row(case.name, *map(_text, _row(case)))
    return table


def _row(case: Case) -> list[Cell]:
    metrics = case.metrics
    estimated = None if metrics.estimated_error is None else metrics.estimated_error.tangential["all"]
    settled, normal = case.settled.rendered_error.tangential["all"], metrics.rendered_error.normal["all"]
    ratios = [*metrics.rendered_error.tangential.values(), settled, normal, estimated]
    lags = [None if lag is None else 1e3 * lag for lag in (metrics.touch.median_s, metrics.release.median_s)]
    stable = metrics.time_to_stable_s
    return [
        *(None if ratio is None else 100.0 * ratio for ratio in ratios),
        "never" if stable is None else f"{stable:.2f} s",
        *lags,
    ]


def _table(title: str, *headers: str) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    table.add_column(headers[0], no_wrap=True)
    for header in headers[1:]:
        table.add_column(escape(header), justify="right")
    return table


def _text(value: Cell) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
