"""The motion that drives every engine: a sine, known inside the step or only sampled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

Array = NDArray[np.float64]
Input = Literal["inside_step", "sampled"]

STEP: Final = 1e-3
"""Of every engine [s]."""

_BACKWARD: Final = np.array([11.0, -18.0, 9.0, -2.0]) / 6.0
"""Third-order backward difference, the latest sample first; off by (omega STEP)^3 / 4 of the velocity."""


@dataclass(frozen=True)
class Probe:
    """A probe at x(t) = sin(omega t) [m].

    Attributes:
        omega: [rad/s].
        steps: made from time 0 on.
        input: `inside_step`: position and velocity are known at all times. `sampled`: only poses are known, one a step
            and none ahead. The velocity at a sample is then the third-order difference of the latest four, which
            multiplies their noise by 3.8 / STEP, and between two samples the probe moves on the cubic through both
            ends: the force at a sample needs none that comes later.
        lead: steps made before time 0.
    """

    omega: float
    steps: int
    input: Input
    lead: int = 0

    @property
    def times(self) -> Array:
        """Of the samples, (lead + steps + 1,) [s]."""
        return self._times(self.lead)

    def at_samples(self) -> tuple[Array, Array]:
        """Position and velocity at `times`, [m], [m/s]."""
        if self.input == "inside_step":
            return self._at(self.times)
        older = len(_BACKWARD) - 1
        poses, _ = self._at(self._times(self.lead + older))
        return poses[older:], np.convolve(poses, _BACKWARD / STEP, mode="valid")

    def at_middles(self) -> tuple[Array, Array]:
        """Position and velocity in the middle of each step, (lead + steps,) each [m], [m/s]."""
        if self.input == "inside_step":
            return self._at(self.times[:-1] + 0.5 * STEP)
        x, v = self.at_samples()
        path, middles = CubicHermiteSpline(self.times, x, v), self.times[:-1] + 0.5 * STEP
        return path(middles), path(middles, 1)

    def _times(self, lead: int) -> Array:
        return np.arange(-lead, self.steps + 1, dtype=np.float64) * STEP

    def _at(self, times: Array) -> tuple[Array, Array]:
        return np.sin(self.omega * times), self.omega * np.cos(self.omega * times)
