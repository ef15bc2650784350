"""From the device's frame to the table's and back, with the clutch between: compiled, once a tick.

    position = origin + scale R (p - centre) + offset        velocity = scale R v        force on the hand = R' F

While the clutch is held the probe rests on the table, the hand moves freely, and `offset` takes up what it moves.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.hw.omega.faults import HandFault
from mmt_drake.hw.omega.settings import OmegaSettings
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

# Beside the motion the driver's state has two parts, the first of which its ports show.
_FAULT, _READ_AT, _HELD, DEVICE_SIZE = map(Layout(), (1, 1, 1, 0))  # a code, [s], 1 while the clutch holds the position
# An offset [m], a share of the force that is 0 while the clutch is held, and whether that has begun.
_OFFSET, _BLEND, _BEGUN, CLUTCH_SIZE = map(Layout(), (3, 1, 1, 0))

# The frame as a vector.
_SCALE, _FORCE_SCALE, _MOST_FORCE, _CENTRE, _ORIGIN, _ROTATION = map(Layout(), (1, 1, 1, 3, 3, 9))

_BLEND_TIME = 0.05  # [s] in which the force comes back after the clutch
_BAD_READING, _BAD_FORCE = int(HandFault.BAD_READING), int(HandFault.BAD_FORCE)


def frame_vector(settings: OmegaSettings) -> Array:
    """(18) the frame as the kernels read it."""
    head = (settings.scale, settings.force_scale, settings.force, *settings.centre, *settings.origin)
    return np.concatenate([np.array(head), settings.rotation_matrix().ravel()])


@njit(cache=True)
def take_reading(
    motion: Array, device: Array, clutch: Array, reading: Array, fault: int, clutched: bool, now: float, frame: Array
) -> None:
    """Bring the driver's state up to a reading.

    A reading that failed, or is not a number, leaves the position where it was, at rest, and a fault code.

    Args:
        motion, device, clutch: the three parts of the state, changed.
        reading: (6) device frame [m, m/s].
        fault: code of the reading.
        clutched: whether the clutch is held.
        now: time of the reading [s].
        frame: (18) of `frame_vector`.
    """
    for i in range(6):
        if fault == 0 and not math.isfinite(reading[i]):
            fault = _BAD_READING
    elapsed = max(0.0, now - device[_READ_AT]) if clutch[_BEGUN] else 0.0
    device[_FAULT], device[_READ_AT], device[_HELD] = fault, now, clutched
    clutch[_BLEND] = 0.0 if clutched else min(1.0, clutch[_BLEND] + elapsed / _BLEND_TIME)
    if fault != 0:
        motion[3:6] = 0.0
        return
    for row in range(3):
        position, rate = frame[_ORIGIN + row], 0.0
        for column in range(3):
            turned = frame[_SCALE] * frame[_ROTATION + 3 * row + column]
            position += turned * (reading[column] - frame[_CENTRE + column])
            rate += turned * reading[3 + column]
        if clutched and clutch[_BEGUN]:
            clutch[_OFFSET + row] = motion[row] - position
            motion[3 + row] = 0.0
        else:
            motion[row] = position + clutch[_OFFSET + row]
            motion[3 + row] = rate
    clutch[_BEGUN] = 1.0


@njit(cache=True)
def force_on_hand(device: Array, clutch: Array, force: Array, frame: Array, out: Array) -> int:
    """The force that the device is commanded.

    Zero while the driver has a fault, while the clutch is held and for a force that is not a number; never greater than
    the settings say.

    Args:
        device, clutch: parts of the driver's state.
        force: (3) table frame [N].
        frame: (18) of `frame_vector`.
        out: (3) device frame [N].

    Returns:
        A fault code for the force handed in.
    """
    out[:] = 0.0
    size = math.sqrt(force[0] * force[0] + force[1] * force[1] + force[2] * force[2]) * frame[_FORCE_SCALE]
    if not math.isfinite(size):
        return _BAD_FORCE
    if device[_FAULT] != 0.0:
        return 0
    scale = frame[_FORCE_SCALE] * clutch[_BLEND]
    if size > frame[_MOST_FORCE]:
        scale *= frame[_MOST_FORCE] / size
    for row in range(3):
        for column in range(3):
            out[row] += scale * frame[_ROTATION + 3 * column + row] * force[column]
    return 0
