"""Motions in closed form: minimum-jerk steps and windowed sine sweeps, added up.

A motion is a resting place plus a sum of pieces, each on one axis:

- a *step* moves by a displacement D within [start, end], D (10 s^3 - 15 s^4 + 6 s^5) with s from 0
  to 1: the minimum-jerk reach of Flash and Hogan, "The coordination of arm movements", J. Neurosci.
  5(7), 1985. Overlapping steps add, as submovements of a hand do;
- a *wave* is A(t) sin(phase(t)) under a window that rises and falls like a step. Frequency and
  amplitude grow exponentially from start to end; equal ends make it a plain sine.

All pieces are twice continuously differentiable, hence so is the motion. It begins again after
`cycle` seconds, so that its size in memory does not depend on how long it is run.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

Row = tuple[float, ...]

# The table that the kernel reads: a head row, then the steps by their start, then the waves.
#   head: number of steps, cycle, origin x, y, z
#   step: axis, start, end, displacement
#   wave: axis, start, end, ramp, amplitude, growth [1/s], omega [rad/s], sweep [1/s], phase [rad]
_WIDTH = 9


def step(axis: int, start: float, end: float, displacement: float) -> Row:
    """A minimum-jerk move of `displacement` [m] along `axis` (0, 1, 2) from `start` to `end` [s]."""
    if not end > start:
        raise BadInput("step", at="end", found=end, expected=f"later than the start, {start} s")
    return (float(axis), float(start), float(end), float(displacement))


def wave(
    axis: int,
    start: float,
    end: float,
    amplitude: float,
    frequency: float,
    *,
    end_amplitude: float | None = None,
    end_frequency: float | None = None,
    phase: float = 0.0,
    ramp: float = 0.5,
) -> Row:
    """A windowed sine, or an exponential sweep, along one axis.

    Args:
        axis: 0, 1 or 2.
        start, end: where the window opens and where it has closed [s].
        amplitude: at the start [m].
        frequency: at the start [Hz], > 0.
        end_amplitude, end_frequency: at the end; as at the start unless given.
        phase: at the start [rad].
        ramp: time the window takes to open, and to close [s]; at most half of end - start.

    Raises:
        BadInput: times out of order, or a frequency or an amplitude that cannot grow exponentially.
    """
    length = end - start
    last_amplitude = amplitude if end_amplitude is None else end_amplitude
    last_frequency = frequency if end_frequency is None else end_frequency
    if not 0.0 < ramp <= 0.5 * length:
        raise BadInput("wave", at="ramp", found=f"{ramp} s", expected=f"within 0 and half of its length, {length} s")
    if not (frequency > 0.0 and last_frequency > 0.0):
        raise BadInput("wave", at="frequency", found=f"{frequency} to {last_frequency} Hz", expected="> 0")
    growth = 0.0
    if last_amplitude != amplitude:
        if not amplitude * last_amplitude > 0.0:
            raise BadInput(
                "wave", at="end_amplitude", found=last_amplitude, expected=f"the sign of the first, {amplitude}"
            )
        growth = math.log(last_amplitude / amplitude) / length
    sweep = math.log(last_frequency / frequency) / length
    omega = 2.0 * math.pi * frequency
    return (float(axis), float(start), float(end), float(ramp), float(amplitude), growth, omega, sweep, float(phase))


@njit(cache=True)
def _minimum_jerk(s: float) -> tuple[float, float]:
    """The unit step at s and its slope, 0 <= s <= 1."""
    return s * s * s * (10.0 + s * (-15.0 + 6.0 * s)), 30.0 * s * s * (1.0 - s) * (1.0 - s)


@njit(cache=True)
def motion_at(t: float, table: Array, out: Array) -> None:
    """Writes position [m] and velocity [m/s] at t [s] into out (6).

    Args:
        t: time [s].
        table: `AnalyticMotion.table`.
        out: (6) result.
    """
    steps = int(table[0, 0])
    cycle = table[0, 1]
    t = t - math.floor(t / cycle) * cycle
    for axis in range(3):
        out[axis] = table[0, 2 + axis]
        out[3 + axis] = 0.0
    for i in range(1, 1 + steps):
        start, end = table[i, 1], table[i, 2]
        if t <= start:
            break
        axis = int(table[i, 0])
        if t >= end:
            out[axis] += table[i, 3]
        else:
            value, slope = _minimum_jerk((t - start) / (end - start))
            out[axis] += table[i, 3] * value
            out[3 + axis] += table[i, 3] * slope / (end - start)
    for i in range(1 + steps, table.shape[0]):
        since, left = t - table[i, 1], table[i, 2] - t
        if since <= 0.0 or left <= 0.0:
            continue
        axis, ramp = int(table[i, 0]), table[i, 3]
        window, window_rate = 1.0, 0.0
        if since < ramp:
            window, slope = _minimum_jerk(since / ramp)
            window_rate = slope / ramp
        elif left < ramp:
            window, slope = _minimum_jerk(left / ramp)
            window_rate = -slope / ramp
        amplitude = table[i, 4] * math.exp(table[i, 5] * since)
        omega, sweep = table[i, 6], table[i, 7]
        phase = table[i, 8] + (omega * since if sweep == 0.0 else omega * math.expm1(sweep * since) / sweep)
        rate = omega * math.exp(sweep * since)
        sine, cosine = math.sin(phase), math.cos(phase)
        out[axis] += amplitude * window * sine
        out[3 + axis] += amplitude * (window * rate * cosine + (window_rate + window * table[i, 5]) * sine)


@njit(cache=True)
def _sample(times: Array, table: Array, out: Array) -> None:
    for i in range(times.shape[0]):
        motion_at(times[i], table, out[i])


class Motion:
    """A motion of the hand, which a kernel reads off a table.

    Attributes:
        table: of the kernel.
        sample_into: the kernel: (times (n), table, out (n, 6)), which writes positions [m] and velocities [m/s].
    """

    table: Array
    sample_into: ClassVar[Callable[[Array, Array, Array], None]]

    def at(self, t: float) -> tuple[Array, Array]:
        """Position (3) [m] and velocity (3) [m/s] at time t [s]."""
        position, velocity = self.sample([t])
        return position[0], velocity[0]

    def sample(self, times: ArrayLike) -> tuple[Array, Array]:
        """Positions (n, 3) [m] and velocities (n, 3) [m/s] at times (n) [s]."""
        clock = np.ascontiguousarray(times, dtype=np.float64)
        out = np.empty((len(clock), 6))
        type(self).sample_into(clock, self.table, out)
        return out[:, :3], out[:, 3:]


@dataclass(frozen=True, eq=False)
class AnalyticMotion(Motion):
    """A motion of the hand in closed form, in the table frame.

    Args:
        origin: where it begins and where each cycle ends [m].
        steps: rows of `step`; along each axis they add up to nothing, so that the cycle closes.
        waves: rows of `wave`.
        cycle: time after which the motion begins again [s].

    Raises:
        BadInput: a piece that leaves [0, cycle], or steps that do not return to the origin.
    """

    origin: tuple[float, float, float]
    _: KW_ONLY
    steps: Sequence[Row]
    waves: Sequence[Row] = ()
    cycle: float
    table: Array = field(init=False, repr=False)

    sample_into = _sample

    def __post_init__(self) -> None:
        self._check()
        steps = sorted(self.steps, key=lambda row: row[1])  # the kernel stops at the first that is still to come
        table = np.zeros((1 + len(steps) + len(self.waves), _WIDTH))
        table[0, :5] = (len(steps), self.cycle, *self.origin)
        for i, row in enumerate((*steps, *self.waves), start=1):
            table[i, : len(row)] = row
        object.__setattr__(self, "table", table)

    def _check(self) -> None:
        if not 0.0 < self.cycle < math.inf:
            raise BadInput("motion", at="cycle", found=self.cycle, expected="a positive time [s]")
        net = [0.0, 0.0, 0.0]
        for row in (*self.steps, *self.waves):
            if not (row[1] >= 0.0 and row[2] <= self.cycle * (1.0 + 1e-12)):
                piece = f"a piece from {row[1]} to {row[2]} s"
                raise BadInput("motion", found=piece, expected=f"within the cycle of {self.cycle} s")
        for row in self.steps:
            net[int(row[0])] += row[3]
        if max(map(abs, net)) > 1e-9:
            raise BadInput("motion", at="steps", found=f"a net displacement of {net} m", expected="0: the cycle closes")
