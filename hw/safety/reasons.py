"""Reasons for which a supervisor holds the force at zero."""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class Reason(IntEnum):
    """What the numbers `reason` and `present` of a supervisor's status mean."""

    NONE = 0
    NOT_ARMED = 1
    EMERGENCY_STOP = 2
    DEVICE_FAULT = 3
    MOTION_NOT_FINITE = 4
    COMMAND_NOT_FINITE = 5
    CLOCK = 6
    OVERRUN = 7
    SILENT_DEVICE = 8
    SPEED = 9
    JUMP = 10
    WORKSPACE = 11
    STUCK = 12
    #: The first of the watched ages is too old; the next one has the next number.
    STALE = 16


_TOLD = {
    Reason.NONE: "nothing is wrong",
    Reason.NOT_ARMED: "not armed yet",
    Reason.EMERGENCY_STOP: "emergency stop",
    Reason.DEVICE_FAULT: "the device reports a fault",
    Reason.MOTION_NOT_FINITE: "the device's motion is not a number",
    Reason.COMMAND_NOT_FINITE: "the commanded force is not a number",
    Reason.CLOCK: "the device's clock runs backwards, or is not a number",
    Reason.OVERRUN: "too long between two readings of the device",
    Reason.SILENT_DEVICE: "the device gives no new reading",
    Reason.SPEED: "the device moves too fast",
    Reason.JUMP: "the device's position jumped",
    Reason.WORKSPACE: "the device left its workspace",
    Reason.STUCK: "the device's position is stuck",
}


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
    return _TOLD[Reason(code)]


def is_stale(code: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Where the present reason is that nothing new has come in time, from the device or from what is watched."""
    return np.asarray((code == Reason.SILENT_DEVICE) | (code >= Reason.STALE))
