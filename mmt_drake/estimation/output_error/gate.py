"""One tick of the estimator: is the sample to be believed, what joins the next sample of the fit, what force does the
model give; compiled.

What is not to be believed is left out, never mended: the sample of the fit that it would belong to says so, the model
moves on with what was good last, and `status` tells why. As soon as samples are good again they count again.
"""

from __future__ import annotations

import math
from enum import IntEnum
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.standstill import SIZE as STANDSTILL_SIZE
from mmt_drake.estimation.output_error.standstill import STILL_S, band, begin_here, initial_standstill, stood, watch
from mmt_drake.estimation.output_error.window import CONTACT, MOTION_GOOD, SAMPLE_SIZE, STAMP
from mmt_drake.model import flexible_box as box
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.parameters import KERNEL_SIZE, THETA, adopt_theta
from mmt_drake.model.regrouping_equations import regroup

Array = NDArray[np.float64]


class Status(IntEnum):
    """What the estimator is about; from `NOT_FINITE` on its input is not to be believed, and it holds what it knows."""

    LEARNING = 0
    FREE = 1  # not in contact: nothing to learn
    NOT_FINITE = 2  # NaN or infinity
    FROZEN = 3  # position, velocity or force stands still, noise included, while the others say that it moves
    SATURATED = 4  # the force stands at the largest value that it ever had, or is beyond the sensor's limit
    DROPPED = 5  # the last sample once more, although the probe moves
    JUMPED = 6  # the clock or the position did
    FLICKERING = 7  # the contact flag comes and goes


#: What a tick puts out, one after the other; the first five as the thesis's estimator has them.
PORT_SIZES = {
    "theta": len(THETA),
    "regrouped": 7,
    "stable": 1,
    "estimated_force": 3,
    "filtered_force": 3,
    "deviation": len(THETA),
    "status": 1,
    "held_body": HELD_SIZE,
}
_EDGES = (0, *accumulate(PORT_SIZES.values()))
THETA_PART, REGROUPED, STABLE, ESTIMATED, FILTERED, DEVIATION, STATUS, HELD = (slice(a, b) for a, b in pairwise(_EDGES))
READOUT_SIZE = _EDGES[-1]
_MEMORY = slice(READOUT_SIZE, None)

# The memory.
_STARTED, _TIME, _BROKEN, _TOLD, _TOLD_FOR, _JUMPS, _SINCE_GOOD = range(7)
_FLAG, _ACCEPTED, _NEW_FOR, _CHANGES, _FLICKERS = range(7, 12)
_STANDSTILL = slice(12, 12 + STANDSTILL_SIZE)
_GOOD = 12 + STANDSTILL_SIZE  # (6) the motion that was believed last
_LARGEST = _GOOD + 6  # (3) of the force along each axis
# (9), -, (4), -: the sample of the fit in the making
_SUM, _TICKS, _OK, _STAMPED = _LARGEST + 3, _LARGEST + 12, _LARGEST + 13, _LARGEST + 17
_P = _STAMPED + 1
_STATE = _P + KERNEL_SIZE
_COUNT = _STATE + box.STATE_SIZE  # samples that wait to be taken
_ROWS = _COUNT + 1

_MOVED = 5e-5  # [m] that the probe must have moved meanwhile
_ASTRAY = 3e-4  # [m] that position and velocity may contradict each other
_MOVING = 1e-3  # [m/s]: a probe that moves
_FASTEST, _ROUGHLY = 3.0, 1e-3  # [m/s], [m]: what a position may jump by
_BELIEVED_AFTER = 5  # ticks: then a position that jumped is where the probe is now
_DEBOUNCE_S = 0.01
_FLICKERS_AT, _STEADY_AT, _FADES_S = 3.0, 0.5, 0.05  # changes of the flag, which are forgotten one by one
_LONGEST_GAP_S = 0.2
_TOLD_S = 0.1  # a fault is told for so long at least


class Settings(NamedTuple):
    """`OutputErrorOptions` in the form that the compiled tick takes."""

    step: float
    ticks: int
    force_limit: float
    rows: int


def settings(options: OutputErrorOptions) -> Settings:
    """Translate the options."""
    limit = math.inf if options.force_limit is None else options.force_limit
    rows = 2 * options.samples_per_fit + math.ceil((_LONGEST_GAP_S + STILL_S) / options.interval) + 4
    return Settings(options.step, options.ticks, limit, rows)


def initial_readout(fixed: Settings, theta: Array, deviation: Array) -> Array:
    """Outputs and memory before the first sample: the prior, which is handed over from the start."""
    readout = np.zeros(READOUT_SIZE + _ROWS + SAMPLE_SIZE * fixed.rows)
    readout[_MEMORY][_STANDSTILL] = initial_standstill()
    hand_over(readout, theta, deviation, np.zeros(HELD_SIZE))
    readout[STATUS] = Status.FREE
    return readout


def hand_over(readout: Array, theta: Array, deviation: Array, held: Array) -> None:
    """Put out another set of parameters, and where friction then holds the body, and go on with the set.

    One that cannot be integrated is passed over.
    """
    if not adopt_theta(theta, math.inf, 0.0, readout[_MEMORY][_P : _P + KERNEL_SIZE]):
        return
    readout[THETA_PART], readout[DEVIATION], readout[STABLE] = theta, deviation, 1.0
    readout[REGROUPED], readout[HELD] = regroup(*theta[:6]), held


def take_samples(readout: Array, fixed: Settings) -> tuple[Array, bool]:
    """The samples of the fit that wait (k, SAMPLE_SIZE), and whether time broke off before them.

    The newest ones go on waiting: what stands still is only seen after a while, and then they are doubted.
    """
    memory = readout[_MEMORY]
    count, broken = int(memory[_COUNT]), memory[_BROKEN] != 0.0
    ready = max(0, count - math.ceil(STILL_S / (fixed.ticks * fixed.step)) - 1)
    rows = memory[_ROWS:].reshape(-1, SAMPLE_SIZE)
    samples = rows[:ready].copy()
    rows[: count - ready] = rows[ready:count].copy()
    memory[_COUNT], memory[_BROKEN] = float(count - ready), 0.0
    return samples, broken


@njit(cache=True, error_model="numpy")
def _finish(memory: Array, fixed: Settings) -> None:
    """Put the sample in the making to those that wait."""
    count = int(memory[_COUNT])
    if count == fixed.rows:  # nobody took them: what comes now has no connection to what was before
        memory[_BROKEN] = 1.0
        count = 0
    row = memory[_ROWS + SAMPLE_SIZE * count : _ROWS + SAMPLE_SIZE * (count + 1)]
    for i in range(9):
        row[i] = memory[_SUM + i] / fixed.ticks
        memory[_SUM + i] = 0.0
    row[CONTACT], row[STAMP] = memory[_ACCEPTED], memory[_STAMPED]
    row[MOTION_GOOD] = 1.0 if memory[_OK] == 0.0 else 0.0
    for i in range(3):
        row[MOTION_GOOD + 1 + i] = 1.0 if memory[_OK + 1 + i] == 0.0 else 0.0
    for i in range(4):
        memory[_OK + i] = 0.0
    memory[_TICKS] = 0.0
    memory[_COUNT] = count + 1.0


@njit(cache=True, error_model="numpy")
def _doubt(memory: Array, what: int, ticks: float, fixed: Settings) -> None:
    """Do not believe the motion (0) or the force along an axis (1, 2, 3) for the last ticks, as far as they wait."""
    memory[_OK + what] = 1.0
    back = math.ceil((ticks - memory[_TICKS]) / fixed.ticks)
    count = int(memory[_COUNT])
    for k in range(max(0, count - back), count):
        memory[_ROWS + SAMPLE_SIZE * k + MOTION_GOOD + what] = 0.0


@njit(cache=True, error_model="numpy")
def _frozen(sample: Array, memory: Array, fixed: Settings) -> int:
    """The status after doubting whatever stands still while the rest of the sample moves."""
    status, still = Status.LEARNING.value, memory[_STANDSTILL]
    for i in range(3):
        v = sample[3 + i]
        ticks, _ = stood(still, i, fixed.step)
        if abs(v) * ticks * fixed.step > _MOVED:
            _doubt(memory, 0, ticks, fixed)
            status = Status.FROZEN.value
        ticks, since = stood(still, 3 + i, fixed.step)
        if ticks > 0.0 and abs(sample[i] - since - v * ticks * fixed.step) > _ASTRAY:
            _doubt(memory, 0, ticks, fixed)
            status = Status.FROZEN.value
        if memory[_ACCEPTED] == 0.0:  # in free space a force may well stand still
            begin_here(still, 6 + i, sample[i])
        ticks, since = stood(still, 6 + i, fixed.step)
        moved = ticks > 0.0 and abs(sample[i] - since) > _MOVED
        F, largest, about = abs(sample[6 + i]), memory[_LARGEST + i], band(still, 6 + i, fixed.step)
        beyond = fixed.force_limit - about <= F
        if beyond or moved:
            _doubt(memory, 1 + i, ticks, fixed)
            at_its_largest = beyond or largest - about <= F
            status = Status.SATURATED.value if at_its_largest else max(status, Status.FROZEN.value)
        memory[_LARGEST + i] = max(largest, F)
    return status


@njit(cache=True, error_model="numpy")
def _jumped(sample: Array, memory: Array, fixed: Settings) -> bool:
    """Whether the probe cannot have come here; after some ticks it is believed all the same."""
    reach = _FASTEST * fixed.step * (memory[_SINCE_GOOD] + 1.0) + _ROUGHLY
    for i in range(3):
        if abs(sample[i] - memory[_GOOD + i]) > reach:
            memory[_JUMPS] += 1.0
            if memory[_JUMPS] <= _BELIEVED_AFTER:
                return True
    memory[_JUMPS] = 0.0
    return False


@njit(cache=True, error_model="numpy")
def _touching(flag: bool, memory: Array, fixed: Settings) -> bool:
    """Take the contact flag; whether it flickers. A change is believed once it has lasted, from its beginning on."""
    memory[_CHANGES] = max(0.0, memory[_CHANGES] - fixed.step / _FADES_S)
    value = 1.0 if flag else 0.0
    if value != memory[_FLAG]:
        memory[_CHANGES] = min(memory[_CHANGES] + 1.0, 2.0 * _FLICKERS_AT)
        memory[_NEW_FOR] = 0.0
    memory[_FLAG] = value
    memory[_NEW_FOR] += 1.0
    if memory[_CHANGES] >= _FLICKERS_AT:
        memory[_FLICKERS] = 1.0
    elif memory[_CHANGES] < _STEADY_AT:
        memory[_FLICKERS] = 0.0
    if memory[_FLICKERS] != 0.0:
        return True
    if value != memory[_ACCEPTED] and memory[_NEW_FOR] * fixed.step >= _DEBOUNCE_S - 1e-9:
        memory[_ACCEPTED] = value
        count = int(memory[_COUNT])
        back = round((memory[_NEW_FOR] - memory[_TICKS]) / fixed.ticks)
        for k in range(max(0, count - back), count):
            memory[_ROWS + SAMPLE_SIZE * k + CONTACT] = value
    return False


@njit(cache=True, error_model="numpy")
def tick(sample: Array, in_contact: float, t: float, stamp: float, readout: Array, fixed: Settings) -> None:
    """One sample; allocates nothing.

    Args:
        sample: position, velocity, force (9) in the table frame [m, m/s, N].
        in_contact: 1.0 in contact, else 0.0.
        t: time [s].
        stamp: when the motion of the sample was sent [s].
        readout: of `initial_readout`, changed.
        fixed: `settings`.
    """
    memory = readout[_MEMORY]
    state, p = memory[_STATE : _STATE + box.STATE_SIZE], memory[_P : _P + KERNEL_SIZE]
    finite = math.isfinite(in_contact)
    for i in range(9):
        finite = finite and math.isfinite(sample[i])
    status = Status.LEARNING.value if finite else Status.NOT_FINITE.value
    if memory[_STARTED] == 0.0:
        if finite:
            memory[_STARTED] = 1.0
            memory[_GOOD : _GOOD + 6] = sample[:6]
            box.begin(state, t, sample[:6], 0.0, p)
    else:
        ticks = (t - memory[_TIME]) / fixed.step
        missing = round(ticks) - 1
        if missing != 0:
            status = Status.JUMPED.value
            if 0 < missing <= _LONGEST_GAP_S / fixed.step:
                for _ in range(missing):
                    for what in range(4):
                        memory[_OK + what] = 1.0
                    memory[_TICKS] += 1.0
                    memory[_SINCE_GOOD] += 1.0
                    if memory[_TICKS] == fixed.ticks:
                        _finish(memory, fixed)
            else:
                memory[_BROKEN], memory[_COUNT], memory[_TICKS] = 1.0, 0.0, 0.0
                memory[_SUM : _SUM + 9] = 0.0
                memory[_OK : _OK + 4] = 0.0
                if finite:
                    memory[_GOOD : _GOOD + 6] = sample[:6]
                state[box.TIME] = t  # the object is where it was
    memory[_TIME] = t
    if memory[_STARTED] == 0.0:
        readout[STATUS.start] = status
        return

    believed = finite
    if finite:
        same = watch(sample, memory[_STANDSTILL], fixed.step)
        if _touching(in_contact > 0.5, memory, fixed):
            status = max(status, Status.FLICKERING.value)
            for i in range(3):
                memory[_OK + 1 + i] = 1.0
        moving = max(abs(sample[3]), abs(sample[4]), abs(sample[5])) > _MOVING
        if same and moving:
            believed, status = False, max(status, Status.DROPPED.value)
        elif _jumped(sample, memory, fixed):
            believed, status = False, max(status, Status.JUMPED.value)
        frozen = _frozen(sample, memory, fixed)
        status = max(status, frozen)
    if believed:
        memory[_GOOD : _GOOD + 6] = sample[:6]
        memory[_SINCE_GOOD] = 0.0
        for i in range(3):
            readout[FILTERED.start + i] = sample[6 + i]
        for i in range(9):
            memory[_SUM + i] += sample[i]
        # The model waits while there is nothing to drive it, and then catches up.
        touching = memory[_FLAG] if memory[_FLICKERS] == 0.0 else memory[_ACCEPTED]
        box.advance(state, t, sample[:6], touching, p)
    else:
        memory[_SINCE_GOOD] += 1.0
        for what in range(4):
            memory[_OK + what] = 1.0
    if memory[_TICKS] == 0.0:
        memory[_STAMPED] = stamp
    memory[_TICKS] += 1.0
    if memory[_TICKS] >= fixed.ticks:
        _finish(memory, fixed)
    box.force_on_probe(state, p, readout[ESTIMATED])

    if status >= Status.NOT_FINITE.value:
        memory[_TOLD], memory[_TOLD_FOR] = status, 0.0
    elif memory[_TOLD] != 0.0:
        memory[_TOLD_FOR] += 1.0
        if memory[_TOLD_FOR] * fixed.step >= _TOLD_S:
            memory[_TOLD] = 0.0
    if memory[_TOLD] != 0.0:
        readout[STATUS.start] = memory[_TOLD]
    else:
        readout[STATUS.start] = Status.LEARNING.value if memory[_ACCEPTED] != 0.0 else Status.FREE.value
