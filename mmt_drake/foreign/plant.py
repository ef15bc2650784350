"""A mass on a table, in the plane, under a probe: other equations, stick rule and integrator than `mmt_drake.model`.

Friction of the table is a vector, F = -Fd v/|v|, held at rest by a spring-slider (Cundall and Strack, "A discrete
numerical model for granular assemblies", Géotechnique 29 (1979) 47-65): a stiff spring with some damping, in
increments, whose force is cut to Fs in norm while it holds and to Fd from then on, until it is less than Fd again. Its
stiffness is m w^2 with w = `SLIDER_RATE`, so that the body gives by F/(m w^2) before it slides: 0.014 um of 0.5 N on
1 kg, less than 1 um for any F/m below 36 m/s^2.

Everything smooth is integrated by classical Runge-Kutta steps of fixed length. Between samples position and velocity of
the probe are linear in time, each by itself. The tip touches where it is below the surface, found to a step; the
contact spring then starts unstretched, what remembers the deflection forgets it, and the body keeps its velocity.
Displacements count from the first instant, at which the body rests.

Divisions are those of numpy, without a check for zero: a third of the time. Nothing here divides by what may be zero.
"""

import math
from typing import Any

import numpy as np
from numba import njit

from mmt_drake.foreign.numbers import Numbers
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

Pair = tuple[float, float]
Hand = tuple[float, float, float, float, float, float]
"""A probe's motion: position [m] and velocity [m/s]."""

STEP_S = 1e-5
"""Longest step of the integration [s]."""
SLIDER_RATE = 6000.0
"""Natural frequency of the body on the slider's spring [rad/s]."""
_SLIDER_DAMPING = 0.3  # of critical

# The state. What is integrated, each along x and y: body, Maxwell's deflection, Bouc and Wen's, bristles, second mode.
_of = Layout()
BODY, VELOCITY, _MAXWELL, _BOUC, _BRISTLE, _MODE, _MODE_V = (_of(2) for _ in range(7))
_SMOOTH = _of.size
# Then the slider's force and whether it slides, the deflection's origin, whether the tip touches, the last instant, the
# probe's motion then, the force on the probe, and this after the low pass.
_SLIDER, _SLIDES, _ANCHOR, TOUCHES, TIME, _PROBE, FORCE, LOW = map(_of, (2, 1, 2, 1, 1, 6, 3, 3))
STATE_SIZE = _of.size

WORK_SIZE = 3 * _SMOOTH
"""Of the scratch that the integration needs."""


@njit(cache=True, error_model="numpy")
def _norm(x: float, y: float) -> float:
    return math.sqrt(x * x + y * y)  # `hypot` takes ten times as long


@njit(cache=True, error_model="numpy")
def _cut(x: float, y: float, most: float) -> tuple[float, float, bool]:
    """A vector cut to a norm, and whether it was longer."""
    size = _norm(x, y)
    if size > most:
        return x * most / size, y * most / size, True
    return x, y, False


@njit(cache=True, error_model="numpy")
def _levels(t: float, speed: float, hand: Hand, state: Array, p: Any) -> Pair:
    """Friction at rest and sliding [N]."""
    dip = math.exp(-((speed / p.v_s) ** 2)) if p.v_s > 0.0 else 0.0
    more = p.mu * max(_normal(hand, p), 0.0) if state[TOUCHES] != 0.0 else 0.0
    if p.wander_F != 0.0:
        w = 2.0 * math.pi * t / p.wander_period
        more += p.wander_F * (1.0 + 0.5 * math.sin(w) + 0.5 * math.sin(2.7 * w + 1.0))
    return p.Fs + more, p.Fd + (p.Fs - p.Fd) * dip + more


@njit(cache=True, error_model="numpy")
def _tried(state: Array, y: Array, mass: float) -> Pair:
    """The slider's force if it did not slide: what it was at the start of the step, and its increment since."""
    k, b = mass * SLIDER_RATE**2, 2.0 * _SLIDER_DAMPING * mass * SLIDER_RATE
    x_force = state[_SLIDER] + k * (y[BODY] - state[BODY]) + b * (y[VELOCITY] - state[VELOCITY])
    y_force = state[_SLIDER + 1] + k * (y[BODY + 1] - state[BODY + 1]) + b * (y[VELOCITY + 1] - state[VELOCITY + 1])
    return x_force, y_force


@njit(cache=True, error_model="numpy")
def _size(p: Any) -> int:
    """How much of the state there is to integrate: without laws that remember the body alone."""
    remembers = p.k_maxwell != 0.0 or p.alpha != 0.0 or p.sigma0 != 0.0 or p.mode_m != 0.0
    return _SMOOTH if remembers else 4


@njit(cache=True, error_model="numpy")
def _mass(t: float, p: Any) -> float:
    return float(p.m + (p.dm if t >= p.mass_time else 0.0))


@njit(cache=True, error_model="numpy")
def _normal(hand: Hand, p: Any) -> float:
    """The normal force on a tip that touches [N]."""
    return float(-p.normal_k * (hand[2] - p.surface) - p.normal_b * hand[5])


@njit(cache=True, error_model="numpy")
def _contact(t: float, y: Array, hand: Hand, state: Array, p: Any) -> tuple[Pair, Pair, Pair]:
    """Force of the contact on the body, the deflection left of clearance, and its rate; the tip touches."""
    dx, dy = hand[0] - y[BODY] - state[_ANCHOR], hand[1] - y[BODY + 1] - state[_ANCHOR + 1]
    ux, uy = hand[3] - y[VELOCITY], hand[4] - y[VELOCITY + 1]
    r = _norm(dx, dy)
    if p.gap > 0.0:
        left = max(r - 0.5 * p.gap, 0.0)
        part = left / r if r > 0.0 else 0.0
        dx, dy, r = part * dx, part * dy, left
        if left == 0.0:
            ux = uy = 0.0
    k = p.k2 * (1.0 + p.drift_rate * t) * (1.0 - (p.step_loss if t >= p.step_time else 0.0)) + p.k3 * r * r
    b = p.b2 * (1.0 + p.hunt_crossley * r)
    fx = k * dx + b * ux + p.k_maxwell * (dx - y[_MAXWELL]) + p.alpha * y[_BOUC]
    fy = k * dy + b * uy + p.k_maxwell * (dy - y[_MAXWELL + 1]) + p.alpha * y[_BOUC + 1]
    return (fx, fy), (dx, dy), (ux, uy)


@njit(cache=True, error_model="numpy")
def _along(t: float, x: float, p: Any) -> float:
    """Forces on the body that each axis has by itself [N]."""
    force = p.F - (p.k1 + (p.ground_k if t >= p.ground_time else 0.0)) * x
    into = (x - p.stop_position) * p.stop_side
    if into > 0.0:
        force -= p.stop_side * p.stop_stiffness * into
    if p.ripple_F != 0.0:
        force += p.ripple_F * math.sin(2.0 * math.pi * x / p.ripple_period + p.ripple_phase)
    if p.texture_F != 0.0:
        w = 2.0 * math.pi * x / p.texture_length
        force += p.texture_F * (math.sin(w + 1.0) + math.sin(1.618 * w + 2.0) + math.sin(2.871 * w)) / math.sqrt(1.5)
    return float(force)


@njit(cache=True, error_model="numpy")
def _rates(t: float, y: Array, hand: Hand, state: Array, p: Any, rate: Array) -> None:
    """The rates of what is integrated, `y`, within the step that starts from `state`."""
    mass, vx, vy = _mass(t, p), y[VELOCITY], y[VELOCITY + 1]
    speed = _norm(vx, vy)
    resists = p.b1 + p.c * speed + p.drag * math.sqrt(speed)
    fx, fy = _along(t, y[BODY], p) - resists * vx, _along(t, y[BODY + 1], p) - resists * vy
    hold, slide = _levels(t, speed, hand, state, p)
    if state[TOUCHES] != 0.0:
        (sx, sy), d, u = _contact(t, y, hand, state, p)
        fx, fy = fx + sx, fy + sy
        for i in range(2):
            rate[_MAXWELL + i] = (d[i] - y[_MAXWELL + i]) / p.tau
        size = _norm(y[_BOUC], y[_BOUC + 1])
        work = u[0] * y[_BOUC] + u[1] * y[_BOUC + 1]
        back = (p.beta * abs(work) + p.gamma * work) / size if size > 0.0 else 0.0
        for i in range(2):
            rate[_BOUC + i] = u[i] - back * y[_BOUC + i]
    else:
        for i in range(2):
            rate[_MAXWELL + i] = rate[_BOUC + i] = 0.0
    if p.sigma0 > 0.0:
        over = p.sigma0 * speed / slide if slide > 0.0 else 0.0
        for i in range(2):
            rate[_BRISTLE + i] = y[VELOCITY + i] - over * y[_BRISTLE + i]
        fx -= p.sigma0 * y[_BRISTLE] + p.sigma1 * rate[_BRISTLE]
        fy -= p.sigma0 * y[_BRISTLE + 1] + p.sigma1 * rate[_BRISTLE + 1]
    else:
        tx, ty = _tried(state, y, mass)
        tx, ty, _ = _cut(tx, ty, hold if state[_SLIDES] == 0.0 else slide)
        fx, fy = fx - tx, fy - ty
    if p.mode_m > 0.0:
        px = p.mode_k * (y[BODY] - y[_MODE]) + p.mode_b * (vx - y[_MODE_V])
        py = p.mode_k * (y[BODY + 1] - y[_MODE + 1]) + p.mode_b * (vy - y[_MODE_V + 1])
        fx, fy = fx - px, fy - py
        rate[_MODE], rate[_MODE + 1] = y[_MODE_V], y[_MODE_V + 1]
        rate[_MODE_V], rate[_MODE_V + 1] = px / p.mode_m, py / p.mode_m
    rate[BODY], rate[BODY + 1] = vx, vy
    rate[VELOCITY], rate[VELOCITY + 1] = fx / mass, fy / mass


@njit(cache=True, error_model="numpy")
def _settle(t: float, hand: Hand, state: Array, p: Any) -> None:
    """Touch and release, and the force on the probe."""
    if (hand[2] < p.surface) != (state[TOUCHES] != 0.0):
        state[TOUCHES] = 1.0 if hand[2] < p.surface else 0.0
        for i in range(2):
            state[_ANCHOR + i] = hand[i] - state[BODY + i]
            state[_MAXWELL + i] = state[_BOUC + i] = 0.0
    if state[TOUCHES] == 0.0:
        for i in range(3):
            state[FORCE + i] = 0.0
        return
    if p.slip_mu < math.inf:
        most = p.slip_mu * max(_normal(hand, p), 0.0) / p.k2
        dx, dy = hand[0] - state[BODY] - state[_ANCHOR], hand[1] - state[BODY + 1] - state[_ANCHOR + 1]
        held_x, held_y, _ = _cut(dx, dy, most)
        state[_ANCHOR] += dx - held_x
        state[_ANCHOR + 1] += dy - held_y
    (sx, sy), _, _ = _contact(t, state, hand, state, p)
    state[FORCE], state[FORCE + 1], state[FORCE + 2] = -sx, -sy, _normal(hand, p)


@njit(cache=True, error_model="numpy")
def _between(before: Array, after: Array, part: float) -> Hand:
    """The probe on its way from one sample to the next."""
    return (
        before[0] + part * (after[0] - before[0]),
        before[1] + part * (after[1] - before[1]),
        before[2] + part * (after[2] - before[2]),
        before[3] + part * (after[3] - before[3]),
        before[4] + part * (after[4] - before[4]),
        before[5] + part * (after[5] - before[5]),
    )


@njit(cache=True, error_model="numpy")
def _step(state: Array, t: float, h: float, after: Array, on: Pair, p: Any, work: Array) -> None:
    """One step of length h from t, over the part `on` (from, by) of the probe's way to `after`."""
    y, rate, total = work[:_SMOOTH], work[_SMOOTH : 2 * _SMOOTH], work[2 * _SMOOTH :]
    before, size = state[_PROBE : _PROBE + 6], _size(p)
    for i in range(_SMOOTH):
        rate[i], y[i], total[i] = 0.0, state[i], 0.0
    for stage in range(4):
        part = 0.5 * ((stage + 1) // 2)
        for i in range(size):
            y[i] = state[i] + part * h * rate[i]
        _rates(t + part * h, y, _between(before, after, on[0] + part * on[1]), state, p, rate)
        for i in range(size):
            total[i] += rate[i] * (h / 6.0 if stage in (0, 3) else h / 3.0)
    for i in range(size):
        y[i] = state[i] + total[i]
    hand = _between(before, after, on[0] + on[1])
    hold, slide = _levels(t + h, _norm(y[VELOCITY], y[VELOCITY + 1]), hand, state, p)
    tx, ty = _tried(state, y, _mass(t, p))
    tx, ty, slides = _cut(tx, ty, slide if state[_SLIDES] != 0.0 else hold)
    if slides:
        tx, ty, _ = _cut(tx, ty, slide)
    state[_SLIDER], state[_SLIDER + 1], state[_SLIDES] = tx, ty, 1.0 if slides else 0.0
    assign(state[:_SMOOTH], y)
    kept = math.exp(-h / p.lag) if p.lag > 0.0 else 0.0
    for i in range(3):
        state[LOW + i] = kept * state[LOW + i] + 0.5 * (1.0 - kept) * state[FORCE + i]
    _settle(t + h, hand, state, p)
    for i in range(3):
        state[LOW + i] = state[LOW + i] + 0.5 * (1.0 - kept) * state[FORCE + i] if p.lag > 0.0 else state[FORCE + i]


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, motion: Array, numbers: Any) -> None:
    """Rest at time t [s] with the probe at `motion` (6: position [m], velocity [m/s]).

    Args:
        state: (STATE_SIZE,), to be filled.
        t: [s].
        motion: see above.
        numbers: of `Numbers.checked`.
    """
    for i in range(STATE_SIZE):
        state[i] = 0.0
    state[TIME] = t
    assign(state[_PROBE : _PROBE + 6], motion)
    _settle(t, _between(motion, motion, 0.0), state, numbers[0])
    assign(state[LOW : LOW + 3], state[FORCE : FORCE + 3])


@njit(cache=True, error_model="numpy")
def advance(
    state: Array, t: float, motion: Array, numbers: Any, longest: float, work: Array, forces: Array, first: int
) -> int:
    """Bring the state to time t with the probe at `motion` then.

    Args:
        state: of `begin`.
        t: [s].
        motion: (6,) position [m] and velocity [m/s] of the probe.
        numbers: of `Numbers.checked`; times in it count as t does.
        longest: step [s].
        work: (WORK_SIZE,) scratch.
        forces: (n, 3) to be filled with the force on the probe after each step [N], from row `first` on; or (0, 3).
        first: see above.

    Returns:
        The row after the last that was filled.
    """
    p, start = numbers[0], state[TIME]
    count = math.ceil((t - start) / longest - 1e-6) if t > start else 0
    for step in range(count):
        h = (t - start) / count
        _step(state, start + step * h, h, motion, (step / count, 1.0 / count), p, work)
        if forces.shape[0] > 0:
            assign(forces[first + step], state[FORCE : FORCE + 3])
    if count == 0:
        _settle(t, _between(motion, motion, 0.0), state, p)
        if p.lag == 0.0:
            assign(state[LOW : LOW + 3], state[FORCE : FORCE + 3])
    state[TIME] = t
    assign(state[_PROBE : _PROBE + 6], motion)
    return first + count


def simulated(time: Array, motion: Array, numbers: Numbers, substeps: int) -> tuple[Array, Array]:
    """`run` on an even clock: the force on the probe ((n - 1) * substeps + 1, 3) [N], and the body (n, 4).

    Raises:
        BadInput: numbers that such steps do not follow.
    """
    force, body = np.empty(((len(time) - 1) * substeps + 1, 3)), np.empty((len(time), 4))
    run(time, motion, numbers.checked(float(time[1] - time[0]) / substeps), substeps, force, body)
    return force, body


@njit(cache=True, error_model="numpy")
def run(time: Array, motion: Array, numbers: Any, substeps: int, forces: Array, body: Array) -> None:
    """Run from rest at the first sample.

    Args:
        time: (n,) [s], increasing; the times in `numbers` count from the first one.
        motion: (n, 6) position [m] and velocity [m/s] of the probe.
        numbers: of `Numbers.checked`.
        substeps: steps per sample.
        forces: ((n - 1) * substeps + 1, 3) to be filled with the force on the probe at every step [N].
        body: (n, 4) to be filled with the body's displacement [m], then its velocity [m/s].
    """
    state, work = np.zeros(STATE_SIZE), np.zeros(WORK_SIZE)
    begin(state, 0.0, motion[0], numbers)
    assign(forces[0], state[FORCE : FORCE + 3])
    filled = 1
    for i in range(1, len(time)):
        longest = (time[i] - time[i - 1]) / substeps * (1.0 + 1e-7)
        filled = advance(state, time[i] - time[0], motion[i], numbers, longest, work, forces, filled)
        assign(body[i], state[BODY : BODY + 4])
    assign(body[0], np.zeros(4))
