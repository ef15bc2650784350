"""A study: cases that are run, figures with what is to be reached, and the ways in which they are told."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from mmt_drake.diagrams.studies.figures import Reached, reached_table, to_json

if TYPE_CHECKING:
    from mmt_drake.analysis.page import Section
    from mmt_drake.analysis.table import Table


Progress = Callable[[float], None]
"""Told how much of a study is done."""

OF_A_RUN: Final = ("operator", "seconds", "seed")
"""What a person may ask of everything that runs scenarios."""


@dataclass(frozen=True)
class Asked:
    """What a person asks of a study; None where it is the study's own choice.

    Attributes:
        out: folder for recordings, figures and the page.
        seed: of everything random.
        operator: recording of a hand's motion.
        seconds: simulated time of each case [s].
        estimator: name of one (`mmt_drake.diagrams.stations.estimators.KINDS`).
        count: how many cases.
        anisotropic: objects whose normal axis is of another material.
        jobs: processes at work at the same time.
        say: is told each line that is known before the end.
    """

    out: Path
    seed: int = 0
    operator: str | None = None
    seconds: float | None = None
    estimator: str | None = None
    count: int | None = None
    anisotropic: bool = False
    jobs: int = 1
    say: Callable[[str], None] = lambda line: None

    def of_a_run(self) -> dict[str, Any]:
        """What everything that runs scenarios is told."""
        run = {"out": self.out, "operator": self.operator, "seed": self.seed, "seconds": self.seconds}
        return {**run, "jobs": self.jobs}


@dataclass(frozen=True)
class Report:
    """What came of a study.

    Attributes:
        data: plain values, the document but for the figures to reach.
        title, lead: of the page.
        heading: on a terminal, above tables and sentences.
        own_tables: on a terminal, above that of the figures to reach.
        sentences: what the figures come to, in words made from them.
        reached: figures beside what is to be reached; none where the study tells of them in another way.
        sections: of the page, below what was found.
    """

    data: Mapping[str, Any]
    title: str
    lead: str
    heading: str
    own_tables: Sequence[Table]
    sentences: Sequence[str]
    sections: Sequence[Section] = ()
    reached: Sequence[Reached] = ()

    @property
    def document(self) -> dict[str, Any]:
        """The document that `--json` prints."""
        return {**self.data, **({"figures_to_reach": to_json(self.reached)} if self.reached else {})}

    @property
    def tables(self) -> list[Table]:
        """All that a terminal shows."""
        return [*self.own_tables, *([reached_table(self.reached)] if self.reached else [])]

    def write(self, out: str | Path) -> Path:
        """Write the page `index.html` into a folder, made if need be, with its pictures beside it.

        Raises:
            BadInput: the folder cannot be written.
        """
        from mmt_drake.analysis.page import Section, write_page

        table = reached_table(self.reached) if self.reached else None
        found = Section("What was found", "\n\n".join(self.sentences), table=table)
        return write_page(Path(out) / "index.html", self.title, [found, *self.sections], self.lead)

    def markdown(self, command: str) -> str:
        """Title, lead, tables and sentences as a page of Markdown, below the command that gives them."""
        sentences = "\n".join(f"- {sentence}" for sentence in self.sentences)
        parts = [f"# {self.title}", f"`{command}`", self.lead, *(table.markdown() for table in self.tables), sentences]
        return "\n\n".join(parts) + "\n"


@dataclass(frozen=True)
class Study:
    """One study.

    Attributes:
        label: what its progress is told as.
        takes: attributes of `Asked` that it heeds, beside `out` and `jobs`.
        steps: how much there is to do; cases, or simulated seconds.
        run: does it, telling its progress in those steps.
        simulated: whether the steps are simulated seconds.
    """

    label: str
    takes: tuple[str, ...]
    steps: Callable[[Asked], float]
    run: Callable[[Asked, Progress], Report]
    simulated: bool = False
