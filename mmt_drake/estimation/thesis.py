"""The thesis's estimator (section 3.2, appendix D.2) as one compiled step.

Each step: backward differences of velocity and force, low-pass filters on all signals alike, the regressors of eq. 7
for the two tangential axes (one theta, two rows) and of eq. 8 along the normal, recursive least squares (eq. 4-5) while
in contact, and the back-solve of eq. 30. Out of contact psi = 0: nothing is learned and the estimated force is 0
(eq. 9); the filters run on.

Kept as the thesis has it, at a price: the filters are not reset at a touch and mix samples from before and after it,
which no single model explains (`RlsOptions.settle` waits that out); each backward difference is half a sample late,
which biases the parameters (`RlsOptions.differences`); the friction regressor has the sign of the probe's velocity,
not of the body's.
"""

import numpy as np
from numba import njit

from mmt_drake.estimation.options import RlsOptions
from mmt_drake.model import regrouping
from mmt_drake.model.cholesky import cholesky_factor, cholesky_solve
from mmt_drake.model.regrouping_equations import band_weight
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.butterworth import butterworth, lowpass, rest_state, set_at_rest
from mmt_drake.numeric.layout import Layout

# The signals of the filter bank: for x and for y these eight, then the normal axis's three.
_JERK, _ACCELERATION, _VELOCITY, _POSITION, _FORCE_2, _FORCE_1, _SIGN, _FORCE = range(8)
_NORMAL = 16
_SIGNALS = 19

_FULL_EVERY = 20  # ticks in contact from one back-solve for all roots to the next

#: What a step puts out, one after the other; the estimator's memory stands behind it. All of it is one array, because
#: that is one state of a LeafSystem's Context.
PORT_SIZES = {"theta": 10, "regrouped": 7, "stable": 1, "estimated_force": 3, "filtered_force": 3}
#: Where each of them stands in the readout.
THETA, REGROUPED, STABLE, ESTIMATED, FILTERED = map(Layout().part, PORT_SIZES.values())
READOUT_SIZE = FILTERED.stop
_MEMORY = slice(READOUT_SIZE, None)

# The memory. Ticks in contact are counted for the present touch, and over all touches.
_next = Layout()
_STARTED, _TOUCHING, _TICKS_OF_TOUCH, _TICKS_IN_CONTACT = map(_next, [1] * 4)
_TOUCH = _next(2)  # probe position at touch, x and y
_DEFLECTION = _next(2)  # of the contact spring, x and y; for the body's velocity
_LAST_SIZE = 6
_LAST = _next(2 * _LAST_SIZE)  # by axis: velocity, its difference, force, its difference, position, friction's velocity
_NORMAL_THETA = _next(2)  # b, k
_NORMAL_P, _P = _next(2 * 2), _next(7 * 7)
_VALUES = _next(_SIGNALS)  # the bank's, filtered
_WORK = _next(7 + 7 + 2)  # from here on nothing is remembered: psi, gain, normal psi, roots, weight, scratch
_ROOTS = _next(regrouping.MAX_ROOTS * regrouping.ROOT_SIZE)
_WEIGHT = _next(6 * 6)
_SCRATCH = _next(regrouping.SCRATCH_SIZE)
_BANK = _next.size


# `RlsOptions` in the form the compiled step takes: a vector, since a named tuple costs it two microseconds.
_next = Layout()
_STEP, _FORGETTING, _SETTLE_TICKS, _FREEZE_TICKS, _LEFT_OUT = map(_next, [1] * 5)
_BY_INFORMATION, _FRICTION_OF_BODY, _FILTER_FRICTION, _FROM_TOUCH, _CENTRAL = map(_next, [1] * 5)
_REST = _next()  # of the filters, 2 numbers a section; then their coefficients, 6 a section


def settings(options: RlsOptions) -> Array:
    """Design the filters and translate the options."""
    sos = butterworth(options.filter_order, options.cutoff_hz, options.step)
    numbers = [
        options.step,
        options.forgetting,
        round(options.settle / options.step),
        np.inf if options.freeze_after is None else round(options.freeze_after / options.step),
        regrouping.EQUATIONS.index(options.equations),
        options.weighting == "information",
        options.friction_velocity == "body",
        options.filter_friction,
        options.position_origin == "touch",
        options.differences == "central",
    ]
    return np.concatenate([np.array(numbers, dtype=np.float64), rest_state(sos).ravel(), sos.ravel()])


def covariance(readout: Array) -> Array:
    """P of a ... g (7 x 7) within the memory, in units of the equation error's variance."""
    return readout[_MEMORY][_P:_VALUES].reshape(7, 7)


def initial_readout(options: RlsOptions) -> Array:
    """Outputs and memory before the first sample: theta is NaN, all else of the outputs zero."""
    sections = (options.filter_order + 1) // 2
    readout = np.zeros(READOUT_SIZE + _BANK + sections * 2 * _SIGNALS)
    readout[THETA] = np.nan
    covariance(readout)[...] = options.initial_covariance * np.eye(7)
    readout[_MEMORY][_NORMAL_P:_P].reshape(2, 2)[...] = options.initial_covariance * np.eye(2)
    return readout


@njit(cache=True, error_model="numpy")
def dot(x: Array, y: Array) -> float:
    """Inner product of two short vectors."""
    total = 0.0
    for i in range(x.size):
        total += x[i] * y[i]
    return total


@njit(cache=True, error_model="numpy")
def rls_update(theta: Array, P: Array, psi: Array, y: float, forgetting: float, gain: Array) -> None:
    """One row y = psi' theta of the thesis's eq. 4-5, with exponential forgetting.

    theta += P psi (y - psi' theta) / (lambda + psi' P psi);  P = (P - P psi psi' P / (lambda + psi' P psi)) / lambda

    lambda = 1 is eq. 4-5. Then psi = 0 changes nothing, which is how the thesis pauses; with lambda < 1 it would
    inflate P, so whoever pauses does not call. Several rows of one instant: lambda with the first, 1 with the others.

    Args:
        theta: estimate (n), changed.
        P: its covariance in units of the equation error's variance (n x n), changed; stays exactly symmetric.
        psi: regressor (n).
        y: output.
        forgetting: lambda in (0, 1].
        gain: work space (n).
    """
    n = theta.size
    scale = forgetting
    for i in range(n):
        gain[i] = dot(P[i], psi)
        scale += psi[i] * gain[i]
    error = (y - dot(psi, theta)) / scale
    for i in range(n):
        theta[i] += gain[i] * error
        for j in range(i, n):
            P[i, j] = (P[i, j] - gain[i] * gain[j] / scale) / forgetting
            P[j, i] = P[i, j]


@njit(cache=True, error_model="numpy")
def _read_axis(
    i: int, measurement: Array, memory: Array, step: float, friction_velocity: float, central: float
) -> None:
    """Signals of tangential axis i from the latest samples, unfiltered, into the memory's bank values."""
    x, v, F = measurement[i], measurement[3 + i], measurement[6 + i]
    last = memory[_LAST + _LAST_SIZE * i : _LAST + _LAST_SIZE * (i + 1)]
    values = memory[_VALUES + 8 * i : _VALUES + 8 * i + 8]
    if memory[_STARTED] == 0.0:
        last[0], last[2], last[4], last[5] = v, F, x, friction_velocity
    dv, dF = (v - last[0]) / step, (F - last[2]) / step
    values[_JERK], values[_FORCE_2] = (dv - last[1]) / step, (dF - last[3]) / step
    if central > 0.0:  # where these second differences belong: one sample ago
        values[_ACCELERATION], values[_FORCE_1] = 0.5 * (dv + last[1]), 0.5 * (dF + last[3])
        values[_VELOCITY], values[_FORCE], values[_POSITION] = last[0], last[2], last[4]
        values[_SIGN] = np.sign(last[5])
    else:
        values[_ACCELERATION], values[_FORCE_1] = dv, dF
        values[_VELOCITY], values[_FORCE], values[_POSITION] = v, F, x
        values[_SIGN] = np.sign(friction_velocity)
    last[0], last[1], last[2], last[3], last[4], last[5] = v, dv, F, dF, x, friction_velocity


@njit(cache=True, error_model="numpy")
def _body_velocity(i: int, measurement: Array, theta: Array, memory: Array, step: float) -> float:
    """v_m = v - d' of axis i, from F = -(k2 d + b2 d') by a backward Euler step of the deflection d since touch."""
    k2, b2 = theta[2], theta[4]
    d = memory[_DEFLECTION + i]
    new = (b2 * d - step * measurement[6 + i]) / (b2 + step * k2)
    memory[_DEFLECTION + i] = new
    return measurement[3 + i] - (new - d) / step


@njit(cache=True, error_model="numpy")
def _back_solve(
    regrouped: Array, theta: Array, stable: Array, memory: Array, left_out: int, by_information: float
) -> None:
    """theta and the flag from the regrouped and the normal parameters; with no physical solution theta[:6] stays.

    The root of the tick before is taken along; every `_FULL_EVERY` ticks, and where that fails, all are sought: the
    admissible root that is the better one may have become another.
    """
    roots = memory[_ROOTS:_WEIGHT].reshape((regrouping.MAX_ROOTS, regrouping.ROOT_SIZE))
    weight = memory[_WEIGHT:_SCRATCH].reshape((6, 6))
    scratch = memory[_SCRATCH:_BANK]
    theta[6], theta[7] = memory[_NORMAL_THETA + 1], memory[_NORMAL_THETA]
    known = stable[0] > 0.0 and memory[_TICKS_IN_CONTACT] % _FULL_EVERY != 0.0
    stable[0] = 0.0
    if by_information > 0.0:
        P, L = memory[_P:_VALUES].reshape((7, 7)), scratch[:36].reshape((6, 6))
        for i in range(6):
            assign(L[i], P[i, :6])
        if not cholesky_factor(L):
            return
        for i in range(6):
            weight[i, :] = 0.0
            weight[i, i] = 1.0
            cholesky_solve(L, weight[i])
    else:
        band_weight(regrouped, left_out, weight)
    chosen = 0
    assign(roots[0, :6], theta[:6])
    if not (known and regrouping.follow_root(regrouped, weight, roots[0], scratch)):
        normal_k = theta[6] if theta[6] > 0.0 else np.nan
        status, chosen, _ = regrouping.back_solve_core(regrouped, left_out, weight, normal_k, roots, scratch)
        if status != regrouping.SOLVED:
            return
    assign(theta[:6], roots[chosen, :6])
    theta[8], theta[9] = theta[5], 0.0  # eq. 7 knows Coulomb friction alone
    if theta[6] > 0.0 and theta[7] >= 0.0:
        stable[0] = 1.0


@njit(cache=True, error_model="numpy")
def _regressor(i: int, values: Array, memory: Array, from_touch: float, psi: Array) -> None:
    """psi of the thesis's eq. 7 for tangential axis i."""
    for n in range(7):
        psi[n] = -values[8 * i + n]
    if from_touch > 0.0:
        psi[_POSITION] += memory[_TOUCH + i]


@njit(cache=True, error_model="numpy")
def readout_step(measurement: Array, in_contact: float, readout: Array, fixed: Array) -> bool:
    """One sample; allocates nothing.

    Args:
        measurement: position, velocity, force (9) in the table frame [m, m/s, N].
        in_contact: 1.0 in contact, else 0.0.
        readout: of `initial_readout`, changed: theta (m, k1, k2, b1, b2, Fc, normal k, normal b), the recursive
            estimate a ... g, the flag `stable`, psi' theta along x, y, z [N], the filtered force [N]; then the memory.
        fixed: `settings`.

    Returns:
        False, with nothing changed, where an input is not finite.
    """
    if not np.isfinite(in_contact):
        return False
    for i in range(9):
        if not np.isfinite(measurement[i]):
            return False
    theta, regrouped, stable = readout[THETA], readout[REGROUPED], readout[STABLE]
    estimated, filtered, memory = readout[ESTIMATED], readout[FILTERED], readout[_MEMORY]
    touching = in_contact > 0.5
    if touching and memory[_TOUCHING] == 0.0:
        memory[_TICKS_OF_TOUCH] = 0.0
        for i in range(2):
            memory[_TOUCH + i] = measurement[i]
            memory[_DEFLECTION + i] = 0.0
    memory[_TOUCHING] = 1.0 if touching else 0.0

    values = memory[_VALUES:_WORK]
    sections = (fixed.size - _REST) // 8
    coefficients = _REST + 2 * sections
    bank, sos = memory[_BANK:].reshape((sections, 2, _SIGNALS)), fixed[coefficients:].reshape((sections, 6))
    for i in range(2):
        friction_velocity = measurement[3 + i]
        if fixed[_FRICTION_OF_BODY] > 0.0 and touching and not np.isnan(theta[4]):
            friction_velocity = _body_velocity(i, measurement, theta, memory, fixed[_STEP])
        _read_axis(i, measurement, memory, fixed[_STEP], friction_velocity, fixed[_CENTRAL])
    values[_NORMAL], values[_NORMAL + 1], values[_NORMAL + 2] = measurement[5], measurement[2], measurement[8]
    sign_x, sign_y = values[_SIGN], values[8 + _SIGN]
    if memory[_STARTED] == 0.0:
        set_at_rest(fixed[_REST:coefficients].reshape((sections, 2)), values, bank)
        memory[_STARTED] = 1.0
    lowpass(sos, values, bank)
    if fixed[_FILTER_FRICTION] == 0.0:
        values[_SIGN], values[8 + _SIGN] = sign_x, sign_y
    filtered[0], filtered[1], filtered[2] = values[_FORCE], values[8 + _FORCE], values[_NORMAL + 2]

    if not touching:
        estimated[:] = 0.0
        return True
    learning = memory[_TICKS_OF_TOUCH] >= fixed[_SETTLE_TICKS] and memory[_TICKS_IN_CONTACT] < fixed[_FREEZE_TICKS]
    memory[_TICKS_OF_TOUCH] += 1.0
    memory[_TICKS_IN_CONTACT] += 1.0

    psi, gain = memory[_WORK : _WORK + 7], memory[_WORK + 7 : _WORK + 14]
    normal_psi = memory[_WORK + 14 : _ROOTS]
    normal_psi[0], normal_psi[1] = -values[_NORMAL], -values[_NORMAL + 1]
    normal_theta = memory[_NORMAL_THETA:_NORMAL_P]
    if learning:
        P, normal_P = memory[_P:_VALUES].reshape((7, 7)), memory[_NORMAL_P:_P].reshape((2, 2))
        for i in range(2):
            _regressor(i, values, memory, fixed[_FROM_TOUCH], psi)
            rls_update(regrouped, P, psi, filtered[i], fixed[_FORGETTING] if i == 0 else 1.0, gain)
        rls_update(normal_theta, normal_P, normal_psi, filtered[2], fixed[_FORGETTING], gain)
        _back_solve(regrouped, theta, stable, memory, int(fixed[_LEFT_OUT]), fixed[_BY_INFORMATION])
    for i in range(2):
        _regressor(i, values, memory, fixed[_FROM_TOUCH], psi)
        estimated[i] = dot(psi, regrouped)
    estimated[2] = dot(normal_psi, normal_theta)
    return True
