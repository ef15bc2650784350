"""The guard of the arm's set-points: checked, held when none comes, approached when one is far."""

import numpy as np

from mmt_drake.hw.franka.faults import ArmFault
from mmt_drake.hw.franka.settings import FrankaSettings
from mmt_drake.numeric.arrays import Array

_LONGEST_STEP = 0.010  # [s]; after a pause the approach does not make up for it


class SetpointGuard:
    """Between the set-points that come in and those that the arm gets.

    Attributes:
        position, velocity: what the arm gets (3) [m], [m/s], table frame.
        following: whether that is what came in; else the arm holds its place, or comes slowly.
    """

    def __init__(self, settings: FrankaSettings) -> None:
        self._settings = settings
        self._low, self._high = np.array(settings.low), np.array(settings.high)
        self.position, self.velocity, self.following = np.zeros(3), np.zeros(3), False
        self._held = False

    def start(self, position: Array) -> None:
        """Hold a place (3) [m]; the first set-point is approached."""
        self.position, self.velocity = position.copy(), np.zeros(3)
        self.following = self._held = False

    def advance(self, commanded: Array, age: float, step: float) -> ArmFault:
        """Take a set-point in.

        Args:
            commanded: position and velocity (6) [m], [m/s].
            age: of it [s].
            step: since the latest call [s].

        Returns:
            Why the arm has to stop, or `ArmFault.NONE`.
        """
        settings = self._settings
        if not age <= settings.stop_after:
            return ArmFault.SETPOINTS_LOST
        if age > settings.hold_after:
            self._held = self._held or self.following
            self.following, self.velocity = False, np.zeros(3)
            return ArmFault.NONE
        fault = self._fault(commanded)
        if fault:
            return fault
        away = commanded[:3] - self.position
        distance = float(np.linalg.norm(away))
        if self.following or (self._held and distance <= settings.jump):
            if distance > settings.jump:
                return ArmFault.JUMP
            self.following, self._held = True, False
            self.position, self.velocity = commanded[:3].copy(), commanded[3:].copy()
            return ArmFault.NONE
        self._held = False
        reach = settings.approach * min(step, _LONGEST_STEP)
        if distance <= reach:
            self.following = True
            self.position, self.velocity = commanded[:3].copy(), commanded[3:].copy()
        else:
            self.velocity = settings.approach / distance * away
            self.position = self.position + reach / distance * away
        return ArmFault.NONE

    def _fault(self, commanded: Array) -> ArmFault:
        if not np.isfinite(commanded).all():
            return ArmFault.BAD_SETPOINT
        if np.linalg.norm(commanded[3:]) > self._settings.speed:
            return ArmFault.FAST_SETPOINT
        inside = (commanded[:3] >= self._low).all() and (commanded[:3] <= self._high).all()
        return ArmFault.NONE if inside else ArmFault.WORKSPACE
