"""What an experiment reaches, beside what the thesis prints, what is to be reached and what the noise would allow."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.table import Cell, Table
from mmt_drake.analysis.wording import significant
from mmt_drake.diagrams.experiments.plans import DELAYED, OUTPUT_ERROR
from mmt_drake.diagrams.experiments.targets import (
    DELAY_COSTS,
    ESTIMATED,
    RENDERED,
    RENDERED_DELAYED,
    STABLE,
    Target,
    lag,
)
from mmt_drake.diagrams.stations.scenario import updates_name

if TYPE_CHECKING:
    from mmt_drake.analysis.metrics import ForceError, Metrics
    from mmt_drake.diagrams.experiments.runs import Case, ExperimentResult

_ROUNDING: Final = 1e-6  # of times on a clock
_MARKS: Final = {True: " ✓", False: " ✗", None: ""}
_NOTHING: Final = "–"
BY_PRIOR: Final = "by its prior"
NOISE_FORBIDS: Final = "the noise forbids it"


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
        value = ("never" if self.never else _NOTHING) if self.value is None else _told(self.value, self.target)
        bound = "" if self.bound is None else f" / {_told(self.bound, self.target)}"
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
    for top, told in zip(tops, (_says, _most), strict=True):
        top += [""] if several else []
        top += [_several(told(each.target) for each in cells.values()) for cells in columns.values()]
    rows: list[list[Cell]] = [
        [case, *([name] if several else []), *(_cell(cells.get(case)) for cells in columns.values())]
        for case, name in updates.items()
    ]
    return Table(["case", *(["updates"] if several else []), *columns], tops + rows, _caption(figures))


def _caption(figures: Sequence[Reached]) -> str:
    told = "✓ reached, ✗ missed, no mark: nothing to reach, or not to be told."
    if any(each.bound is not None for each in figures):
        told += " Behind a stroke what the force's noise alone would allow (Cramer-Rao bound along the true motion)."
        if any(each.unasked == NOISE_FORBIDS for each in figures):
            told += " Where that is more than is to be reached, there is no verdict."
    if any(each.unasked == BY_PRIOR for each in figures):
        told += f" {BY_PRIOR.capitalize()}: it could not be otherwise, so it is no achievement."
    return told


def _several(told: Iterable[str]) -> str:
    """What cases of one column are held against; nothing only where it is nothing for all."""
    every = list(dict.fromkeys(told))
    return " or ".join([each for each in every if each != _NOTHING] or every)


def _cell(each: Reached | None) -> Cell:
    return None if each is None else each.cell()


def _told(value: float, target: Target) -> str:
    return significant(target.factor * value, 2 if target.factor * value < 10.0 else 3)


def _says(target: Target) -> str:
    return target.thesis_says if target.thesis is None else _told(target.thesis, target)


def _most(target: Target) -> str:
    return _NOTHING if target.to_reach is None else _told(target.to_reach, target)


def bands(
    case: str,
    error: ForceError | None,
    targets: Mapping[str, Target],
    *,
    updates: str | None = None,
    bound: Mapping[str, float | None] | None = None,
) -> list[Reached]:
    """The error of the rendered force in every band that holds enough of the force.

    Args:
        case: whose.
        error: of it, against the plant's force without noise.
        targets: by band.
        updates: see `Reached`.
        bound: by band, see `Reached`.
    """
    if error is None:
        return []
    return [
        Reached(case, target, error.tangential[band], (bound or {}).get(band), updates)
        for band, target in targets.items()
        if band in error.telling
    ]


def stable(case: str, metrics: Metrics, *, by_prior: bool, updates: str | None = None) -> Reached:
    """Time in contact until the parameters are stable; what starts from a stable prior gets no verdict."""
    time = metrics.time_to_stable_s
    return Reached(case, STABLE, time, None, updates, never=time is None, unasked=BY_PRIOR if by_prior else "")


def estimated(case: str, error: ForceError | None, *, updates: str | None = None) -> list[Reached]:
    """The error of the estimated force, of which the thesis says something and nothing is asked."""
    return [] if error is None else [Reached(case, ESTIMATED, error.tangential["all"], None, updates)]


def answered(case: str, metrics: Metrics, tick: float, *, updates: str | None = None) -> list[Reached]:
    """The longest lag of a touch and of a release, `tick` [s] being the clock's."""
    events = (("touch", metrics.touch), ("release", metrics.release))
    return [
        Reached(case, lag(event, tick), _longest(found), None, updates, never=found.lost > 0) for event, found in events
    ]


def figures_to_reach(result: ExperimentResult) -> list[Reached]:
    """The figures of every case of experiment 1 or 3."""
    found: list[Reached] = []
    names = {case.name for case in result.cases}
    delayed = any(case.metrics.delay_s > 0.0 for case in result.cases)
    for case in result.cases:
        name, metrics, updates = case.name, case.metrics, updates_name(case.scenario)
        targets = RENDERED_DELAYED if delayed else RENDERED
        found += bands(name, metrics.rendered_error_true, targets, updates=updates)
        found += estimated(name, metrics.estimated_error, updates=updates)
        found.append(stable(name, metrics, by_prior=name.startswith(OUTPUT_ERROR), updates=updates))
        if not delayed:
            continue
        found += answered(name, metrics, case.scenario.step, updates=updates)
        near = DELAYED.get(name)
        if near in names:
            ours, theirs = _off(case), _off(result[near])
            more = None if ours is None or theirs is None else abs(ours - theirs)
            found.append(Reached(name, DELAY_COSTS, more, None, updates))
    return found


def _off(case: Case) -> float | None:
    """Error of the rendered force against the plant's without noise."""
    error = case.metrics.rendered_error_true
    return None if error is None else error.tangential["all"]


def _longest(lags: Lags) -> float | None:
    """The lag farthest from none [s]; None where no event could be answered, or one was lost."""
    return None if lags.lost else max((abs(each) for each in lags.lags_s if each is not None), default=None)
