"""Reasons for which a supervisor holds the force at zero."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mmt_drake.hw.errors import FaultCode


class Reason(FaultCode):
    """What the numbers `reason` and `present` of a supervisor's status mean."""

    NONE = 0, "nothing is wrong"
    NOT_ARMED = 1, "not armed yet"
    EMERGENCY_STOP = 2, "emergency stop"
    DEVICE_FAULT = 3, "the device reports a fault"
    MOTION_NOT_FINITE = 4, "the device's motion is not a number"
    COMMAND_NOT_FINITE = 5, "the commanded force is not a number"
    CLOCK = 6, "the device's clock runs backwards, or is not a number"
    OVERRUN = 7, "too long between two readings of the device"
    SILENT_DEVICE = 8, "the device gives no new reading"
    SPEED = 9, "the device moves too fast"
    JUMP = 10, "the device's position jumped"
    WORKSPACE = 11, "the device left its workspace"
    STUCK = 12, "the device's position is stuck"
    #: The first of the watched ages is too old; the next one has the next number.
    STALE = 16


def describe(status: NDArray[np.float64], watched: Sequence[str] = ()) -> str:
    """A supervisor's status for a person, in one line.

    Args:
        status: (6) as on the port `status` of `SafetySupervisor`.
        watched: names of the watched ages.
    """
    armed, reason, present = (int(number) for number in status[:3])
    if armed:
        limited = [name for bit, name in ((1, "force"), (2, "power")) if int(status[3]) & bit]
        return f"armed, {' and '.join(limited)} limited" if limited else "armed"
    if present not in (Reason.NONE, reason):
        return f"stopped: {reason_words(reason, watched)}; now {reason_words(present, watched)}"
    return f"stopped: {reason_words(reason, watched)}{'' if present else '; ready to arm'}"


def reason_words(code: int, watched: Sequence[str] = ()) -> str:
    """A `Reason`, or the watched age that is behind it, in words."""
    if code >= Reason.STALE:
        index = code - Reason.STALE
        return f"{watched[index] if index < len(watched) else f'input {index}'} is stale or lost"
    return Reason(code).words


def is_stale(code: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where the present reason is that nothing new has come in time, from the device or from what is watched."""
    return np.asarray((code == Reason.SILENT_DEVICE) | (code >= Reason.STALE))
