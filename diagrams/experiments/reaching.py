"""What an experiment is to reach, beside what it does reach and what the thesis prints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from diagrams.experiments.plans import DELAYED, OUTPUT_ERROR
from diagrams.scenario import updates_name
from mmt_drake.analysis.lags import Lags
from mmt_drake.analysis.signals import BAND_NAMES
from mmt_drake.analysis.table import Cell, Table

if TYPE_CHECKING:
    from diagrams.experiments.runs import Case, ExperimentResult

FORCE_ERROR: Final = 0.005
"""Error of the rendered force against the plant's in each band, and what a delay may add to it."""
STABLE_S: Final = 0.5
"""Time in contact after which the parameters are stable [s]."""

_ROUNDING: Final = 1e-6  # of times on a clock
_THESIS_ERROR: Final = "0.3 (low frequencies) to 1 (high)"
_THESIS_STABLE: Final = "16.1 (its experiment 2)"


@dataclass(frozen=True)
class Reached:
    """One figure.

    Attributes:
        name: what it is.
        unit: s, or empty for a ratio.
        thesis: what the thesis says of it, in its words' sense.
        to_reach: at most this.
        value: as measured; None where the run does not tell.
        updates: how the renderer of that case takes up new parameters.
        by_construction: it could not be otherwise, so that it is no achievement and gets no verdict.
    """

    name: str
    unit: str
    thesis: str
    to_reach: float
    value: float | None
    updates: str | None = None
    by_construction: bool = False

    @property
    def reached(self) -> bool | None:
        """Whether it is; None where the run does not tell, or could not have told otherwise."""
        return None if self.value is None or self.by_construction else self.value <= self.to_reach * (1.0 + _ROUNDING)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self) | {"reached": self.reached}


def figures_to_reach(result: ExperimentResult) -> list[Reached]:
    """The figures of an experiment, of its cases with the estimator whose model runs freely or a second detector."""
    found = []
    for case in result.cases:
        if case.name != OUTPUT_ERROR:
            continue
        error, stable = case.metrics.rendered_error_true, case.metrics.time_to_stable_s
        if error is not None:
            found += [
                Reached(
                    f"{case.name}: error of the rendered force, {BAND_NAMES[band]}",
                    "",
                    _THESIS_ERROR,
                    FORCE_ERROR,
                    error.tangential[band],
                )
                for band in error.telling
            ]
        # What this estimator puts out is stable from its prior on, whatever it has learned.
        name = f"{case.name}: time in contact until stable"
        found.append(Reached(name, "s", _THESIS_STABLE, STABLE_S, stable, by_construction=True))
    for far, near in _compared(result).items():
        far_off, near_off = (_off(result[name]) for name in (far, near))
        more = None if far_off is None or near_off is None else abs(far_off - near_off)
        found.append(Reached(f"{far}: error less that without the delay", "", "the same", FORCE_ERROR, more))
        tick = result[far].scenario.step
        for what, lags in (("touch", result[far].metrics.touch), ("release", result[far].metrics.release)):
            found.append(Reached(f"{far}: longest lag of a {what}", "s", "0.8", tick, _longest(lags)))
    return [replace(each, updates=updates_name(result[each.name.split(":")[0]].scenario)) for each in found]


def reached_table(figures: Sequence[Reached]) -> Table:
    """The same as a table."""
    verdicts = {True: "reached", False: "missed", None: "not known"}
    rows: list[Sequence[Cell]] = []
    for each in figures:
        name = f"{each.name} [{each.unit}]" if each.unit else each.name
        verdict = "by its prior" if each.by_construction else verdicts[each.reached]
        rows.append([name, each.updates, each.thesis, each.to_reach, each.value, verdict])
    return Table(["figure", "updates", "thesis", "to reach", "measured", "verdict"], rows)


def _compared(result: ExperimentResult) -> dict[str, str]:
    """The cases with a delay that were run without it as well."""
    names = {case.name for case in result.cases}
    return {far: near for far, near in DELAYED.items() if far in names and near in names}


def _off(case: Case) -> float | None:
    """Error of the rendered force against the plant's without noise."""
    error = case.metrics.rendered_error_true
    return None if error is None else error.tangential["all"]


def _longest(lags: Lags) -> float | None:
    """The lag farthest from none [s]; None where there was no event, or one was never answered."""
    answered = [abs(lag) for lag in lags.lags_s if lag is not None]
    return max(answered) if answered and len(answered) == len(lags.lags_s) else None
