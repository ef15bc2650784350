"""One Kalman filter at work: what it believes, and how well it has foretold."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.unknowns import UNKNOWNS, Stick
from mmt_drake.estimation.recursive.kalman_step import OWN, STATES, Tuning, filter_samples
from mmt_drake.estimation.recursive.samples import Samples
from mmt_drake.model.body import MODE, VELOCITY

Array = NDArray[np.float64]

_LOST = np.array([0.02, 0.05, 0.02]) ** 2  # variances of the body's own states after time broke off


@dataclass(frozen=True)
class Belief:
    """A filter's state; never changed.

    Attributes:
        x: (UNKNOWNS,) as in `mmt_drake.estimation.output_error.unknowns`.
        stick: static friction, which the filter takes for known.
        axes: (2, AXIS_SIZE) the body.
        P: (STATES, STATES) covariance.
        scale: noise over what is known of it.
        unlikely: -log likelihood of the samples since it began.
    """

    x: Array
    stick: Stick
    axes: Array
    P: Array
    scale: float = 1.0
    unlikely: float = 0.0

    @classmethod
    def of(cls, x: Array, covariance: Array, axes: Array) -> Self:
        """Unknowns with their covariance, and a body whose motion is known."""
        P = np.zeros((STATES, STATES))
        P[:UNKNOWNS, :UNKNOWNS] = covariance
        return cls(x, Stick(), axes, P)

    def after(self, samples: Samples, span: tuple[int, int], tuning: Tuning) -> Self | None:
        """With samples; None where the filter cannot follow them."""
        x, axes, P = self.x.copy(), self.axes.copy(), self.P.copy()
        stick = self.stick.excess, self.stick.speed
        try:
            scale, unlikely = filter_samples(samples, span, stick, tuning, x, axes, P, self.scale)
        except RuntimeError:  # the body would stick and slide without end
            return None
        if not (np.isfinite(x).all() and np.isfinite(axes).all() and np.isfinite(P).all()):
            return None
        return replace(self, x=x, axes=axes, P=0.5 * (P + P.T), scale=scale, unlikely=self.unlikely + unlikely)

    def told(self, j: int, value: float, variance: float) -> Self:
        """With unknown j measured from elsewhere."""
        gain = self.P[:, j] / (self.P[j, j] + variance)
        return replace(
            self,
            x=self.x + gain[:UNKNOWNS] * (value - self.x[j]),
            P=self.P - np.outer(gain, self.P[j]),
        )

    def doubting(self, deviations: float) -> Self:
        """The same unknowns, less sure of by so many times; nothing foretold yet."""
        spread = np.ones(STATES)
        spread[:UNKNOWNS] = deviations
        return replace(self, P=self.P * np.outer(spread, spread), unlikely=0.0)

    def reopened(self, covariance: Array) -> Self:
        """The same unknowns as if they were not known yet, with this covariance; nothing foretold yet."""
        return replace(type(self).of(self.x, covariance, self.axes), stick=self.stick, scale=self.scale)

    def lost(self) -> Self:
        """After time broke off: the unknowns stay, the body rests somewhere about."""
        axes, P = self.axes.copy(), self.P.copy()
        axes[:, [VELOCITY, MODE]] = 0.0
        for i in range(2):
            own = slice(UNKNOWNS + OWN * i, UNKNOWNS + OWN * (i + 1))
            P[own, :] = P[:, own] = 0.0
            P[own, own] = np.diag(_LOST)
        return replace(self, axes=axes, P=P)
