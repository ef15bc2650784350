"""`mmt-drake experiment`: the thesis's experiments, as figures, tables and one page."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.markup import escape

from mmt_drake.cli.options import seconds, seed
from mmt_drake.cli.output import add_json, console, on_terminal, print_json
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.analysis.table import Table

EPILOG = """\
examples:
  mmt-drake experiment 1
  mmt-drake experiment 2 --out out/contacts
  mmt-drake experiment 3 --json
  mmt-drake experiment 1 --operator hand.csv --out out/my_hand
  mmt-drake experiment engines
  mmt-drake experiment ablation --seconds 30
  mmt-drake experiment peers --json

1 and 3: one case per way of solving eq. 30 of the thesis, and one that learns nothing for 0.5 s after each touch
(settled_0.5s); in experiment 1 also one whose parameters stand still after 5 s of contact (frozen_5s).
2: the estimators on contacts: a simulated Panda (its model is the optional extra `arm`) slides an object, and public
recordings of a robot that palpates, where MMT_RECORDINGS or ../shared/recordings is a folder; what is not there is left
out.
engines: appendix E, our renderer and other people's physics engines on both of its tables; MuJoCo, Bullet and DART are
the optional extra `engines`, and are left out where they are not installed.
ablation: what may be behind the thesis's errors, one cause at a time and the likely ones together, and which of its
figures each reproduces; its recordings take 2 GB.
estimators: the thesis's estimator and the one whose model runs freely over a window, on strokes, a chirp and hands:
errors, when parameters are found, cost; --estimator rls: one.
objects: a hundred objects drawn at random; --estimator rls: the thesis's; --anisotropic: objects of two materials.
network: a play-out buffer against jitter, loss and reordering, beside constant delays.
updates: how new parameters are taken up; the jumps of the force and the energy that this makes.
peers: the model beside direct and passivity-controlled force feedback, on one motion and one network.
bands: a second model fused in at high frequencies, and where it wins.
cloud: contact on the cloud of a simulated depth camera, against its noise and its filters; --count: contacts.
--out (out/experiment1 and so on by default) receives recordings, figures and index.html."""

_COMPARISONS = ("estimators", "network", "updates", "peers", "bands")
_RUN = ("operator", "seconds", "seed")
_TAKES = {
    "1": _RUN,
    "2": ("seconds", "seed"),
    "3": _RUN,
    "engines": (),
    "ablation": _RUN,
    "objects": ("seed", "estimator", "count", "anisotropic"),
    "cloud": ("seed", "count"),
    **dict.fromkeys(_COMPARISONS, _RUN),
    "bands": ("seconds", "seed"),  # its cases differ in their motion
    "estimators": ("seconds", "seed", "estimator"),  # and so do these
}
"""Experiment -> the options it has a use for, beside --out and --json."""
_ESTIMATORS = ("output_error", "rls")
_WHICH = {"1": "experiment1", "2": "experiment2", "3": "experiment3"} | {
    name: name for name in ("engines", "ablation", "objects", "cloud", *_COMPARISONS)
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument(
        "which",
        choices=_WHICH,
        help="experiment 1 (no delay), 2 (contacts) or 3 (400 ms each way) of the thesis, or as below",
    )
    parser.add_argument("--operator", metavar="REC", help="replay the probe motion of a recording in place of strokes")
    parser.add_argument("--out", metavar="DIR", help="folder for recordings, figures and the page")
    parser.add_argument("--seconds", type=seconds, metavar="N", help="simulated time of each case")
    parser.add_argument("--seed", type=seed, metavar="S", help="of everything random (default 0)")
    parser.add_argument(
        "--estimator", choices=_ESTIMATORS, help="of objects (default output_error); of estimators: no other"
    )
    parser.add_argument("--count", type=int, metavar="N", help="of objects (default 100), of contacts (16)")
    parser.add_argument("--anisotropic", action="store_true", help="objects whose normal axis is of another material")
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run an experiment."""
    _refuse_others(arguments)
    out = Path(arguments.out or f"out/{_WHICH[arguments.which]}")
    done = _RUNNERS[arguments.which](arguments, out)
    if arguments.json:
        print_json(done.document)
    else:
        _tell(done)
    return 0


@dataclass(frozen=True)
class _Done:
    """What came of an experiment: its JSON document, and the same for a person."""

    document: dict[str, Any]
    title: str
    tables: Sequence[Table]
    findings: Sequence[str]
    page: Path


def _refuse_others(arguments: argparse.Namespace) -> None:
    """Options that this experiment would not heed."""
    takes = _TAKES[arguments.which]
    options = sorted({name for names in _TAKES.values() for name in names})
    values = {name: getattr(arguments, name) for name in options}
    given = [name for name, value in values.items() if value is not None and value is not False]
    if others := [f"--{name}" for name in given if name not in takes]:
        expected = " and ".join((", ".join(f"--{name}" for name in (*takes, "out")), "--json"))
        raise BadInput(f"experiment {arguments.which}", found=", ".join(others), expected=f"no option but {expected}")


def _numbered(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.analysis.summary import error_table
    from mmt_drake.diagrams.experiments import (
        PLANS,
        figures_to_reach,
        findings,
        parameter_table,
        reached_table,
        run_experiment,
        write_report,
    )

    number = int(arguments.which)

    with progress(f"experiment {number}, cases", len(PLANS[number].cases())) as update:
        result = run_experiment(
            number,
            out=out,
            operator=arguments.operator,
            seed=arguments.seed or 0,
            seconds=arguments.seconds,
            jobs=os.cpu_count() or 1,
            progress=update,
        )
    title = f"Experiment {number}: scenario {result.scenario}, operator {result.operator}"
    tables = [
        error_table(result.metrics, result.settled),
        parameter_table(result),
        reached_table(figures_to_reach(result)),
    ]
    return _Done(result.to_json(), title, tables, findings(result), write_report(result, out))


def _second(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments import reached_table
    from mmt_drake.diagrams.experiments.second import findings, known_contacts, run_second, second_table, write_second
    from mmt_drake.diagrams.experiments.second.run import ESTIMATORS

    there = sum(contact.take is not None for contact in known_contacts())
    with progress("experiment 2, cases", there * len(ESTIMATORS)) as update:
        result = run_second(out=out, seed=arguments.seed or 0, seconds=arguments.seconds, progress=update)
    title, tables = (
        "Experiment 2: estimators on contacts",
        [second_table(result), reached_table(result.figures_to_reach())],
    )
    return _Done(result.to_json(), title, tables, findings(result), write_second(result, out))


def _engines(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments.engines import (
        engines_table,
        findings,
        run_engines,
        runs_of,
        thesis_table,
        write_report,
    )

    with progress("engines, runs", runs_of()) as update:
        result = run_engines(progress=update)
    title, tables = "Engine table: appendix E of the thesis", [engines_table(result), thesis_table()]
    return _Done(result.to_json(), title, tables, findings(result), write_report(result, out))


def _ablation(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments.ablation import CAUSES, RUNS, findings, run_ablation, short_table, write_report

    with progress("ablation, runs", len(CAUSES) * len(RUNS)) as update:
        result = run_ablation(
            out=out,
            operator=arguments.operator,
            seed=arguments.seed or 0,
            seconds=arguments.seconds,
            jobs=os.cpu_count() or 1,
            progress=update,
        )
    title = f"Ablation: operator {result.operator}"
    return _Done(result.to_json(), title, [short_table(result)], findings(result), write_report(result, out))


def _objects(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments import reached_table
    from mmt_drake.diagrams.experiments.objects import objects_findings, objects_table, run_objects, write_objects

    count = 100 if arguments.count is None else arguments.count
    if count < 1:
        raise BadInput("experiment objects", found=f"--count {count}", expected="one object at least")
    with progress("objects", count) as update:
        result = run_objects(
            count,
            estimator=arguments.estimator or "output_error",
            isotropic=not arguments.anisotropic,
            seed=arguments.seed or 0,
            progress=update,
        )
    title, tables = "Objects drawn at random", [objects_table(result), reached_table(result.figures_to_reach())]
    return _Done(result.to_json(), title, tables, objects_findings(result), write_objects(result, out))


def _cloud(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments import cloud

    touches = cloud.Plan.touches if arguments.count is None else arguments.count
    plan = cloud.Plan(touches=touches, seed=arguments.seed or 0)
    with progress("cloud", plan.motion().cycle, simulated=True) as update:
        result = cloud.run_cloud(plan, progress=update)
    title, tables = "Contact on a measured cloud, in simulation", [cloud.cloud_table(result)]
    return _Done(result.to_json(), title, tables, cloud.cloud_findings(result), cloud.write_cloud(result, out))


def _comparison(arguments: argparse.Namespace, out: Path) -> _Done:
    from mmt_drake.diagrams.experiments import reached_table
    from mmt_drake.diagrams.experiments.comparisons import COMPARISONS, run_comparison, with_estimator, write_comparison

    comparison, seed = COMPARISONS[arguments.which], arguments.seed or 0
    if arguments.estimator is not None:
        comparison = with_estimator(comparison, arguments.estimator)
    with progress(f"{comparison.name}, runs", len(comparison.cases(seed, arguments.seconds))) as update:
        compared = run_comparison(
            comparison,
            out=out,
            operator=arguments.operator,
            seed=seed,
            seconds=arguments.seconds,
            jobs=os.cpu_count() or 1,
            progress=update,
        )
    judgement, title = compared.judgement, f"{comparison.title} Operator {compared.operator}"
    tables = [judgement.table, reached_table(judgement.reached)]
    return _Done(compared.to_json(), title, tables, judgement.sentences, write_comparison(compared, out))


_RUNNERS: dict[str, Callable[[argparse.Namespace, Path], _Done]] = {
    **dict.fromkeys(("1", "3"), _numbered),
    "2": _second,
    "engines": _engines,
    "ablation": _ablation,
    "objects": _objects,
    "cloud": _cloud,
    **dict.fromkeys(_COMPARISONS, _comparison),
}


def _tell(done: _Done) -> None:
    target = console()
    target.print(escape(done.title))
    for table in done.tables:
        target.print()
        target.print(on_terminal(table))
    target.print()
    for sentence in done.findings:
        target.print(f"– {escape(sentence)}")
    target.print()
    target.print(f"page: {escape(str(done.page))} (figures and recordings beside it)", soft_wrap=True)
