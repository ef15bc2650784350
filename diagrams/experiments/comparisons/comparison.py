"""A comparison: runs of one motion that differ in one thing, and what is read off their recordings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.table import Table
from mmt_drake.diagrams.experiments.runs import MeasuredRun, run_cases
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.diagrams.stations.scenario import Scenario, operator_name
from mmt_drake.diagrams.studies.figures import Reached, reached_table
from mmt_drake.diagrams.studies.figures import to_json as reached_json
from mmt_drake.diagrams.studies.study import Progress, Report
from mmt_drake.errors import BadInput
from mmt_drake.recording import Recording, load

Cases = Mapping[str, MeasuredRun]
Recordings = Mapping[str, Recording]


@dataclass(frozen=True)
class ComparisonFindings:
    """What the runs of a comparison say.

    Attributes:
        table: one row per case.
        sentences: what it comes to, in words made from the numbers.
        figures: name of a case -> what `to_json` tells beside the figures that every case has.
        reached: beside what the thesis prints and what is to be reached.
        pictures: name of a file -> figure and caption.
    """

    table: Table
    sentences: list[str]
    figures: Mapping[str, Mapping[str, Any]]
    reached: Sequence[Reached]
    pictures: Mapping[str, tuple[Figure, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Comparison:
    """Runs that differ in one thing.

    Attributes:
        name: on the command line, and in the names of recordings.
        title: the question it answers.
        lead: what is the same and what differs, in a few sentences.
        cases: seed and length of a run [s] (None: the comparison's own) -> name of a case -> what to build.
        judge: the measured cases and their recordings -> what they say.
    """

    name: str
    title: str
    lead: str
    cases: Callable[[int, float | None], Mapping[str, Scenario]]
    judge: Callable[[Cases, Recordings], ComparisonFindings]


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

    def to_json(self) -> dict[str, Any]:
        """The document that `experiment --json` prints."""
        return {
            "experiment": self.comparison.name,
            "scenario": next(iter(self.cases.values())).scenario.name,
            "seed": self.seed,
            "operator": self.operator,
            "cases": [case.to_json() | dict(self.judgement.figures.get(name, {})) for name, case in self.cases.items()],
            "figures_to_reach": reached_json(self.judgement.reached),
        }


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
    """Run every case of a comparison and judge them; arguments and errors are those of `run_experiment`.

    Raises:
        BadInput: also a recording of a hand for a comparison whose cases differ in their motion.
    """
    recording = operator if isinstance(operator, Recording | None) else load_operator(operator)
    scenarios = comparison.cases(seed, seconds)
    if recording is not None:
        motions = {str(scenario.operator) for scenario in scenarios.values()}
        if len(motions) > 1:
            expected = "no other motion: the cases differ in theirs"
            raise BadInput(f"experiment {comparison.name}", found="--operator", expected=expected)
        scenarios = {name: replace(scenario, duration=seconds) for name, scenario in scenarios.items()}
    files = {name: Path(out) / f"{comparison.name}_{name}.mcap" for name in scenarios}
    done = run_cases(scenarios, files, operator=recording, jobs=jobs, progress=progress)
    cases = {case.name: case for case in done}
    judgement = comparison.judge(cases, {name: load(case.recording) for name, case in cases.items()})
    return Compared(comparison, seed, operator_name(done[0].scenario, recording), cases, judgement)


def report_of(compared: Compared) -> Report:
    """What a comparison comes to."""
    judgement, reached = compared.judgement, reached_table(compared.judgement.reached)
    pictures = [Picture(figure, caption, name=name) for name, (figure, caption) in judgement.pictures.items()]
    sections = [
        Section("What was found", "\n\n".join(judgement.sentences), table=reached),
        Section("Every figure", figures=pictures, table=judgement.table),
    ]
    lead = f"{compared.comparison.lead} Operator {compared.operator}, seed {compared.seed}. Recordings stand beside."
    title = compared.comparison.title
    heading, tables = f"{title} Operator {compared.operator}", [judgement.table, reached]
    return Report(compared.to_json(), heading, tables, judgement.sentences, title, lead, sections)
