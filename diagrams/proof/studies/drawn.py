"""Studies of cases that are drawn at random: each case a task of its own, told of in one table."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any, Generic, TypeVar

from mmt_drake.analysis.page import Section
from mmt_drake.analysis.table import Table
from mmt_drake.diagrams.proof.studies.processes import results_of
from mmt_drake.diagrams.proof.studies.study import Asked, Progress, Reached, Report, Study, unheard

Case = TypeVar("Case")


@dataclass(frozen=True)
class DrawnFindings:
    """What the cases of a study come to.

    Attributes:
        lead: of the page.
        table: that tells of all of them.
        sentences: what it comes to, in words made from the numbers.
        reached: figures beside what is to be reached.
    """

    lead: str
    table: Table
    sentences: Sequence[str]
    reached: Sequence[Reached]


@dataclass(frozen=True)
class DrawnCases(Generic[Case]):
    """A study of so many draws, whose cases do not depend on each other.

    Attributes:
        name: of the experiment.
        label: of its progress: what its cases are.
        usual: how many draws there are unless a person says it.
        tasks: of so many draws from a seed; each returns a case, a dataclass.
        title: of the page.
        heading: on a terminal, above table and sentences.
        by: heading of the table on the page.
        judge: what cases come to, drawn from a seed.
        one_by_one: a case has use for all processors, and is timed.
    """

    name: str
    label: str
    usual: int
    tasks: Callable[[int, int], Sequence[Callable[[], Case]]]
    title: str
    heading: str
    by: str
    judge: Callable[[Sequence[Case], int], DrawnFindings]
    one_by_one: bool = False

    def run(self, asked: Asked, progress: Progress = unheard) -> list[Case]:
        """Every case, on several cores unless `one_by_one`; what comes out does not depend on the jobs.

        Raises:
            BadInput: fewer than one draw.
        """
        return results_of(self._tasks(asked), 1 if self.one_by_one else asked.jobs, progress, compile_first=True)

    def report(self, cases: Sequence[Any], seed: int = 0) -> Report:
        """What these cases come to, drawn from this seed."""
        found = self.judge(cases, seed)
        data = {"experiment": self.name, "seed": seed, "cases": [asdict(case) for case in cases]}
        sections = [Section(self.by, table=found.table)]
        tables = [found.table]
        return Report(data, self.title, found.lead, self.heading, tables, found.sentences, sections, found.reached)

    @property
    def studies(self) -> dict[str, Study]:
        """The study by its name, as `experiment` takes it."""
        return {self.name: Study(self.label, ("seed", "count"), lambda asked: len(self._tasks(asked)), self._report)}

    def _tasks(self, asked: Asked) -> Sequence[Callable[[], Case]]:
        return self.tasks(asked.objects(self.name, self.usual), asked.seed)

    def _report(self, asked: Asked, progress: Progress) -> Report:
        return self.report(self.run(asked, progress), asked.seed)


def each_draw(run_case: Callable[..., Case], *ways: Iterable[Any]) -> Callable[[int, int], list[partial[Case]]]:
    """Tasks `run_case(number, *way, seed)`: every draw in every way, one of each of `ways`."""
    every = list(product(*ways))
    return lambda count, seed: [partial(run_case, number, *way, seed) for number in range(count) for way in every]
