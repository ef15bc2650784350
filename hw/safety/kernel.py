"""The supervisor's decision, once a tick: compiled, without allocation, and short enough to be read in one sitting.

The memory of one tick is all that the next one knows; its head is what the ports show.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.hw.safety.reasons import Reason
from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout

# ------------------------------------------------------------------------------------------------ layout of the memory
_next = Layout()
_FORCE = _next.part(3)  # given out [N]
_ARMED = _next()  # 1: the command passes; the first of the six numbers of the status
_REASON = _next()  # what disarmed it
_PRESENT = _next()  # what is wrong now
_LIMITED = _next()  # 1: force, 2: power, 3: both are being limited
_GAIN = _next()  # on the command, 0 to 1
_TRIPS = _next()  # how often a fault disarmed it
_REMAINING = _next()  # of the ramp to zero [s]
_RELEASED = _next()  # 1: the arm switch has been seen open since the last fault
_BEGUN = _next()  # 1: what follows is known
_TIME = _next()  # [s]
_STAMP = _next()  # of the device's latest reading, by its own clock [s]
_SILENCE = _next()  # since the stamp changed [s]
_STILL = _next()  # since the position changed, while it should [s]
_POSITION = _next.part(3)  # the latest finite one [m]
MEMORY_SIZE = _next.size

PORT_SIZES = {"force": 3, "status": 6}  # from the memory's start

_FORCE_LIMIT, _POWER_LIMIT, _SPEED_LIMIT, _LOW, _HIGH, _GAP, _STUCK, _RAMP, _RISE = map(
    Layout(), (1, 1, 1, 3, 3, 1, 1, 1, 1)
)

_ARM, _STOP = 0, 1  # of the switches
_FAULT, _READ_AT, _HELD = 0, 1, 2  # of the device

_JUMP = 10.0  # a position that changes faster than this many times the speed limit has not moved: it is wrong
# A device at rest may well report the same bits for ever; one that is pushed or moves cannot.
_PUSHED = 0.5  # [N]
_MOVES = 0.01  # [m/s]

# numba knows plain numbers alone.
_EMERGENCY_STOP, _DEVICE_FAULT = int(Reason.EMERGENCY_STOP), int(Reason.DEVICE_FAULT)
_MOTION_NOT_FINITE, _COMMAND_NOT_FINITE = int(Reason.MOTION_NOT_FINITE), int(Reason.COMMAND_NOT_FINITE)
_CLOCK, _OVERRUN, _SILENT_DEVICE, _STALE = map(int, (Reason.CLOCK, Reason.OVERRUN, Reason.SILENT_DEVICE, Reason.STALE))
_TOO_FAST, _JUMPED, _WORKSPACE, _STUCK_VALUE = map(int, (Reason.SPEED, Reason.JUMP, Reason.WORKSPACE, Reason.STUCK))


def initial_memory() -> Array:
    """(`MEMORY_SIZE`) before the first tick: no force, not armed, nothing known."""
    memory = np.zeros(MEMORY_SIZE)
    memory[_REASON] = memory[_PRESENT] = Reason.NOT_ARMED
    return memory


@njit(cache=True)
def supervise(
    memory: Array,
    t: float,
    command: Array,
    motion: Array,
    device: Array,
    ages: Array,
    switches: Array,
    limits: Array,
    oldest: Array,
    out: Array,
) -> None:
    """One tick.

    Args:
        memory: (`MEMORY_SIZE`) after the tick before.
        t: time of the diagram [s].
        command: (3) force asked for [N].
        motion: (6) of the device, position [m] and velocity [m/s].
        device: (3) its fault code, 0 if it is well; when it was read by its own clock [s]; 1 while a clutch holds its
            position, which may then rest under a force.
        ages: (n) of the watched inputs [s].
        switches: (2) arm and emergency stop.
        limits: (13) as `SafetyLimits.kernel_vector` gives them.
        oldest: (n) what the ages may be [s].
        out: (`MEMORY_SIZE`) the memory after this tick.
    """
    assign(out, memory)
    # How long this tick has taken, by the diagram's clock and by the device's: the later one counts for every ramp.
    by_diagram = t - memory[_TIME] if memory[_BEGUN] else 0.0
    by_device = device[_READ_AT] - memory[_STAMP] if memory[_BEGUN] else 0.0
    elapsed = by_diagram
    if math.isfinite(by_device) and by_device > elapsed:
        elapsed = by_device
    out[_SILENCE] = 0.0 if by_device != 0.0 else memory[_SILENCE] + by_diagram
    out[_STILL] = memory[_STILL] + elapsed if device[_HELD] == 0.0 and _should_have_moved(memory, motion) else 0.0

    fault = _fault(out, by_device, elapsed, command, motion, device, ages, switches, limits, oldest)
    out[_PRESENT] = fault
    if switches[_ARM] == 0.0:
        out[_RELEASED] = 1.0
    if out[_ARMED] and fault:
        out[_ARMED], out[_REASON], out[_RELEASED] = 0.0, fault, 0.0
        out[_GAIN], out[_LIMITED], out[_REMAINING] = 0.0, 0.0, limits[_RAMP]
        out[_TRIPS] += 1.0
    elif not out[_ARMED] and not fault and out[_REMAINING] == 0.0 and out[_RELEASED] and switches[_ARM] == 1.0:
        # A person presses the switch after the fault: nothing else re-arms, and a switch that hangs never does.
        out[_ARMED], out[_REASON], out[_RELEASED] = 1.0, 0.0, 0.0

    if out[_ARMED]:
        out[_GAIN] = min(1.0, out[_GAIN] + elapsed / limits[_RISE])
        scale, limited = _limits(command, motion, limits)
        out[_LIMITED] = limited
        for axis in range(3):
            out[axis] = out[_GAIN] * scale * command[axis]
    else:
        _ramp_down(out, elapsed, motion, limits)

    out[_BEGUN], out[_TIME] = 1.0, t
    if math.isfinite(device[_READ_AT]):
        out[_STAMP] = device[_READ_AT]
    if _finite(motion):
        assign(out[_POSITION], motion[:3])


@njit(cache=True)
def _fault(
    now: Array,
    by_device: float,
    elapsed: float,
    command: Array,
    motion: Array,
    device: Array,
    ages: Array,
    switches: Array,
    limits: Array,
    oldest: Array,
) -> int:
    """What is wrong at this tick; 0: nothing. Comparisons are written so that NaN is a fault.

    What is wrong with the hand comes before what is wrong with the force: an arm that follows it must know (`HandAge`).
    """
    if switches[_STOP] != 0.0:
        return _EMERGENCY_STOP
    if device[_FAULT] != 0.0:
        return _DEVICE_FAULT
    if not _finite(motion):
        return _MOTION_NOT_FINITE
    if not (math.isfinite(device[_READ_AT]) and by_device >= 0.0):
        return _CLOCK
    if not elapsed <= limits[_GAP]:
        return _OVERRUN
    if not now[_SILENCE] <= limits[_GAP]:
        return _SILENT_DEVICE
    if not math.sqrt(_dot(motion[3:], motion[3:])) <= limits[_SPEED_LIMIT]:
        return _TOO_FAST
    if now[_BEGUN]:
        square = 0.0
        for axis in range(3):
            square += (motion[axis] - now[_POSITION][axis]) ** 2
        if elapsed > 0.0 and not math.sqrt(square) <= _JUMP * limits[_SPEED_LIMIT] * elapsed:
            return _JUMPED
    for axis in range(3):
        if not limits[_LOW + axis] <= motion[axis] <= limits[_HIGH + axis]:
            return _WORKSPACE
    if not now[_STILL] <= limits[_STUCK]:
        return _STUCK_VALUE
    if not _finite(command):
        return _COMMAND_NOT_FINITE
    for i in range(ages.size):
        if not abs(ages[i]) <= oldest[i]:
            return _STALE + i
    return 0


@njit(cache=True)
def _limits(force: Array, motion: Array, limits: Array) -> tuple[float, float]:
    """By how much to scale a force, and which limits ask for it: 1 force, 2 power, 3 both."""
    scale, limited = 1.0, 0.0
    size = math.sqrt(_dot(force, force))
    if size > limits[_FORCE_LIMIT]:
        scale, limited = limits[_FORCE_LIMIT] / size, 1.0
    power = scale * _dot(force, motion[3:])
    if power > limits[_POWER_LIMIT]:
        scale, limited = scale * limits[_POWER_LIMIT] / power, limited + 2.0
    return scale, limited


@njit(cache=True)
def _ramp_down(out: Array, elapsed: float, motion: Array, limits: Array) -> None:
    """Shrinks the force given out last, linearly to zero, whatever the command has become."""
    left = max(0.0, out[_REMAINING] - elapsed)
    shrink = left / out[_REMAINING] if left > 0.0 else 0.0
    if shrink > 0.0 and _finite(motion):
        shrink = min(shrink, _limits(out[_FORCE], motion, limits)[0])
    for axis in range(3):
        out[axis] = shrink * out[axis] if shrink > 0.0 else 0.0
    out[_REMAINING] = left


@njit(cache=True)
def _should_have_moved(memory: Array, motion: Array) -> bool:
    """A position that is the same to the bit although the device is pushed, or says that it moves."""
    if not memory[_BEGUN]:
        return False
    for axis in range(3):
        if motion[axis] != memory[_POSITION][axis]:
            return False
    pushed, speed = _dot(memory[_FORCE], memory[_FORCE]), _dot(motion[3:], motion[3:])
    return pushed > _PUSHED * _PUSHED or speed > _MOVES * _MOVES


@njit(cache=True)
def _dot(a: Array, b: Array) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _finite(values: Array) -> bool:
    for i in range(values.size):  # noqa: SIM110 - numba has no `all` of a generator
        if not math.isfinite(values[i]):
            return False
    return True
