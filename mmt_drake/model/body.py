"""One body with friction on one axis: the equation of motion and its compiled integration.

A tangential axis of the flexible object and a driven body are both this::

    m v' = -k1 x - b1 v + [k2 d + b2 (v_p - v)] + [gain u + offset - G(x)] - friction

The first bracket is the contact spring and damper, there while the probe (position p, velocity v_p) holds the
body, with d = p - x - anchor. The second is there where something drives the body by an input u, under gravity
G(x) = pendulum sin x; a constant gravity is part of the offset.

Friction is set-valued at rest, so the integration knows two modes. *Sliding* in one direction the equation is smooth
and a classical Runge-Kutta step (order 4) is taken, the input being evaluated inside the step. The step ends where the
body would stick or turn, and there the mode changes. *Stuck*, the body waits until the drive passes the break-away
level.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.hermite import hermite_coefficients, hermite_position, hermite_velocity
from mmt_drake.model.parameters import B1, B2, DRIVEN, FD, FS, GAIN, K1, K2, MAX_STEP, OFFSET, PENDULUM, VD, M

Array = NDArray[np.float64]

# Layout of a body's state.
AXIS_SIZE = 4
POSITION, VELOCITY, ANCHOR, MODE = range(AXIS_SIZE)  # mode: 0 stuck, else the direction of sliding

_BISECTIONS = 40  # halves a step of 1 ms to 1e-15 s
_MOST_EVENTS = 1000  # mode changes within one sample interval, which no physical friction makes


@njit(inline="always")
def contact_push(d: float, d_rate: float, p: Array) -> float:
    """Force of the contact spring and damper on the body [N]; the probe feels its negative."""
    return p[K2] * d + p[B2] * d_rate


@njit(inline="always")
def drive(x: float, v: float, xp: float, vp: float, anchor: float, contact: bool, p: Array) -> float:
    """All forces on the body but friction [N]; xp, vp are the probe's motion, or the input and its rate."""
    force = -p[K1] * x - p[B1] * v
    if contact:
        force += contact_push(xp - x - anchor, vp - v, p)
    if p[DRIVEN] != 0.0:
        force += p[GAIN] * xp + p[OFFSET] - p[PENDULUM] * math.sin(x)
    return force


@njit(inline="always")
def _may_stick(x: float, v: float, xp: float, vp: float, anchor: float, contact: bool, p: Array) -> bool:
    """Karnopp's condition; what has to be held is the drive of a body at rest."""
    return abs(v) < p[VD] and abs(drive(x, 0.0, xp, vp, anchor, contact, p)) < p[FS]


@njit(inline="always")
def _slide(
    x: float,
    v: float,
    mode: float,
    s: float,
    h: float,
    x0: float,
    v0: float,
    c2: float,
    c3: float,
    anchor: float,
    contact: bool,
    p: Array,
) -> tuple[float, float]:
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
def _break_away(
    x: float, s: float, s_end: float, x0: float, v0: float, c2: float, c3: float, anchor: float, contact: bool, p: Array
) -> tuple[float, float]:
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
def _end_of_slide(
    x: float,
    v: float,
    x1: float,
    v1: float,
    mode: float,
    s: float,
    h: float,
    x0: float,
    v0: float,
    c2: float,
    c3: float,
    anchor: float,
    contact: bool,
    p: Array,
) -> float:
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


@njit(cache=True, error_model="numpy")
def advance_axis(
    state: Array, at: int, contact: bool, s: float, s_end: float, x0: float, v0: float, c2: float, c3: float, p: Array
) -> None:
    """Advance a body from s to s_end [s] after the latest sample, in place.

    Args:
        state: holds the body's position, velocity, anchor and mode.
        at: where they begin in it.
        contact: whether the probe holds the contact spring throughout.
        s, s_end: the stretch of time within the sample interval.
        x0, v0, c2, c3: the probe's motion, or the input, over the interval, see `mmt_drake.model.hermite`.
        p: kernel vector.
    """
    x, v, anchor, mode = state[at + POSITION], state[at + VELOCITY], state[at + ANCHOR], state[at + MODE]
    smooth = p[FS] == 0.0 and p[FD] == 0.0
    h_max = s_end - s
    if h_max > p[MAX_STEP]:
        h_max /= math.ceil(h_max / p[MAX_STEP])
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
        if ends:
            events += 1
            if events > _MOST_EVENTS:
                raise RuntimeError("the body sticks and slides more than 1000 times within one step")
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
    state[at + POSITION], state[at + VELOCITY], state[at + MODE] = x, v, mode
