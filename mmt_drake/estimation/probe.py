"""From what a force sensor at an arm's wrist reads to the force on the tip of the probe beyond it; compiled.

The sensor carries the probe. With its reading r in the sign of a force on the probe, its offset o, the probe's mass m
and acceleration a, and gravity g::

    r = F + m (g - a) + o        hence        F = r - o - m g + m a

The acceleration is the slope of the measured velocity over samples on both sides, so that it belongs to the sample in
their middle; that is why everything is handed over `Settings.reach` samples late. The offset, and with it whatever the
weight was taken wrong by, is the mean of what is left in free space, anew at each lift.

The reading itself is handed on beside the force: a sensor that saturates or freezes is seen in that alone, since probe
and acceleration move what has been made of it.

A sample that is not finite is handed on as it is, for whoever comes next to see, and leaves no trace otherwise: neither
the slopes of the samples around it nor the offset take it up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.errors import BadInput

Array = NDArray[np.float64]

_ROW = 10  # of a sample: position, velocity, reading, contact

#: What a tick puts out, one after the other.
PORT_SIZES = {"measurement": 9, "in_contact": 1, "offset": 3, "reading": 3}
_CONTACT, _OFFSET, _READING = 9, slice(10, 13), slice(13, 16)
# The memory behind it: samples taken, samples since contact, samples that the offset is the mean of, the samples.
_TAKEN, _FREE_FOR, _AVERAGED, _SAMPLES = 16, 17, 18, 19


@dataclass(frozen=True)
class ProbeOptions:
    """What is known of the probe, and how its force is cleared of it.

    Attributes:
        mass: what the sensor carries [kg].
        weight: of it, along x, y and z of the table frame [N]; the offset takes up what this is wrong by.
        step: sample time [s].
        slope: time over which the slope of the velocity is taken [s].
        clear: time out of contact before the offset is renewed [s].

    Raises:
        BadInput: a value that is out of range.
    """

    mass: float = 0.0
    weight: tuple[float, float, float] = (0.0, 0.0, 0.0)
    step: float = 0.001
    slope: float = 0.02
    clear: float = 0.05

    def __post_init__(self) -> None:
        limits = (("mass", 0.0, 100.0, "kg"), ("step", 1e-5, 0.1, "s"), ("slope", 0.0, 0.5, "s"))
        for name, least, most, unit in (*limits, ("clear", 0.0, 10.0, "s")):
            value = getattr(self, name)
            if not least <= value <= most:
                raise BadInput("probe", at=name, found=value, expected=f"{least:g} to {most:g} {unit}")
        if len(self.weight) != 3 or not all(map(math.isfinite, self.weight)):
            raise BadInput("probe", at="weight", found=self.weight, expected="three finite forces in N")

    @property
    def delay(self) -> float:
        """By how much what is handed over is late [s]."""
        return settings(self).reach * self.step

    @property
    def ticks_late(self) -> int:
        """The same in samples, with the one that its system takes."""
        return settings(self).reach + 1


class Settings(NamedTuple):
    """`ProbeOptions` in the form that the compiled tick takes."""

    mass: float
    weight: tuple[float, float, float]
    step: float
    reach: int
    clear: int


def settings(options: ProbeOptions) -> Settings:
    """Translate the options."""
    reach = max(1, round(0.5 * options.slope / options.step))
    weight = (float(options.weight[0]), float(options.weight[1]), float(options.weight[2]))
    return Settings(options.mass, weight, options.step, reach, math.ceil(options.clear / options.step))


def initial_readout(fixed: Settings) -> Array:
    """Outputs and memory before the first sample."""
    return np.zeros(_SAMPLES + _ROW * (2 * fixed.reach + 1))


@njit(cache=True, error_model="numpy")
def compensate(sample: Array, in_contact: float, readout: Array, fixed: Settings) -> None:
    """One tick; allocates nothing.

    Args:
        sample: position, velocity and the sensor's reading (9) in the table frame [m, m/s, N].
        in_contact: 1.0 where the probe touches, else 0.0; whatever else it is, the probe is not known to be free.
        readout: of `initial_readout`, changed; until `reach` samples are there the first one is put out.
        fixed: `settings`.
    """
    size = 2 * fixed.reach + 1
    taken = int(readout[_TAKEN])
    for k in range(size if taken == 0 else 1):  # the first sample stands for what was before
        row = readout[_SAMPLES + _ROW * ((taken + k) % size) :]
        row[:9] = sample
        row[9] = in_contact
    oldest = taken + 1  # in the ring, after which they follow in their order
    readout[_TAKEN] = taken + 1.0

    middle = readout[_SAMPLES + _ROW * ((oldest + fixed.reach) % size) :]
    readout[:_CONTACT] = middle[:9]
    readout[_CONTACT] = middle[9]
    readout[_READING] = middle[6:9]
    for i in range(3):
        slope, squares = 0.0, 0.0
        for j in range(1, fixed.reach + 1):
            after = readout[_SAMPLES + _ROW * ((oldest + fixed.reach + j) % size) + 3 + i]
            before = readout[_SAMPLES + _ROW * ((oldest + fixed.reach - j) % size) + 3 + i]
            if math.isfinite(after - before):
                slope += j * (after - before)
                squares += 2.0 * j * j
        readout[6 + i] += fixed.mass * slope / (squares * fixed.step) - fixed.weight[i]

    # A contact that is seen anywhere in the ring, or was within `clear`, may be in the reading already, or still.
    readout[_FREE_FOR] = readout[_FREE_FOR] + 1.0 if in_contact <= 0.5 else 0.0
    if readout[_FREE_FOR] <= size + fixed.clear:
        readout[_AVERAGED] = 0.0
    elif math.isfinite(readout[6] + readout[7] + readout[8]):
        readout[_AVERAGED] += 1.0
        for i in range(3):
            readout[_OFFSET.start + i] += (readout[6 + i] - readout[_OFFSET.start + i]) / readout[_AVERAGED]
    for i in range(3):
        readout[6 + i] -= readout[_OFFSET.start + i]
