"""Limits of a device: how much force, speed, power and room it may have, and how long anything may be silent."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from mmt_drake.ceilings import Bound
from mmt_drake.errors import BadInput
from mmt_drake.quantities import Checked, Force, Quantity, Speed, Time

#: No fault leaves a force on for longer than this after the first tick that could see it [s].
STOP_WITHIN = 0.020

#: Of the device's makers: greatest continuous force 12 N, closed-loop stiffness 14.5 N/mm.
OMEGA_7 = "Force Dimension, omega.7 data sheet"
#: An option that no data sheet bounds: what this project stands for.
OURS = "this project's own bound"
REACH = 0.855
"""Of the arm that follows a hand [m] (Franka Robotics, Panda and FR3 data sheets): no box is larger."""

BOX = "each of `low` below its partner of `high`"


@dataclass(frozen=True)
class SafetyLimits(Checked):
    """Limits of one device; the defaults suit a hand-held haptic device of the Omega's size.

    Force and power are limits that scale a command down, direction kept; everything else is a fault. The bounds are
    those of an Omega.7, and keep `STOP_WITHIN` true: they hold for a device (`hw.omega.settings`), whose limits these
    are, not for the same limits in scaled units.

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

    force: Annotated[Force, Bound(12.0, "N", OMEGA_7)] = 6.0
    power: Annotated[float, Quantity("W", positive=True), Bound(24.0, "W", "12 N at 2 m/s")] = 5.0
    speed: Annotated[Speed, Bound(2.0, "m/s", OURS)] = 1.0
    low: Annotated[tuple[float, float, float], Bound(REACH, "m", "reach of the arm")] = (-0.2, -0.2, -0.2)
    high: Annotated[tuple[float, float, float], Bound(REACH, "m", "reach of the arm")] = (0.2, 0.2, 0.2)
    gap: Annotated[Time, Bound(STOP_WITHIN, "s", "a fault is over within 20 ms")] = 0.010
    stuck: Annotated[Time, Bound(0.2, "s", OURS)] = 0.100
    ramp: Annotated[Time, Bound(STOP_WITHIN, "s", "a fault is over within 20 ms")] = 0.015
    rise: Annotated[Time, Bound(0.02, "s", OURS, least=True)] = 0.25

    CALLED: ClassVar = "safety limits"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not all(a < b for a, b in zip(self.low, self.high, strict=True)):
            raise BadInput("safety limits", at="low, high", found=(self.low, self.high), expected=BOX)
        if self.ramp > STOP_WITHIN:
            raise BadInput("safety limits", at="ramp", found=self.ramp, expected=f"at most {STOP_WITHIN:g} s")

    def kernel_vector(self) -> NDArray[np.float64]:
        """(13) the limits as the kernel reads them, in the order of the attributes."""
        motion = (self.force, self.power, self.speed, *self.low, *self.high)
        return np.array((*motion, self.gap, self.stuck, self.ramp, self.rise), dtype=np.float64)
