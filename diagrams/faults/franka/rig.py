"""An emulated arm with its driver, and a hand that streams set-points to it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.franka import ArmFault, FrankaDriver, FrankaSettings
from mmt_drake.hw.franka.emulator import EmulatedFranka

Array = NDArray[np.float64]

#: The machine may be busy: a gap is long, and the box holds all that the arm can reach.
SETTINGS = FrankaSettings(
    "127.0.0.1", realtime="ignore", table=(0.55, 0.0, 0.5), low=(-0.4,) * 3, high=(0.4,) * 3, gap=0.4, hold_after=0.1
)
_TICK = 2e-3


class FrankaRig:
    """The driver, told what a function of time says.

    Attributes:
        home: where the arm was when it last took control (3) [m].

    Args:
        franka: the emulated arm.
        changed: settings other than `SETTINGS`.
    """

    def __init__(self, franka: EmulatedFranka, **changed: Any) -> None:
        self.franka, self.settings = franka, replace(SETTINGS, address=franka.address, **changed)
        self.driver = FrankaDriver(self.settings)
        self.home = self.position

    @property
    def position(self) -> Array:
        """(3) of the tip, as it was read last [m]."""
        return self.driver.latest.motion[:3].copy()

    @property
    def fault(self) -> int:
        """That the driver tells."""
        return int(self.driver.latest.device[0])

    @property
    def following(self) -> bool:
        """Whether the arm follows the set-points."""
        return self.driver.latest.device[2] == 0.0

    def stay(self, elapsed: float) -> Array:
        """The set-point where the arm took control."""
        return self.off(0.0)

    def off(self, x: float, y: float = 0.0, vy: float = 0.0) -> Array:
        """A set-point beside where the arm took control."""
        return np.array([self.home[0] + x, self.home[1] + y, self.home[2], 0.0, vy, 0.0])

    def until(
        self, done: Callable[[], bool], within: float = 5.0, commanded: Callable[[float], Array | None] | None = None
    ) -> bool:
        """Stream set-points until something is so; whether it came to be."""
        began, commanded = time.monotonic(), commanded or self.stay
        while (elapsed := time.monotonic() - began) < within:
            setpoint = commanded(elapsed)
            if setpoint is not None:
                self.driver.send(setpoint)
            if done():
                return True
            time.sleep(_TICK)
        return False

    def circle(self, elapsed: float) -> Array:
        """A set-point that goes round, at 63 mm/s."""
        a, r, w = np.pi * elapsed, 0.02, np.pi
        around = r * np.array([np.sin(a), 1.0 - np.cos(a), 0.0, w * np.cos(a), w * np.sin(a), 0.0])
        return self.off(0.0) + around

    def go(self, seconds: float, commanded: Callable[[float], Array | None] | None = None) -> None:
        """Stream set-points for a while."""
        self.until(lambda: False, seconds, commanded)

    def follow(self) -> bool:
        """Ask for control and wait for the arm to follow."""
        self.home = self.position
        self.driver.request_control()
        return self.until(lambda: self.following)

    def seen(self, fault: ArmFault, commanded: Callable[[float], Array | None] | None = None) -> bool:
        """Stream set-points until the driver tells a fault."""
        return self.until(lambda: self.fault == fault, 5.0, commanded)

    def ticks_to_rest(self, since: int) -> int:
        """Of the robot's milliseconds, until no motion runs any more."""
        for _ in range(2000):
            told = self.franka.get()
            if not told["moving"]:
                break
            self.driver.send(self.stay(0.0))
            time.sleep(_TICK)
        return int(told["ticks"]) - since
