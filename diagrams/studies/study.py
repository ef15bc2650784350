"""A study: cases that are run, figures with what is to be reached, and the ways in which they are told."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

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
    """

    out: Path
    seed: int = 0
    operator: str | None = None
    seconds: float | None = None
    estimator: str | None = None
    count: int | None = None
    anisotropic: bool = False
    jobs: int = 1

    def of_a_run(self) -> dict[str, Any]:
        """What everything that runs scenarios is told."""
        run = {"out": self.out, "operator": self.operator, "seed": self.seed, "seconds": self.seconds}
        return {**run, "jobs": self.jobs}


@dataclass(frozen=True)
class Report:
    """What came of a study.

    Attributes:
        document: as data, plain values.
        heading: on a terminal, above tables and sentences.
        tables: on a terminal.
        sentences: what the figures come to, in words made from them.
        title, lead, sections: of the page.
    """

    document: Mapping[str, Any]
    heading: str
    tables: Sequence[Table]
    sentences: Sequence[str]
    title: str
    lead: str
    sections: Sequence[Section]

    def write(self, out: str | Path) -> Path:
        """Write the page `index.html` into a folder, made if need be, with its pictures beside it.

        Raises:
            BadInput: the folder cannot be written.
        """
        from mmt_drake.analysis.page import write_page

        return write_page(Path(out) / "index.html", self.title, self.sections, self.lead)

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
