"""A rod in a grip, on a table and in the air: other coordinates, equations and integrator than `mmt_drake.model`.

A rigid thin rod of mass m and length 2 c in space, by place and velocity of its centre, its direction e (unit, from the
grip down) and its turning w. The grip is at its upper end p = r - c e. One equation holds everywhere::

    m r'' = f + table + m g,   I w' = -c e x f + torque of the table's edge - beta w,   e' = w x e,   I = m c^2 / 3

The table is a stiff spring and damper under the lower end that only presses, and while it presses its friction is
smooth, -Fd v / sqrt(|v|^2 + v_s^2) times the share of the weight that it carries, and the rod's flat foot keeps it
upright. The grip is springs and dampers either way, cut where friction ends. Angles are whole ones. Classical
Runge-Kutta steps; the tip's position and velocity are linear between samples, each by itself.
"""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

G = 9.81  # [m/s^2]
STEP = 5e-5  # [s]
_CREEP = 2e-4  # v_s [m/s]
_TABLE_RATE, _FOOT_RATE = 600.0, 60.0  # natural frequencies of the rod on the table and on its foot [rad/s]
_SLID_OUT = 0.015  # [m]
_CLOSED = 0.5  # [N]

# Numbers: m, k2, b2, k, b, c, zeta, Fd, mu of the grip.
_M, _K, _B, _NK, _NB, _C, _ZETA, _FD, _MU = range(9)

# The state: r, v, e, w; anchors; whether the tip touches, what the grip has (0 nothing, 1 the rod, 2 lost it), how far
# it has slipped, the force on the rod, how hard the table presses; the tip and the time; scratch.
_of = Layout()
_R, _V, _E, _W = _of(3), _of(3), _of(3), _of(3)
_SMOOTH = _of.size
_ANCHOR, _TOUCHES, _GRIP, _SLIPPED, _PULL, _PRESS, TIP, _TIME = map(_of, (3, 1, 1, 1, 3, 1, 6, 1))
_HAND, _RATE, _TOTAL, _Y = _of(6), _of(_SMOOTH), _of(_SMOOTH), _of(_SMOOTH)
ROD_SIZE = _of.size


@njit(cache=True)
def _top(y: Array, c: float, i: int) -> tuple[float, float]:
    """Place and velocity of the upper end along one axis."""
    j, k = (i + 1) % 3, (i + 2) % 3
    turn = y[_W + j] * y[_E + k] - y[_W + k] * y[_E + j]
    return y[_R + i] - c * y[_E + i], y[_V + i] - c * turn


@njit(cache=True)
def _grasp(y: Array, state: Array, hand: Array, p: Array, i: int) -> float:
    """Force of the tip on the rod along one axis [N]."""
    if state[_TOUCHES] == 0.0:
        return 0.0
    place, rate = _top(y, p[_C], i)
    k, b = (p[_NK], p[_NB]) if i == 2 else (p[_K], p[_B])
    force = k * (hand[i] - place - state[_ANCHOR + i]) + b * (hand[3 + i] - rate)
    return float(min(force, 0.0) if i == 2 and state[_GRIP] != 1.0 else force)  # an open grip only presses


@njit(cache=True)
def _press(y: Array, p: Array) -> float:
    """By which the table presses on the lower end [N]."""
    c = p[_C]
    depth = -(y[_R + 2] + c * y[_E + 2] + 2.0 * c)
    rate = y[_V + 2] + c * (y[_W] * y[_E + 1] - y[_W + 1] * y[_E])
    k, b = p[_M] * _TABLE_RATE**2, 1.4 * p[_M] * _TABLE_RATE
    return max(k * depth - b * rate, 0.0) if depth > 0.0 else 0.0


@njit(cache=True)
def _rates(y: Array, state: Array, hand: Array, p: Array, rate: Array) -> None:
    m, c = p[_M], p[_C]
    inertia, swing = m * c * c / 3.0, math.sqrt(3.0 * G / (4.0 * c))
    beta = 2.0 * p[_ZETA] * swing * 4.0 * inertia
    fx, fy, fz = _grasp(y, state, hand, p, 0), _grasp(y, state, hand, p, 1), _grasp(y, state, hand, p, 2)
    ex, ey, ez, wx, wy, wz = y[_E], y[_E + 1], y[_E + 2], y[_W], y[_W + 1], y[_W + 2]
    press = _press(y, p)
    share = min(press / (m * G), 1.0)
    slow = p[_FD] * share / math.sqrt(y[_V] ** 2 + y[_V + 1] ** 2 + _CREEP**2)
    for i in range(3):
        rate[_R + i] = y[_V + i]
    rate[_V], rate[_V + 1] = (fx - slow * y[_V]) / m, (fy - slow * y[_V + 1]) / m
    rate[_V + 2] = (fz + press) / m - G
    rate[_E], rate[_E + 1], rate[_E + 2] = wy * ez - wz * ey, wz * ex - wx * ez, wx * ey - wy * ex
    foot, edge = share * inertia * _FOOT_RATE**2, beta + share * 2.0 * inertia * _FOOT_RATE
    # The foot turns e back to (0, 0, -1), along e x (0, 0, -1) = (-ey, ex, 0).
    rate[_W] = (-c * (ey * fz - ez * fy) - foot * ey - edge * wx) / inertia
    rate[_W + 1] = (-c * (ez * fx - ex * fz) + foot * ex - edge * wy) / inertia
    rate[_W + 2] = (-c * (ex * fy - ey * fx) - edge * wz) / inertia


@njit(cache=True)
def _settle(state: Array, grip: float, hand: Array, p: Array) -> None:
    """Touch, release and slip, and the force on the rod."""
    height, _ = _top(state, p[_C], 2)
    if grip < _CLOSED:
        state[_GRIP] = state[_SLIPPED] = state[_ANCHOR + 2] = 0.0
    below = hand[2] < height + state[_ANCHOR + 2]
    if state[_GRIP] == 0.0 and grip >= _CLOSED and below:
        state[_GRIP] = 1.0
    touches = state[_GRIP] == 1.0 or (below and state[_PRESS] > 0.0)
    if touches and state[_TOUCHES] == 0.0:
        for i in range(2):
            state[_ANCHOR + i] = hand[i] - _top(state, p[_C], i)[0]
    state[_TOUCHES] = 1.0 if touches else 0.0
    for i in range(3):
        state[_PULL + i] = _grasp(state, state, hand, p, i)
    state[_PRESS] = _press(state, p)
    if state[_GRIP] != 1.0 or below:
        return
    size, most = math.sqrt(state[_PULL] ** 2 + state[_PULL + 1] ** 2 + state[_PULL + 2] ** 2), p[_MU] * grip
    if size > most:
        gone = 0.0
        for i in range(3):
            way = state[_PULL + i] * (1.0 - most / size) / (p[_NK] if i == 2 else p[_K])
            state[_ANCHOR + i] += way
            state[_PULL + i] *= most / size
            gone += way * way
        state[_SLIPPED] += math.sqrt(gone)
        if state[_SLIPPED] > _SLID_OUT:
            state[_GRIP], state[_ANCHOR + 2] = 2.0, 0.0


@njit(cache=True)
def stand(state: Array, t: float, motion: Array, p: Array) -> None:
    """The rod upright and at rest on the table at time t [s], its top at z = 0 under a tip at `motion` (6)."""
    for i in range(ROD_SIZE):
        state[i] = 0.0
    state[_E + 2] = -1.0
    state[_R + 2] = -p[_C] - G / _TABLE_RATE**2
    state[_TIME] = t
    state[_PRESS] = p[_M] * G
    assign(state[TIP : TIP + 6], motion)
    _settle(state, 0.0, motion, p)


@njit(cache=True)
def move(state: Array, t: float, motion: Array, grip: float, p: Array) -> None:
    """Bring the rod to time t, in place.

    Args:
        state: (ROD_SIZE,).
        t: [s].
        motion: (6,) of the tip [m], [m/s].
        grip: its force [N].
        p: (9,) m, k2, b2, k, b, c, zeta, Fd, mu of the grip.
    """
    start = state[_TIME]
    count = math.ceil((t - start) / STEP - 1e-6) if t > start else 0
    hand, rate, total, y = state[_HAND:_RATE], state[_RATE:_TOTAL], state[_TOTAL:_Y], state[_Y : _Y + _SMOOTH]
    for n in range(count):
        h = (t - start) / count
        for i in range(_SMOOTH):
            total[i] = rate[i] = 0.0
        for stage in range(4):
            part = 0.5 * ((stage + 1) // 2)
            for i in range(_SMOOTH):
                y[i] = state[i] + part * h * rate[i]
            for i in range(6):
                hand[i] = state[TIP + i] + (motion[i] - state[TIP + i]) * (n + part) / count
            _rates(y, state, hand, p, rate)
            for i in range(_SMOOTH):
                total[i] += rate[i] * (h / 6.0 if stage in (0, 3) else h / 3.0)
        for i in range(_SMOOTH):
            state[i] += total[i]
        size = math.sqrt(state[_E] ** 2 + state[_E + 1] ** 2 + state[_E + 2] ** 2)
        for i in range(3):
            state[_E + i] /= size
        _settle(state, grip, hand, p)
    if count == 0:
        _settle(state, grip, motion, p)
    assign(state[TIP : TIP + 6], motion)
    state[_TIME] = t


@njit(cache=True)
def look(state: Array, p: Array, force: Array, body: Array, held: Array) -> float:
    """Write what is to be seen of the rod, as `mmt_drake.model.grasped_box.read_grasped`; 1 where the tip has it."""
    height, _ = _top(state, p[_C], 2)
    for i in range(3):
        force[i] = -state[_PULL + i]
    for i in range(2):
        body[i], body[2 + i] = state[_R + i], state[_V + i]
    held[0], held[1], held[2] = state[_GRIP], state[_ANCHOR + 2], state[_SLIPPED]
    held[3] = height if state[_PRESS] == 0.0 else 0.0
    return state[_TOUCHES]
