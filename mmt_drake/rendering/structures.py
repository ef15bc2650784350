"""Structures in which a renderer takes theta, beside the flexible object's own: the thesis's first examples.

- `mass_spring_damper`, eq. 1 and 2: F = -(m x'' + b1 x' + k1 (x - x_r)), the hand has hold of the body. That asks for
  its acceleration, which nobody measures: between hand and body stands a virtual coupling, a spring and a damper so
  stiff that up to some hertz nothing is left of it (Colgate, Stanley, Brown: "Issues in the haptic display of tool
  use", IROS 1995). Numbers of the contact spring and friction are not used.
- `spring`, eq. 10: F = -k2 (x - x_r), and -k z along the normal; nothing moves, nothing damps.

x_r is where the hand has touched, at the surface along the normal. Both are the flexible object with other numbers, so
all that holds of its renderer holds of them.
"""

from typing import Final, Literal

import numpy as np

from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array

RenderedStructure = Literal["flexible_box", "mass_spring_damper", "spring"]

COUPLING: Final = 200.0
"""Natural frequency of the body on a virtual coupling that is critically damped [rad/s]."""
_HELD_N: Final = 1e9
"""Friction that nothing overcomes [N]."""
_m, _k1, _k2, _b1, _b2, _Fc, _normal_k, _normal_b, _Fs, _v_d = range(len(THETA))


def rendered_as(structure: RenderedStructure, theta: Array) -> Array:
    """theta (10,) of the flexible object that does what a structure does with this theta."""
    if structure == "flexible_box":
        return theta
    found: Array = np.array(theta, dtype=np.float64)
    if structure == "spring":
        found[[_k1, _b1, _b2, _normal_b, _v_d]], found[[_Fc, _Fs]] = 0.0, _HELD_N
    else:
        found[_k2], found[_b2] = COUPLING**2 * found[_m], 2.0 * COUPLING * found[_m]
        found[[_Fc, _Fs, _v_d]] = 0.0
    return found
