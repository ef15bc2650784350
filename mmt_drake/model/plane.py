"""A body whose friction is a vector in the plane: F = -Fc v/|v|, and at rest what holds it, up to a level.

Its two tangential axes are those of `mmt_drake.model.body` but for friction, the clearance and the laws that look at
both. As long as sliding changes little within a step, both axes take a classical Runge-Kutta step (order 4) together.
Where friction could turn or stop the body, short steps are taken that are implicit in it: the velocity that it would
have without friction is shortened by what friction can take in that time (Moreau's time stepping; Acary and Brogliato
2008, chapter 10). *Stuck*, it waits until the norm of the drive passes the break-away level. Laws of friction that
depend on the velocity are evaluated at the speed, those of a direction with the sign of each axis.
"""

import math
from typing import NamedTuple

from numba import njit

from mmt_drake.model.body import BISECTIONS, limited, pull_at_rest, short_at_edge
from mmt_drake.model.forces import Beside, BodyMotion, Surroundings, beside, forces_in_plane
from mmt_drake.model.hermite import cubic, position_at, velocity_at
from mmt_drake.model.laws import Memory, norm
from mmt_drake.model.memory import after_step, between, moved
from mmt_drake.model.parameters import Constants

_MOST_CHANGE = 0.5  # of the speed within a Runge-Kutta step
_SHORT_STEPS = 32.0  # of those that are implicit in friction there are so many for one
_MOST_STEPS = 1e7  # within one sample interval
_MOST_SLIPS = 20  # of a creeping body within an integration step; beyond, it rests for the next


class Pushed(NamedTuple):
    """An axis of a sliding body at an instant.

    Attributes:
        drive: what all forces but friction accelerate it by [m/s^2].
        braking: what friction takes from the speed, if it slides along this axis [m/s^2].
        rates: of its memory.
        decay: the fastest of its memory [1/s].
    """

    drive: float
    braking: float
    rates: Memory
    decay: float


@njit(error_model="numpy", forceinline=True)
def _pushed(body: BodyMotion, other: Beside, speed: float, s: float, around: Surroundings, p: Constants) -> Pushed:
    acting = forces_in_plane(body, math.copysign(speed, body.mode), s, around, p, other)
    braking = acting.sliding * acting.inverse_mass
    return Pushed(acting.drive * acting.inverse_mass, braking, acting.rates, acting.decay)


@njit(error_model="numpy", forceinline=True)
def _direction(v: float) -> float:
    """The mode of an axis of a body that slides."""
    return math.copysign(1.0, v)


@njit(error_model="numpy", forceinline=True)
def _accelerations(vx: float, vy: float, x: Pushed, y: Pushed) -> tuple[float, float]:
    speed = max(norm(vx, vy), 1e-300)
    return x.drive - x.braking * vx / speed, y.drive - y.braking * vy / speed


@njit(error_model="numpy", forceinline=True)
def _both_pushed(
    x: BodyMotion, y: BodyMotion, s: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[Pushed, Pushed]:
    speed = norm(x.v, y.v)
    return (
        _pushed(x, beside(y, s, across, p), speed, s, along, p),
        _pushed(y, beside(x, s, along, p), speed, s, across, p),
    )


@njit(error_model="numpy", forceinline=True)
def _moved_on(body: BodyMotion, h: float, v: float, a: float, rates: Memory) -> BodyMotion:
    """An axis after h [s] at a velocity, an acceleration and rates of its memory."""
    return BodyMotion(body.x + h * v, body.v + h * a, body.mode, moved(body.q, h, rates))


@njit(error_model="numpy", forceinline=True)
def _slide(
    x: BodyMotion,
    y: BodyMotion,
    first: tuple[Pushed, Pushed],
    s: float,
    h: float,
    along: Surroundings,
    across: Surroundings,
    p: Constants,
) -> tuple[BodyMotion, BodyMotion]:
    """A sliding body after a Runge-Kutta step of order 4; `first` acts on it at s."""
    half = 0.5 * h
    ax1, ay1 = _accelerations(x.v, y.v, *first)
    x2, y2 = _moved_on(x, half, x.v, ax1, first[0].rates), _moved_on(y, half, y.v, ay1, first[1].rates)
    second = _both_pushed(x2, y2, s + half, along, across, p)
    ax2, ay2 = _accelerations(x2.v, y2.v, *second)
    x3, y3 = _moved_on(x, half, x2.v, ax2, second[0].rates), _moved_on(y, half, y2.v, ay2, second[1].rates)
    third = _both_pushed(x3, y3, s + half, along, across, p)
    ax3, ay3 = _accelerations(x3.v, y3.v, *third)
    x4, y4 = _moved_on(x, h, x3.v, ax3, third[0].rates), _moved_on(y, h, y3.v, ay3, third[1].rates)
    fourth = _both_pushed(x4, y4, s + h, along, across, p)
    ax4, ay4 = _accelerations(x4.v, y4.v, *fourth)
    vx, vy = x.v + h / 6.0 * (ax1 + 2.0 * ax2 + 2.0 * ax3 + ax4), y.v + h / 6.0 * (ay1 + 2.0 * ay2 + 2.0 * ay3 + ay4)
    qx = after_step(x.q, h, first[0].rates, second[0].rates, third[0].rates, fourth[0].rates)
    qy = after_step(y.q, h, first[1].rates, second[1].rates, third[1].rates, fourth[1].rates)
    return (
        BodyMotion(x.x + h / 6.0 * (x.v + 2.0 * x2.v + 2.0 * x3.v + x4.v), vx, _direction(vx), qx),
        BodyMotion(y.x + h / 6.0 * (y.v + 2.0 * y2.v + 2.0 * y3.v + y4.v), vy, _direction(vy), qy),
    )


@njit(error_model="numpy", forceinline=True)
def _exceeds(along: float, across: float, level_along: float, level_across: float) -> bool:
    """Whether a force is more than friction can hold, whose level may depend on the direction along each axis."""
    if level_along <= 0.0 or level_across <= 0.0:
        return along != 0.0 or across != 0.0
    return norm(along / level_along, across / level_across) > 1.0


@njit(error_model="numpy", forceinline=True)
def _brake(x: BodyMotion, y: BodyMotion, acting: tuple[Pushed, Pushed], h: float) -> tuple[BodyMotion, BodyMotion]:
    """A sliding body after a short step that is implicit in friction; at velocity 0 if friction stops it."""
    free_x, free_y = x.v + h * acting[0].drive, y.v + h * acting[1].drive
    taken_x, taken_y = h * acting[0].braking, h * acting[1].braking
    vx = vy = 0.0
    if _exceeds(free_x, free_y, taken_x, taken_y):
        speed = norm(free_x, free_y)
        vx, vy = free_x * max(1.0 - taken_x / speed, 0.0), free_y * max(1.0 - taken_y / speed, 0.0)
    half = 0.5 * h
    return (
        BodyMotion(x.x + half * (x.v + vx), vx, _direction(vx), moved(x.q, h, acting[0].rates)),
        BodyMotion(y.x + half * (y.v + vy), vy, _direction(vy), moved(y.q, h, acting[1].rates)),
    )


@njit(error_model="numpy")
def _is_held(
    x: float, qx: Memory, y: float, qy: Memory, s: float, along: Surroundings, across: Surroundings, p: Constants
) -> bool:
    """Whether friction holds a body at rest there."""
    pull_x, hold_x = pull_at_rest(x, qx, s, along, p, _resting(y, qy, s, across, p))
    pull_y, hold_y = pull_at_rest(y, qy, s, across, p, _resting(x, qx, s, along, p))
    return not _exceeds(pull_x, pull_y, hold_x, hold_y)


@njit(error_model="numpy", forceinline=True)
def _resting(x: float, q: Memory, s: float, around: Surroundings, p: Constants) -> Beside:
    """An axis of a body at rest, as the other has to know it."""
    return beside(BodyMotion(x, 0.0, 0.0, q), s, around, p)


@njit(error_model="numpy", forceinline=True)
def _let_go(
    x: BodyMotion, y: BodyMotion, s: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[BodyMotion, BodyMotion]:
    """A body at rest that begins to slide as it is pulled."""
    pull_x, _ = pull_at_rest(x.x, x.q, s, along, p, _resting(y.x, y.q, s, across, p))
    pull_y, _ = pull_at_rest(y.x, y.q, s, across, p, _resting(x.x, x.q, s, along, p))
    return BodyMotion(x.x, 0.0, _direction(pull_x), x.q), BodyMotion(y.x, 0.0, _direction(pull_y), y.q)


@njit(error_model="numpy", forceinline=True)
def _rested(body: BodyMotion, q: Memory) -> BodyMotion:
    return BodyMotion(body.x, 0.0, 0.0, q)


@njit(error_model="numpy")
def _remembered(
    x: BodyMotion, y: BodyMotion, s: float, s_end: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[BodyMotion, BodyMotion]:
    """A body that rests from s to s_end, with what its laws remember then."""
    while s < s_end:
        first = _both_pushed(x, y, s, along, across, p)
        h = limited(min(s_end - s, p.max_step), max(first[0].decay, first[1].decay))
        half = 0.5 * h
        x2, y2 = _rested(x, moved(x.q, half, first[0].rates)), _rested(y, moved(y.q, half, first[1].rates))
        second = _both_pushed(x2, y2, s + half, along, across, p)
        x3, y3 = _rested(x, moved(x.q, half, second[0].rates)), _rested(y, moved(y.q, half, second[1].rates))
        third = _both_pushed(x3, y3, s + half, along, across, p)
        x4, y4 = _rested(x, moved(x.q, h, third[0].rates)), _rested(y, moved(y.q, h, third[1].rates))
        fourth = _both_pushed(x4, y4, s + h, along, across, p)
        qx = after_step(x.q, h, first[0].rates, second[0].rates, third[0].rates, fourth[0].rates)
        qy = after_step(y.q, h, first[1].rates, second[1].rates, third[1].rates, fourth[1].rates)
        x, y = _rested(x, qx), _rested(y, qy)
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return x, y


@njit(error_model="numpy")
def _wait(
    x: BodyMotion, y: BodyMotion, s: float, s_end: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[float, BodyMotion, BodyMotion]:
    """Time within [s, s_end] at which a stuck body lets go, and the body then; s_end and stuck if it does not."""
    if not _is_held(x.x, x.q, y.x, y.q, s, along, across, p):
        return s, *_let_go(x, y, s, along, across, p)
    while s < s_end:
        h, qx, qy = s_end - s, x.q, y.q
        if p.remembers:
            h = min(h, p.max_step)
            later_x, later_y = _remembered(_rested(x, qx), _rested(y, qy), s, s + h, along, across, p)
            qx, qy = later_x.q, later_y.q
        if not _is_held(x.x, qx, y.x, qy, s + h, along, across, p):
            low, high = 0.0, h
            for _ in range(BISECTIONS):
                mid = 0.5 * (low + high)
                inside_x, inside_y = between(x.q, qx, mid / h), between(y.q, qy, mid / h)
                if _is_held(x.x, inside_x, y.x, inside_y, s + mid, along, across, p):
                    low = mid
                else:
                    high = mid
            x, y = _rested(x, between(x.q, qx, high / h)), _rested(y, between(y.q, qy, high / h))
            return s + high, *_let_go(x, y, s + high, along, across, p)
        x, y = _rested(x, qx), _rested(y, qy)
        s = s_end if s + h >= s_end - 1e-9 * h else s + h
    return s_end, x, y


@njit(error_model="numpy")
def _may_stick(x: BodyMotion, y: BodyMotion, s: float, along: Surroundings, across: Surroundings, p: Constants) -> bool:
    """Karnopp's condition, by the norms."""
    return norm(x.v, y.v) < p.v_d and _is_held(x.x, x.q, y.x, y.q, s, along, across, p)


@njit(error_model="numpy")
def _end_of_slide(
    x: BodyMotion,
    y: BodyMotion,
    x1: BodyMotion,
    y1: BodyMotion,
    s: float,
    h: float,
    along: Surroundings,
    across: Surroundings,
    p: Constants,
) -> float:
    """Time after s, within a step of h, at which a body sticks that slides from (x, y) to (x1, y1)."""
    path_x, path_y = cubic(x.x, x.v, x1.x, x1.v, h), cubic(y.x, y.v, y1.x, y1.v, h)
    low, high = 0.0, h
    for _ in range(BISECTIONS):
        mid = 0.5 * (low + high)
        inside_x = BodyMotion(position_at(path_x, mid), velocity_at(path_x, mid), x.mode, between(x.q, x1.q, mid / h))
        inside_y = BodyMotion(position_at(path_y, mid), velocity_at(path_y, mid), y.mode, between(y.q, y1.q, mid / h))
        if _may_stick(inside_x, inside_y, s + mid, along, across, p):
            high = mid
        else:
            low = mid
    return high


@njit(cache=True, error_model="numpy")
def advance_axes(
    x: BodyMotion, y: BodyMotion, s: float, s_end: float, along: Surroundings, across: Surroundings, p: Constants
) -> tuple[BodyMotion, BodyMotion]:
    """Advance a body with friction in the plane from s to s_end [s] after the latest sample.

    Args:
        x, y: its two axes at s.
        s, s_end: the stretch of time within the sample interval.
        along, across: what acts on it along either.
        p: of the body.

    Returns:
        Both axes at s_end.

    Raises:
        RuntimeError: its laws decay too fast to follow, or the stretch is ten million steps long.
    """
    h_max = s_end - s
    if h_max > p.max_step:
        if not h_max <= _MOST_STEPS * p.max_step:
            raise RuntimeError("two samples more than ten million integration steps apart")
        h_max /= math.ceil(h_max / p.max_step)
    shortest, stops_made, began = h_max / _SHORT_STEPS * max(p.coarsening, 1.0), 0, s
    while s < s_end:
        if x.mode == 0.0:
            s, x, y = _wait(x, y, s, s_end, along, across, p)
            if x.mode == 0.0:
                break
        acting = _both_pushed(x, y, s, along, across, p)
        h = h_max
        if p.gap != 0.0:
            h = short_at_edge(h, x, s, along, p, beside(y, s, across, p))
        h = limited(h, max(acting[0].decay, acting[1].decay))
        braking = max(acting[0].braking, acting[1].braking)
        change = norm(acting[0].drive, acting[1].drive) + braking if braking > 0.0 else 0.0
        smooth = _MOST_CHANGE * norm(x.v, y.v)
        brakes = change * h > smooth and change * shortest > smooth
        h = min(h, shortest if brakes else max(smooth / change, shortest) if change * h > smooth else h)
        last = s + h >= s_end - 1e-9 * h
        if last:
            h = s_end - s
        if brakes:
            x1, y1 = _brake(x, y, acting, h)
            stops = x1.v == 0.0 and y1.v == 0.0 and _is_held(x1.x, x1.q, y1.x, y1.q, s + h, along, across, p)
        else:
            x1, y1 = _slide(x, y, acting, s, h, along, across, p)
            stops = False
        if not stops and p.v_d > 0.0 and _may_stick(x1, y1, s + h, along, across, p):
            stops = True
            h = _end_of_slide(x, y, x1, y1, s, h, along, across, p)
            last = False
            if brakes:
                x1, y1 = _brake(x, y, acting, h)
            else:
                x1, y1 = _slide(x, y, acting, s, h, along, across, p)
        if stops:
            x1, y1 = _rested(x1, x1.q), _rested(y1, y1.q)
            stops_made += 1
            if stops_made * h_max > _MOST_SLIPS * (s + h - began + h_max):
                # A probe that creeps at the break-away level makes it slip by less than an atom's width, ever again.
                rest = min(h_max, s_end - s - h)
                if p.remembers:
                    x1, y1 = _remembered(x1, y1, s + h, s + h + rest, along, across, p)
                h += rest
                last = s + h >= s_end - 1e-9 * h_max
        x, y = x1, y1
        s = s_end if last else s + h
    return x, y
