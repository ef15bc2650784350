"""How a hand turns that holds a tool: where the tip of the tool is, and how fast, from where the hand is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import Recording
from mmt_drake.recording.derive import rate_of
from mmt_drake.recording.signals import ORIENTATION

Place = tuple[float, float, float]


@dataclass(frozen=True)
class HandOrientation:
    """The orientation of a hand in the course of a recording.

    Attributes:
        turn: (n, 3, 3) rotation R from the hand's frame to that of positions.
        rate: (n, 3, 3) its rate [1/s].
    """

    turn: Array
    rate: Array

    @classmethod
    def of(cls, time: Array, orientation: Array) -> HandOrientation:
        """The hand of a recording.

        Args:
            time: (n,) [s].
            orientation: (n, 4) quaternion x, y, z, w of about unit length, of either sign.
        """
        turn = Rotation.from_quat(orientation).as_matrix()
        return cls(turn, rate_of(time, turn.reshape(len(time), 9)).reshape(turn.shape))

    @property
    def quaternion(self) -> Array:
        """(n, 4) as of `of`."""
        return Rotation.from_matrix(self.turn).as_quat()

    @property
    def spread(self) -> float:
        """RMS angle by which it turns about its mean [rad]."""
        turns = Rotation.from_matrix(self.turn)
        return float(np.sqrt(np.mean((turns.mean().inv() * turns).magnitude() ** 2)))

    def tip(self, position: Array, velocity: Array, tool: Place) -> tuple[Array, Array]:
        """Position p + R o [m] and velocity (n, 3) of a tip at o in the hand's frame [m].

        Args:
            position, velocity: (n, 3) of the hand [m], [m/s].
            tool: o.
        """
        return position + self.turn @ tool, velocity + self.rate @ tool


def orientation_of(recording: Recording) -> Array:
    """(n, 4) quaternions x, y, z, w of a recording, signs such that neighbours are near each other: q and -q are one.

    Raises:
        BadInput: it has none.
    """
    orientation = np.column_stack([recording[name] for name in ORIENTATION])
    flips = np.sum(orientation[1:] * orientation[:-1], axis=1) < 0.0
    sign = np.where(np.concatenate([[0], np.cumsum(flips)]) % 2 == 1, -1.0, 1.0)
    return orientation * sign[:, np.newaxis]
