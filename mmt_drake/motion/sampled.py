"""Motions given by samples of position and velocity, with a cubic between neighbours."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from mmt_drake.errors import BadInput
from mmt_drake.lookup import row_before
from mmt_drake.model.hermite import cubic, position_at, velocity_at
from mmt_drake.motion.analytic import Motion
from mmt_drake.numeric.arrays import Array


@njit(cache=True)
def sampled_motion_at(t: float, table: Array, out: Array) -> None:
    """Writes position [m] and velocity [m/s] at t [s] into out (6).

    Before the first sample and after the last one the hand rests where that sample is.

    Args:
        t: time [s].
        table: `SampledMotion.table`, rows of time, position, velocity.
        out: (6) result.
    """
    last = table.shape[0] - 1
    if t < table[0, 0] or t >= table[last, 0]:
        end = 0 if t < table[0, 0] else last
        at_rest = t != table[end, 0]
        for axis in range(3):
            out[axis] = table[end, 1 + axis]
            out[3 + axis] = 0.0 if at_rest else table[end, 4 + axis]
        return
    i = row_before(t, table)
    s = t - table[i, 0]
    h = table[i + 1, 0] - table[i, 0]
    for axis in range(3):
        between = cubic(table[i, 1 + axis], table[i, 4 + axis], table[i + 1, 1 + axis], table[i + 1, 4 + axis], h)
        out[axis] = position_at(between, s)
        out[3 + axis] = velocity_at(between, s)


@njit(cache=True)
def _sample(times: Array, table: Array, out: Array) -> None:
    for i in range(times.shape[0]):
        sampled_motion_at(times[i], table, out[i])


@dataclass(frozen=True, eq=False)
class SampledMotion(Motion):
    """A motion through samples, continuously differentiable, in the table frame.

    Args:
        time: (n) [s], n >= 2, increasing.
        position: (n, 3) [m].
        velocity: (n, 3) [m/s].
        source: where it came from; opens error messages.
        notes: what was done to it, one line each.

    Raises:
        BadInput: shapes that do not fit, values that are not finite, times that do not increase.
    """

    time: Array
    position: Array
    velocity: Array
    source: str = "motion"
    notes: tuple[str, ...] = ()
    table: Array = field(init=False, repr=False)

    sample_into = _sample

    def __post_init__(self) -> None:
        for name in ("time", "position", "velocity"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        n = self.time.size
        if self.time.ndim != 1 or n < 2:
            raise BadInput(self.source, at="time", found=f"shape {self.time.shape}", expected="two samples or more")
        for name in ("position", "velocity"):
            shape = getattr(self, name).shape
            if shape != (n, 3):
                raise BadInput(self.source, at=name, found=f"shape {shape}", expected=f"({n}, 3)")
        object.__setattr__(self, "table", np.column_stack([self.time, self.position, self.velocity]))
        bad = ~np.isfinite(self.table).all(axis=1)
        if bad.any():
            raise BadInput(self.source, at=f"sample {np.argmax(bad)}", found="NaN or infinity", expected="numbers")
        stuck = np.diff(self.time) <= 0.0
        if stuck.any():
            i = int(np.argmax(stuck)) + 1
            raise BadInput(
                self.source, at=f"sample {i}", found=f"time {self.time[i]} s", expected=f"after {self.time[i - 1]} s"
            )

    @classmethod
    def from_positions(
        cls, time: ArrayLike, position: ArrayLike, *, source: str = "motion", notes: tuple[str, ...] = ()
    ) -> SampledMotion:
        """The motion whose velocities are those of the cubic spline through the positions.

        Between samples it then *is* that spline, twice continuously differentiable.
        """
        clock, points = np.asarray(time, dtype=np.float64), np.asarray(position, dtype=np.float64)
        cls(clock, points, np.zeros_like(points), source)  # checks them, before the spline stumbles
        return cls(clock, points, CubicSpline(clock, points)(clock, 1), source, notes)

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])
