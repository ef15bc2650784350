"""Studies of cases that are drawn at random: each case a task of its own, told of in one table."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Generic, TypeVar

from mmt_drake.analysis.page import Section
from mmt_drake.analysis.table import Table
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Reached, Report, Study, unheard

Case = TypeVar("Case")


@dataclass(frozen=True)
class DrawnCases(Generic[Case]):
    """A study of so many draws, whose cases do not depend on each other.

    Attributes:
        name: of the experiment.
        label: of its progress: what its cases are.
        usual: how many draws there are unless a person says it.
        tasks: of so many draws from a seed; each returns a case, a dataclass.
        report_of: what the cases come to, and the seed that they were drawn with.
    """

    name: str
    label: str
    usual: int
    tasks: Callable[[int, int], Sequence[Callable[[], Case]]]
    report_of: Callable[[Sequence[Case], int], Report]

    def run(self, asked: Asked, progress: Progress = unheard) -> list[Case]:
        """Every case, on several cores; what comes out does not depend on the jobs.

        Raises:
            BadInput: fewer than one draw.
        """
        return results_of(self._tasks(asked), asked.jobs, progress, compile_first=True)

    @property
    def study(self) -> Study:
        """As `experiment` takes it."""
        return Study(self.label, ("seed", "count"), lambda asked: len(self._tasks(asked)), self._report)

    def _tasks(self, asked: Asked) -> Sequence[Callable[[], Case]]:
        return self.tasks(asked.objects(self.name, self.usual), asked.seed)

    def _report(self, asked: Asked, progress: Progress) -> Report:
        return self.report_of(self.run(asked, progress), asked.seed)


def report_of_cases(
    experiment: str,
    seed: int,
    cases: Sequence[Any],
    *,
    title: str,
    lead: str,
    heading: str,
    table: Table,
    by: str,
    sentences: Sequence[str],
    reached: Sequence[Reached],
) -> Report:
    """The report of cases (dataclasses) that one table tells of; `by` is its heading on the page."""
    data = {"experiment": experiment, "seed": seed, "cases": [asdict(case) for case in cases]}
    return Report(data, title, lead, heading, [table], sentences, [Section(by, table=table)], reached)
