"""Energy that the flexible object of `mmt_drake.model.flexible_box` holds in store.

E = m v_m²/2 + k1 x_m²/2 for each tangential axis, and in contact k2 d²/2 for each and k z²/2 along the normal. Laws of
effects are not counted. As long as no stiffness, damper or mass is negative and none changes, a hand cannot get more
out of the object than this.
"""

from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION, VELOCITY
from mmt_drake.model.flexible_box import BODY, CONTACT, PROBE
from mmt_drake.model.parameters import K1, K2, NORMAL_K, M
from mmt_drake.numeric.arrays import Array


@njit(cache=True)
def stored_energy(state: Array, p: Array) -> float:
    """Energy [J] of an object in a state of `flexible_box`, whose kernel vector is p."""
    energy = 0.0
    contact = state[CONTACT] != 0.0
    for i in range(2):
        body = BODY + AXIS_SIZE * i
        x, v = state[body + POSITION], state[body + VELOCITY]
        energy += 0.5 * (p[M] * v * v + p[K1] * x * x)
        if contact:
            d = state[PROBE + i] - x - state[body + ANCHOR]
            energy += 0.5 * p[K2] * d * d
    if contact:
        energy += 0.5 * p[NORMAL_K] * state[PROBE + 2] ** 2
    return energy
