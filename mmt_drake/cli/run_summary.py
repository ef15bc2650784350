"""The summary at the end of a run, all of it computed from the recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Self, TypeVar

from mmt_drake.analysis import summary
from mmt_drake.analysis.carried import CarriedObject, NothingCarried, carried_object, nothing_lifted
from mmt_drake.analysis.clouds_missed import CloudsMissed, clouds_missed
from mmt_drake.analysis.force_lateness import ForceLateness, force_lateness
from mmt_drake.analysis.learned import LearnerRecord, ToldLaws, learned, learner
from mmt_drake.analysis.metrics import Metrics, measure
from mmt_drake.analysis.model_trust import ModelTrust, model_trust
from mmt_drake.analysis.objects_touched import ObjectsTouched, objects_touched
from mmt_drake.analysis.passivity import Passivity, passivity
from mmt_drake.analysis.surface_raised import SurfaceRaised, surface_raised
from mmt_drake.analysis.zeroing import Zeroing, zeroing
from mmt_drake.cli.output import RunFigure
from mmt_drake.errors import BadInput
from mmt_drake.realtime import Pace
from mmt_drake.recording import Recording

if TYPE_CHECKING:
    from mmt_drake.diagrams.stations.scenario import Scenario

T = TypeVar("T")
_Figure = (
    Zeroing
    | ModelTrust
    | ForceLateness
    | SurfaceRaised
    | LearnerRecord
    | ToldLaws
    | NothingCarried
    | ObjectsTouched
    | CloudsMissed
    | CarriedObject
)


_FIGURES: Final[Mapping[str, Callable[[Recording], _Figure | None]]] = {
    "zero": zeroing,
    "model": model_trust,
    "force_lateness": force_lateness,
    "surface": surface_raised,
    "learner": learner,
    "learned": learned,
    "grip": nothing_lifted,
    "objects": objects_touched,
    "camera": clouds_missed,
    "carried": carried_object,
}
"""Further figures of a run: their key, and what finds them in the recording; None where that knows nothing of them."""


@dataclass(frozen=True)
class RunScores:
    """What a recording says of a run.

    Attributes:
        metrics: errors of force and lags, or why there are none.
        energy: at both ends, or why it is not known.
    """

    metrics: Metrics | BadInput
    energy: Passivity | BadInput

    @classmethod
    def of(cls, recording: Recording | BadInput) -> Self:
        """Of a recording, if there is one."""
        if isinstance(recording, BadInput):
            return cls(recording, recording)
        return cls(tried(lambda: measure(recording)), tried(lambda: passivity(recording)))

    def lines(self) -> list[str]:
        """For a terminal."""
        metrics, energy = self.metrics, self.energy
        if isinstance(metrics, BadInput):
            lines = [f"force errors and lags: none; {_why(metrics)}"]
        else:
            lines = summary.lines(metrics)
        return lines + ([f"energy: not known; {_why(energy)}"] if isinstance(energy, BadInput) else energy.lines())

    def to_json(self) -> dict[str, Any]:
        """The same as data; `missing` says why `errors` or `energy` is null."""
        both = {"errors": self.metrics, "energy": self.energy}
        told = {name: None if isinstance(found, BadInput) else found.to_json() for name, found in both.items()}
        missing = {name: _why(reason) for name, reason in both.items() if isinstance(reason, BadInput)}
        return {**told, "missing": missing}


@dataclass(frozen=True)
class RunSummary:
    """The outcome of a run.

    Attributes:
        scenario: what was run.
        operator: whose motion it was.
        simulated_s, wall_s: how long it took, in simulated and in real time [s].
        pacing: how well it kept to the wall clock; None where it was not meant to.
        process: what the system was asked for to keep to it, a few words each.
        scores: what its recording says of it.
        recording: the file that was kept.
        figures: what else came of it, by its key as data: of the `link` to the other side, the operator's `device`, the
            telerobot's `arm`, where there was one, and what the recording says.
        gaps: rows and clouds that are missing in the recording, the disk having been too slow for them.
    """

    scenario: Scenario
    operator: str
    simulated_s: float
    wall_s: float
    pacing: Pace | None
    process: Sequence[str]
    scores: RunScores
    recording: str | None
    figures: Mapping[str, RunFigure]
    gaps: int

    def lines(self) -> list[str]:
        """For a terminal."""
        speed = self.simulated_s / self.wall_s
        lines = [
            f"{self.scenario.name}, operator {self.operator}: {self.simulated_s:.3f} s simulated in "
            f"{self.wall_s:.2f} s, {speed:.3g} times real time"
        ]
        lines += self.scores.lines()
        lines.append("overruns: not paced" if self.pacing is None else self.pacing.line())
        if self.process:
            lines.append(f"process: {', '.join(self.process)}")
        lines += [figure.line for figure in self.figures.values()]
        gaps = f", {self.gaps} rows and clouds missing: the disk was too slow" if self.gaps else ""
        lines.append(f"recording: {self.recording or 'not kept (--record OUT keeps it)'}{gaps}")
        return lines

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {
            "scenario": self.scenario.name,
            "seed": self.scenario.seed,
            "operator": self.operator,
            "simulated_s": self.simulated_s,
            "wall_s": self.wall_s,
            "overruns": None if self.pacing is None else self.pacing.to_json(),
            "process": list(self.process),
            **self.scores.to_json(),
            "recording": self.recording,
            "recording_gaps": self.gaps,
        } | {name: figure.data for name, figure in self.figures.items()}


def further(recording: Recording) -> dict[str, RunFigure]:
    """The further figures of a recording, by their key as data."""
    found = {name: find(recording) for name, find in _FIGURES.items()}
    return {name: RunFigure(figure.to_json(), figure.line()) for name, figure in found.items() if figure is not None}


def tried(compute: Callable[[], T]) -> T | BadInput:
    """The result, or what stands against it."""
    try:
        return compute()
    except BadInput as error:
        return error


def _why(reason: BadInput) -> str:
    where = "" if reason.at is None else f"{reason.at}: "
    return f"{where}found {reason.found}, expected {reason.expected}"
