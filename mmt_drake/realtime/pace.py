"""The pace of a loop: when each tick began and was done."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.wording import percent

_FIRST_ROOM = 1 << 16


class Pace:
    """Takes down every tick of a paced loop.

    A tick is due at its own time and must be done when the next one is due; one that is not is an overrun.

    Args:
        ticks: for which there is room; more are taken, at the price of an allocation in the midst of the run.
    """

    def __init__(self, ticks: int = _FIRST_ROOM) -> None:
        self._late = np.full(max(ticks, 1), np.nan)  # written, so that its pages are there when the clock runs
        self._behind = np.full(max(ticks, 1), np.nan)
        self._count = 0
        #: How long after it was due the present tick began [s],
        self.late = 0.0
        #: and how many ticks before it were overruns.
        self.overruns = 0

    def reserve(self, ticks: int) -> None:
        """Make room for so many more ticks, before the clock starts."""
        more = np.full(max(0, self._count + ticks - len(self._late)), np.nan)
        self._late, self._behind = np.concatenate([self._late, more]), np.concatenate([self._behind, more])

    def began(self, late: float) -> None:
        """A tick begins, so long after it was due [s]."""
        self.late = late

    def done(self, behind: float) -> None:
        """It is done, so long after the next was due [s]; negative: so long before."""
        count = self._count
        if count == len(self._late):
            self.reserve(count)
        self._late[count], self._behind[count] = self.late, behind
        self._count = count + 1
        self.overruns += behind > 0.0

    @property
    def late_s(self) -> NDArray[np.float64]:
        """For every tick how long after it was due it began [s]."""
        return self._late[: self._count]

    @property
    def behind_s(self) -> NDArray[np.float64]:
        """For every tick how long after the next was due it was done [s]; negative: so long before."""
        return self._behind[: self._count]

    def to_json(self) -> dict[str, float]:
        """How many ticks, how many overruns, and quantiles of both times; empty without a tick."""
        if not self._count:
            return {}
        figures: dict[str, float] = {"steps": self._count, "overruns": self.overruns}
        for name, times in (("late", self.late_s), ("behind", self.behind_s)):
            median, p99, p999 = np.quantile(times, [0.5, 0.99, 0.999])
            figures |= {
                f"{name}_median_s": float(median),
                f"{name}_p99_s": float(p99),
                f"{name}_p99.9_s": float(p999),
                f"{name}_worst_s": float(times.max()),
            }
        return figures

    def live(self) -> str:
        """How things stand, in a few words."""
        return f"{self.overruns} overruns of {self._count} steps"

    def line(self) -> str:
        """The same for a terminal."""
        figures = self.to_json()
        if not figures:
            return "overruns: none, no step was made"
        return (
            f"overruns: {figures['overruns']} of {figures['steps']} steps "
            f"({percent(figures['overruns'] / figures['steps'])}) were not done when the next was due, "
            f"{_quantiles(figures, 'behind')}; steps began {_quantiles(figures, 'late')}"
        )


def _quantiles(figures: Mapping[str, float], name: str) -> str:
    median, p99, worst = (_placed(figures[f"{name}_{which}_s"]) for which in ("median", "p99", "worst"))
    return f"median {median}, 99th percentile {p99}, worst {worst}"


def _placed(behind: float) -> str:
    return f"{abs(behind) * 1e3:.3f} ms {'late' if behind > 0.0 else 'early'}"
