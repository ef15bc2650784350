"""What a robot really sends: a measured contact with something wrong in it, and what an estimator should call it."""

from collections.abc import Callable

import numpy as np

from mmt_drake.estimation.output_error.layout import Status

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


def clipped_behind_noise(data: Array, flag: Array, time: Array) -> None:
    """The converter behind the sensor's limit has noise of its own."""
    saturated(data, flag, time)
    data[:, 6:] += np.random.default_rng(8).normal(0.0, 1e-4, (len(data), 3))


def frozen_behind_noise(data: Array, flag: Array, time: Array) -> None:
    frozen_force(data, flag, time)
    data[BAD, 6:] += np.random.default_rng(8).normal(0.0, 1e-6, (BAD.stop - BAD.start, 3))


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
    "clipped_behind_noise": (clipped_behind_noise, Status.SATURATED),
    "frozen_behind_noise": (frozen_behind_noise, Status.FROZEN),
    "dropped": (dropped, Status.DROPPED),
    "flickering": (flickering, Status.FLICKERING),
    "late_clock": (late_clock, Status.JUMPED),
    "far_clock": (far_clock, Status.JUMPED),
    "early_clock": (early_clock, Status.JUMPED),
    "jumping_position": (jumping_position, Status.JUMPED),
}
#: Faults that are there until the end.
LASTING = ("saturated", "clipped_behind_noise", "dropped")
#: Faults that make all of the input worthless for a while.
TOTAL = ("not_finite", "no_flag", "frozen_position", "frozen_sensors", "flickering")
