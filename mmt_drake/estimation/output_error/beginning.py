"""Where the body is at the first sample of a window, and how far that follows from the unknowns.

The samples before have brought the body there, and they bring another object elsewhere. Were the place taken as
measured, the force of its stretched springs would tell the springs' stiffness, from nothing: each window that is let go
would make the numbers surer than they are, and hold them to the place's error.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from mmt_drake.errors import attempt
from mmt_drake.estimation.output_error.unknowns import HIGH, LOW, SIZE, UNKNOWNS
from mmt_drake.model.body import ANCHOR, AXIS_SIZE, MEMORY, MEMORY_SIZE, MODE, POSITION, VELOCITY
from mmt_drake.numeric.arrays import Array

OF_LAWS = slice(MEMORY, MEMORY + MEMORY_SIZE)
"""Where in the state of an axis stands what laws on the body remember."""

_FOLLOW = [POSITION, VELOCITY, ANCHOR]
_LEAST = 1e-3  # of an unknown's size: what it is moved by at least


@dataclass(frozen=True)
class Beginning:
    """The body's state at the first sample.

    Attributes:
        state: (2, AXIS_SIZE) along x and y, with the unknowns `x`.
        x: (UNKNOWNS,) the unknowns that have led there.
        slope: (UNKNOWNS, 2, AXIS_SIZE) of the state after the unknowns; 0 where it was measured.
    """

    state: Array
    x: Array
    slope: Array

    @classmethod
    def known(cls, state: Array) -> Self:
        """A state (2, AXIS_SIZE) that no unknown changes."""
        return cls(state, np.zeros(UNKNOWNS), np.zeros((UNKNOWNS, 2, AXIS_SIZE)))

    @classmethod
    def at_rest(cls, probe: Array | None = None) -> Self:
        """A body at rest along x and y, with the probe (2,) where it is counted from, at 0 by default [m]."""
        state = np.zeros((2, AXIS_SIZE))
        if probe is not None:
            state[:, ANCHOR] = probe
        return cls.known(state)

    @classmethod
    def after(cls, end: Callable[[Array], Array], x: Array, deviation: Array) -> Self:
        """Where a simulation ends.

        The slope is that of the chord over one deviation to each side: friction makes the state rough.

        Args:
            end: unknowns (UNKNOWNS,) -> state (2, AXIS_SIZE).
            x: the unknowns.
            deviation: (UNKNOWNS,) of them.

        Raises:
            MmtError: x cannot be integrated.
        """
        state, slope = end(x), np.zeros((UNKNOWNS, 2, AXIS_SIZE))
        for j, step in enumerate(np.clip(deviation, _LEAST * SIZE, SIZE)):
            low, high = x.copy(), x.copy()
            low[j], high[j] = max(x[j] - step, LOW[j]), min(x[j] + step, HIGH[j])
            sides = attempt(end, low), attempt(end, high)
            if sides[0] is not None and sides[1] is not None:
                slope[j] = (sides[1] - sides[0]) / (high[j] - low[j])
        held = state[:, MODE] == 0.0
        slope[:, held, VELOCITY] = 0.0
        return cls(state, x, slope)

    def of(self, x: Array) -> Array:
        """The state (2, AXIS_SIZE) with other unknowns (UNKNOWNS,); what slides does not turn."""
        state = self.state.copy()
        if self.slope.any():
            state[:, _FOLLOW] += np.tensordot(x - self.x, self.slope[:, :, _FOLLOW], 1)
            state[state[:, VELOCITY] * state[:, MODE] < 0.0, VELOCITY] = 0.0
        return state

    def moved(self, offset: Array) -> Self:
        """With the probe (2,) elsewhere by so much [m]."""
        state = self.state.copy()
        state[:, ANCHOR] += offset
        return type(self)(state, self.x, self.slope)

    def elsewhere(self, offset: Array, memory: Array) -> Self:
        """With the body (2,) elsewhere by so much [m], the contact spring stretched as it was.

        What its laws remember is `memory` (2, MEMORY_SIZE), whatever it has been.
        """
        state = self.state.copy()
        state[:, POSITION] += offset
        state[:, ANCHOR] -= offset
        state[:, OF_LAWS] = memory
        return type(self)(state, self.x, self.slope)
