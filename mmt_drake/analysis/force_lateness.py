"""Lateness of the measured force, as the estimator found it by the end of a run."""

from dataclasses import asdict, dataclass
from typing import Any

from mmt_drake.estimation.output_error.lateness import LONGEST_S
from mmt_drake.model.parameters import FORCE_LATENESS
from mmt_drake.recording.recording import Recording


@dataclass(frozen=True)
class ForceLateness:
    """By how much the measured force is later than the motion, with standard deviations [s].

    Attributes:
        delay: part of it that is a delay.
        lag: time constant of the low pass.
        sum: of both, which slow motion tells alone.
        delay_deviation, lag_deviation, sum_deviation: how sure these are.
    """

    delay: float
    lag: float
    sum: float
    delay_deviation: float
    lag_deviation: float
    sum_deviation: float

    def line(self) -> str:
        """For a terminal."""
        total = f"{1e3 * self.sum:.2f} +- {1e3 * self.sum_deviation:.2f} ms"
        if self.sum < 2.0 * self.sum_deviation:
            return f"measured force: not noticeably later than the motion ({total})"
        if self.sum > LONGEST_S - 2.0 * self.sum_deviation:
            return f"measured force: {1e3 * LONGEST_S:g} ms later than the motion or more: no more is sought"
        return f"measured force: {total} later than the motion, {1e3 * self.lag:.1f} ms of it as of a low pass"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {f"{name}_s": value for name, value in asdict(self).items()}


def force_lateness(recording: Recording) -> ForceLateness | None:
    """What the last sample of a recording says of it; None where it says nothing: another estimator."""
    columns = [f"force_lateness_{name}" for name in FORCE_LATENESS]
    if not all(name in recording for name in columns):
        return None
    return ForceLateness(*(float(recording[name][-1]) for name in columns))
