"""Jumps of a force: those that updates of the rendered model make, and those that one run has and another has not."""

from dataclasses import dataclass

import numpy as np

from mmt_drake.analysis.signals import flag, vector
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording

LARGE = 0.05
"""A jump counts as large above this part of the RMS force."""


@dataclass(frozen=True)
class Jumps:
    """Changes of a force from one tick to the next that its cause should not have made.

    Attributes:
        largest: the greatest magnitude [N].
        largest_at: when that is [s].
        reference_rms: RMS of the magnitude of the force that they are held against, in contact [N].
        large: how many are above `LARGE` of that.
    """

    largest: float
    largest_at: float
    reference_rms: float
    large: int

    @property
    def ratio(self) -> float | None:
        """The largest one over the RMS force; None where that is zero."""
        return self.largest / self.reference_rms if self.reference_rms > 0.0 else None

    def to_json(self) -> dict[str, float | int | None]:
        """Plain numbers."""
        return {"largest_n": self.largest, "at_s": self.largest_at, "ratio": self.ratio, "above_5_percent": self.large}


def update_jumps(recording: Recording) -> Jumps:
    """By how much updates of the rendered parameters changed the force, against the measured force.

    Args:
        recording: with `update_jump_*`, `force_*` and `in_contact`.

    Raises:
        BadInput: a column is missing or broken.
    """
    size = np.linalg.norm(vector(recording, "update_jump"), axis=1)
    return _jumps(size, recording.time, _rms_in_contact(recording, vector(recording, "force")))


def jumps_beside(recording: Recording, reference: Recording, name: str) -> Jumps:
    """Changes of a force from tick to tick that the same force of another run of the same motion does not have.

    Args:
        recording, reference: on the same clock, with the force, and `in_contact` in the reference.
        name: of the force, `rendered_force` or `true_force` for instance.

    Raises:
        BadInput: a column is missing or broken, or the clocks differ.
    """
    if not np.array_equal(recording.time, reference.time):
        raise BadInput(recording.source, at="time", found="another clock", expected=f"that of {reference.source}")
    expected = vector(reference, name)
    change = np.diff(vector(recording, name) - expected, axis=0, prepend=0.0)
    return _jumps(np.linalg.norm(change, axis=1), recording.time, _rms_in_contact(reference, expected))


def _rms_in_contact(recording: Recording, force: Array) -> float:
    """RMS [N] of the magnitude of a force, (n, 3)."""
    held = force[flag(recording, "in_contact")]
    return float(np.sqrt(np.mean(np.sum(held**2, axis=1)))) if len(held) else 0.0


def _jumps(size: Array, time: Array, rms: float) -> Jumps:
    at = int(np.argmax(size))
    return Jumps(float(size[at]), float(time[at]), rms, int(np.count_nonzero(size > LARGE * rms)))
