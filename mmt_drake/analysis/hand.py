"""The hand's motion: how it yields, how far the telerobot is from it, and whether both come to rest."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import delayed, mean_step, vector
from mmt_drake.errors import BadInput
from mmt_drake.recording.recording import Recording

AT_REST = 0.01
"""A hand is at rest below this part of its RMS speed while it meant to move."""


@dataclass(frozen=True)
class Settling:
    """The rest of a hand that means to hold still: it comes to rest if the loop through force and motion is stable.

    Attributes:
        moving: RMS speed of the hand before it means to hold still [m/s].
        holding: the same over the last quarter of the time in which it means to [m/s].
    """

    moving: float
    holding: float

    @property
    def stable(self) -> bool:
        """True if it came to rest."""
        return self.holding < AT_REST * self.moving

    def to_json(self) -> dict[str, float | bool]:
        """Plain numbers."""
        return {"stable": self.stable, "holding_m_s": self.holding, "moving_m_s": self.moving}


def settling(recording: Recording, since_s: float, until_s: float) -> Settling:
    """The settling of a hand that means to hold still from one time to another [s].

    Raises:
        BadInput: `master_position_*` or `master_velocity_*` is missing or broken, or the recording does not cover it.
    """
    time = recording.time
    if not time[0] < since_s < until_s <= time[-1] + 1e-9:
        found, expected = f"{time[0]:g} to {time[-1]:g} s", f"{since_s:g} to {until_s:g} s within it"
        raise BadInput(recording.source, at="time", found=found, expected=expected)
    speed = np.linalg.norm(vector(recording, "master_velocity"), axis=1)
    last = (time >= until_s - 0.25 * (until_s - since_s)) & (time <= until_s)
    return Settling(
        moving=float(np.sqrt(np.mean(speed[time < since_s] ** 2))), holding=float(np.sqrt(np.mean(speed[last] ** 2)))
    )


def tracking_error(recording: Recording, delay_s: float) -> float:
    """RMS distance [m] of the telerobot from where the hand was a delay [s] ago.

    Raises:
        BadInput: `position_*` or `master_position_*` is missing or broken.
    """
    wanted = delayed(vector(recording, "master_position"), delay_s, mean_step(recording))
    return float(np.sqrt(np.mean(np.sum((vector(recording, "position") - wanted) ** 2, axis=1))))
