"""From what a force sensor at an arm's wrist reads to the force on the tip of the probe beyond it; compiled.

The sensor carries the probe. With its reading r in the sign of a force on the probe, its offset o, the probe's mass m
and acceleration a, and gravity g::

    r = F + m (g - a) + o        hence        F = r - o - m g + m a

The acceleration is the slope of the measured velocity over samples on both sides, so that it belongs to the sample in
their middle; that is why everything is handed over `ProbeOptions.reach` samples late. The offset, and with it
whatever the weight was taken wrong by, is the mean of what is left in free space, anew at each lift.

A zero that is taken while the probe is pressed stays wrong until the next one, and no contact *reported* is not free
space: a proxy can come through a coarse cloud, a camera can stop. So three things have to agree, `ProbeOptions.clear`
long before and throughout each window that counts: no contact is reported; the probe is above the surface by `margin`,
and the surface is seen; and what is left of the force is steady, and no further from the last zero than `departure`.
Where they do not the offset is held, and `Zero` says why. The first zero has nothing that it could be far from. A force
that has departed in free space, by a tool that was changed or a sensor that was overloaded, is for a person to look at.

The reading itself is handed on beside the force: a sensor that saturates or freezes is seen in that alone, since probe
and acceleration move what has been made of it.

A sample that is not finite is handed on as it is, for whoever comes next to see, and leaves no trace otherwise: neither
the slopes of the samples around it nor the offset take it up.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, ClassVar

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array, assign
from mmt_drake.numeric.layout import Layout
from mmt_drake.quantities import Checked, Quantity

_ROW = 10  # of a sample: position, velocity, reading, contact
_LATEST = 50.0  # windows that the offset is the mean of, at most: a drift in a long lift is followed

#: What a tick puts out, one after the other.
PORT_SIZES = {"measurement": 9, "in_contact": 1, "offset": 3, "reading": 3, "zero": 1}
_next = Layout()
_, _CONTACT, _OFFSET, _READING, _ZERO = _next(9), _next(), _next.part(3), _next.part(3), _next()
# The memory behind it: samples taken, samples since the probe was last not known to be free, whether there has been a
# zero, windows that the offset is the mean of; of this window the samples, and mean and sum of squares about it by
# axis; the samples.
_TAKEN, _FREE_FOR, _ZEROED, _AVERAGED, _IN_WINDOW, _MEAN, _SQUARES = map(_next, (1, 1, 1, 1, 1, 3, 3))
_SAMPLES = _next.size


class Zero(IntEnum):
    """The fate of the sensor's offset."""

    HELD = 0  # the probe touches, is near the surface, or has just been
    RENEWED = 1  # in free space
    LOST = 2  # held: no contact is reported, but the probe is under the surface, or none is seen
    RESTLESS = 3  # held: free, but the force is not steady
    DEPARTED = 4  # held: free and steady, but far from the last zero


@dataclass(frozen=True)
class ProbeOptions(Checked):
    """The probe, and how its force is cleared of it.

    Attributes:
        mass: what the sensor carries [kg].
        weight: of it, along x, y and z of the table frame [N]; the offset takes up what this is wrong by.
        step: sample time [s].
        slope: time over which the slope of the velocity is taken [s].
        clear: time out of contact before the offset is renewed [s].
        margin: so far above the surface the probe is certain to be free [m]; well above the noise of its cloud.
        window: so long the force has to be steady [s],
        steady: to within this standard deviation, all axes together [N],
        departure: and no further than this from the last zero [N].

    Raises:
        BadInput: a value that is out of range.
    """

    mass: Annotated[float, Quantity("kg", 0.0, 100.0)] = 0.0
    weight: tuple[float, float, float] = (0.0, 0.0, 0.0)
    step: Annotated[float, Quantity("s", 1e-5, 0.1)] = 0.001
    slope: Annotated[float, Quantity("s", 0.0, 0.5)] = 0.02
    clear: Annotated[float, Quantity("s", 0.0, 10.0)] = 0.05
    margin: Annotated[float, Quantity("m", 0.0, 0.1)] = 0.003
    window: Annotated[float, Quantity("s", 1e-3, 10.0)] = 0.05
    steady: Annotated[float, Quantity("N", 1e-6, 1e3)] = 0.5
    departure: Annotated[float, Quantity("N", 1e-6, 1e3)] = 1.0

    CALLED: ClassVar = "probe"

    @property
    def reach(self) -> int:
        """Samples on either side that a slope of the velocity is taken over."""
        return max(1, round(0.5 * self.slope / self.step))

    @property
    def delay(self) -> float:
        """By how much what is handed over is late [s]."""
        return self.reach * self.step

    @property
    def ticks_late(self) -> int:
        """The same in samples, with the one that its system takes."""
        return self.reach + 1


# `ProbeOptions` in the form that the compiled tick takes, times but the step in samples.
_next = Layout()
_MASS, _WEIGHT, _STEP, _REACH, _CLEAR = map(_next, (1, 3, 1, 1, 1))
_MARGIN, _WINDOW, _STEADY, _DEPARTURE = map(_next, [1] * 4)


def settings(options: ProbeOptions) -> Array:
    """The options as the vector that `compensate` reads."""
    clear, window = math.ceil(options.clear / options.step), max(1, round(options.window / options.step))
    probe = [options.mass, *options.weight, options.step, options.reach]
    return np.array([*probe, clear, options.margin, window, options.steady, options.departure], dtype=np.float64)


def initial_readout(options: ProbeOptions) -> Array:
    """Outputs and memory before the first sample."""
    return np.zeros(_SAMPLES + _ROW * (2 * options.reach + 1))


@njit(cache=True, error_model="numpy")
def compensate(sample: Array, in_contact: float, clearance: float, readout: Array, fixed: Array) -> None:
    """One tick; allocates nothing.

    Args:
        sample: position, velocity and the sensor's reading (9) in the table frame [m, m/s, N].
        in_contact: 1.0 where the probe touches, else 0.0; whatever else it is, the probe is not known to be free.
        clearance: of the probe above the surface (`mmt_drake.cloud.clearance`) [m]; -inf or NaN: no surface is seen.
        readout: of `initial_readout`, changed; until `reach` samples are there the first one is put out.
        fixed: `settings`.
    """
    reach = int(fixed[_REACH])
    size = 2 * reach + 1
    taken = int(readout[_TAKEN])
    for k in range(size if taken == 0 else 1):  # the first sample stands for what was before
        row = readout[_SAMPLES + _ROW * ((taken + k) % size) :]
        assign(row[:9], sample)
        row[9] = in_contact
    oldest = taken + 1  # in the ring, after which they follow in their order
    readout[_TAKEN] = taken + 1.0

    middle = readout[_SAMPLES + _ROW * ((oldest + reach) % size) :]
    assign(readout[:_CONTACT], middle[:9])
    readout[_CONTACT] = middle[9]
    assign(readout[_READING], middle[6:9])
    for i in range(3):
        slope, squares = 0.0, 0.0
        for j in range(1, reach + 1):
            after = readout[_SAMPLES + _ROW * ((oldest + reach + j) % size) + 3 + i]
            before = readout[_SAMPLES + _ROW * ((oldest + reach - j) % size) + 3 + i]
            if math.isfinite(after - before):
                slope += j * (after - before)
                squares += 2.0 * j * j
        readout[6 + i] += fixed[_MASS] * slope / (squares * fixed[_STEP]) - fixed[_WEIGHT + i]

    # A contact that is seen anywhere in the ring, or was within `clear`, may be in the reading already, or still.
    free = in_contact <= 0.5 and clearance > fixed[_MARGIN]
    readout[_FREE_FOR] = readout[_FREE_FOR] + 1.0 if free else 0.0
    if readout[_FREE_FOR] <= size + fixed[_CLEAR]:
        readout[_AVERAGED] = readout[_IN_WINDOW] = 0.0
        lost = in_contact <= 0.5 and not clearance >= -fixed[_MARGIN]
        readout[_ZERO] = Zero.LOST.value if lost else Zero.HELD.value
    elif math.isfinite(readout[6] + readout[7] + readout[8]):
        _renew(readout, fixed)
    for i in range(3):
        readout[6 + i] -= readout[_OFFSET.start + i]


@njit(cache=True, error_model="numpy")
def _renew(readout: Array, fixed: Array) -> None:
    """Take a force in free space, offset included, into this window, and the window, once full, into the offset."""
    if readout[_IN_WINDOW] == 0.0:
        readout[_MEAN : _MEAN + 6] = 0.0
    readout[_IN_WINDOW] += 1.0
    spread, away = 0.0, 0.0
    for i in range(3):
        off = readout[6 + i] - readout[_MEAN + i]
        readout[_MEAN + i] += off / readout[_IN_WINDOW]
        readout[_SQUARES + i] += off * (readout[6 + i] - readout[_MEAN + i])
        spread += readout[_SQUARES + i] / readout[_IN_WINDOW]
        away += (readout[_MEAN + i] - readout[_OFFSET.start + i]) ** 2
    if readout[_IN_WINDOW] < fixed[_WINDOW]:
        return
    readout[_IN_WINDOW] = 0.0
    if spread > fixed[_STEADY] ** 2:
        readout[_ZERO] = Zero.RESTLESS.value
    elif readout[_ZEROED] == 1.0 and away > fixed[_DEPARTURE] ** 2:
        readout[_ZERO] = Zero.DEPARTED.value
    else:
        readout[_ZERO] = Zero.RENEWED.value
        readout[_ZEROED] = 1.0
        readout[_AVERAGED] = min(readout[_AVERAGED] + 1.0, _LATEST)
        for i in range(3):
            readout[_OFFSET.start + i] += (readout[_MEAN + i] - readout[_OFFSET.start + i]) / readout[_AVERAGED]
