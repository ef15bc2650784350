"""`mmt-drake trial`: the proof that a diagnosis finds what was concealed, and names nothing that was not."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mmt_drake.cli.options import add_workers, count, seed, share
from mmt_drake.cli.output import add_json, console, on_terminal, print_json, say
from mmt_drake.cli.progress import progress
from mmt_drake.processors import processors
from mmt_drake.with_parent import end_with_parent

if TYPE_CHECKING:
    from mmt_drake.diagrams.trial.real.run import Diagnosed
    from mmt_drake.recording import Recording

EPILOG = """\
examples:
  mmt-drake trial
  mmt-drake trial --seed 7 --per-effect 8 --out out/trial
  mmt-drake trial --real recordings --json

Cases are made by an engine of their own, their truths sealed: the hash is printed before the first diagnosis, the
truths are written after the last one (DIR/truths.json). --real diagnoses public recordings of real systems, the known
physics concealed from the model, and scores the models on recordings held out."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of the cases that are drawn (default 0)")
    parser.add_argument("--per-effect", type=count, default=4, metavar="K", help="cases of each effect (default 4)")
    parser.add_argument(
        "--remainder",
        type=share,
        default=0.0,
        metavar="R",
        help="conceal single effects above a remainder without a name: R of the RMS that they leave after a refit",
    )
    parser.add_argument("--real", metavar="DIR", help="diagnose the public recordings in this folder instead")
    parser.add_argument("--out", default="out/trial", metavar="DIR", help="folder for all of it (default out/trial)")
    add_workers(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run the trial."""
    return _real(arguments) if arguments.real is not None else _sealed(arguments)


def _sealed(arguments: argparse.Namespace) -> int:
    from mmt_drake.diagrams.trial.run import run_trial
    from mmt_drake.diagrams.trial.sealed import draw_trial
    from mmt_drake.diagrams.trial.summary import effects_table, rates_table

    cases = draw_trial(arguments.seed, arguments.per_effect, arguments.remainder)
    target = console(stderr=arguments.json)
    with _processes(arguments.jobs, arguments.cluster) as executor, progress("trial, cases", len(cases)) as update:

        def spread(function: Callable[[Any], Any], items: Sequence[Any]) -> Iterable[Any]:
            for done, result in enumerate(executor.map(function, items), 1):
                update(done)
                yield result

        whole, _ = run_trial(cases, Path(arguments.out), diagnose_case, spread=spread, announce=target.print)
    if arguments.json:
        print_json(whole)
        return 0
    for table in (rates_table(whole["summary"]), effects_table(whole["summary"])):
        target.print()
        target.print(on_terminal(table))
    target.print(f"\n{arguments.out}: trial.json, truths.json, confusion.png and every case", soft_wrap=True)
    return 0


def diagnose_case(folder: Path) -> Mapping[str, Any]:
    """The diagnosis of a case's folder as plain data, by one thread; the document is written beside the recording."""
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.tell.written import write_diagnosis
    from mmt_drake.diagrams.trial.sealed import MODEL, RECORDING
    from mmt_drake.model_files import load_model
    from mmt_drake.recording import load

    with workers(1) as executor:
        outcome = diagnose([load(folder / RECORDING)], load_model(folder / MODEL), executor=executor)
    write_diagnosis(outcome.diagnosis, folder / "diagnosis.json")
    return outcome.diagnosis.to_json()


@contextmanager
def _processes(jobs: int | None, cluster: str | None) -> Iterator[Executor]:
    """Workers for whole cases: processes here, or those of a cluster."""
    from mmt_drake.diagnosis.fit.workers import workers

    if cluster is not None:
        with workers(jobs, cluster) as executor:
            yield executor
        return
    spawn = get_context("spawn")
    with ProcessPoolExecutor(jobs or processors(), spawn, initializer=end_with_parent) as executor:
        yield executor


def _real(arguments: argparse.Namespace) -> int:
    from mmt_drake.diagrams.trial.real.data_sets import real_cases, without_a_case
    from mmt_drake.diagrams.trial.real.run import real_table, run_real

    cases = real_cases(arguments.real)
    with progress("real recordings, data sets", len(cases)) as update:
        started = iter(range(len(cases)))
        results = run_real(
            arguments.real,
            _RealDiagnosis(arguments.jobs, arguments.cluster),
            Path(arguments.out),
            cases=cases,
            starting=lambda case: update(next(started)),
        )
    if arguments.json:
        print_json({"real": [result.document() for result in results]})
        return 0
    console().print(on_terminal(real_table(results)))
    if untried := without_a_case(arguments.real):
        say(f"not tried, for want of a case: {', '.join(untried)}")
    return 0


class _RealDiagnosis:
    """Diagnoses the recordings of one real system and writes what it found."""

    def __init__(self, jobs: int | None, cluster: str | None):
        self._jobs, self._cluster = jobs, cluster

    def __call__(self, recordings: Sequence[Recording], model: Mapping[str, Any], out: Path) -> Diagnosed:
        from mmt_drake.diagnosis.diagnose import diagnose
        from mmt_drake.diagnosis.fit.workers import workers
        from mmt_drake.diagnosis.tell.deliver import augmented_model
        from mmt_drake.diagnosis.tell.written import write_outcome
        from mmt_drake.diagrams.trial.real.run import Diagnosed
        from mmt_drake.model_files import parse_model

        with workers(self._jobs, self._cluster) as executor:
            outcome = diagnose(recordings, parse_model(dict(model)), executor=executor)
        write_outcome(outcome, out)
        refit, best = (None if f is None else augmented_model(f) for f in (outcome.refit, outcome.best))
        return Diagnosed(outcome.diagnosis, refit, best)
