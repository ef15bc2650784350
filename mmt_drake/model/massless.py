"""A body without inertia on one axis: it is where the forces on it balance.

The equation is that of `mmt_drake.model.forces` with m = 0. A slow recording says nothing of a mass, and a mass made up
to be light asks for short steps and rings. Each step is implicit: the body stays where friction holds it, else goes as
far as leaves friction in balance with the drive, at its mean velocity over the step. Where forces depend on that
velocity, a step in two halves corrects the whole one (Richardson): its error falls with the square of its length.
"""

import math

from numba import njit

from mmt_drake.model.body import break_away, pull_at_rest, remember
from mmt_drake.model.forces import ALONE, BodyMotion, Surroundings, forces
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.memory import between
from mmt_drake.model.parameters import Constants

LONGEST_STEP = 1e-3
"""[s]; memories of laws follow within it, and what is faster shows in no recording."""

_MOST_STEPS = 1e7  # within one sample interval, as of a body with mass
_DOUBLINGS, _TRIES = 200, 100
_BALANCED = 1e-9  # of the force that a step begins with
_ROUNDING = 1e-15  # of the position


@njit(cache=True, error_model="numpy")
def follow(body: BodyMotion, s: float, s_end: float, around: Surroundings, p: Constants) -> BodyMotion:
    """The body at s_end; arguments as of `mmt_drake.model.body.advance_axis`, with m = 0 and k2 > 0 in p.

    Raises:
        RuntimeError: nothing balances the drive, laws decay too fast to follow, or the stretch is ten million steps
            long.
    """
    steps = math.ceil((s_end - s) / p.max_step)
    if not steps <= _MOST_STEPS:
        raise RuntimeError("two samples more than ten million integration steps apart")
    h = (s_end - s) / steps
    damped = p.b1 != 0.0 or p.b2 != 0.0 or p.laws != 0
    for i in range(steps):
        begun, end = s + i * h, s + (i + 1) * h
        if body.mode == 0.0 and damped:
            begun, mode, q = break_away(body.x, body.q, begun, end, around, p)
            body = BodyMotion(body.x, 0.0, mode, q)
            if mode == 0.0 or not begun < end:
                continue
        whole = _step(body, begun, end - begun, around, p)
        if damped:
            half = 0.5 * (end - begun)
            halves = _step(_step(body, begun, half, around, p), begun + half, half, around, p)
            if halves.mode == whole.mode:
                x, q = 2.0 * halves.x - whole.x, between(whole.q, halves.q, 2.0)
                whole = BodyMotion(x, halves.v, whole.mode, q)
            else:
                whole = halves
        body = whole
    return body


@njit(error_model="numpy", forceinline=True)
def _gone(
    body: BodyMotion, way: float, mode: float, s: float, h: float, around: Surroundings, p: Constants
) -> tuple[BodyMotion, float]:
    """The body after h, some way farther along a direction, and how much the drive then exceeds friction there [N]."""
    v, q = mode * way / h, body.q
    if p.remembers:
        q = remember(q, s, s + h, Cubic(body.x - v * s, v, 0.0, 0.0), around, p)
    moved = BodyMotion(body.x + mode * way, v, mode, q)
    acting = forces(moved, s + h, around, p, ALONE)
    return moved, mode * acting.drive - acting.sliding


@njit(error_model="numpy")
def _slid(
    body: BodyMotion, mode: float, guess: float, s: float, h: float, around: Surroundings, p: Constants
) -> tuple[BodyMotion, bool]:
    """The body where friction balances the drive after h of sliding in a direction; False if it does not get away.

    Args:
        body: at s.
        mode: the direction.
        guess: of the way [m], more than 0.
        s, h: the step [s].
        around, p: as of `follow`.
    """
    way = guess
    moved, beyond = _gone(body, way, mode, s, h, around, p)
    step = abs(beyond) / p.k2
    least = _BALANCED * p.k2 * (way + step) + _ROUNDING * p.k2 * abs(moved.x)
    near, excess, far, lack = 0.0, -1.0, -1.0, 1.0  # where the drive wins, and where friction does; unknown
    for _ in range(_DOUBLINGS):
        if abs(beyond) <= least:
            return moved, True
        if beyond > 0.0:
            near, excess = way, beyond
        else:
            far, lack = way, beyond
            if way <= 0.0:
                return moved, False
        if excess > 0.0 and lack < 0.0:
            break
        way = way + step if beyond > 0.0 else max(way - step, 0.0)
        step *= 2.0
        moved, beyond = _gone(body, way, mode, s, h, around, p)
    else:
        raise RuntimeError("nothing balances the forces on a body without mass")
    kept = 0.0
    for _ in range(_TRIES):  # false position (Illinois)
        if abs(beyond) <= least or far - near <= _ROUNDING * abs(moved.x):
            break
        way = far - lack * (far - near) / (lack - excess)
        moved, beyond = _gone(body, way, mode, s, h, around, p)
        side = math.copysign(1.0, beyond)
        if beyond > 0.0:
            near, excess = way, beyond
            lack *= 0.5 if kept == side else 1.0
        else:
            far, lack = way, beyond
            excess *= 0.5 if kept == side else 1.0
        kept = side
    return moved, True


@njit(error_model="numpy")
def _step(body: BodyMotion, s: float, h: float, around: Surroundings, p: Constants) -> BodyMotion:
    """The body after h [s] from s on."""
    found, moved = False, body
    # Where nothing but the spring holds it, it rests within a gap and does not coast.
    if body.v != 0.0 and (p.b1 > 0.0 or p.gap == 0.0):
        moved, found = _slid(body, body.mode, abs(body.v) * h, s, h, around, p)
        if found and abs(moved.v) >= p.v_d:
            return moved
    resting, _ = _gone(body, 0.0, 0.0, s, h, around, p)
    pull, hold = pull_at_rest(body.x, resting.q, s + h, around, p, ALONE)
    if not abs(pull) > hold:
        return resting
    if found:
        return moved
    mode = math.copysign(1.0, pull)
    sliding = forces(BodyMotion(body.x, 0.0, mode, resting.q), s + h, around, p, ALONE).sliding
    if not abs(pull) > sliding:  # friction grows as soon as it moves
        return resting
    moved, found = _slid(body, mode, (abs(pull) - sliding) / p.k2, s, h, around, p)
    return moved if found else resting
