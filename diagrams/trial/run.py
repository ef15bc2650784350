"""A trial from end to end: seal, write, diagnose, open, score, report."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from functools import cache, partial
from pathlib import Path
from typing import Any

from mmt_drake.diagrams.studies import Asked, Report, Study
from mmt_drake.diagrams.studies.study import Progress
from mmt_drake.diagrams.trial.cases import Case
from mmt_drake.diagrams.trial.pictures import confusion_picture
from mmt_drake.diagrams.trial.score import score
from mmt_drake.diagrams.trial.sealed import draw_trial, seal, write_case, write_truths
from mmt_drake.diagrams.trial.summary import document, effects_table, rates_table
from mmt_drake.errors import MmtError
from mmt_drake.recording.atomic import replacing, writing

Diagnose = Callable[[Path], Mapping[str, Any]]
"""From a case's folder (`sealed.RECORDING`, `sealed.MODEL`) to its `diagnosis.json`."""
Diagnosed = tuple[Mapping[str, Any], float]
Spread = Callable[[Callable[[Case], Diagnosed], Sequence[Case]], Iterable[Diagnosed]]
"""Applies a function to every case, in order: `map`, or a pool of workers."""


def run_trial(
    cases: Sequence[Case],
    out: Path,
    diagnose: Diagnose,
    *,
    spread: Spread = map,
    announce: Callable[[str], None] = print,
) -> dict[str, Any]:
    """Run sealed cases through a diagnosis and score them.

    Args:
        cases: of `sealed.draw_trial`.
        out: folder for the cases, `diagnoses.json`, `truths.json`, `trial.json` and `confusion.png`.
        diagnose: sees a case's folder and nothing else.
        spread: how the cases are spread over workers; `diagnose` must then be importable there.
        announce: is given the seal before the first diagnosis.

    Returns:
        The trial's JSON (contract section 6).

    Raises:
        BadInput: the folder cannot be written.
    """
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
    sealed = seal(cases)
    announce(f"sealed {len(cases)} truths, sha256 {sealed}")
    diagnosed = list(spread(partial(_one, folder=out / "cases", diagnose=diagnose), cases))
    # The diagnoses are on disk before the truths are.
    _write(out / "diagnoses.json", {case.name: answer for case, (answer, _) in zip(cases, diagnosed, strict=True)})
    write_truths(cases, out / "truths.json")
    scores = [score(case.truth(), answer, took) for case, (answer, took) in zip(cases, diagnosed, strict=True)]
    whole = document(sealed, scores)
    _write(out / "trial.json", whole)
    with replacing(out / "confusion.png") as temporary:
        confusion_picture(scores).savefig(temporary)
    return whole


def _one(case: Case, folder: Path, diagnose: Diagnose) -> Diagnosed:
    """Write a case and diagnose it; one that crashes is counted, not hidden, and does not end the trial."""
    own = write_case(case, folder)
    start = time.perf_counter()
    try:
        answer = diagnose(own)
    except (MmtError, ArithmeticError, ValueError, LookupError, RuntimeError, TypeError) as error:
        answer = {"verdict": "crashed", "summary": f"{type(error).__name__}: {error}"}
    return answer, time.perf_counter() - start


def _write(path: Path, content: Mapping[str, Any]) -> None:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, allow_nan=False), encoding="utf-8")


def sealed_study(
    per_effect: int, remainder: float, diagnose: Diagnose, workers: Callable[[], AbstractContextManager[Executor]]
) -> Study:
    """The study that draws sealed cases and has them diagnosed.

    Args:
        per_effect, remainder: of `sealed.draw_trial`.
        diagnose: of `run_trial`.
        workers: gives who diagnoses.
    """
    drawn = cache(lambda seed: draw_trial(seed, per_effect, remainder))

    def run(asked: Asked, progress: Progress) -> Report:
        def spread(function: Callable[[Case], Diagnosed], items: Sequence[Case]) -> Iterator[Diagnosed]:
            for done, result in enumerate(executor.map(function, items), 1):
                progress(done)
                yield result

        with workers() as executor:
            whole = run_trial(drawn(asked.seed), asked.out, diagnose, spread=spread, announce=asked.say)
        return Report(
            whole,
            title="Concealed effects",
            lead=f"Cases by an engine of their own, their truths sealed until all are diagnosed; seed {asked.seed}, "
            f"{per_effect} of each effect{f', above a remainder of {remainder:g}' if remainder else ''}.",
            heading="",
            own_tables=[rates_table(whole["summary"]), effects_table(whole["summary"])],
            sentences=[f"{asked.out}: trial.json, truths.json, confusion.png and every case"],
        )

    return Study("trial, cases", ("seed",), lambda asked: len(drawn(asked.seed)), run)
