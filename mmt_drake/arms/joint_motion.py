"""The motion of one joint, and what its effects are computed from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mmt_drake.numeric.arrays import Array

REST = 0.01
"""A joint that is slower than this part of its highest speed rests: dry friction holds whatever it has to, there."""


@dataclass(frozen=True)
class JointMotion:
    """One joint of a log, evenly sampled, smooth.

    Attributes:
        joint: its number.
        step: sampling interval [s].
        q, v, a: (n,) position, velocity and acceleration [rad] or [m].
        rigid: (n,) torque that moves the links as the model believes [N m].
        others: (n, joints) torque of all joints as logged [N m].
        jerk: (n,) rate of its own logged torque [N m/s].
        ripples: periods over which what is left comes back [rad], strongest first.
        delays: by which all torques may be late [s].
        geared: joints whose drives may be geared with its own.
    """

    joint: int
    step: float
    q: Array
    v: Array
    a: Array
    rigid: Array
    others: Array
    jerk: Array
    ripples: tuple[float, ...] = ()
    delays: tuple[float, ...] = (0.0,)
    geared: tuple[int, ...] = ()

    @cached_property
    def fastest(self) -> float:
        """Highest speed; a joint that never moves has a tiny one."""
        return max(float(np.abs(self.v).max()), 1e-9)

    @property
    def rest(self) -> float:
        """Speed below which it rests."""
        return REST * self.fastest

    @property
    def reach(self) -> float:
        """Length of its way."""
        return max(float(np.ptp(self.q)), 1e-9)

    @property
    def load(self) -> Array:
        """What friction may grow with: the size of the torque that moves the links, (n,).

        Not of the torque that was logged: where friction is most of it, that would explain itself.
        """
        return np.abs(self.rigid)

    @property
    def direction(self) -> Array:
        """-1 to 1, (n,): turned over between them while it rests."""
        return np.clip(self.v / self.rest, -1.0, 1.0)
