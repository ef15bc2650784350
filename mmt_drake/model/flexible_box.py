"""The flexible object on the table: equations of motion and their compiled integration.

One tangential axis (figure 3 of the thesis; x and y are alike and independent)::

    m v_m' = k2 d + b2 (v - v_m) - k1 x_m - b1 v_m - friction        in contact
    m v_m' =                     - k1 x_m - b1 v_m - friction        off contact
    F      = -(k2 d + b2 (v - v_m)),   d = x - x_m - (x - x_m at touch)

The normal axis is the Kelvin-Voigt contact of eq. 8, F_z = -k z - b v_z for z < 0, and free space
is eq. 9, F = 0.

Friction is set-valued at rest, so the integration knows two modes. *Sliding* in one direction the
equations are smooth and a classical Runge-Kutta step (order 4) is taken, the probe's motion being
evaluated inside the step. The step ends where the body would stick or turn, and there the mode
changes. *Stuck*, the body waits until the drive passes the break-away level. Touch and release are
located within the step as well, so a result depends on the sampling of the motion only through its
interpolation.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.hermite import hermite_coefficients, hermite_position, hermite_velocity
from mmt_drake.model.parameters import B1, B2, FD, FS, K1, K2, MAX_STEP, NORMAL_B, NORMAL_K, VD, M

Array = NDArray[np.float64]

# Layout of the state vector.
TIME = 0  # [s] of the latest sample
PROBE_POSITION = 1  # (3) [m] at that sample
PROBE_VELOCITY = 4  # (3) [m/s]
CONTACT = 7  # 0 or 1
BODY = 8  # two axes of (position, velocity, anchor, mode)
AXIS_SIZE = 4
POSITION, VELOCITY, ANCHOR, MODE = range(AXIS_SIZE)
STATE_SIZE = BODY + 2 * AXIS_SIZE

_BISECTIONS = 40  # halves a step of 1 ms to 1e-15 s
_MAX_EVENTS = 64  # mode changes within one step; beyond it the body is left sliding to the step's end

#: `contact` argument of `advance`: contact is where the probe is below the surface.
CONTACT_BY_GEOMETRY = -1.0


@njit(inline="always")
def contact_push(d: float, d_rate: float, p: Array) -> float:
    """Force of the contact spring and damper on the body [N]; the probe feels its negative."""
    return p[K2] * d + p[B2] * d_rate


@njit(inline="always")
def normal_force(z: float, vz: float, p: Array) -> float:
    """Force on the probe along the surface normal, in contact [N] (eq. 8)."""
    return -p[NORMAL_K] * z - p[NORMAL_B] * vz


@njit(inline="always")
def drive(x: float, v: float, xp: float, vp: float, anchor: float, contact: bool, p: Array) -> float:
    """All forces on the body but friction [N]."""
    force = -p[K1] * x - p[B1] * v
    if contact:
        force += contact_push(xp - x - anchor, vp - v, p)
    return force


@njit(inline="always")
def _may_stick(x: float, v: float, xp: float, vp: float, anchor: float, contact: bool, p: Array) -> bool:
    """Karnopp's condition; what has to be held is the drive of a body at rest."""
    return abs(v) < p[VD] and abs(drive(x, 0.0, xp, vp, anchor, contact, p)) < p[FS]


@njit(inline="always")
def _slide(x, v, mode, s, h, x0, v0, c2, c3, anchor, contact, p):  # type: ignore[no-untyped-def]
    """One Runge-Kutta step of order 4 while sliding in the direction `mode`: (x, v) at s + h."""
    xa, va = hermite_position(x0, v0, c2, c3, s), hermite_velocity(v0, c2, c3, s)
    sm = s + 0.5 * h
    xm, vm = hermite_position(x0, v0, c2, c3, sm), hermite_velocity(v0, c2, c3, sm)
    se = s + h
    xe, ve = hermite_position(x0, v0, c2, c3, se), hermite_velocity(v0, c2, c3, se)
    friction = mode * p[FD]
    per_mass = 1.0 / p[M]
    a1 = (drive(x, v, xa, va, anchor, contact, p) - friction) * per_mass
    v2 = v + 0.5 * h * a1
    a2 = (drive(x + 0.5 * h * v, v2, xm, vm, anchor, contact, p) - friction) * per_mass
    v3 = v + 0.5 * h * a2
    a3 = (drive(x + 0.5 * h * v2, v3, xm, vm, anchor, contact, p) - friction) * per_mass
    v4 = v + h * a3
    a4 = (drive(x + h * v3, v4, xe, ve, anchor, contact, p) - friction) * per_mass
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@njit(inline="always")
def _break_away(x, s, s_end, x0, v0, c2, c3, anchor, contact, p):  # type: ignore[no-untyped-def]
    """When a stuck body lets go within [s, s_end], and in which direction; s_end and 0 if it does not."""
    force = drive(x, 0.0, hermite_position(x0, v0, c2, c3, s), hermite_velocity(v0, c2, c3, s), anchor, contact, p)
    if abs(force) > p[FS]:
        return s, math.copysign(1.0, force)
    force = drive(
        x, 0.0, hermite_position(x0, v0, c2, c3, s_end), hermite_velocity(v0, c2, c3, s_end), anchor, contact, p
    )
    if abs(force) <= p[FS]:
        return s_end, 0.0
    low, high = s, s_end
    direction = math.copysign(1.0, force)
    for _ in range(_BISECTIONS):
        mid = 0.5 * (low + high)
        force = drive(
            x, 0.0, hermite_position(x0, v0, c2, c3, mid), hermite_velocity(v0, c2, c3, mid), anchor, contact, p
        )
        if abs(force) > p[FS]:
            high = mid
        else:
            low = mid
    return high, direction


@njit(inline="always")
def _end_of_slide(x, v, x1, v1, mode, s, h, x0, v0, c2, c3, anchor, contact, p):  # type: ignore[no-untyped-def]
    """The first moment (after s) in a step of h at which a sliding body turns or sticks.

    The body's motion inside the step is the cubic through its ends.
    """
    a0 = (
        drive(x, v, hermite_position(x0, v0, c2, c3, s), hermite_velocity(v0, c2, c3, s), anchor, contact, p)
        - mode * p[FD]
    ) / p[M]
    se = s + h
    a1 = (
        drive(x1, v1, hermite_position(x0, v0, c2, c3, se), hermite_velocity(v0, c2, c3, se), anchor, contact, p)
        - mode * p[FD]
    ) / p[M]
    d2, d3 = hermite_coefficients(v, a0, v1, a1, h)
    e2, e3 = hermite_coefficients(x, v, x1, v1, h)
    low, high = 0.0, h
    for _ in range(_BISECTIONS):
        mid = 0.5 * (low + high)
        v_mid = hermite_position(v, a0, d2, d3, mid)
        x_mid = hermite_position(x, v, e2, e3, mid)
        xp, vp = hermite_position(x0, v0, c2, c3, s + mid), hermite_velocity(v0, c2, c3, s + mid)
        if v_mid * mode < 0.0 or _may_stick(x_mid, v_mid, xp, vp, anchor, contact, p):
            high = mid
        else:
            low = mid
    return high


@njit(cache=True)
def advance_axis(body, contact, s, s_end, x0, v0, c2, c3, p):  # type: ignore[no-untyped-def]
    """Advance one tangential axis from s to s_end [s] after the latest sample, in place.

    Args:
        body: (4,) position, velocity, anchor, mode of the axis.
        contact: whether the probe holds the contact spring throughout.
        s, s_end: the stretch of time within the sample interval.
        x0, v0, c2, c3: the probe's motion over the interval, see `mmt_drake.model.hermite`.
        p: kernel vector.
    """
    x, v, anchor, mode = body[POSITION], body[VELOCITY], body[ANCHOR], body[MODE]
    smooth = p[FS] == 0.0 and p[FD] == 0.0
    steps = math.ceil((s_end - s) / p[MAX_STEP])
    h_max = (s_end - s) / max(steps, 1)
    events = 0
    while s < s_end:
        if mode == 0.0 and not smooth:
            v = 0.0
            s, mode = _break_away(x, s, s_end, x0, v0, c2, c3, anchor, contact, p)
            if mode == 0.0:
                break
        last = s + 1.5 * h_max > s_end and s + h_max >= s_end - 1e-9 * h_max
        h = s_end - s if last else h_max
        x1, v1 = _slide(x, v, mode, s, h, x0, v0, c2, c3, anchor, contact, p)
        xp, vp = hermite_position(x0, v0, c2, c3, s + h), hermite_velocity(v0, c2, c3, s + h)
        ends = not smooth and (v1 * mode < 0.0 or _may_stick(x1, v1, xp, vp, anchor, contact, p))
        if ends and events < _MAX_EVENTS:
            events += 1
            h = _end_of_slide(x, v, x1, v1, mode, s, h, x0, v0, c2, c3, anchor, contact, p)
            last = False
            x1, v1 = _slide(x, v, mode, s, h, x0, v0, c2, c3, anchor, contact, p)
            xp, vp = hermite_position(x0, v0, c2, c3, s + h), hermite_velocity(v0, c2, c3, s + h)
            held = drive(x1, 0.0, xp, vp, anchor, contact, p)
            if abs(held) <= p[FS]:
                v1, mode = 0.0, 0.0
            else:
                # It turns: the drive beats friction in the other direction.
                v1, mode = 0.0, math.copysign(1.0, held)
        x, v = x1, v1
        s = s_end if last else s + h
    body[POSITION], body[VELOCITY], body[MODE] = x, v, mode


@njit(inline="always")
def _crossing(z0: float, v0: float, c2: float, c3: float, h: float) -> float:
    """Time after the sample at which the probe's height changes sign within h [s]."""
    above = z0 >= 0.0
    low, high = 0.0, h
    for _ in range(_BISECTIONS):
        mid = 0.5 * (low + high)
        if (hermite_position(z0, v0, c2, c3, mid) >= 0.0) == above:
            low = mid
        else:
            high = mid
    return high


@njit(cache=True)
def begin(state, t, position, velocity, contact, p):  # type: ignore[no-untyped-def]
    """The object at rest under the probe's first sample, in place.

    Args:
        state: (STATE_SIZE,) to be filled.
        t: time of the first sample [s].
        position, velocity: (3,) of the probe [m], [m/s].
        contact: 0 or 1, or CONTACT_BY_GEOMETRY.
        p: kernel vector.
    """
    state[:] = 0.0
    state[TIME] = t
    touching = position[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    state[CONTACT] = 1.0 if touching else 0.0
    for i in range(3):
        state[PROBE_POSITION + i] = position[i]
        state[PROBE_VELOCITY + i] = velocity[i]
    for i in range(2):
        state[BODY + AXIS_SIZE * i + ANCHOR] = position[i]


@njit(cache=True)
def advance(state, t, position, velocity, contact, p):  # type: ignore[no-untyped-def]
    """Advance the object to the probe's next sample, in place; t must not lie before the state's time.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: time of the sample [s]; equal to the state's time only replaces the sample.
        position, velocity: (3,) of the probe there [m], [m/s].
        contact: CONTACT_BY_GEOMETRY (z < 0, touch and release located between samples), or 0 or 1 as
            told by a detector or a recording (then touch and release fall on the surface crossing if
            there is one in this interval, else on the sample).
        p: kernel vector.
    """
    h = t - state[TIME]
    before = state[CONTACT] != 0.0
    after = position[2] < 0.0 if contact == CONTACT_BY_GEOMETRY else contact != 0.0
    z0, vz0 = state[PROBE_POSITION + 2], state[PROBE_VELOCITY + 2]
    s_switch = h
    if before != after and h > 0.0 and (z0 < 0.0) == before and (position[2] < 0.0) == after:
        c2, c3 = hermite_coefficients(z0, vz0, position[2], velocity[2], h)
        s_switch = _crossing(z0, vz0, c2, c3, h)
    for i in range(2):
        body = state[BODY + AXIS_SIZE * i : BODY + AXIS_SIZE * (i + 1)]
        x0, v0 = state[PROBE_POSITION + i], state[PROBE_VELOCITY + i]
        touch_at = position[i]
        if h > 0.0:
            c2, c3 = hermite_coefficients(x0, v0, position[i], velocity[i], h)
            advance_axis(body, before, 0.0, s_switch, x0, v0, c2, c3, p)
            touch_at = hermite_position(x0, v0, c2, c3, s_switch)
        if after and not before:
            body[ANCHOR] = touch_at - body[POSITION]
        if s_switch < h:
            advance_axis(body, after, s_switch, h, x0, v0, c2, c3, p)
    state[TIME] = t
    state[CONTACT] = 1.0 if after else 0.0
    for i in range(3):
        state[PROBE_POSITION + i] = position[i]
        state[PROBE_VELOCITY + i] = velocity[i]


@njit(cache=True)
def force_on_probe(state, p, force):  # type: ignore[no-untyped-def]
    """Write the (3,) force that the object exerts on the probe at the latest sample [N]."""
    if state[CONTACT] == 0.0:
        force[0] = force[1] = force[2] = 0.0
        return
    for i in range(2):
        body = BODY + AXIS_SIZE * i
        d = state[PROBE_POSITION + i] - state[body + POSITION] - state[body + ANCHOR]
        force[i] = -contact_push(d, state[PROBE_VELOCITY + i] - state[body + VELOCITY], p)
    force[2] = normal_force(state[PROBE_POSITION + 2], state[PROBE_VELOCITY + 2], p)


@njit(cache=True)
def replay(time, position, velocity, contact, p, force, body):  # type: ignore[no-untyped-def]
    """Free-running simulation over a whole recording, at rest at the first sample.

    Args:
        time: (n,) sample times [s], increasing.
        position, velocity: (n, 3) of the probe [m], [m/s].
        contact: (n,) of 0 and 1, or of CONTACT_BY_GEOMETRY.
        p: kernel vector.
        force: (n, 3) to be filled with the force on the probe [N].
        body: (n, 4) to be filled with x_m, y_m [m] and their rates [m/s].
    """
    state = np.empty(STATE_SIZE)
    begin(state, time[0], position[0], velocity[0], contact[0], p)
    for k in range(len(time)):
        if k > 0:
            advance(state, time[k], position[k], velocity[k], contact[k], p)
        force_on_probe(state, p, force[k])
        for i in range(2):
            body[k, i] = state[BODY + AXIS_SIZE * i + POSITION]
            body[k, 2 + i] = state[BODY + AXIS_SIZE * i + VELOCITY]
