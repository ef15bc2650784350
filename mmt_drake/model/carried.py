"""An object that a grasp carries: weight, inertia and swing in free space.

The object is a rod of mass m that hangs upright from the grasp, its centre c below it, and turns about its own centre
with the inertia of a thin rod gripped at its end, I = m c^2 / 3. The grasp holds it as the contact of
`mmt_drake.model.flexible_box` does, but either way: by k2, b2 along x and y, by k, b along z. With the centre at r, the
angle theta of the swing, and p = r - c theta where it is gripped, each lateral axis is, for small angles::

    m r''     = f,   f = k2 (x - p - a) + b2 (v - p')
    I theta'' = -m g c theta - beta theta' - c f,   beta = 2 zeta w (4/3) m c^2,   w^2 = 3 g / (4 c)

and the vertical one, z_m being how high the object is off the table::

    m z_m'' = f_z - m g,   f_z = k (z - z_m - a_z) + b (v_z - z_m')

The force on the probe is -f. w is the frequency of the free swing about the grasp, zeta its damping ratio. Friction of
the grip holds |f| up to mu G, G being its force; beyond, the anchors a follow and the object slips. Terms of the second
order in the angle are left out: 1 % of the weight at 8 degrees.

The step is the implicit midpoint rule. With it the energy `stored` balances exactly: what the tip puts in, f times its
way, less what dampers burn, whatever the numbers and however long the step. The rod is the equation of a uniform rod of
any textbook; the rule: Hairer, Lubich, Wanner, "Geometric Numerical Integration", Springer 2006, section IV.2.
"""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

GRAVITY = 9.81  # [m/s^2]

# The numbers: m, k2, b2, normal_k, normal_b, c, zeta.
MASS, K, B, NORMAL_K, NORMAL_B, CENTRE, ZETA = range(7)
NUMBERS = 7

# The state: of each lateral axis centre, its velocity, angle, its rate, anchor; then height, its rate, anchor; then the
# force on the object, in the middle of the latest step.
_next = Layout()
LATERAL = _next(10)
RADIUS, RATE, ANGLE, TURNING, ANCHOR, AXIS = range(6)
HEIGHT, CLIMB, ANCHOR_Z = _next(), _next(), _next()
PULL = _next(3)
CARRIED_SIZE = _next.size


@njit(cache=True)
def swing_rate(c: float) -> float:
    """Of the free swing about the grasp, the centre c [m] below it [rad/s]."""
    return math.sqrt(0.75 * GRAVITY / c)


@njit(cache=True)
def swing_damper(m: float, c: float, zeta: float) -> float:
    """Damper of the swing, beta [N m s]."""
    return 2.0 * zeta * swing_rate(c) * 4.0 / 3.0 * m * c * c


@njit(cache=True)
def lift(state: Array, place: tuple[float, float], rate: tuple[float, float], anchor: tuple[float, float]) -> None:
    """The object as it leaves the table: upright, its place [m], velocity [m/s] and the contact's anchors [m] kept.

    The anchor along z stays what it is.
    """
    for i in range(2):
        at = LATERAL + AXIS * i
        state[at + RADIUS], state[at + RATE], state[at + ANCHOR] = place[i], rate[i], anchor[i]
        state[at + ANGLE] = state[at + TURNING] = 0.0
    state[HEIGHT] = state[CLIMB] = 0.0


@njit(cache=True)
def swing(state: Array, i: int, x0: float, x1: float, h: float, p: Array) -> None:
    """One lateral axis i over a step of h [s] in which the tip goes straight from x0 to x1 [m], as `carry`."""
    at, m, c = LATERAL + AXIS * i, p[MASS], p[CENTRE]
    inertia, weight, beta = m * c * c / 3.0, m * GRAVITY * c, swing_damper(m, c, p[ZETA])
    r, v, angle, turning, a = state[at], state[at + RATE], state[at + ANGLE], state[at + TURNING], state[at + ANCHOR]
    give = p[B] + 0.5 * h * p[K]
    first = p[K] * (0.5 * (x0 + x1) - r + c * angle - a) + p[B] * (x1 - x0) / h
    # Two equations for the velocities in the middle: symmetric and positive definite.
    m11, m12, m22 = 2.0 * m / h + give, -c * give, 2.0 * inertia / h + 0.5 * h * weight + beta + c * c * give
    right1 = first + 2.0 * m / h * v
    right2 = 2.0 * inertia / h * turning - weight * angle - c * first
    det = m11 * m22 - m12 * m12
    middle_v, middle_turning = (m22 * right1 - m12 * right2) / det, (m11 * right2 - m12 * right1) / det
    state[PULL + i] = first - give * (middle_v - c * middle_turning)
    state[at + RADIUS], state[at + RATE] = r + h * middle_v, 2.0 * middle_v - v
    state[at + ANGLE], state[at + TURNING] = angle + h * middle_turning, 2.0 * middle_turning - turning


@njit(cache=True)
def carry(state: Array, before: Array, after: Array, h: float, p: Array) -> None:
    """Carry the object over a step of h [s], in place.

    Args:
        state: (CARRIED_SIZE,).
        before, after: (3,) or longer, the tip's position at both ends [m]; between, it goes straight.
        h: [s], above 0.
        p: (NUMBERS,), all above 0 but dampers and zeta, which may be 0.
    """
    for i in range(2):
        swing(state, i, before[i], after[i], h, p)
    m, k, b = p[MASS], p[NORMAL_K], p[NORMAL_B]
    give, rate = b + 0.5 * h * k, (after[2] - before[2]) / h
    first = k * (0.5 * (before[2] + after[2]) - state[HEIGHT] - state[ANCHOR_Z]) + b * rate
    middle = (first + 2.0 * m / h * state[CLIMB] - m * GRAVITY) / (2.0 * m / h + give)
    state[PULL + 2] = first - give * middle
    state[HEIGHT] += h * middle
    state[CLIMB] = 2.0 * middle - state[CLIMB]


@njit(cache=True)
def fall(state: Array, h: float) -> None:
    """Let the object fall for h [s], in place: nothing holds it."""
    for i in range(2):
        state[LATERAL + AXIS * i + RADIUS] += h * state[LATERAL + AXIS * i + RATE]
        state[PULL + i] = 0.0
    state[HEIGHT] += h * (state[CLIMB] - 0.5 * h * GRAVITY)
    state[CLIMB] -= h * GRAVITY
    state[PULL + 2] = 0.0


@njit(cache=True)
def gripped_at(state: Array, i: int, c: float) -> tuple[float, float]:
    """Where the object is gripped along x (0), y (1) or z (2), and its velocity [m], [m/s]."""
    if i == 2:
        return state[HEIGHT], state[CLIMB]
    at = LATERAL + AXIS * i
    return state[at + RADIUS] - c * state[at + ANGLE], state[at + RATE] - c * state[at + TURNING]


@njit(cache=True)
def pull_of(state: Array, i: int, motion: Array, p: Array) -> float:
    """The force on the object along an axis with the tip at `motion` (6: [m], [m/s]) [N]."""
    place, rate = gripped_at(state, i, p[CENTRE])
    k, b, anchor = p[K], p[B], state[LATERAL + AXIS * i + ANCHOR]
    if i == 2:
        k, b, anchor = p[NORMAL_K], p[NORMAL_B], state[ANCHOR_Z]
    return float(k * (motion[i] - place - anchor) + b * (motion[3 + i] - rate))


@njit(cache=True)
def slip_of(pull: float, size: float, most: float, k: float) -> float:
    """How far an anchor follows so that a force whose norm is `size` [N] comes down to `most` [m]."""
    return pull * (1.0 - most / size) / k


@njit(cache=True)
def slip(state: Array, motion: Array, most: float, p: Array) -> float:
    """Let the grip slip until the force on the object is at most `most` [N]; by how far it slips [m]."""
    x, y, z = pull_of(state, 0, motion, p), pull_of(state, 1, motion, p), pull_of(state, 2, motion, p)
    size = math.sqrt(x * x + y * y + z * z)
    if size <= most:
        return 0.0
    dx, dy, dz = slip_of(x, size, most, p[K]), slip_of(y, size, most, p[K]), slip_of(z, size, most, p[NORMAL_K])
    state[LATERAL + ANCHOR] += dx
    state[LATERAL + AXIS + ANCHOR] += dy
    state[ANCHOR_Z] += dz
    return math.sqrt(dx * dx + dy * dy + dz * dz)


@njit(cache=True)
def stored(state: Array, tip: Array, p: Array) -> float:
    """Energy [J] with the tip (3) there [m]: of motion, height over the table, swing and the grasp's springs."""
    m, c = p[MASS], p[CENTRE]
    energy = 0.5 * m * state[CLIMB] ** 2 + m * GRAVITY * state[HEIGHT]
    energy += 0.5 * p[NORMAL_K] * (tip[2] - state[HEIGHT] - state[ANCHOR_Z]) ** 2
    for i in range(2):
        at = LATERAL + AXIS * i
        place, _ = gripped_at(state, i, c)
        energy += 0.5 * m * state[at + RATE] ** 2 + m * c * c / 6.0 * state[at + TURNING] ** 2
        energy += 0.5 * m * GRAVITY * c * state[at + ANGLE] ** 2
        energy += 0.5 * p[K] * (tip[i] - place - state[at + ANCHOR]) ** 2
    return float(energy)
