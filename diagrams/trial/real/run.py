"""The cases on public recordings, diagnosed: what was said, and what it is worth on recordings it did not see."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagnosis.tell.result import Diagnosis
from mmt_drake.diagrams.studies import Asked, Report, Study
from mmt_drake.diagrams.studies.study import Progress
from mmt_drake.diagrams.trial.real.case import HeldOut, Published, RealCase
from mmt_drake.diagrams.trial.real.data_sets import real_cases, without_a_case
from mmt_drake.errors import BadInput
from mmt_drake.model_files import Model, parse_model
from mmt_drake.recording import Recording
from mmt_drake.simulate import simulate

Array = NDArray[np.float64]
Simulate = Callable[[Model, Recording], Recording]

_OUTPUT = {"driven_body": "output", "single_axis": "force"}


@dataclass(frozen=True)
class Diagnosed:
    """A diagnosis and the models it compared, as model files' mappings; None where it fitted none."""

    diagnosis: Diagnosis
    refit: Mapping[str, Any] | None
    augmented: Mapping[str, Any] | None


class Diagnose(Protocol):
    """Diagnoses recordings of one system against a model; what it writes goes into the folder `out`."""

    def __call__(self, recordings: Sequence[Recording], model: Mapping[str, Any], out: Path) -> Diagnosed:
        """What is missing from the model, and the models with it and without."""


@dataclass(frozen=True)
class Errors:
    """A figure for the nominal model, for the same refitted, and for that with its effects; None: no such model."""

    nominal: float
    refit: float | None
    augmented: float | None


@dataclass(frozen=True)
class RealResult:
    """What came of one held-out test.

    Attributes:
        case: name of the case.
        test: name of the held-out test.
        verdict: of the diagnosis.
        effects: names, strongest first.
        alternatives: names of what could not be ruled out.
        unit: of `rmse` and `published`.
        rmse: free-running on the held-out recordings, from rest at the first sample.
        nrmse: the same over the standard deviation of what was measured there.
        published: best known figure.
        seconds: that the diagnosis took.
    """

    case: str
    test: str
    verdict: str
    effects: tuple[str, ...]
    alternatives: tuple[str, ...]
    unit: str
    rmse: Errors
    nrmse: Errors
    published: Published | None
    seconds: float

    def document(self) -> dict[str, Any]:
        """Plain numbers, strings, None, lists and dicts, for JSON."""
        return asdict(self)


def run_real(
    directory: str | Path,
    diagnose: Diagnose,
    out: Path,
    *,
    cases: Iterable[RealCase] | None = None,
    simulated: Simulate = simulate,
    starting: Callable[[RealCase], None] = lambda case: None,
) -> list[RealResult]:
    """Diagnose every case on what is fitted and score the models on what is held out.

    Args:
        directory: holds the folders of the data sets.
        diagnose: is given the recordings to fit and the nominal model, never what is held out.
        out: gets a folder for every case.
        cases: all of `real_cases` unless given.
        simulated: replays a recording through a model.
        starting: called before each case.

    Returns:
        One result per held-out test.

    Raises:
        BadInput: a folder or file of the data is missing or not as expected.
    """
    results = []
    for case in real_cases(directory) if cases is None else cases:
        starting(case)
        fitted, held_out = case.load_fitted(directory), case.load_held_out(directory)
        start = time.perf_counter()
        diagnosed = diagnose(fitted, case.model, out / case.name.replace("/", "-"))
        seconds = time.perf_counter() - start
        for test in case.held_out:
            results.append(_score(case, test, held_out[test.name], diagnosed, simulated, seconds))
    return results


def real_table(results: Sequence[RealResult]) -> Table:
    """The table of `trial --real`: one row per held-out test."""
    headers = ("recordings", "held out", "verdict", "effects", "unit", "nominal", "refit", "augmented", "published")
    rows: list[list[Cell]] = [
        [
            result.case,
            result.test,
            result.verdict,
            " + ".join(result.effects) or "none",
            result.unit,
            result.rmse.nominal,
            result.rmse.refit,
            result.rmse.augmented,
            None if result.published is None else result.published.value,
        ]
        for result in results
    ]
    return Table(headers, rows, "RMS error on recordings that nothing was fitted to, free-running; best published")


def held_out_error(
    model: Model, recordings: Sequence[Recording], simulated: Simulate = simulate
) -> tuple[float, float]:
    """RMS error of a model over all samples of some recordings, and the same over the standard deviation measured.

    Args:
        model: a driven body or a Kelvin-Voigt contact.
        recordings: of one kind; each starts at rest.
        simulated: replays a recording through a model.

    Raises:
        BadInput: recordings of three axes, or that the model does not fit.
    """
    pairs = [_measured_and_simulated(model, recording, simulated) for recording in recordings]
    measured = np.concatenate([pair[0] for pair in pairs])
    error = float(np.sqrt(np.mean((measured - np.concatenate([pair[1] for pair in pairs])) ** 2)))
    return error, error / float(np.std(measured))


def _measured_and_simulated(model: Model, recording: Recording, simulated: Simulate) -> tuple[Array, Array]:
    if recording.kind not in _OUTPUT:
        expected = "a driven body or a single axis"
        raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=expected)
    column = _OUTPUT[recording.kind]
    return recording[column], simulated(model, recording)[column]


def _score(
    case: RealCase,
    test: HeldOut,
    recordings: Sequence[Recording],
    diagnosed: Diagnosed,
    simulated: Simulate,
    seconds: float,
) -> RealResult:
    def error(model: Mapping[str, Any]) -> tuple[float, float]:
        rmse, nrmse = held_out_error(parse_model(dict(model), case.name), recordings, simulated)
        return rmse * case.per_si, nrmse

    nominal = error(case.model)
    fitted = [None if model is None else error(model) for model in (diagnosed.refit, diagnosed.augmented)]
    rmse, nrmse = (Errors(nominal[i], *(None if pair is None else pair[i] for pair in fitted)) for i in (0, 1))
    said = diagnosed.diagnosis
    return RealResult(
        case=case.name,
        test=test.name,
        verdict=said.verdict,
        effects=tuple(effect.name for effect in said.effects),
        alternatives=tuple(alternative.name for alternative in said.alternatives),
        unit=case.unit,
        rmse=rmse,
        nrmse=nrmse,
        published=test.published,
        seconds=seconds,
    )


def real_study(directory: str, diagnose: Diagnose) -> Study:
    """The study that diagnoses every case of a folder of public recordings."""

    def run(asked: Asked, progress: Progress) -> Report:
        started = count()
        results = run_real(directory, diagnose, asked.out, starting=lambda case: progress(next(started)))
        untried = without_a_case(directory)
        return Report(
            {"real": [result.document() for result in results]},
            title="Real recordings",
            lead="Known physics concealed from the model that is handed in; judged on recordings that nothing was "
            "fitted to.",
            heading="",
            own_tables=[real_table(results)],
            sentences=[f"not tried, for want of a case: {', '.join(untried)}"] if untried else [],
        )

    return Study("real recordings, data sets", (), lambda asked: len(real_cases(directory)), run)
