"""How much force, speed, power and room a device may have, and how long anything may be silent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput, check_number

#: No fault leaves a force on for longer than this after the first tick that could see it [s].
STOP_WITHIN = 0.020

_BOX = "three finite numbers [m], each of `low` below its partner of `high`"


@dataclass(frozen=True)
class SafetyLimits:
    """Limits of one device; the defaults suit a hand-held haptic device of the Omega's size.

    Force and power are limits that scale a command down, direction kept; everything else is a fault.

    Attributes:
        force: greatest force [N].
        power: greatest power that the device gives to what moves it, force times velocity [W].
        speed: a device that moves faster has been let go [m/s].
        low, high: corners of the box that it must stay in, table frame [m].
        gap: longest time between two readings of the device, and longest silence of its clock [s].
        stuck: a position that does not change by one bit for this long, under a force or at a speed, is stuck [s].
        ramp: time in which a force falls to zero after a fault [s].
        rise: time in which it comes back after arming [s].

    Raises:
        BadInput: a limit that is not positive and finite, a box without room, a ramp longer than `STOP_WITHIN`.
    """

    force: float = 6.0
    power: float = 5.0
    speed: float = 1.0
    low: tuple[float, float, float] = (-0.2, -0.2, -0.2)
    high: tuple[float, float, float] = (0.2, 0.2, 0.2)
    gap: float = 0.010
    stuck: float = 0.100
    ramp: float = 0.015
    rise: float = 0.25

    def __post_init__(self) -> None:
        for name in ("force", "power", "speed", "gap", "stuck", "ramp", "rise"):
            check_number("safety limits", name, getattr(self, name), least=0.0, open_interval=True)
        box = (*self.low, *self.high)
        ordered = len(self.low) == len(self.high) == 3 and all(a < b for a, b in zip(self.low, self.high, strict=True))
        if not (ordered and all(map(math.isfinite, box))):
            raise BadInput("safety limits", at="low, high", found=(self.low, self.high), expected=_BOX)
        if self.ramp > STOP_WITHIN:
            raise BadInput("safety limits", at="ramp", found=self.ramp, expected=f"at most {STOP_WITHIN:g} s")

    def kernel_vector(self) -> NDArray[np.float64]:
        """(13) the limits as the kernel reads them, in the order of the attributes."""
        motion = (self.force, self.power, self.speed, *self.low, *self.high)
        return np.array((*motion, self.gap, self.stuck, self.ramp, self.rise), dtype=np.float64)
