"""What a carried object weighs, and where its centre is, from force and motion of the tip: one compiled tick.

The mass is that of a least-squares fit of -F = m (g + a) along z, both sides behind one low pass, so that no velocity
is differentiated; a is of the place that is gripped, which the contact's known spring and damper tell from tip and
force. What pushing has told counts as `PRIOR_S` of carrying.

Centre c and damping zeta of the swing are those of a bank of rods (`mmt_drake.model.carried`) that hang from the same
place, driven by its velocity v, whose force explains the measured one best. With W = (4/3) c theta' + v each obeys

    W' = -g theta - beta' theta',   theta' = 3/(4 c) (W - v),   f/m = v'/4 - (3/4) (g theta + beta' theta')

which has no acceleration at its input; v' comes from the same low pass. Between the rods of the bank a parabola through
the sum of squares gives c and zeta. (An output-error fit: Ljung, "System Identification", 2nd ed., 1999, section 4.2.)
"""

import math
from typing import Final

import numpy as np
from numba import njit

from mmt_drake.model.carried import GRAVITY, swing_rate
from mmt_drake.model.grasped_box import HOLDS, LEAST_GRIP, LOST
from mmt_drake.model.parameters import THETA
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

FREE, ON_TABLE, CARRIED, SLIPS, GONE = range(5)
"""What becomes of an object in a grip: there is none; it stands; it is carried; and slips; it has slipped out."""
TELLS, LEARNING, _, UNEXCITED = range(4)
"""Whether numbers are told: both; not yet; the swing does not tell the centre."""

LIFTED, LANDED = 2e-4, 1e-4
"""Height of the object from which on it is carried, and at which no longer [m]."""
_SURELY: Final = 2e-3  # [m]: as much as a stiffness that is told wrong may make of a contact that presses
PRIOR_S: Final = 0.02
LOW_PASS: Final = 20.0  # [rad/s]
_SETTLES_S, _LEARNING_S, _SLIPS_S = 0.15, 0.5, 0.1  # [s]; the first: what the table did leaves the low passes
_UNSURE = 0.15  # of ln c, standard deviation
_MODEL = 0.005  # of the weight: what the rod leaves of the force across, which no mean takes away
_CENTRES, _ZETAS = 24, 4
_LEAST_C, _RATIO = 0.012, 0.122  # of the bank [m], from one to the next (logarithm)
_LEAST_ZETA, _ZETA_RATIO = 0.01, math.log(3.2)
_RODS = _CENTRES * _ZETAS

_M, _K2, _B2 = (THETA.index(name) for name in ("m", "k2", "b2"))
_NORMAL_K, _NORMAL_B = (THETA.index(name) for name in ("normal_k", "normal_b"))

PORT_SIZES: Final = {"carried": 5, "deviation": 3, "status": 1, "in_contact": 1}
LOAD, DEVIATION, STATUS, CONTACT, _MEMORY = map(Layout(), (*PORT_SIZES.values(), 0))
# The memory: deflection of the grasp; low passes of the gripped place's velocity and of the force; how long it has been
# held, and carried, and how long it still counts as slipping [s], how far the grip had slipped; sums of the mass, of
# the force across; what is told; then of each rod W, theta and a low pass, both axes, and two sums.
_next = Layout()
_DEFLECTION, _SLOW, _FORCE = _next(3), _next(3), _next(3)
_STATE, _HELD, _AGE, _STEADY, _SLID = _next(), _next(), _next(), _next(), _next()
_YY, _YX, _XX, _COUNT, _ACROSS = _next(), _next(), _next(), _next(), _next()
_TOLD, _SURE, _HOW = _next(3), _next(3), _next()
_BANK, _SUMS = _next(6 * _RODS), _next(2 * _RODS)
MEMORY_SIZE = _next.size


def bank() -> Array:
    """(rods, 3): c [m], beta' [m/s] and zeta of each."""
    rods = []
    for i in range(_CENTRES):
        c = _LEAST_C * math.exp(_RATIO * i)
        for j in range(_ZETAS):
            zeta = _LEAST_ZETA * math.exp(_ZETA_RATIO * j)
            rods.append((c, 8.0 / 3.0 * zeta * swing_rate(c) * c, zeta))
    return np.array(rods)


@njit(cache=True)
def _follow(memory: Array, measurement: Array, theta: Array, h: float) -> tuple[float, float, float]:
    """Bring the grasp's deflection and the low passes up to date; velocities of the gripped place [m/s]."""
    moves = (0.0, 0.0, 0.0)
    share = 1.0 - math.exp(-LOW_PASS * h)
    fresh = memory[_HELD] == 0.0
    for i in range(3):
        k, b = (theta[_NORMAL_K], theta[_NORMAL_B]) if i == 2 else (theta[_K2], theta[_B2])
        force = measurement[6 + i]
        if fresh:
            memory[_DEFLECTION + i] = -force / k
        before = memory[_DEFLECTION + i]
        kept = math.exp(-k / b * h) if b > 0.0 else 0.0
        after = kept * before - (1.0 - kept) * force / k
        memory[_DEFLECTION + i] = after
        v = measurement[3 + i] - (after - before) / h
        if fresh:
            memory[_SLOW + i], memory[_FORCE + i] = v, force
        memory[_SLOW + i] += share * (v - memory[_SLOW + i])
        memory[_FORCE + i] += share * (force - memory[_FORCE + i])
        moves = (v, moves[1], moves[2]) if i == 0 else (moves[0], v, moves[2]) if i == 1 else (moves[0], moves[1], v)
    return moves


@njit(cache=True)
def _swing_all(memory: Array, v: tuple[float, float, float], h: float, rods: Array, weight: float) -> None:
    """Let every rod of the bank swing for a tick, and add up how its force goes with the measured one."""
    share = 1.0 - math.exp(-LOW_PASS * h)
    for i in range(2):
        y = -memory[_FORCE + i]
        memory[_ACROSS] += weight * y * y
        direct = 0.25 * LOW_PASS * (v[i] - memory[_SLOW + i])
        for j in range(len(rods)):
            at, q, damper = _BANK + 6 * j + 3 * i, 0.75 / rods[j, 0], rods[j, 1]
            turned = memory[at + 1]
            give = 0.5 * h * damper * q + 0.25 * h * h * GRAVITY * q  # the midpoint rule again
            middle = (memory[at] - 0.5 * h * GRAVITY * turned + give * v[i]) / (1.0 + give)
            rate = q * (middle - v[i])
            memory[at] = 2.0 * middle - memory[at]
            memory[at + 1] = turned + h * rate
            back = GRAVITY * (turned + 0.5 * h * rate) + damper * rate
            memory[at + 2] += share * (back - memory[at + 2])
            x = direct - 0.75 * memory[at + 2]
            memory[_SUMS + 2 * j] += weight * y * x
            memory[_SUMS + 2 * j + 1] += weight * x * x


@njit(cache=True)
def _squares(memory: Array, j: int, m: float) -> float:
    """What rod j leaves of the force across, squared and added up [N^2]."""
    return float(memory[_ACROSS] - 2.0 * m * memory[_SUMS + 2 * j] + m * m * memory[_SUMS + 2 * j + 1])


@njit(cache=True)
def _bottom(below: float, here: float, above: float) -> tuple[float, float]:
    """Of the parabola through three points one apart: its lowest, from the middle one, and its curvature."""
    curvature = below - 2.0 * here + above
    return (0.5 * (below - above) / curvature if curvature > 0.0 else 0.0), curvature


@njit(cache=True)
def _tell(memory: Array, h: float, rods: Array) -> None:
    """Numbers and deviations of what is carried."""
    if memory[_COUNT] == 0.0:
        return
    m = memory[_YX] / memory[_XX]
    independent = max(0.5 * LOW_PASS * h * memory[_COUNT], 1.0)
    left = max(memory[_YY] - m * memory[_YX], 0.0)
    memory[_TOLD], memory[_SURE] = m, math.sqrt(left / memory[_XX] / independent)
    memory[_HOW] = LEARNING if memory[_AGE] < _LEARNING_S else UNEXCITED
    best, least = 0, math.inf
    for j in range(len(rods)):
        squares = _squares(memory, j, m)
        if squares < least:
            best, least = j, squares
    centre, damping = best // _ZETAS, best % _ZETAS
    if not 0 < centre < _CENTRES - 1:
        return
    lower, upper = _squares(memory, best - _ZETAS, m), _squares(memory, best + _ZETAS, m)
    off, curvature = _bottom(lower, least, upper)
    if curvature <= 0.0:
        return
    spread = max(least, 0.0) / independent + (_MODEL * m * GRAVITY) ** 2 * memory[_COUNT]
    deviation = _RATIO * math.sqrt(2.0 * spread / curvature)
    if deviation > _UNSURE or memory[_HOW] == LEARNING:
        return
    memory[_HOW] = TELLS
    memory[_TOLD + 1] = rods[best, 0] * math.exp(_RATIO * off)
    memory[_SURE + 1] = memory[_TOLD + 1] * deviation
    memory[_TOLD + 2], memory[_SURE + 2] = rods[best, 2], rods[best, 2]
    if 0 < damping < _ZETAS - 1:
        off, curvature = _bottom(_squares(memory, best - 1, m), least, _squares(memory, best + 1, m))
        if curvature > 0.0:
            memory[_TOLD + 2] = rods[best, 2] * math.exp(_ZETA_RATIO * off)
            apart = _ZETA_RATIO * math.sqrt(2.0 * max(least, 0.0) / curvature / independent)
            memory[_SURE + 2] = memory[_TOLD + 2] * min(apart, 1.0)


@njit(cache=True)
def estimate_load(
    memory: Array,
    measurement: Array,
    held: Array,
    grip: float,
    in_contact: float,
    theta: Array,
    h: float,
    rods: Array,
    out: Array,
) -> None:
    """One tick.

    Args:
        memory: (MEMORY_SIZE,) of the last tick.
        measurement: (9,) of the tip [m], [m/s], [N].
        held: what the grip's sensors tell: what it has, how far it has slipped up the object and in all [m].
        grip: its force [N].
        in_contact: that the tip touches the surface, as a detector has it.
        theta: (10,) of the contact.
        h: [s].
        rods: of `bank`.
        out: what is put out and the new memory.
    """
    now = out[_MEMORY:]
    assign(now, memory)
    k, k2 = theta[_NORMAL_K], theta[_K2]
    known = k > 0.0 and k2 > 0.0 and theta[_NORMAL_B] >= 0.0 and theta[_B2] >= 0.0
    if held[0] != HOLDS or grip < LEAST_GRIP:
        now[_STATE] = GONE if held[0] == LOST and grip >= LEAST_GRIP else FREE
        now[_HELD] = now[_AGE] = now[_SLID] = now[_STEADY] = 0.0
    elif known:
        v = _follow(now, measurement, theta, h)
        now[_HELD] += h
        height = measurement[2] - held[1] - now[_DEFLECTION + 2]
        flies = height > (LANDED if now[_AGE] > 0.0 else LIFTED)
        pulls = -measurement[8] > (0.3 if now[_AGE] > 0.0 else 0.7) * max(theta[_M], 0.0) * GRAVITY
        flies = flies and (pulls or height > _SURELY)  # what presses stands
        now[_STEADY] = _SLIPS_S if held[2] > now[_SLID] else max(now[_STEADY] - h, 0.0)
        now[_SLID] = held[2]
        if not flies:
            now[_STATE], now[_AGE] = ON_TABLE, 0.0
        else:
            if now[_AGE] == 0.0:
                _begin(now, theta, v, h)
            now[_AGE] += h
            now[_STATE] = SLIPS if now[_STEADY] > 0.0 else CARRIED
            weight = 1.0 if now[_STATE] == CARRIED and now[_AGE] > _SETTLES_S else 0.0
            x, y = GRAVITY + LOW_PASS * (v[2] - now[_SLOW + 2]), -now[_FORCE + 2]
            now[_YY] += weight * y * y
            now[_YX] += weight * x * y
            now[_XX] += weight * x * x
            now[_COUNT] += weight
            _swing_all(now, v, h, rods, weight)
            _tell(now, h, rods)
    else:
        now[_STATE] = ON_TABLE
    out[LOAD], out[LOAD + 4] = now[_STATE], grip
    for i in range(3):
        out[LOAD + 1 + i], out[DEVIATION + i] = now[_TOLD + i], now[_SURE + i]
    out[STATUS] = now[_HOW] if now[_XX] > 0.0 else LEARNING
    out[CONTACT] = 0.0 if now[_STATE] >= CARRIED else in_contact


@njit(cache=True)
def _begin(memory: Array, theta: Array, v: tuple[float, float, float], h: float) -> None:
    """A new object: nothing is known of it but what pushing has told; it hangs at rest in the moving grasp."""
    for i in range(_BANK, MEMORY_SIZE):
        memory[i] = 0.0
    for j in range(_RODS):
        for i in range(2):
            memory[_BANK + 6 * j + 3 * i] = v[i]
    memory[_YY] = memory[_YX] = memory[_XX] = memory[_COUNT] = memory[_ACROSS] = 0.0
    memory[_HOW] = LEARNING
    for i in range(3):
        memory[_TOLD + i] = memory[_SURE + i] = 0.0
    if theta[_M] > 0.0:
        weight = PRIOR_S / h * GRAVITY**2
        memory[_XX], memory[_YX], memory[_YY] = weight, weight * theta[_M], weight * theta[_M] ** 2
        memory[_TOLD] = theta[_M]
