"""A hand that yields to what it feels: the impedance of arm and device about the motion that was intended.

On each axis m e'' + b e' + k e = F for the deviation e from the intended motion, F being held between ticks. A person
who meets no force so moves as intended. Stiffness 50 to 300 N/m, damping 5 to 30 N s/m and 1 to 2 kg are what is
measured of arms at rest (Tsuji, Morasso, Goto, Ito, "Human hand impedance characteristics during maintained posture",
Biological Cybernetics 72, 1995); a device adds its moving mass.
"""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

from numba import njit

from mmt_drake.model.second_order import exact_step
from mmt_drake.numeric.arrays import Array
from mmt_drake.quantities import Checked, Damping, Force, Mass, Quantity


@dataclass(frozen=True)
class HandImpedance(Checked):
    """Of arm and device together, on each axis.

    Attributes:
        mass: [kg], > 0.
        damping: [N s/m], >= 0.
        stiffness: [N/m], > 0.
        force_limit: the most that the device gives [N], > 0; 12 N is an Omega.7's. A greater force becomes so large.

    Raises:
        BadInput: a number outside these ranges.
    """

    mass: Mass = 1.0
    damping: Damping = 15.0
    stiffness: Annotated[float, Quantity("N/m", positive=True)] = 200.0
    force_limit: Force = 12.0

    CALLED: ClassVar = "hand"

    def matrices(self, period: float) -> tuple[Array, Array]:
        """The exact step over a period [s] of a held force: (2, 2) for deviation and rate, (2,) for the force."""
        return exact_step(self.mass, self.damping, self.stiffness, period)


@njit(cache=True)
def step_deviation(deviation: Array, force: Array, limit: float, own: Array, forced: Array) -> None:
    """One tick, in place.

    Args:
        deviation: (6,) from the intended motion [m], then its rate [m/s].
        force: (3,) on the hand [N].
        limit: the most that the device gives [N].
        own, forced: `HandImpedance.matrices`.
    """
    length = math.sqrt(force[0] ** 2 + force[1] ** 2 + force[2] ** 2)
    part = 1.0 if length <= limit else limit / length
    for i in range(3):
        e, v, F = deviation[i], deviation[3 + i], part * force[i]
        deviation[i] = own[0, 0] * e + own[0, 1] * v + forced[0] * F
        deviation[3 + i] = own[1, 0] * e + own[1, 1] * v + forced[1] * F
