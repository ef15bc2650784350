"""How long a run had no cloud of its camera that still counts."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mmt_drake.analysis.signals import mean_step
from mmt_drake.recording.recording import Recording


@dataclass(frozen=True)
class CloudsMissed:
    """What a run did without.

    Attributes:
        seconds: for how long, after the first cloud, there was none that counts [s].
        oldest: age of the oldest [s].
    """

    seconds: float
    oldest: float

    def line(self) -> str:
        """For a terminal."""
        return f"camera: NO CLOUD that counts for {self.seconds:.2f} s in all; the oldest was {self.oldest:.2f} s old"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {"without_cloud_s": self.seconds, "oldest_s": self.oldest}


def clouds_missed(recording: Recording) -> CloudsMissed | None:
    """What a recording says of it; None: there was no camera, or always a cloud."""
    if "camera_fault" not in recording:
        return None
    fault = recording["camera_fault"]
    begun = np.flatnonzero(fault == 0.0)
    missing = (fault != 0.0) & (np.arange(len(fault)) >= (begun[0] if len(begun) else 0))
    if not missing.any():
        return None
    return CloudsMissed(mean_step(recording) * int(np.count_nonzero(missing)), float(recording["camera_age"].max()))
