"""Runs of scenarios that differ in one thing, and what is read off their recordings: experiments 1 and 3, and more."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from mmt_drake.analysis.page import Picture, Section
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.diagrams.proof.experiments.runs import Cases, run_cases
from mmt_drake.diagrams.proof.studies.study import OF_A_RUN, Asked, Progress, Reached, Report, Study, unheard
from mmt_drake.diagrams.stations.estimators import KINDS, OwnEstimator
from mmt_drake.diagrams.stations.scenario import Scenario, updates_name
from mmt_drake.errors import BadInput


@dataclass(frozen=True)
class CaseFindings:
    """One case of a comparison.

    Attributes:
        row: of the table.
        figures: in the document, beside those that every case has.
        reached: beside what the thesis prints and what is to be reached.
    """

    row: Sequence[Cell]
    figures: Mapping[str, Any] = field(default_factory=dict)
    reached: Sequence[Reached] = ()


@dataclass(frozen=True)
class Findings:
    """What the runs of a comparison say.

    Attributes:
        tables: on a terminal; of the first one, one row per case.
        sentences: what it comes to, in words made from the numbers.
        sections: of the page.
        reached: beside what the thesis prints and what is to be reached.
        figures: name of a case -> what the document tells beside the figures that every case has.
        document: what it tells beside the cases.
    """

    tables: Sequence[Table]
    sentences: Sequence[str]
    sections: Sequence[Section]
    reached: Sequence[Reached] = ()
    figures: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    document: Mapping[str, Any] = field(default_factory=dict)


def findings_of(
    each: Mapping[str, CaseFindings],
    headers: Sequence[str],
    caption: str,
    sentences: Sequence[str] = (),
    pictures: Sequence[Picture] = (),
) -> Findings:
    """What cases say one by one, in one table."""
    found = each.values()
    table = Table(headers, [case.row for case in found], caption)
    return Findings(
        tables=[table],
        sentences=sentences,
        sections=[Section("Every figure", figures=pictures, table=table)],
        reached=[figure for case in found for figure in case.reached],
        figures={name: case.figures for name, case in each.items()},
    )


@dataclass(frozen=True)
class Comparison:
    """Runs that differ in one thing.

    Attributes:
        name: on the command line; a number is the thesis's.
        title: the question it answers.
        lead: what is the same and what differs, in a few sentences.
        cases: what is asked (length of a run None: the comparison's own) -> name of a case -> what to build.
        judge: the measured cases -> what they say.
        takes: see `Study`.
        heading: on a terminal, with the title and the operator put in.
        conditions: the lead's end, with operator and seed put in.
        file: number and name of a case -> name of its recording; after the comparison's by default.
    """

    name: int | str
    title: str
    lead: str
    cases: Callable[[Asked], Mapping[str, Scenario]]
    judge: Callable[[Cases], Findings]
    takes: tuple[str, ...] = OF_A_RUN
    heading: str = "{title} Operator {operator}"
    conditions: str = "Operator {operator}, seed {seed}. Recordings stand beside."
    file: Callable[[int, str], str] = lambda number, name: name

    @property
    def study(self) -> Study:
        """The study that runs it."""
        return Study(
            f"experiment {self.name}, runs",
            self.takes,
            lambda asked: len(self.scenarios(asked)),
            lambda asked, progress: self.report(asked, self.run(asked, progress)),
        )

    def scenarios(self, asked: Asked) -> Mapping[str, Scenario]:
        """Name of a case -> what is built; of one estimator (`KINDS`) and one's own alone where one is asked."""
        made = self.cases(asked)
        if asked.estimator is None:
            return made
        chosen = (asked.estimator, KINDS[OwnEstimator].name)
        return {name: case for name, case in made.items() if KINDS[type(case.estimator)].name in chosen}

    def run(self, asked: Asked, progress: Progress = unheard) -> Cases:
        """Run every case into recordings, `exp1_thesis_rls_all.mcap`, `network_newest_wins.mcap` and so on.

        Args:
            asked: an operator's recording replaces the scenarios' motion; then a run is as long as that.
            progress: called with the number of cases done.

        Raises:
            BadInput: a recording that is none, or one for a comparison whose cases differ in their motion; a value out
                of range; a folder that cannot be made.
        """
        scenarios = self.scenarios(asked)
        if asked.operator is not None:
            if len({str(scenario.operator) for scenario in scenarios.values()}) > 1:
                expected = "no other motion: the cases differ in theirs"
                raise BadInput(f"experiment {self.name}", found="--operator", expected=expected)
            scenarios = {name: replace(scenario, duration=asked.seconds) for name, scenario in scenarios.items()}
        stem = f"exp{self.name}" if isinstance(self.name, int) else self.name
        stems = {name: f"{stem}_{self.file(number, name)}" for number, name in enumerate(scenarios)}
        files = {name: asked.out / f"{stem}.mcap" for name, stem in stems.items()}
        return run_cases(scenarios, files, asked, progress)

    def report(self, asked: Asked, cases: Cases) -> Report:
        """What the cases come to."""
        found, (first, *_) = self.judge(cases), cases.values()
        data = {
            "experiment": self.name,
            "scenario": first.scenario.name,
            "seed": asked.seed,
            "operator": first.operator,
            "cases": [case.to_json() | dict(found.figures.get(name, {})) for name, case in cases.items()],
            **found.document,
        }
        return Report(
            data=data,
            title=self.title,
            heading=self.heading.format(title=self.title, operator=first.operator),
            lead=f"{self.lead} {self.conditions.format(operator=first.operator, seed=asked.seed)}",
            own_tables=found.tables,
            sentences=found.sentences,
            reached=[replace(each, updates=updates_name(cases[each.case].scenario)) for each in found.reached],
            sections=found.sections,
        )
