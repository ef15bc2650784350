"""Runs of scenarios that differ in one thing, and what is read off their recordings: experiments 1 and 3, and more."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.table import Table
from mmt_drake.diagrams.experiments.runs import MeasuredRun, run_cases
from mmt_drake.diagrams.stations.estimators import KINDS
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.scenario import Scenario, operator_name
from mmt_drake.diagrams.studies.figures import Reached
from mmt_drake.diagrams.studies.study import OF_A_RUN, Asked, Progress, Report, Study
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load

Cases = Mapping[str, MeasuredRun]


class Recordings(dict[str, Recording]):
    """Name of a case -> its recording, read when it is first asked for."""

    def __init__(self, cases: Cases) -> None:
        self._cases = cases

    def __missing__(self, name: str) -> Recording:
        return self.setdefault(name, load(self._cases[name].recording))


@dataclass(frozen=True)
class ComparisonFindings:
    """What the runs of a comparison say.

    Attributes:
        tables: on a terminal; of the first one, one row per case.
        sentences: what it comes to, in words made from the numbers.
        reached: beside what the thesis prints and what is to be reached.
        figures: name of a case -> what the document tells beside the figures that every case has.
        pictures: name of a file -> figure and caption.
        sections: of the page, in the place of one with the first table and the pictures.
    """

    tables: Sequence[Table]
    sentences: Sequence[str]
    reached: Sequence[Reached]
    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    pictures: Mapping[str, tuple[Figure, str]] = field(default_factory=dict)
    sections: Sequence[Section] = ()


@dataclass(frozen=True)
class Comparison:
    """Runs that differ in one thing.

    Attributes:
        name: on the command line; a number is the thesis's.
        title: the question it answers.
        lead: what is the same and what differs, in a few sentences.
        cases: seed and length of a run [s] (None: the comparison's own) -> name of a case -> what to build.
        judge: the measured cases and their recordings -> what they say.
    """

    name: int | str
    title: str
    lead: str
    cases: Callable[[int, float | None], Mapping[str, Scenario]]
    judge: Callable[[Cases, Recordings], ComparisonFindings]

    def of_estimator(self, name: str | None) -> Comparison:
        """The comparison without the cases of other estimators (`stations.estimators.KINDS`); all of it for None."""

        def fewer(seed: int, seconds: float | None) -> Mapping[str, Scenario]:
            made = self.cases(seed, seconds)
            return {case: scenario for case, scenario in made.items() if KINDS[type(scenario.estimator)].name == name}

        return self if name is None else replace(self, cases=fewer)


@dataclass(frozen=True)
class Compared:
    """A comparison that has been run.

    Attributes:
        comparison: what was compared.
        seed: of everything random.
        operator: whose motion it was.
        cases: name -> the run, measured.
        judgement: what they say.
    """

    comparison: Comparison
    seed: int
    operator: str
    cases: Cases
    judgement: ComparisonFindings

    def report(self) -> Report:
        """What it comes to."""
        found, (first, *_) = self.judgement, self.cases.values()
        pictures = [Picture(figure, caption, name=name) for name, (figure, caption) in found.pictures.items()]
        data = {
            "experiment": self.comparison.name,
            "scenario": first.scenario.name,
            "seed": self.seed,
            "operator": self.operator,
            "cases": [case.to_json() | dict(found.figures.get(name, {})) for name, case in self.cases.items()],
        }
        return Report(
            data=data,
            title=self.comparison.title,
            heading=f"{self.comparison.title} Operator {self.operator}",
            lead=f"{self.comparison.lead} Operator {self.operator}, seed {self.seed}. Recordings stand beside.",
            own_tables=found.tables,
            sentences=found.sentences,
            reached=found.reached,
            sections=found.sections or [Section("Every figure", figures=pictures, table=found.tables[0])],
        )


def run_comparison(
    comparison: Comparison,
    *,
    out: str | Path,
    operator: str | Path | Recording | None = None,
    seed: int = 0,
    seconds: float | None = None,
    jobs: int = 1,
    progress: Progress | None = None,
) -> Compared:
    """Run every case of a comparison and judge them.

    Args:
        comparison: what is run.
        out: folder for the recordings, `exp1_thesis_rls_all.mcap`, `network_newest_wins.mcap` and so on; made if need
            be.
        operator: a recording whose probe motion replaces the scenarios'; then a run is as long as that.
        seed: of everything random.
        seconds: how long each run is; by default as long as the scenario or the operator's recording says.
        jobs: processes at work at the same time; the numbers do not depend on it. More than one need a script whose
            entry stands under `if __name__ == "__main__"`.
        progress: called with the number of cases done.

    Raises:
        BadInput: a recording that is none, or one for a comparison whose cases differ in their motion; a value out of
            range; a folder that cannot be made.
    """
    recording = operator if isinstance(operator, Recording | None) else load_operator(operator)
    scenarios = comparison.cases(seed, seconds)
    if recording is not None:
        motions = {str(scenario.operator) for scenario in scenarios.values()}
        if len(motions) > 1:
            expected = "no other motion: the cases differ in theirs"
            raise BadInput(f"experiment {comparison.name}", found="--operator", expected=expected)
        scenarios = {name: replace(scenario, duration=seconds) for name, scenario in scenarios.items()}
    stem = f"exp{comparison.name}" if isinstance(comparison.name, int) else comparison.name
    files = {name: Path(out) / f"{stem}_{name}.mcap" for name in scenarios}
    done = run_cases(scenarios, files, operator=recording, jobs=jobs, progress=progress)
    cases = {case.name: case for case in done}
    judgement = comparison.judge(cases, Recordings(cases))
    return Compared(comparison, seed, operator_name(done[0].scenario, recording), cases, judgement)


def study_of_runs(comparison: Comparison, takes: tuple[str, ...] = OF_A_RUN) -> Study:
    """The study that runs a comparison."""

    def steps(asked: Asked) -> float:
        return len(comparison.of_estimator(asked.estimator).cases(asked.seed, asked.seconds))

    def run(asked: Asked, progress: Progress) -> Report:
        return run_comparison(comparison.of_estimator(asked.estimator), **asked.of_a_run(), progress=progress).report()

    return Study(f"experiment {comparison.name}, runs", takes, steps, run)
