"""`mmt-drake trial`: the proof that a diagnosis finds what was concealed, and names nothing that was not.

examples:
  mmt-drake trial
  mmt-drake trial --seed 7 --per-effect 8 --out out/trial
  mmt-drake trial --plant foreign --remainder 0.2
  mmt-drake trial --plant palpation
  mmt-drake trial --effects my_effect.py
  mmt-drake trial --arms --per-effect 2 --jobs 2
  mmt-drake trial --real recordings --only emps --only carter_pendulum --time-budget 60

Cases are made by an engine of their own, their truths sealed: the hash is printed before the first diagnosis, the
truths are written after the last one (DIR/truths.json). --real diagnoses public recordings of real systems, the known
physics concealed from the model, and scores the models on recordings held out. With --effects every diagnosis knows an
effect of your own too: whether it is named where it is not. No case conceals it, since the cases' engine does not have
its law.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mmt_drake.cli.interrupted import known_kept
from mmt_drake.cli.options import (
    TIME_BUDGET_S,
    add_effects,
    add_repeated,
    add_time_budget,
    add_workers,
    count,
    seed,
    share,
)
from mmt_drake.cli.output import add_json, console, on_terminal, print_json, say
from mmt_drake.cli.progress import progress
from mmt_drake.errors import BadInput
from mmt_drake.processors import processors

if TYPE_CHECKING:
    from mmt_drake.diagrams.proof.studies import Study
    from mmt_drake.diagrams.proof.trial.real.run import Diagnosed
    from mmt_drake.recording import Recording


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of this command."""
    parser.add_argument("--seed", type=seed, default=0, metavar="S", help="of the cases that are drawn (default 0)")
    parser.add_argument("--per-effect", type=count, default=4, metavar="K", help="cases of each effect (default 4)")
    text = "conceal single effects above a remainder without a name: R of the RMS that they leave after a refit"
    parser.add_argument("--remainder", type=share, metavar="R", help=text)
    text = (
        "what simulates the cases: own (default), one axis at a time; foreign, both axes at once, friction a vector, "
        "by another integrator and stick rule. What that does not have is drawn on the own plant alone: friction that "
        "differs by direction, a rough patch, ageing, heating, running in, stiffening under load, a loose mass, a "
        "vibrating table, driven bodies and materials; palpation, a tip on surfaces that nobody recorded"
    )
    parser.add_argument("--plant", choices=("own", "foreign", "palpation"), default="own", help=text)
    parser.add_argument("--real", metavar="DIR", help="diagnose the public recordings in this folder instead")
    text = "of --real: further recordings of the same systems, each alone, to which no case is fitted"
    parser.add_argument("--further", action="store_true", help=text)
    text = "conceal effects of robot arms, simulated by MuJoCo (default remainder then 0.2)"
    parser.add_argument("--arms", action="store_true", help=text)
    add_repeated(parser, "--only", "NAME", "of --real: this data set")
    parser.add_argument("--out", default="out/trial", metavar="DIR", help="folder for all of it (default out/trial)")
    text = f"of each case; default: as long as it takes, with --real {TIME_BUDGET_S:g} for each data set"
    add_time_budget(parser, None, text)
    add_workers(parser)
    add_effects(parser)
    add_json(parser)


def main(arguments: argparse.Namespace) -> int:
    """Run the trial."""
    from mmt_drake.diagrams.proof.studies import Asked
    from mmt_drake.effects import register_file

    for file in arguments.effects:
        register_file(file)
    target = console(stderr=arguments.json)
    jobs = arguments.jobs or processors()
    asked = Asked(Path(arguments.out), seed=arguments.seed, jobs=jobs, say=target.print)
    study = trial_study(arguments)
    with known_kept(asked.out, arguments.command_line), progress(study.label, study.steps(asked)) as update:
        report = study.run(asked, update)
    if arguments.json:
        print_json(report.document)
        return 0
    for table in report.tables:
        target.print()
        target.print(on_terminal(table))
    for sentence in report.sentences:
        say(f"\n{sentence}")
    return 0


def trial_study(arguments: argparse.Namespace) -> Study:
    """The study that this command's arguments ask for.

    Raises:
        BadInput: options that do not go together.
    """
    from mmt_drake.diagrams.proof.trial.real.run import real_study
    from mmt_drake.diagrams.proof.trial.run import sealed_study

    if arguments.arms:
        from mmt_drake.diagrams.proof.trial.arms.run import arm_study

        if arguments.real is not None or arguments.plant != "own" or arguments.effects:
            raise BadInput("--arms", found="--real, --plant or --effects beside it", expected="--arms alone")
        return arm_study(arguments.per_effect, 0.2 if arguments.remainder is None else arguments.remainder)
    remainder = 0.0 if arguments.remainder is None else arguments.remainder
    if arguments.real is not None:
        if arguments.plant != "own":
            raise BadInput("--plant", found=arguments.plant, expected="no --real beside it: those are recordings")
        budget = arguments.time_budget or TIME_BUDGET_S
        diagnosed = partial(_diagnose_real, jobs=arguments.jobs, cluster=arguments.cluster, time_budget=budget)
        return real_study(arguments.real, diagnosed, arguments.only, budget, further=arguments.further)
    for option in ("only", "further"):
        if getattr(arguments, option):
            raise BadInput(f"--{option}", found="no --real", expected="a folder of public recordings beside it")
    own = tuple(str(Path(file).resolve()) for file in arguments.effects)
    case = partial(diagnose_case, time_budget=arguments.time_budget or math.inf, effects=own)
    workers = partial(_processes, arguments.jobs, arguments.cluster)
    return sealed_study(arguments.per_effect, remainder, arguments.plant, case, workers)


def diagnose_case(folder: Path, time_budget: float = math.inf, effects: Sequence[str] = ()) -> Mapping[str, Any]:
    """The diagnosis of a case's folder as plain data, by one thread; the document is written beside the recording.

    Args:
        folder: of the case.
        time_budget: of the search [s].
        effects: files with effects of a person's own, to be known too.
    """
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.tell.written import write_diagnosis
    from mmt_drake.diagrams.proof.trial.run import MODEL, RECORDING
    from mmt_drake.effects import register_file
    from mmt_drake.model_files import load_model
    from mmt_drake.recording import load

    for file in effects:
        register_file(file)
    with workers(1) as executor:
        recording, model = load(folder / RECORDING), load_model(folder / MODEL)
        outcome = diagnose([recording], model, executor=executor, time_budget=time_budget)
    write_diagnosis(outcome.diagnosis, folder / "diagnosis.json")
    return outcome.diagnosis.to_json()


@contextmanager
def _processes(jobs: int | None, cluster: str | None) -> Iterator[Executor]:
    """Workers for whole cases: processes here, or those of a cluster."""
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagrams.proof.studies.processes import processes

    if cluster is not None:
        with workers(jobs, cluster) as executor:
            yield executor
        return
    with processes(jobs or processors()) as executor:
        yield executor


def _diagnose_real(
    recordings: Sequence[Recording],
    model: Mapping[str, Any],
    out: Path,
    *,
    jobs: int | None,
    cluster: str | None,
    time_budget: float,
) -> Diagnosed:
    """Diagnose the recordings of one real system, and write what was found."""
    from mmt_drake.diagnosis.diagnose import diagnose
    from mmt_drake.diagnosis.fit.workers import workers
    from mmt_drake.diagnosis.tell.written import augmented_model, write_outcome
    from mmt_drake.diagrams.proof.trial.real.run import Diagnosed
    from mmt_drake.model_files import parse_model

    with workers(jobs, cluster) as executor:
        outcome = diagnose(recordings, parse_model(dict(model)), executor=executor, time_budget=time_budget)
    write_outcome(outcome, out)
    refit, best = (None if f is None else augmented_model(f) for f in (outcome.refit, outcome.best))
    return Diagnosed(outcome.diagnosis, refit, best)
