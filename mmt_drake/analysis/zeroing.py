"""How a telerobot's force was zeroed in the course of a run, and where it was not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import column, mean_step
from mmt_drake.estimation.probe import Zero
from mmt_drake.recording.recording import Recording

_WHY = {
    Zero.LOST: "no contact told, yet under the surface or none seen",
    Zero.RESTLESS: "free, but the force not steady",
    Zero.DEPARTED: "free, but far from the last zero: look at probe and sensor",
}


@dataclass(frozen=True)
class Zeroing:
    """Time in each state of `mmt_drake.estimation.probe.Zero` but touching [s]."""

    seconds: dict[Zero, float]

    def line(self) -> str:
        """For a terminal: for how long the zero was renewed, and why it was not although no contact was told."""
        renewed = self.seconds[Zero.RENEWED]
        told = [f"renewed for {renewed:.2f} s" if renewed else "NEVER taken, forces hold the sensor's offset"]
        told += [f"held for {self.seconds[zero]:.2f} s ({why})" for zero, why in _WHY.items() if self.seconds[zero]]
        return f"zero of the force: {'; '.join(told)}"

    def to_json(self) -> dict[str, float]:
        """The same as data."""
        return {f"{zero.name.lower()}_s": seconds for zero, seconds in self.seconds.items()}


def zeroing(recording: Recording) -> Zeroing | None:
    """What `probe_zero` of a recording says; None where it is not recorded: no telerobot carried a probe."""
    if "probe_zero" not in recording:
        return None
    states, step = column(recording, "probe_zero"), mean_step(recording)
    return Zeroing({zero: step * int(np.count_nonzero(states == zero)) for zero in Zero if zero != Zero.HELD})
