"""One tick of the estimator: is the sample to be believed, what joins the next sample of the fit, what force does the
model give; compiled.

What is not to be believed is left out, never mended: the sample of the fit that it would belong to says so, the model
moves on with what was good last, and `status` tells why. As soon as samples are good again they count again.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.estimation.output_error import layout as at
from mmt_drake.estimation.output_error.fit import LEAST_STEP
from mmt_drake.estimation.output_error.frozen_signal import STILL_S, initial_history, watch
from mmt_drake.estimation.output_error.knowledge import Knowledge, Told
from mmt_drake.estimation.output_error.layout import LearningSettings, Status
from mmt_drake.estimation.output_error.options import OutputErrorOptions
from mmt_drake.estimation.output_error.sample_validity import finish, frozen, jumped, touching
from mmt_drake.estimation.output_error.sensor_error import read_too_much
from mmt_drake.estimation.output_error.window import SAMPLE_SIZE
from mmt_drake.model import flexible_box as box
from mmt_drake.model.message_layout import MESSAGE_NUMBER
from mmt_drake.model.parameters import MAX_STEP, PLANAR
from mmt_drake.model.plane_call import planar
from mmt_drake.model.regrouping_equations import regroup
from mmt_drake.model.theta import adopt_theta
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.told_laws import TOLD_SIZE, VECTOR_SIZE, forget, put_laws, silence, step_with_laws, told_by_bytes

_MOVING = 1e-3  # [m/s]: a probe that moves
_LONGEST_GAP_S = 0.2
_SHOWN_S = 0.1  # a fault is shown for so long at least


def settings(options: OutputErrorOptions) -> LearningSettings:
    """Translate the options."""
    limit = math.inf if options.force_limit is None else options.force_limit
    rows = 2 * options.samples_per_fit + math.ceil((_LONGEST_GAP_S + STILL_S) / options.interval) + 4
    return LearningSettings(options.step, options.ticks, limit, rows, planar(options.in_plane))


def initial_readout(fixed: LearningSettings, known: Knowledge) -> Array:
    """Outputs and memory before the first sample; what is known is handed over at once."""
    readout = np.zeros(at.READOUT_SIZE + at.ROWS + SAMPLE_SIZE * fixed.rows)
    readout[at.MEMORY][at.HISTORY] = initial_history()
    memory = readout[at.MEMORY]
    memory[at.P + PLANAR] = fixed.planar
    hand_over(readout, known.told)
    readout[at.STATUS] = Status.FREE
    return readout


def hand_over(readout: Array, told: Told) -> None:
    """Put out what is known, and go on with it; a theta that cannot be integrated is passed over."""
    readout[at.MODEL_STATUS], readout[at.RESIDUAL] = told.status, told.left
    readout[at.LATE], theta, readout[at.THING] = told.lateness, told.theta, told.thing
    memory = readout[at.MEMORY]
    if readout[at.MODEL][MESSAGE_NUMBER] != told.model[MESSAGE_NUMBER]:
        readout[at.MODEL], memory[at.LAWS : at.LAWS + TOLD_SIZE] = told.model, told_by_bytes(told.model.tobytes())
    p = memory[at.P : at.P + VECTOR_SIZE]
    if not adopt_theta(theta, math.inf, 0.0, p[PLANAR], p):
        return
    put_laws(memory[at.LAWS : at.LAWS + TOLD_SIZE], p)
    if step_with_laws(p) < LEAST_STEP:
        silence(p)
    p[MAX_STEP] = step_with_laws(p)
    readout[at.THETA_PART], readout[at.DEVIATION], readout[at.STABLE] = theta, told.deviation, 1.0
    readout[at.REGROUPED], readout[at.HELD] = regroup(*theta[:6]), told.held


def drop_laws(readout: Array) -> None:
    """Go on without the laws: they are too fast to be followed."""
    memory = readout[at.MEMORY]
    forget(memory[at.LAWS : at.LAWS + TOLD_SIZE])
    silence(memory[at.P : at.P + VECTOR_SIZE])


def take_samples(readout: Array, fixed: LearningSettings) -> tuple[Array, bool]:
    """The samples of the fit that wait (k, SAMPLE_SIZE), and whether time broke off before them.

    The newest ones go on waiting: what stands still is only seen after a while, and then they are doubted.
    """
    memory = readout[at.MEMORY]
    count, broken = int(memory[at.COUNT]), memory[at.BROKEN] != 0.0
    ready = max(0, count - math.ceil(STILL_S / (fixed.ticks * fixed.step)) - 1)
    rows = memory[at.ROWS :].reshape(-1, SAMPLE_SIZE)
    samples = rows[:ready].copy()
    rows[: count - ready] = rows[ready:count].copy()
    memory[at.COUNT], memory[at.BROKEN] = float(count - ready), 0.0
    return samples, broken


@njit(cache=True, error_model="numpy")
def tick(
    sample: Array, reading: Array, in_contact: float, t: float, stamp: float, readout: Array, fixed: LearningSettings
) -> None:
    """One sample; allocates nothing.

    Args:
        sample: position, velocity, force (9) in the table frame [m, m/s, N].
        reading: what the force sensor itself says (3) [N], in which it is seen to saturate or freeze: the sample's
            force, unless that has been made of it and of other things.
        in_contact: 1.0 in contact, else 0.0.
        t: time [s].
        stamp: when the motion of the sample was sent [s].
        readout: of `initial_readout`, changed.
        fixed: `settings`.
    """
    memory = readout[at.MEMORY]
    state, p = memory[at.STATE : at.STATE + box.STATE_SIZE], memory[at.P : at.P + VECTOR_SIZE]
    finite = math.isfinite(in_contact)
    for i in range(9):
        finite = finite and math.isfinite(sample[i])
    for i in range(3):
        finite = finite and math.isfinite(reading[i])
    status = Status.LEARNING.value if finite else Status.NOT_FINITE.value
    if memory[at.STARTED] == 0.0:
        if finite:
            memory[at.STARTED] = 1.0
            assign(memory[at.GOOD : at.GOOD + 6], sample[:6])
            box.begin(state, t, sample[:6], 0.0, p)
    else:
        ticks = (t - memory[at.TIME]) / fixed.step
        missing = round(ticks) - 1
        if missing != 0:
            status = Status.JUMPED.value
            if 0 < missing <= _LONGEST_GAP_S / fixed.step:
                for _ in range(missing):
                    for what in range(4):
                        memory[at.OK + what] = 1.0
                    memory[at.TICKS] += 1.0
                    memory[at.SINCE_GOOD] += 1.0
                    if memory[at.TICKS] == fixed.ticks:
                        finish(memory, fixed)
            else:
                memory[at.BROKEN], memory[at.COUNT], memory[at.TICKS] = 1.0, 0.0, 0.0
                memory[at.SUM : at.SUM + 9] = 0.0
                memory[at.OK : at.OK + 4] = 0.0
                if finite:
                    assign(memory[at.GOOD : at.GOOD + 6], sample[:6])
                state[box.TIME] = t  # the object is where it was
    memory[at.TIME] = t
    if memory[at.STARTED] == 0.0:
        readout[at.STATUS.start] = status
        return

    believed = finite
    if finite:
        seen = memory[at.SEEN : at.SEEN + 9]
        assign(seen[:6], sample[:6])
        assign(seen[6:], reading)
        same = watch(seen, memory[at.HISTORY], fixed.step)
        if touching(in_contact > 0.5, memory, fixed):
            status = max(status, Status.FLICKERING.value)
            for i in range(3):
                memory[at.OK + 1 + i] = 1.0
        moving = max(abs(sample[3]), abs(sample[4]), abs(sample[5])) > _MOVING
        if same and moving:
            believed, status = False, max(status, Status.DROPPED.value)
        elif jumped(sample, memory, fixed):
            believed, status = False, max(status, Status.JUMPED.value)
        status = max(status, frozen(seen, memory, fixed))
    if believed:
        assign(memory[at.GOOD : at.GOOD + 6], sample[:6])
        memory[at.SINCE_GOOD] = 0.0
        too_much = read_too_much(readout[at.OF_SENSOR], t, sample[8])
        for i in range(3):
            readout[at.FILTERED.start + i] = sample[6 + i] - (too_much if i < 2 else 0.0)
        for i in range(9):
            memory[at.SUM + i] += sample[i]
        # The model waits while there is nothing to drive it, and then catches up.
        contact = memory[at.FLAG] if memory[at.FLICKERS] == 0.0 else memory[at.ACCEPTED]
        box.advance(state, t, sample[:6], contact, p)
    else:
        memory[at.SINCE_GOOD] += 1.0
        for what in range(4):
            memory[at.OK + what] = 1.0
    if memory[at.TICKS] == 0.0:
        memory[at.STAMPED] = stamp
    memory[at.TICKS] += 1.0
    if memory[at.TICKS] >= fixed.ticks:
        finish(memory, fixed)
    box.force_on_probe(state, p, readout[at.ESTIMATED])

    if status >= Status.NOT_FINITE.value:
        memory[at.FAULT], memory[at.FAULT_FOR] = status, 0.0
    elif memory[at.FAULT] != 0.0:
        memory[at.FAULT_FOR] += 1.0
        if memory[at.FAULT_FOR] * fixed.step >= _SHOWN_S:
            memory[at.FAULT] = 0.0
    if memory[at.FAULT] != 0.0:
        readout[at.STATUS.start] = memory[at.FAULT]
    else:
        readout[at.STATUS.start] = Status.LEARNING.value if memory[at.ACCEPTED] != 0.0 else Status.FREE.value
