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
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.hermite import Cubic, cubic, position_at, velocity_at
from mmt_drake.model.parameters import B1, B2, DRIVEN, FD, FS, GAIN, K1, K2, MAX_STEP, OFFSET, PENDULUM, VD, M

Array = NDArray[np.float64]

# Layout of a body's state.
AXIS_SIZE = 4
POSITION, VELOCITY, ANCHOR, MODE = range(AXIS_SIZE)  # mode: 0 stuck, else the direction of sliding

BISECTIONS = 40  # halve a step of 1 ms to 1e-15 s
_MOST_EVENTS = 1000  # mode changes within one sample interval, which no physical friction makes


class Surroundings(NamedTuple):
    """What acts on a body between two samples.

    Attributes:
        probe: the probe's motion [m], or the input that drives the body.
        anchor: probe less body where the contact spring is unstretched [m].
        contact: whether the probe holds the contact spring.
    """

    probe: Cubic
    anchor: float
    contact: bool


@njit(inline="always")
def contact_push(d: float, d_rate: float, p: Array) -> float:
    """Force of the contact spring and damper on the body [N]; the probe feels its negative."""
    return p[K2] * d + p[B2] * d_rate


@njit(inline="always")
def drive(x: float, v: float, s: float, around: Surroundings, p: Array) -> float:
    """All forces but friction on a body at x, v [m], [m/s], s [s] after the first sample [N]."""
    force = -p[K1] * x - p[B1] * v
    if around.contact:
        d = position_at(around.probe, s) - x - around.anchor
        force += contact_push(d, velocity_at(around.probe, s) - v, p)
    if p[DRIVEN] != 0.0:
        force += p[GAIN] * position_at(around.probe, s) + p[OFFSET] - p[PENDULUM] * math.sin(x)
    return force


@njit(inline="always")
def _acceleration(x: float, v: float, mode: float, s: float, around: Surroundings, p: Array) -> float:
    """Of a body that slides in the direction `mode` [m/s^2]."""
    return (drive(x, v, s, around, p) - mode * p[FD]) / p[M]


@njit(inline="always")
def _may_stick(x: float, v: float, s: float, around: Surroundings, p: Array) -> bool:
    """Karnopp's condition; what has to be held is the drive of a body at rest."""
    return abs(v) < p[VD] and abs(drive(x, 0.0, s, around, p)) < p[FS]


@njit(inline="always")
def _slide(x: float, v: float, mode: float, s: float, h: float, around: Surroundings, p: Array) -> tuple[float, float]:
    """One Runge-Kutta step of order 4 while sliding in the direction `mode`: (x, v) at s + h."""
    half = 0.5 * h
    a1 = _acceleration(x, v, mode, s, around, p)
    v2 = v + half * a1
    a2 = _acceleration(x + half * v, v2, mode, s + half, around, p)
    v3 = v + half * a2
    a3 = _acceleration(x + half * v2, v3, mode, s + half, around, p)
    v4 = v + h * a3
    a4 = _acceleration(x + h * v3, v4, mode, s + h, around, p)
    return x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4), v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@njit(inline="always")
def _break_away(x: float, s: float, s_end: float, around: Surroundings, p: Array) -> tuple[float, float]:
    """When a stuck body lets go within [s, s_end], and in which direction; s_end and 0 if it does not."""
    level = p[FS]
    force = drive(x, 0.0, s, around, p)
    if abs(force) > level:
        return s, math.copysign(1.0, force)
    force = drive(x, 0.0, s_end, around, p)
    if abs(force) <= level:
        return s_end, 0.0
    low, high = s, s_end
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        if abs(drive(x, 0.0, mid, around, p)) > level:
            high = mid
        else:
            low = mid
    return high, math.copysign(1.0, force)


@njit(inline="always")
def _end_of_slide(
    x: float, v: float, x1: float, v1: float, mode: float, s: float, h: float, around: Surroundings, p: Array
) -> float:
    """How long after s, within a step of h to (x1, v1), a sliding body turns or sticks.

    The body's motion inside the step is the cubic through its ends.
    """
    position = cubic(x, v, x1, v1, h)
    velocity = cubic(v, _acceleration(x, v, mode, s, around, p), v1, _acceleration(x1, v1, mode, s + h, around, p), h)
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        v_mid = position_at(velocity, mid)
        if v_mid * mode < 0.0 or _may_stick(position_at(position, mid), v_mid, s + mid, around, p):
            high = mid
        else:
            low = mid
    return high


@njit(cache=True, error_model="numpy")
def advance_axis(state: Array, at: int, contact: bool, s: float, s_end: float, probe: Cubic, p: Array) -> None:
    """Advance a body from s to s_end [s] after the latest sample, in place.

    Args:
        state: holds the body's position, velocity, anchor and mode.
        at: where they begin in it.
        contact: whether the probe holds the contact spring throughout.
        s, s_end: the stretch of time within the sample interval.
        probe: the probe's motion over the interval, or the input.
        p: kernel vector.

    Raises:
        RuntimeError: the body would stick and slide without end.
    """
    x, v, mode = state[at + POSITION], state[at + VELOCITY], state[at + MODE]
    around = Surroundings(probe, state[at + ANCHOR], contact)
    smooth = p[FS] == 0.0 and p[FD] == 0.0
    h_max = s_end - s
    if h_max > p[MAX_STEP]:
        h_max /= math.ceil(h_max / p[MAX_STEP])
    events = 0
    while s < s_end:
        if mode == 0.0 and not smooth:
            v = 0.0
            s, mode = _break_away(x, s, s_end, around, p)
            if mode == 0.0:
                break
        last = s + 1.5 * h_max > s_end and s + h_max >= s_end - 1e-9 * h_max
        h = s_end - s if last else h_max
        x1, v1 = _slide(x, v, mode, s, h, around, p)
        if not smooth and (v1 * mode < 0.0 or _may_stick(x1, v1, s + h, around, p)):
            events += 1
            if events > _MOST_EVENTS:
                raise RuntimeError("the body sticks and slides more than 1000 times within one step")
            h = _end_of_slide(x, v, x1, v1, mode, s, h, around, p)
            last = False
            x1, _ = _slide(x, v, mode, s, h, around, p)
            # It stops there: held by friction, or to turn because the drive beats friction the other way.
            v1 = 0.0
            held = drive(x1, 0.0, s + h, around, p)
            mode = 0.0 if abs(held) <= p[FS] else math.copysign(1.0, held)
        x, v = x1, v1
        s = s_end if last else s + h
    state[at + POSITION], state[at + VELOCITY], state[at + MODE] = x, v, mode
