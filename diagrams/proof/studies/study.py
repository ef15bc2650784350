"""A study: cases that are run, figures with what is to be reached, and the ways in which they are shown."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.errors import BadInput

if TYPE_CHECKING:
    from mmt_drake.analysis.page import Section

Progress = Callable[[float], None]
"""Called with how much of a study is done."""

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
        with_: `my.py:MyEstimator`, one's own, to be held beside the others.
        count: how many cases.
        anisotropic: objects whose normal axis is of another material.
        jobs: processes at work at the same time.
        say: called with each line that is known before the end.
    """

    out: Path
    seed: int = 0
    operator: str | None = None
    seconds: float | None = None
    estimator: str | None = None
    with_: str | None = None
    count: int | None = None
    anisotropic: bool = False
    jobs: int = 1
    say: Callable[[str], None] = lambda line: None

    def objects(self, experiment: str, usual: int) -> int:
        """How many objects an experiment takes, `usual` unless `count` says it.

        Raises:
            BadInput: fewer than one.
        """
        count = usual if self.count is None else self.count
        if count < 1:
            raise BadInput(f"experiment {experiment}", found=f"--count {count}", expected="one object at least")
        return count


def unheard(done: float) -> None:
    """Progress that nobody wants to see."""


_ROUNDING: Final = 1e-6  # of times on a clock
_MARKS: Final = {True: " ✓", False: " ✗", None: ""}
_NOTHING: Final = "–"
BY_PRIOR: Final = "by its prior"
NOISE_FORBIDS: Final = "the noise forbids it"


@dataclass(frozen=True)
class Target:
    """One figure.

    Attributes:
        figure: what it is.
        unit: empty for a ratio that is shown in percent, `times` for one that is not.
        thesis: the thesis's own, in that unit; None where it prints none.
        thesis_says: what it says, in our words.
        to_reach: at most this, in that unit; None where nothing is asked.
    """

    figure: str
    unit: str = ""
    thesis: float | None = None
    thesis_says: str = "not tried"
    to_reach: float | None = None

    @property
    def factor(self) -> float:
        """From the unit to the one that it is shown in."""
        return 1.0 if self.unit else 100.0

    @property
    def title(self) -> str:
        """Its name over a column."""
        return f"{self.figure} [{self.unit or '%'}]"

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


@dataclass(frozen=True)
class Reached:
    """One figure of one case.

    Attributes:
        case: whose.
        target: what the thesis says of it and what is to be reached.
        value: as measured, in the target's unit; None where the run does not tell, or it never happened.
        bound: the least that the noise of the force would allow (`comparisons.bound`); None where nobody asked.
        updates: how the renderer of that case takes up new parameters.
        never: None as a value is `never`, which is missed.
        unasked: why there is no verdict although there is something to reach.
    """

    case: str
    target: Target
    value: float | None
    bound: float | None = None
    updates: str | None = None
    never: bool = False
    unasked: str = ""

    @property
    def reached(self) -> bool | None:
        """Whether it is; None where nothing is asked or the run does not tell."""
        most = self.target.to_reach
        if most is None or self.unasked or (self.value is None and not self.never):
            return None
        return self.value is not None and self.value <= most * (1.0 + _ROUNDING)

    @property
    def verdict(self) -> str:
        """The same in a word or two."""
        if self.reached is not None:
            return "reached" if self.reached else "missed"
        if self.target.to_reach is None:
            return "nothing to reach"
        return self.unasked or "not known"

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        measured = {"value": self.value, "bound": self.bound, "updates": self.updates}
        judged = {"reached": self.reached, "verdict": self.verdict}
        return {"case": self.case, **self.target.to_json(), **measured, **judged}

    def cell(self) -> str:
        """For a table: the value, the bound of the noise behind a stroke, the verdict as a mark."""
        value = ("never" if self.never else _NOTHING) if self.value is None else _written(self.value, self.target)
        bound = "" if self.bound is None else f" / {_written(self.bound, self.target)}"
        return f"{value}{bound}{f' ({BY_PRIOR})' if self.unasked == BY_PRIOR else _MARKS[self.reached]}"


def to_json(figures: Iterable[Reached]) -> list[dict[str, Any]]:
    """`figures_to_reach` of every document that `experiment --json` prints."""
    return [figure.to_json() for figure in figures]


def reached_table(figures: Sequence[Reached]) -> Table:
    """One row a case, one column a figure, below what the thesis says and what is to be reached."""
    columns: dict[str, dict[str, Reached]] = {}
    for each in figures:
        columns.setdefault(each.target.title, {})[each.case] = each
    updates = {each.case: each.updates for each in figures}
    several = any(name is not None for name in updates.values())
    tops: list[list[Cell]] = [["the thesis"], ["to reach"]]
    for top, say in zip(tops, (_says, _most), strict=True):
        top += [""] if several else []
        top += [_several(say(each.target) for each in cells.values()) for cells in columns.values()]
    rows: list[list[Cell]] = [
        [case, *([name] if several else []), *(_cell(cells.get(case)) for cells in columns.values())]
        for case, name in updates.items()
    ]
    return Table(["case", *(["updates"] if several else []), *columns], tops + rows, _caption(figures))


def _caption(figures: Sequence[Reached]) -> str:
    text = "✓ reached, ✗ missed, no mark: nothing to reach, or not known."
    if any(each.bound is not None for each in figures):
        text += " Behind a stroke what the force's noise alone would allow (Cramer-Rao bound along the true motion)."
        if any(each.unasked == NOISE_FORBIDS for each in figures):
            text += " Where that is more than is to be reached, there is no verdict."
    if any(each.unasked == BY_PRIOR for each in figures):
        text += f" {BY_PRIOR.capitalize()}: it could not be otherwise, so it is no achievement."
    return text


def _several(texts: Iterable[str]) -> str:
    """What cases of one column are held against; nothing only where it is nothing for all."""
    every = list(dict.fromkeys(texts))
    return " or ".join([each for each in every if each != _NOTHING] or every)


def _cell(each: Reached | None) -> Cell:
    return None if each is None else each.cell()


def _written(value: float, target: Target) -> str:
    return significant(target.factor * value, 2 if target.factor * value < 10.0 else 3)


def _says(target: Target) -> str:
    return target.thesis_says if target.thesis is None else _written(target.thesis, target)


def _most(target: Target) -> str:
    return _NOTHING if target.to_reach is None else _written(target.to_reach, target)


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
        parts = [f"# {self.title}", f"`{command}`", self.lead, *(table.markdown() for table in self.tables)]
        parts.append("\n".join(f"- {sentence}" for sentence in self.sentences))
        return "\n\n".join(parts).rstrip() + "\n"


@dataclass(frozen=True)
class Study:
    """One study.

    Attributes:
        label: of its progress.
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
