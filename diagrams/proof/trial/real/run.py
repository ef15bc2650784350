"""The cases on public recordings, diagnosed: what was said, and what it is worth on recordings it did not see."""

import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

import numpy as np

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagnosis.tell.result import Diagnosis, HeldoutNrmse
from mmt_drake.diagrams.proof.studies import Asked, Report, Study
from mmt_drake.diagrams.proof.studies.study import Progress
from mmt_drake.diagrams.proof.trial.real.arm_cases import ArmCase, ArmResult, run_case
from mmt_drake.diagrams.proof.trial.real.case import HeldOut, Published, RealCase
from mmt_drake.diagrams.proof.trial.real.data_sets import real_arms, real_cases, without_a_case
from mmt_drake.diagrams.proof.trial.real.further import FURTHER
from mmt_drake.effects.wording import words
from mmt_drake.errors import BadInput
from mmt_drake.model_files import Model, parse_model
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.simulation import simulate

Judged = Literal["right", "partly false", "false", "open"]
"""What names are worth: all of a family that is known to be there (none, where nothing is known to be missing), some,
none of them; or nothing was named that is missing."""

_LEAST_SHOWN = 0.005  # of a budget
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

    nominal: float | None
    refit: float | None
    augmented: float | None


@dataclass(frozen=True)
class RealResult:
    """What came of one held-out test.

    Attributes:
        case: of the recordings.
        test: of it; None where whole recordings are not held out.
        said: the diagnosis.
        rmse: free-running on the held-out recordings, in the unit of the case; None without a test.
        nrmse: the same over the standard deviation of what was measured there.
        seconds: that the diagnosis took.
    """

    case: RealCase
    test: HeldOut | None
    said: Diagnosis
    rmse: Errors | None
    nrmse: Errors | None
    seconds: float

    @property
    def windows(self) -> HeldoutNrmse | None:
        """Held-out error within what was fitted, over the windows of the diagnosis; None where nothing was fitted."""
        return None if self.said.fit is None else self.said.fit.heldout_nrmse

    @property
    def free(self) -> HeldoutNrmse | None:
        """The same free-running."""
        return None if self.said.fit is None else self.said.fit.heldout_nrmse_free

    @property
    def published(self) -> Published | None:
        """Best known figure, in the unit of the case."""
        return None if self.test is None else self.test.published

    @property
    def shares(self) -> dict[str, float]:
        """Of the effects, of the parameters, of what is nameless and of noise; empty without a budget."""
        return {part.part: part.share for part in self.said.budget}

    @property
    def judged(self) -> Judged:
        """What the names that are sure of their family or law are worth; those sure of no more are none."""
        named = [e.family in self.case.families for e in self.said.effects if e.certain in ("family", "law")]
        if not named:
            return "open" if self.case.families else "right"
        return "right" if all(named) else "partly false" if any(named) else "false"

    def document(self) -> dict[str, Any]:
        """Plain numbers, strings, None, lists and dicts, for JSON."""
        errors = {name: getattr(self, name) for name in ("windows", "free", "rmse", "nrmse", "published")}
        plain = {name: None if value is None else asdict(value) for name, value in errors.items()}
        return {
            "case": self.case.name,
            "test": "" if self.test is None else self.test.name,
            "verdict": self.said.verdict,
            "effects": [effect.name for effect in self.said.effects],
            "alternatives": [alternative.name for alternative in self.said.alternatives],
            "known": self.case.concealed,
            "depths": [effect.certain for effect in self.said.effects],
            "judged": self.judged,
            "shares": self.shares,
            "windows": plain["windows"],
            "free": plain["free"],
            "simple": self.case.simple,
            "unit": self.case.unit,
            "rmse": plain["rmse"],
            "nrmse": plain["nrmse"],
            "published": plain["published"],
            "seconds": self.seconds,
        }


def run_real(
    directory: str | Path,
    diagnose: Diagnose,
    out: Path,
    *,
    cases: Iterable[RealCase],
    starting: Callable[[RealCase], None] = lambda case: None,
) -> list[RealResult]:
    """Diagnose every case on what is fitted and score the models on what is held out.

    Args:
        directory: holds the folders of the data sets.
        diagnose: is given the recordings to fit and the nominal model, never what is held out.
        out: gets a folder for every case.
        cases: of `real_cases`.
        starting: called before each case.

    Returns:
        One result per held-out test, or one of a case without.

    Raises:
        BadInput: a folder or file of the data is missing or not as expected.
    """
    results = []
    for case in cases:
        starting(case)
        fitted, held_out = case.load_fitted(directory), case.load_held_out(directory)
        start = time.perf_counter()
        diagnosed = diagnose(fitted, case.model, out / case.name.replace("/", "-"))
        seconds = time.perf_counter() - start
        for test in case.held_out or (None,):
            unseen = () if test is None else held_out[test.name]
            results.append(_score(case, test, unseen, diagnosed, seconds))
    return results


def diagnosed_table(results: Sequence[RealResult]) -> Table:
    """The first table of `trial --real`: one row per case, what is known and what was said."""
    headers = (
        *("recordings", "known", "verdict", "effects, as certain as", "judged"),
        *("shares", "windows", "free", "simple fit", "s"),
    )  # fmt: skip
    rows: list[list[Cell]] = []
    for result in _by_case(results):
        names = " + ".join(f"{effect.name} ({effect.certain or 'not'})" for effect in result.said.effects)
        shares = ", ".join(f"{part} {share:.2f}" for part, share in result.shares.items() if share >= _LEAST_SHOWN)
        errors = (_arrow(result.windows), _arrow(result.free), result.case.simple)
        said = (result.said.verdict, names or "none", result.judged, shares or "none")
        rows.append([result.case.name, result.case.concealed, *said, *errors, result.seconds])
    title = "What is known of each, what was said, and the error on its held-out blocks, refit -> with the effects"
    return Table(headers, rows, title)


def judged_sentence(results: Sequence[RealResult]) -> str:
    """How many cases are judged how."""
    found = Counter(result.judged for result in _by_case(results))
    told = ", ".join(f"{found[judged]} {judged}" for judged in get_args(Judged))
    return (
        f"of {found.total()} cases: {told}. Judged are names as sure as their family or surer; open are cases in "
        "which none is."
    )


def _by_case(results: Sequence[RealResult]) -> list[RealResult]:
    """One result of each case."""
    return list({result.case.name: result for result in results}.values())


def _arrow(errors: HeldoutNrmse | None) -> str:
    if errors is None:
        return "none"
    return " -> ".join("none" if e is None else f"{e:.3g}" for e in (errors.refit, errors.augmented))


def real_table(results: Sequence[RealResult]) -> Table:
    """The second table of `trial --real`: one row per held-out test."""
    headers = ("recordings", "held out", "verdict", "effects", "unit", "nominal", "refit", "augmented", "published")
    rows: list[list[Cell]] = [
        [
            result.case.name,
            result.test.name,
            result.said.verdict,
            " + ".join(effect.name for effect in result.said.effects) or "none",
            result.case.unit,
            result.rmse.nominal,
            result.rmse.refit,
            result.rmse.augmented,
            None if result.test.published is None else result.test.published.value,
        ]
        for result in results
        if result.test is not None and result.rmse is not None
    ]
    return Table(headers, rows, "RMS error on recordings that nothing was fitted to, free-running; best published")


def named_table(results: Sequence[ArmResult]) -> Table:
    """A row for each joint: what was named there, and how far the models are off."""
    rows: list[list[Cell]] = []
    for r in results:
        whole = [f"{names} on {place or 'the arm'}" for place, names in r.named.items() if place not in r.joints]
        if whole:
            rows.append([r.name, "", words(r.verdict), "; ".join(whole), None, None, None, r.seconds])
        for j, joint in enumerate(r.joints):
            first = [r.name, joint, words(r.verdict)] if j == 0 and not whole else ["", joint, ""]
            seconds = r.seconds if j == 0 and not whole else None
            errors = (r.handed_in[j], r.found[j], r.simple[j])
            rows.append([*first, r.named.get(joint, "nothing"), *errors, seconds])
    headers = (
        "arm",
        "joint",
        "verdict",
        "named, as certain as",
        "as handed in",
        "with what was found",
        "simple fit",
        "s",
    )
    title = "Arms, joint by joint: error of the torque over its spread, on a log or on blocks that were not fitted."
    return Table(headers, rows, title, digits=3)


def held_out_error(model: Model, recordings: Sequence[Recording]) -> tuple[float, float]:
    """RMS error of a model over all samples of some recordings, and the same over the standard deviation measured.

    Args:
        model: a driven body, a transmission or a Kelvin-Voigt contact.
        recordings: of one kind; each starts at rest.

    Raises:
        BadInput: recordings of three axes, or that the model does not fit.
    """
    pairs = [_measured_and_simulated(model, recording) for recording in recordings]
    measured = np.concatenate([pair[0] for pair in pairs])
    error = float(np.sqrt(np.mean((measured - np.concatenate([pair[1] for pair in pairs])) ** 2)))
    return error, error / float(np.std(measured))


def _measured_and_simulated(model: Model, recording: Recording) -> tuple[Array, Array]:
    if recording.kind not in _OUTPUT:
        expected = "a driven body or a single axis"
        raise BadInput(recording.source, found=f"a {recording.kind} recording", expected=expected)
    column = _OUTPUT[recording.kind]
    return recording[column], simulate(model, recording)[column]


def _score(
    case: RealCase, test: HeldOut | None, recordings: Sequence[Recording], diagnosed: Diagnosed, seconds: float
) -> RealResult:
    def error(model: Mapping[str, Any]) -> tuple[float, float]:
        rmse, nrmse = held_out_error(parse_model(dict(model), case.name), recordings)
        return rmse * case.per_si, nrmse

    rmse = nrmse = None
    if test is not None:
        nominal = error(case.model)
        fitted = [None if model is None else error(model) for model in (diagnosed.refit, diagnosed.augmented)]
        rmse, nrmse = (Errors(nominal[i], *(None if pair is None else pair[i] for pair in fitted)) for i in (0, 1))
    return RealResult(case, test, diagnosed.diagnosis, rmse, nrmse, seconds)


def real_study(
    directory: str,
    diagnose: Diagnose,
    only: Collection[str] = (),
    time_budget: float = math.inf,
    *,
    further: bool = False,
) -> Study:
    """The study that diagnoses the cases of a folder of public recordings, or of some of its data sets; arms last.

    Args:
        directory: holds the folders of the data sets.
        diagnose: a case that is no arm.
        only: folders of data sets; all unless given.
        time_budget: of the diagnosis of each arm [s].
        further: the further recordings of the data sets in the place of all this.
    """

    def chosen() -> tuple[list[RealCase], list[ArmCase]]:
        if further:
            return real_cases(directory, only, FURTHER), []
        return real_cases(directory, only), real_arms(directory, only)

    def run(asked: Asked, progress: Progress) -> Report:
        started, (cases, arms) = count(), chosen()
        results = run_real(directory, diagnose, asked.out, cases=cases, starting=lambda case: progress(next(started)))
        moved = []
        for arm in arms:
            progress(next(started))
            moved.append(run_case(arm, Path(directory), time_budget))
        untried = [] if only or further else without_a_case(directory)
        sentences = [judged_sentence(results)] if results else []
        tables = [diagnosed_table(results)] if results else []
        tables += [real_table(results)] if any(case.held_out for case in cases) else []
        return Report(
            {"real": [result.document() for result in results], "arms": [asdict(result) for result in moved]},
            title="Further real recordings" if further else "Real recordings",
            lead="Each recording alone; no case of `trial --real` is fitted to one of them."
            if further
            else "Known physics concealed from the model that is handed in; judged on recordings that nothing was "
            "fitted to.",
            heading="",
            own_tables=[*tables, *([named_table(moved)] if moved else [])],
            sentences=[*sentences, *([f"not tried, for want of a case: {', '.join(untried)}"] if untried else [])],
        )

    def steps(asked: Asked) -> float:
        cases, arms = chosen()
        return len(cases) + len(arms)

    return Study("real recordings, data sets", (), steps, run)
