"""The controller of a closed loop: it drives a body towards the goal that its input then is.

In continuous time, with the error e = goal - x::

    u = kp e + ki q - kd x',   held within the limits,   q' = e

The derivative is that of the measured position, so a step of the goal does not kick. Where u is at a limit and the
error would push it further, q waits (conditional integration: Astrom and Hagglund 2006, Advanced PID Control, 3.5).
The body is driven by gain u. Goals are linear between samples, as any input is.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.model.driven_body import swallowed
from mmt_drake.model.laws import ActiveLaw, At, Numbers, Own, Result, Slot, law
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Quantity

ControllerKind = Literal["p", "pd", "pi", "pid"]


@law(Slot.DRIVE)
def _direct(at: At, q: Own, p: Numbers) -> Result:
    gain, kp, _, kd, low, high = p
    return gain * min(max(kp * (at.force / gain - at.x) - kd * at.v, low), high), 0.0, 0.0, 0.0


@law(Slot.DRIVE, remembers=True)
def _integrating(at: At, q: Own, p: Numbers) -> Result:
    gain, kp, ki, kd, low, high = p
    error = at.force / gain - at.x
    wanted = kp * error + ki * q[0] - kd * at.v
    u = min(max(wanted, low), high)
    rate = 0.0 if (wanted - u) * error > 0.0 else error
    return gain * u, rate, 0.0, 0.0


@law(Slot.BODY)
def _dead(at: At, q: Own, p: Numbers) -> Result:
    return -swallowed(at.force, p[0] * abs(p[1])), 0.0, 0.0, 0.0


@dataclass(frozen=True)
class Controller(Checked):
    """Gains and limits of a controller, which are known: nothing of it is fitted.

    Attributes:
        kind: which gains it has: p, pd, pi or pid.
        kp: unit of the body's input over that of its output.
        ki: the same per second.
        kd: the same times a second.
        low, high: limits of what it puts out, in the unit of the body's input.

    Raises:
        BadInput: a gain that is negative or not finite, or not of the kind; limits that leave nothing between them.
    """

    kind: ControllerKind
    kp: Annotated[float, Quantity("")]
    ki: Annotated[float, Quantity("1/s")] = 0.0
    kd: Annotated[float, Quantity("s")] = 0.0
    low: float = -math.inf
    high: float = math.inf

    CALLED: ClassVar = "controller"

    def __post_init__(self) -> None:
        super().__post_init__()
        for part, value in (("i", self.ki), ("d", self.kd)):
            if value != 0.0 and part not in self.kind:
                raise BadInput("controller", at=f"k{part}", found=f"{value:g} of a {self.kind}", expected="0")
        if not self.low < self.high:
            raise BadInput("controller", at="limits", found=f"{self.low:g} to {self.high:g}", expected="low below high")

    def commanded(self, time: Array, goal: Array, x: Array, v: Array) -> Array:
        """(n,) what it put out where its goal, the body's position and rate are known at times [s], (n,) each."""
        low, high, error = self.low, self.high, goal - x
        wanted = self.kp * error - self.kd * v
        if self.ki == 0.0:
            return np.clip(wanted, low, high)
        q, steps = 0.0, np.diff(time, append=time[-1])
        for k, step in enumerate(steps.tolist()):
            wanted[k] += self.ki * q
            if (wanted[k] - min(max(wanted[k], low), high)) * error[k] <= 0.0:
                q += error[k] * step
        return np.clip(wanted, low, high)

    def laws(self, gain: float, dead_band: float) -> tuple[ActiveLaw, ...]:
        """The controller as what drives a body of a gain [N per unit of its input] beyond a dead band of that."""
        numbers = (gain, self.kp, self.ki, self.kd, self.low, self.high)
        drives = _integrating if "i" in self.kind else _direct
        controls = ActiveLaw(drives, numbers, abs(gain) * self.kp, abs(gain) * self.kd)
        # One without a width as well: knots of a curve over the width make vectors of one length.
        return (controls, ActiveLaw(_dead, (dead_band, gain)))
