"""The zeroing of a telerobot's force in the course of a run: when it was, and when it was not."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import column, flag, mean_step
from mmt_drake.estimation.probe import Zero
from mmt_drake.recording.recording import Recording

_SHORTEST = 0.005  # [s] that is listed; a cloud comes a tick or two after the start
_WHY = {
    Zero.LOST: "no contact detected, yet under the surface or none seen",
    Zero.RESTLESS: "free, but the force not steady",
    Zero.DEPARTED: "free, but far from the last zero: look at probe and sensor",
}


@dataclass(frozen=True)
class Zeroing:
    """The states of the zero over a run.

    Attributes:
        seconds: time in each state of `mmt_drake.estimation.probe.Zero` but `HELD` [s].
        before: time in contact before the first zero [s]; forces there hold the sensor's offset.
    """

    seconds: dict[Zero, float]
    before: float

    def line(self) -> str:
        """For a terminal: for how long the zero was renewed, and why it was not although no contact was detected."""
        renewed = self.seconds[Zero.RENEWED]
        parts = [f"renewed for {renewed:.2f} s" if renewed else "NEVER taken"]
        if self.before:
            parts.append(f"the sensor's offset is in the forces of {self.before:.2f} s of contact before the first one")
        held = [(self.seconds[zero], why) for zero, why in _WHY.items() if self.seconds[zero] >= _SHORTEST]
        parts += [f"held for {seconds:.2f} s ({why})" for seconds, why in held]
        return f"zero of the force: {'; '.join(parts)}"

    def to_json(self) -> dict[str, float]:
        """The same as data."""
        times = {f"{zero.name.lower()}_s": seconds for zero, seconds in self.seconds.items()}
        return {**times, "contact_before_s": self.before}


def zeroing(recording: Recording) -> Zeroing | None:
    """The zeroing that `probe_zero` of a recording shows; None where that is missing: no telerobot carried a probe."""
    if "probe_zero" not in recording:
        return None
    states, step = column(recording, "probe_zero"), mean_step(recording)
    seconds: dict[Zero, float] = {
        zero: step * int(np.count_nonzero(states == zero)) for zero in Zero if zero != Zero.HELD
    }
    unknown = np.cumsum(states == Zero.RENEWED) == 0
    return Zeroing(seconds, step * int(np.count_nonzero(unknown & flag(recording, "detected_contact"))))
