"""The flexible object on the table: equations of motion and their compiled integration.

One tangential axis (figure 3 of the thesis; x and y are alike and independent)::

    m v_m' = k2 d + b2 (v - v_m) - k1 x_m - b1 v_m - friction        in contact
    m v_m' =                     - k1 x_m - b1 v_m - friction        off contact
    F      = -(k2 d + b2 (v - v_m)),   d = x - x_m - (x - x_m at touch)

The normal axis is the Kelvin-Voigt contact of eq. 8, F_z = -k z - b v_z for z < 0, and free space
is eq. 9, F = 0.

Touch and release are located within a step, so a result depends on the sampling of the motion only through its
interpolation. How a body with friction is integrated stands in `mmt_drake.model.body`.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import ANCHOR, AXIS_SIZE, BISECTIONS, POSITION, VELOCITY, advance_axis, contact_push
from mmt_drake.model.hermite import Cubic, cubic, position_at
from mmt_drake.model.parameters import NORMAL_B, NORMAL_K

Array = NDArray[np.float64]

# Layout of the state vector.
TIME = 0  # [s] of the latest sample
PROBE = 1  # (6) position [m] and velocity [m/s] at that sample
CONTACT = 7  # 0 or 1
BODY = 8  # two axes of (position, velocity, anchor, mode)
STATE_SIZE = BODY + 2 * AXIS_SIZE

#: `contact` argument of `advance`: contact is where the probe is below the surface.
CONTACT_BY_GEOMETRY = -1.0


@njit(inline="always")
def normal_force(z: float, vz: float, p: Array) -> float:
    """Force on the probe along the surface normal, in contact [N] (eq. 8)."""
    return -p[NORMAL_K] * z - p[NORMAL_B] * vz


@njit(inline="always")
def _crossing(height: Cubic, h: float) -> float:
    """Time after the sample at which the probe's height changes sign within h [s]."""
    above = height.x0 >= 0.0
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        if (position_at(height, mid) >= 0.0) == above:
            low = mid
        else:
            high = mid
    return high


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, motion: Array, contact: float, p: Array) -> None:
    """The object at rest under the probe's first sample, in place.

    Args:
        state: (STATE_SIZE,) to be filled.
        t: time of the first sample [s].
        motion: (6,) position [m] and velocity [m/s] of the probe.
        contact: 0 or 1, or CONTACT_BY_GEOMETRY.
        p: kernel vector.
    """
    state[:] = 0.0
    state[TIME] = t
    touching = motion[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    state[CONTACT] = 1.0 if touching else 0.0
    for i in range(6):
        state[PROBE + i] = motion[i]
    for i in range(2):
        state[BODY + AXIS_SIZE * i + ANCHOR] = motion[i]


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, motion: Array, contact: float, p: Array) -> None:
    """Advance the object to the probe's next sample, in place; t must not lie before the state's time.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: time of the sample [s]; equal to the state's time only replaces the sample.
        motion: (6,) position [m] and velocity [m/s] of the probe there.
        contact: CONTACT_BY_GEOMETRY (z < 0, touch and release located between samples), or 0 or 1 as
            told by a detector or a recording (then touch and release fall on the surface crossing if
            there is one in this interval, else on the sample).
        p: kernel vector.
    """
    h = t - state[TIME]
    before = state[CONTACT] != 0.0
    after = motion[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    z0 = state[PROBE + 2]
    s_switch = h
    if before != after and h > 0.0 and (z0 < 0.0) == before and (motion[2] < 0.0) == after:
        s_switch = _crossing(cubic(z0, state[PROBE + 5], motion[2], motion[5], h), h)
    for i in range(2):
        body = BODY + AXIS_SIZE * i
        probe = Cubic(motion[i], motion[3 + i], 0.0, 0.0)
        if h > 0.0:
            probe = cubic(state[PROBE + i], state[PROBE + 3 + i], motion[i], motion[3 + i], h)
            advance_axis(state, body, before, 0.0, s_switch, probe, p)
        if after and not before:
            state[body + ANCHOR] = position_at(probe, s_switch) - state[body + POSITION]
        if s_switch < h:
            advance_axis(state, body, after, s_switch, h, probe, p)
    state[TIME] = t
    state[CONTACT] = 1.0 if after else 0.0
    for i in range(6):
        state[PROBE + i] = motion[i]


@njit(cache=True, error_model="numpy")
def force_on_probe(state: Array, p: Array, force: Array) -> None:
    """Write the (3,) force that the object exerts on the probe at the latest sample [N]."""
    if state[CONTACT] == 0.0:
        force[0] = force[1] = force[2] = 0.0
        return
    for i in range(2):
        body = BODY + AXIS_SIZE * i
        d = state[PROBE + i] - state[body + POSITION] - state[body + ANCHOR]
        force[i] = -contact_push(d, state[PROBE + 3 + i] - state[body + VELOCITY], p)
    force[2] = normal_force(state[PROBE + 2], state[PROBE + 5], p)


@njit(cache=True, error_model="numpy")
def replay(time: Array, position: Array, velocity: Array, contact: Array, p: Array, force: Array, body: Array) -> None:
    """Free-running simulation over a whole recording, at rest at the first sample.

    Args:
        time: (n,) sample times [s], increasing.
        position, velocity: (n, 3) of the probe [m], [m/s].
        contact: (n,) of 0 and 1, or of CONTACT_BY_GEOMETRY.
        p: kernel vector.
        force: (n, 3) to be filled with the force on the probe [N].
        body: (n, 4) to be filled with x_m, y_m [m] and their rates [m/s].
    """
    # One scratch vector each: rows of arrays as arguments would cost as much as the integration.
    state, motion, felt = np.empty(STATE_SIZE), np.empty(6), np.empty(3)
    for k in range(len(time)):
        for i in range(3):
            motion[i], motion[3 + i] = position[k, i], velocity[k, i]
        if k == 0:
            begin(state, time[k], motion, contact[k], p)
        else:
            advance(state, time[k], motion, contact[k], p)
        force_on_probe(state, p, felt)
        for i in range(3):
            force[k, i] = felt[i]
        for i in range(2):
            body[k, i] = state[BODY + AXIS_SIZE * i + POSITION]
            body[k, 2 + i] = state[BODY + AXIS_SIZE * i + VELOCITY]
