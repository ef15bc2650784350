"""How well a run in real time kept its pace."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.analysis import Simulator

from mmt_drake.analysis.wording import percent


@dataclass
class Pacing:
    """Watches every step of a paced Simulator, on the clock that paces it.

    A step to time t does all that is due before t, and what is published at t. It should be done when the wall clock
    gets to t, where the next one starts; a step that is not is an overrun.

    Attributes:
        behind_s: for every step how long after that it was done [s]; negative: so long before.
    """

    behind_s: array[float] = field(default_factory=lambda: array("d"))

    def __call__(self, simulator: Simulator) -> None:
        """Take down the step that has just been done."""
        rate = simulator.get_actual_realtime_rate()
        time = simulator.get_context().get_time()
        if rate > 0.0:
            self.behind_s.append(time / rate - time)

    def to_json(self) -> dict[str, float]:
        """How many steps, how many overruns, and quantiles of `behind_s`; empty without a step."""
        if not self.behind_s:
            return {}
        behind = np.array(self.behind_s)
        median, p99 = np.quantile(behind, [0.5, 0.99])
        return {
            "steps": len(behind),
            "overruns": int(np.count_nonzero(behind > 0.0)),
            "behind_median_s": float(median),
            "behind_p99_s": float(p99),
            "behind_worst_s": float(behind.max()),
        }

    def line(self) -> str:
        """The same for a terminal."""
        told = self.to_json()
        if not told:
            return "overruns: none, no step was made"
        median, p99, worst = (_placed(told[f"behind_{name}_s"]) for name in ("median", "p99", "worst"))
        share = percent(told["overruns"] / told["steps"])
        return (
            f"overruns: {told['overruns']} of {told['steps']} steps ({share}) were not done when the next was "
            f"due; median {median}, 99th percentile {p99}, worst {worst}"
        )


def _placed(behind: float) -> str:
    return f"{abs(behind) * 1e3:.3f} ms {'late' if behind > 0.0 else 'early'}"
