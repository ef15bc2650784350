"""The output-error estimator fed with what a robot really sends: it holds what it knows, says why, and recovers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hand_and_box import STEP, contact, free_running_error

from mmt_drake.estimation.output_error.gate import Status
from mmt_drake.estimation.output_error.offline import OutputErrorTrace, estimate_output_error
from mmt_drake.estimation.output_error.options import OutputErrorOptions

Array = np.ndarray
Fault = Callable[[Array, Array, Array], None]

SECONDS = 5.0
BAD = slice(2000, 2400)  # ticks; the hand strokes fast there
PERIOD = 50


def not_finite(data: Array, flag: Array, time: Array) -> None:
    data[BAD] = np.nan
    data[BAD.start, 0] = np.inf


def no_flag(data: Array, flag: Array, time: Array) -> None:
    flag[BAD] = np.nan


def frozen_position(data: Array, flag: Array, time: Array) -> None:
    data[BAD, :3] = data[BAD.start, :3]


def frozen_velocity(data: Array, flag: Array, time: Array) -> None:
    data[BAD, 3:6] = data[BAD.start, 3:6]


def frozen_force(data: Array, flag: Array, time: Array) -> None:
    data[BAD, 6:] = data[BAD.start, 6:]


def frozen_sensors(data: Array, flag: Array, time: Array) -> None:
    data[BAD] = data[BAD.start]


def saturated(data: Array, flag: Array, time: Array) -> None:
    limit = 0.6 * np.abs(data[:, 7]).max()
    data[:, 6:8] = data[:, 6:8].clip(-limit, limit)


def dropped(data: Array, flag: Array, time: Array) -> None:
    lost = np.flatnonzero(np.random.default_rng(4).random(len(data)) < 0.1)
    for k in lost[lost > 0]:
        data[k] = data[k - 1]


def flickering(data: Array, flag: Array, time: Array) -> None:
    flag[BAD] = np.arange(BAD.stop - BAD.start) // 5 % 2


def late_clock(data: Array, flag: Array, time: Array) -> None:
    """0.1 s are missing."""
    time[BAD.start :] += 0.1
    data[BAD.start : -100] = data[BAD.start + 100 :]


def far_clock(data: Array, flag: Array, time: Array) -> None:
    """The clock is set forward by an hour."""
    time[BAD.start :] += 3600.0


def early_clock(data: Array, flag: Array, time: Array) -> None:
    """The clock is set back."""
    time[BAD.start :] -= 1.5


def jumping_position(data: Array, flag: Array, time: Array) -> None:
    """The position sensor's clock stalls and then catches up: the position stands, and jumps."""
    data[BAD.start, :3] += (0.0, 0.05, 0.0)
    data[BAD.start + 200 : BAD.start + 203, 1] -= 0.04


FAULTS: dict[str, tuple[Fault, Status]] = {
    "not_finite": (not_finite, Status.NOT_FINITE),
    "no_flag": (no_flag, Status.NOT_FINITE),
    "frozen_position": (frozen_position, Status.FROZEN),
    "frozen_velocity": (frozen_velocity, Status.FROZEN),
    "frozen_force": (frozen_force, Status.FROZEN),
    "frozen_sensors": (frozen_sensors, Status.DROPPED),
    "saturated": (saturated, Status.SATURATED),
    "dropped": (dropped, Status.DROPPED),
    "flickering": (flickering, Status.FLICKERING),
    "late_clock": (late_clock, Status.JUMPED),
    "far_clock": (far_clock, Status.JUMPED),
    "early_clock": (early_clock, Status.JUMPED),
    "jumping_position": (jumping_position, Status.JUMPED),
}
#: Faults that make all of the input worthless for a while.
TOTAL = ("not_finite", "no_flag", "frozen_position", "frozen_sensors", "flickering")


def fed(fault: Fault) -> OutputErrorTrace:
    seen = contact(SECONDS)
    data, flag, time = seen.measurement.copy(), seen.in_contact.copy(), seen.time.copy()
    fault(data, flag, time)
    return estimate_output_error(data, flag, OutputErrorOptions(step=STEP), time=time)


@pytest.mark.parametrize("name", FAULTS)
def test_it_says_what_is_wrong_holds_what_it_knows_and_recovers(name: str) -> None:
    fault, status = FAULTS[name]
    trace = fed(fault)
    assert np.isfinite(trace.theta).all()
    assert np.isfinite(trace.deviation).all()
    assert np.isfinite(trace.estimated_force).all()
    assert trace.stable.all()
    during = trace.status[BAD]
    assert ((trace.status if name == "saturated" else during) == status).any()  # strokes reach the limit elsewhere
    assert set(np.unique(trace.status)) <= {Status.LEARNING, Status.FREE, status, Status.DROPPED, Status.JUMPED}
    if name in TOTAL:
        # What came before the fault is handed over within two periods; from then on there is nothing new.
        held = trace.theta[BAD.start + 2 * PERIOD + 30 : BAD.stop]
        assert (held == held[0]).all()
        assert (during[30:] == status).all()
    if name not in ("saturated", "dropped"):  # those last until the end
        assert set(np.unique(trace.status[-1000:])) <= {Status.LEARNING, Status.FREE}
        assert (trace.theta[-500:] != trace.theta[BAD.stop]).any()
    assert free_running_error(trace.theta[-1], contact(SECONDS)) < 0.02


def test_a_sensor_limit_that_is_told_is_seen_at_once() -> None:
    seen = contact(SECONDS)
    data = seen.measurement.copy()
    limit = 0.5 * float(np.abs(data[:, 7]).max())
    data[:, 7] = data[:, 7].clip(-limit, limit)
    trace = estimate_output_error(data, seen.in_contact, OutputErrorOptions(force_limit=limit))
    beyond = np.abs(data[:, 7]) == limit
    assert (trace.status[beyond] == Status.SATURATED).all()
    assert free_running_error(trace.theta[-1], seen) < 0.02


def test_nothing_but_nan_leaves_the_prior() -> None:
    trace = estimate_output_error(np.full((500, 9), np.nan), np.ones(500))
    assert (trace.theta == trace.theta[0]).all()
    assert (trace.status[1:] == Status.NOT_FINITE).all()


def test_a_hand_at_rest_on_a_sensor_without_noise_is_no_fault() -> None:
    data = np.zeros((1000, 9))
    data[:, 2], data[:, 8] = -0.005, 2.5
    trace = estimate_output_error(data, np.ones(1000))
    assert (trace.status[10:] == Status.LEARNING).all()
