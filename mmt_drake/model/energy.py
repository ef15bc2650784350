"""The energy that a flexible object holds in store."""

from numba import njit

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, POSITION, VELOCITY, read_motion
from mmt_drake.model.flexible_box import (
    BODY,
    CONTACT,
    PROBE,
    around_axis,
    axes_of_laws,
    deflection_of,
    facet_of,
    stored_along_normal,
    tip_of,
)
from mmt_drake.model.forces import beside, constants, deflection, stored_in_laws
from mmt_drake.model.local_contact import height_above, is_level
from mmt_drake.model.parameters import GAP, K1, K2, LAWS, NORMAL_AXIS, NORMAL_K, M
from mmt_drake.numeric.arrays import Array


@njit(cache=True)
def stored_energy(state: Array, p: Array) -> float:
    """Energy [J] that an object whose kernel vector is p holds in store.

    E = m v_m²/2 + k1 x_m²/2 for each tangential axis, and in contact k2 d²/2, d without the clearance, and k z²/2 along
    the normal, and what laws hold (`Law.stored`). As long as no stiffness, damper or mass is negative, the laws are
    passive (`Effect.passive`) and nothing changes, a hand gets no more out than this.
    """
    energy = 0.0
    contact = state[CONTACT] != 0.0
    for i in range(2):
        body = BODY + AXIS_SIZE * i
        x, v = state[body + POSITION], state[body + VELOCITY]
        energy += 0.5 * (p[M] * v * v + p[K1] * x * x)
        if contact and p[GAP] == 0.0:
            d = state[PROBE + i] - x - state[body + ANCHOR]
            energy += 0.5 * p[K2] * d * d
    if contact and p[NORMAL_AXIS] != 0.0:
        energy += stored_along_normal(state, p)
    if contact and is_level(facet_of(state)):
        energy += 0.5 * p[NORMAL_K] * state[PROBE + 2] ** 2
    elif contact:
        above = height_above(facet_of(state), tip_of(state))
        energy += 0.5 * (p[K2] * deflection_of(state)[2] ** 2 + p[NORMAL_K] * above**2)
    across_gap = contact and p[GAP] != 0.0
    return energy + _stored_in_laws(state, p, across_gap) if p[LAWS] != 0.0 or across_gap else energy


@njit(error_model="numpy")
def _stored_in_laws(state: Array, p: Array, across_gap: bool) -> float:
    """In laws, and in the contact spring behind a clearance, which acts on a level surface alone [J]."""
    c, (first, second) = constants(p), axes_of_laws(state)
    x, y = read_motion(state, BODY), read_motion(state, BODY + AXIS_SIZE)
    along, across = around_axis(state, 0, first, p, c), around_axis(state, 1, second, p, c)
    beside_x, beside_y = beside(y, 0.0, across, c), beside(x, 0.0, along, c)
    energy = 0.0
    if across_gap:
        d_x = deflection(x.x, x.v, 0.0, along, c, beside_x).d
        d_y = deflection(y.x, y.v, 0.0, across, c, beside_y).d
        energy += 0.5 * float(p[K2]) * (d_x * d_x + d_y * d_y)
    if p[LAWS] != 0.0:
        energy += stored_in_laws(x, 0.0, along, c, beside_x) + stored_in_laws(y, 0.0, across, c, beside_y)
    return energy
