"""Doubts: samples that are not to be believed, and the sample of the fit in the making that learns of it; compiled."""

import math

from numba import njit

from mmt_drake.estimation.output_error import layout as at
from mmt_drake.estimation.output_error.frozen_signal import band, begin_here, stood
from mmt_drake.estimation.output_error.layout import LearningSettings, Status
from mmt_drake.estimation.output_error.window import CONTACT, MOTION_GOOD, SAMPLE_SIZE, STAMP, TAKEN
from mmt_drake.numeric.arrays import Array

_MOVED = 5e-5  # [m] that the probe must have moved meanwhile
_ASTRAY = 3e-4  # [m] that position and velocity may contradict each other
_FASTEST, _ROUGHLY = 3.0, 1e-3  # [m/s], [m]: what a position may jump by
_BELIEVED_AFTER = 5  # ticks: then a position that jumped is where the probe is now
_DEBOUNCE_S = 0.01
_FLICKERS_AT, _STEADY_AT, _FADES_S = 3.0, 0.5, 0.05  # changes of the flag, which are forgotten one by one


@njit(cache=True, error_model="numpy")
def finish(memory: Array, fixed: LearningSettings) -> None:
    """Put the sample in the making to those that wait."""
    count = int(memory[at.COUNT])
    if count == fixed.rows:  # nobody took them: what comes now has no connection to what was before
        memory[at.BROKEN] = 1.0
        count = 0
    row = memory[at.ROWS + SAMPLE_SIZE * count : at.ROWS + SAMPLE_SIZE * (count + 1)]
    for i in range(9):
        row[i] = memory[at.SUM + i] / fixed.ticks
        memory[at.SUM + i] = 0.0
    row[CONTACT], row[STAMP] = memory[at.ACCEPTED], memory[at.STAMPED]
    row[TAKEN] = memory[at.TIME] - 0.5 * (fixed.ticks - 1) * fixed.step
    row[MOTION_GOOD] = 1.0 if memory[at.OK] == 0.0 else 0.0
    for i in range(3):
        row[MOTION_GOOD + 1 + i] = 1.0 if memory[at.OK + 1 + i] == 0.0 else 0.0
    for i in range(4):
        memory[at.OK + i] = 0.0
    memory[at.TICKS] = 0.0
    memory[at.COUNT] = count + 1.0


@njit(cache=True, error_model="numpy")
def doubt(memory: Array, what: int, ticks: float, fixed: LearningSettings) -> None:
    """Do not believe the motion (0) or the force along an axis (1, 2, 3) for the last ticks, as far as they wait."""
    memory[at.OK + what] = 1.0
    back = math.ceil((ticks - memory[at.TICKS]) / fixed.ticks)
    count = int(memory[at.COUNT])
    for k in range(max(0, count - back), count):
        memory[at.ROWS + SAMPLE_SIZE * k + MOTION_GOOD + what] = 0.0


@njit(cache=True, error_model="numpy")
def frozen(sample: Array, memory: Array, fixed: LearningSettings) -> int:
    """The status after doubting whatever stands still while the rest of the sample moves."""
    status, still = Status.LEARNING.value, memory[at.HISTORY]
    for i in range(3):
        v = sample[3 + i]
        ticks, _ = stood(still, i, fixed.step)
        if abs(v) * ticks * fixed.step > _MOVED:
            doubt(memory, 0, ticks, fixed)
            status = Status.FROZEN.value
        ticks, since = stood(still, 3 + i, fixed.step)
        if ticks > 0.0 and abs(sample[i] - since - v * ticks * fixed.step) > _ASTRAY:
            doubt(memory, 0, ticks, fixed)
            status = Status.FROZEN.value
        if memory[at.ACCEPTED] == 0.0:  # in free space a force may well stand still
            begin_here(still, 6 + i, sample[i])
        ticks, since = stood(still, 6 + i, fixed.step)
        moved = ticks > 0.0 and abs(sample[i] - since) > _MOVED
        F, largest, about = abs(sample[6 + i]), memory[at.LARGEST + i], band(still, 6 + i, fixed.step)
        beyond = fixed.force_limit - about <= F
        if beyond or moved:
            doubt(memory, 1 + i, ticks, fixed)
            at_its_largest = beyond or largest - about <= F
            status = Status.SATURATED.value if at_its_largest else max(status, Status.FROZEN.value)
        memory[at.LARGEST + i] = max(largest, F)
    return status


@njit(cache=True, error_model="numpy")
def jumped(sample: Array, memory: Array, fixed: LearningSettings) -> bool:
    """Whether the probe cannot have come here; after some ticks it is believed all the same."""
    reach = _FASTEST * fixed.step * (memory[at.SINCE_GOOD] + 1.0) + _ROUGHLY
    for i in range(3):
        if abs(sample[i] - memory[at.GOOD + i]) > reach:
            memory[at.JUMPS] += 1.0
            if memory[at.JUMPS] <= _BELIEVED_AFTER:
                return True
    memory[at.JUMPS] = 0.0
    return False


@njit(cache=True, error_model="numpy")
def touching(flag: bool, memory: Array, fixed: LearningSettings) -> bool:
    """Take the contact flag; whether it flickers. A change is believed once it has lasted, from its beginning on."""
    memory[at.CHANGES] = max(0.0, memory[at.CHANGES] - fixed.step / _FADES_S)
    value = 1.0 if flag else 0.0
    if value != memory[at.FLAG]:
        memory[at.CHANGES] = min(memory[at.CHANGES] + 1.0, 2.0 * _FLICKERS_AT)
        memory[at.NEW_FOR] = 0.0
    memory[at.FLAG] = value
    memory[at.NEW_FOR] += 1.0
    if memory[at.CHANGES] >= _FLICKERS_AT:
        memory[at.FLICKERS] = 1.0
    elif memory[at.CHANGES] < _STEADY_AT:
        memory[at.FLICKERS] = 0.0
    if memory[at.FLICKERS] != 0.0:
        return True
    if value != memory[at.ACCEPTED] and memory[at.NEW_FOR] * fixed.step >= _DEBOUNCE_S - 1e-9:
        memory[at.ACCEPTED] = value
        count = int(memory[at.COUNT])
        back = round((memory[at.NEW_FOR] - memory[at.TICKS]) / fixed.ticks)
        for k in range(max(0, count - back), count):
            memory[at.ROWS + SAMPLE_SIZE * k + CONTACT] = value
    return False
