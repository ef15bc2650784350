"""A body that an input moves: input in, position out. The equation stands in `mmt_drake.model.forces`.

A driven body is pushed by its input; the output of a transmission is pulled along by a spring.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.body import (
    AXIS_SIZE,
    MEMORY,
    MODE,
    POSITION,
    SENSOR_MEMORY,
    VELOCITY,
    advance_body,
    advance_memory,
    read_motion,
    write_motion,
)
from mmt_drake.model.forces import Surroundings, constants, level_spring
from mmt_drake.model.hermite import Cubic
from mmt_drake.model.laws import Memory
from mmt_drake.model.massless import follow
from mmt_drake.model.memory import read_memory, write_memory
from mmt_drake.model.over import take_course
from mmt_drake.model.parameters import COURSE, Constants
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.numeric.layout import Layout

Numbers = NDArray[np.intp]
Drive = tuple[Array, Array, Array, Array]
"""time, u, load and p of `replay_part`."""
Work = tuple[Array, Array, Array, Array]
"""A state, output and rate (n,), and how the output changes with position and rate (2, n)."""

_STATE_STEPS = 4  # of the fit of a state
_SHORTER = 0.3  # times a step that made it worse
_DIFFERENCE = 1e-3  # of how far a lead-in goes
_KNOTS = 8  # of the measured motion in the time of a lead-in, of which laws take what they remember
_MEMORY_SIZE = SENSOR_MEMORY - MEMORY

# Layout of the state vector.
_next = Layout()
TIME = _next()  # [s] of the latest sample
INPUT = _next()  # at that sample
LOAD = _next()  # [N], at that sample
BEGAN = _next()  # [s], time of the first sample
BODY = _next(AXIS_SIZE)
STATE_SIZE = _next.size


@njit(cache=True, error_model="numpy")
def begin(state: Array, t: float, u: float, load: float, position: float) -> None:
    """The body at rest at `position` at time t [s], under input u and normal load [N]; fills `state` (STATE_SIZE,)."""
    state[:] = 0.0
    state[TIME] = state[BEGAN] = t
    state[INPUT] = u
    state[LOAD] = load
    state[BODY + POSITION] = position


@njit(cache=True, error_model="numpy")
def set_out(state: Array, began: float, t: float, u: float, load: float, position: float, velocity: float) -> None:
    """`begin` in motion, in a recording whose first sample was at `began` [s]."""
    begin(state, t, u, load, position)
    state[BEGAN] = began
    state[BODY + VELOCITY] = velocity
    state[BODY + MODE] = np.sign(velocity)


@njit(error_model="numpy", forceinline=True)
def swallowed(u: float, width: float) -> float:
    """What a dead band of a total width takes off an input."""
    return min(max(u, -0.5 * width), 0.5 * width)


@njit(error_model="numpy", forceinline=True)
def _acting(u: float, c: Constants) -> float:
    """An input beyond its dead band: as it is where it drives a body by its force, else where it has the output."""
    u -= swallowed(u, c.dead)
    return u if c.driven != 0.0 else c.gain * u + c.offset


@njit(error_model="numpy", forceinline=True)
def _constants_at(state: Array, t: float, p: Array) -> Constants:
    """The numbers of the body until time t [s]; those that change over a condition are taken in the middle."""
    take_course(p, p[COURSE], 0.5 * (state[TIME] + t) - state[BEGAN])
    return constants(p)


@njit(error_model="numpy", forceinline=True)
def _pushed(state: Array, h: float, u: float, load: float, c: Constants) -> tuple[Cubic, Cubic, float]:
    """Input and normal load over the next h [s], at whose end they are u and load, and the time at which it begins."""
    before = _acting(state[INPUT], c)
    line = Cubic(before, (_acting(u, c) - before) / h, 0.0, 0.0)
    normal = Cubic(state[LOAD], (load - state[LOAD]) / h, 0.0, 0.0)
    return line, normal, state[TIME] - state[BEGAN]


@njit(cache=True, error_model="numpy")
def advance(state: Array, t: float, u: float, load: float, p: Array) -> None:
    """Advance the body to time t [s], where the input is u, in place; between samples input and load are linear.

    Args:
        state: (STATE_SIZE,) as left by `begin` or by the previous call.
        t: not before the state's time; equal to it only replaces input and load.
        u: in the recording's unit.
        load: normal load of its bearing, or of a transmission what may push its output [N].
        p: kernel vector of a `PositionOut`.
    """
    h = t - state[TIME]
    if h > 0.0:
        c = _constants_at(state, t, p)
        line, normal, start = _pushed(state, h, u, load, c)
        if c.m > 0.0:
            advance_body(state, BODY, 0.0, h, line, normal, True, start, level_spring(c), c)
        else:
            around = Surroundings(line, normal, 0.0, True, start, level_spring(c))
            write_motion(state, BODY, follow(read_motion(state, BODY), 0.0, h, around, c))
    state[TIME] = t
    state[INPUT] = u
    state[LOAD] = load


@njit(cache=True, error_model="numpy", nogil=True)
def replay_part(
    first: int, end: int, time: Array, u: Array, load: Array, p: Array, state: Array, output: Array, rate: Array
) -> None:
    """Free-running simulation of the samples from `first` to before `end`.

    Args:
        first, end: of the samples.
        time: (n,) sample times [s], increasing.
        u: (n,) input.
        load: (n,) normal load [N].
        p: kernel vector of a `PositionOut`.
        state: (STATE_SIZE,) of `begin` or `set_out`, or after the samples before.
        output, rate: (n,) to be filled with the position and its derivative.
    """
    for k in range(first, end):
        if k > 0:
            advance(state, time[k], u[k], load[k], p)
        output[k] = state[BODY + POSITION]
        rate[k] = state[BODY + VELOCITY]


@njit(cache=True, error_model="numpy", nogil=True)
def replay_windows(
    rows: Numbers,
    kept: Flags,
    used: Flags,
    guess: Array,
    weight: Array,
    measured: Array,
    time: Array,
    u: Array,
    load: Array,
    p: Array,
    output: Array,
    rate: Array,
    states: Array,
) -> None:
    """Simulation over windows, each from the state that fits its lead-in (`mmt_drake.windows`).

    The state is found by a few Gauss-Newton steps from the guess, with the derivatives there; a step that makes it
    worse is shortened.

    Args:
        rows, kept, used, guess, weight: as in `Windows`.
        measured: (n,) output that the lead-ins are fitted to.
        time, u, load, p: as of `replay`.
        output, rate: (n,) filled, lead-ins included where nothing is scored.
        states: (w, 2) filled with the position and rate at the first sample of each window that is kept.
    """
    n, drive, state = len(time), (time, u, load, p), np.empty(STATE_SIZE)
    aside = (state, np.empty(n), np.empty(n), np.empty((2, n)))
    memory, remembers = np.zeros((len(rows), _MEMORY_SIZE)), constants(p).remembers
    for i in range(len(rows)):
        if not kept[i:].any():
            break
        if i > 0 and remembers:
            _pass_on(rows[i - 1 : i + 1], memory[i - 1 : i + 1], states[i - 1], measured, drive, aside)
        first, lead, q = rows[i, 0], rows[i, 1], read_memory(memory[i], 0)
        states[i, 0], states[i, 1] = guess[i, 0], guess[i, 1]
        passes_on = remembers and i + 1 < len(rows) and rows[i + 1, 1] == rows[i + 1, 2]
        if lead > first and (kept[i] or passes_on):
            states[i, 0], states[i, 1] = _fit_state(q, first, lead, used, guess[i], weight[i], measured, drive, aside)
    for i in range(len(rows) - 1, -1, -1):  # what a window scores lies over the lead-in of the next one
        if kept[i]:
            q = read_memory(memory[i], 0)
            _replay_from(states[i, 0], states[i, 1], q, rows[i, 0], rows[i, 3], drive, state, output, rate)


@njit(cache=True, error_model="numpy", nogil=True)
def _pass_on(rows: Numbers, memory: Array, begins: Array, measured: Array, drive: Drive, work: Work) -> None:
    """What laws remember at the first sample of the second of two windows, from what they do at that of the first.

    Where the second one's lead-in is its own beginning, the motion between them is simulated. Else it is the measured
    one, straight through a few knots in the time of a lead-in: from one sample to the next its noise is a way, too.

    Args:
        rows: (2, 4) as in `Windows`.
        memory: (2, 4) whose second row is filled.
        begins: (2,) position and rate at the first sample of the first window.
        measured, drive, work: as of `replay_windows`; what is simulated is no result.
    """
    (time, u, load, p), (state, output, rate, _) = drive, work
    begun, first, lead = rows[0, 0], rows[1, 0], rows[1, 1]
    q = read_memory(memory[0], 0)
    if lead == rows[1, 2]:
        _replay_from(begins[0], begins[1], q, begun, first + 1, drive, state, output, rate)
    else:
        knot = max((lead - first) // _KNOTS, 1)
        k = begun + (first - begun) % knot
        begin(state, time[k], u[k], load[k], measured[k])
        state[BEGAN] = time[0]
        write_memory(state, BODY + MEMORY, q)
        while k < first:
            k += knot
            h = time[k] - state[TIME]
            c = _constants_at(state, time[k], p)
            line, normal, start = _pushed(state, h, u[k], load[k], c)
            path = Cubic(measured[k - knot], (measured[k] - measured[k - knot]) / h, 0.0, 0.0)
            advance_memory(state, BODY, h, path, Surroundings(line, normal, 0.0, True, start, level_spring(c)), c)
            state[TIME], state[INPUT], state[LOAD] = time[k], u[k], load[k]
    write_memory(memory[1], 0, read_memory(state, BODY + MEMORY))


@njit(cache=True, error_model="numpy", nogil=True)
def _fit_state(
    q: Memory,
    first: int,
    lead: int,
    used: Flags,
    guess: Array,
    weight: Array,
    measured: Array,
    drive: Drive,
    work: Work,
) -> tuple[float, float]:
    """Position and rate at the sample `first` that fit the lead-in best; guess and weight are (2,)."""
    time, (state, here, rate, moved) = drive[0], work
    best = guess[0], guess[1]
    x, v = best
    least = np.inf
    low, high = np.min(measured[first:lead]), np.max(measured[first:lead])
    dx = _DIFFERENCE * max(high - low, 1e-9 * max(abs(low), abs(high)), 1e-300)
    dv = dx / max(time[lead - 1] - time[first], 1e-300)
    a, b, c = weight[0], 0.0, weight[1]
    for step in range(_STATE_STEPS + 1):
        _replay_from(x, v, q, first, lead, drive, state, here, rate)
        cost = weight[0] * (x - guess[0]) ** 2 + weight[1] * (v - guess[1]) ** 2
        gx, gv = weight[0] * (guess[0] - x), weight[1] * (guess[1] - v)
        if step == 0:
            _replay_from(x + dx, v, q, first, lead, drive, state, moved[0], rate)
            _replay_from(x, v + dv, q, first, lead, drive, state, moved[1], rate)
            for k in range(first, lead):
                moved[0, k] = (moved[0, k] - here[k]) / dx
                moved[1, k] = (moved[1, k] - here[k]) / dv
        for k in range(first, lead):
            if used[k]:
                left = measured[k] - here[k]
                cost += left * left
                gx += moved[0, k] * left
                gv += moved[1, k] * left
                if step == 0:
                    a += moved[0, k] ** 2
                    b += moved[0, k] * moved[1, k]
                    c += moved[1, k] ** 2
        if not cost <= least:
            x, v = best[0] + _SHORTER * (x - best[0]), best[1] + _SHORTER * (v - best[1])
            continue
        least, best = cost, (x, v)
        determinant = a * c - b * b
        if not determinant > 0.0:
            break
        x, v = x + (c * gx - b * gv) / determinant, v + (a * gv - b * gx) / determinant
    return best


@njit(cache=True, error_model="numpy", nogil=True)
def _replay_from(
    x: float, v: float, q: Memory, first: int, end: int, drive: Drive, state: Array, output: Array, rate: Array
) -> None:
    """`replay_part` from a position, a rate and what laws remember at the sample `first`."""
    time, u, load, p = drive
    set_out(state, time[0], time[first], u[first], load[first], x, v)
    write_memory(state, BODY + MEMORY, q)
    output[first], rate[first] = state[BODY + POSITION], state[BODY + VELOCITY]
    replay_part(first + 1, end, time, u, load, p, state, output, rate)
