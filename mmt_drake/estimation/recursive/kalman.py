"""What the Kalman filter knows, and how new samples change it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.fit import (
    LOG_B2,
    LOG_K2,
    UNKNOWNS,
    Stick,
    derivatives,
    prior_information,
    rest,
    theta_of,
)
from mmt_drake.estimation.output_error.learn import at_rest
from mmt_drake.estimation.output_error.window import Window
from mmt_drake.estimation.recursive.kalman_step import OWN, STATES, Tuning, filter_samples
from mmt_drake.estimation.recursive.normal import NormalAxis
from mmt_drake.estimation.recursive.options import KalmanOptions
from mmt_drake.estimation.recursive.samples import samples_of
from mmt_drake.estimation.recursive.stream import Stream, short_bank
from mmt_drake.model.body import MODE, VELOCITY

Array = NDArray[np.float64]

_FOLLOW_S = 0.5  # in which the noise follows the innovations
_GAP = (1e-7, 1e-4)  # variances that a body gains for each sample of a gap [m^2], [m^2/s^2]
_LOST = np.array([0.02, 0.05, 0.02]) ** 2  # of the body's own states after time broke off


@dataclass(frozen=True)
class KalmanKnowledge:
    """All that is known after some samples; never changed.

    Attributes:
        stream: the samples at hand.
        x: (UNKNOWNS,) of the filter.
        stick: static friction.
        axes: (2, AXIS_SIZE) the body.
        P: (STATES, STATES) covariance.
        normal: the normal axis.
        scale: noise over what is known of it.
    """

    stream: Stream
    x: Array
    stick: Stick
    axes: Array
    P: Array
    normal: NormalAxis
    scale: float = 1.0

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def theta(self) -> Array:
        """What is handed over, in the order of `mmt_drake.model.parameters.THETA`."""
        return theta_of(self.x, self.stick, self.normal.values)

    @property
    def deviation(self) -> Array:
        """Standard deviations of theta."""
        own = derivatives(self.theta) * np.sqrt(np.maximum(np.diag(self.P)[:UNKNOWNS], 0.0))
        return np.array([*own, *self.normal.deviation, own[-1], 0.0])


class KalmanLearner:
    """Makes knowledge of samples; itself it keeps nothing.

    Args:
        options: of the estimator.
    """

    def __init__(self, options: KalmanOptions) -> None:
        self.options = options
        self.h = options.interval
        self._bank = short_bank(self.h, options.ticks)
        self._tuning = Tuning(
            force=options.force_noise**2 / options.ticks,
            push=options.body_noise**2,
            drift=options.drift**2 * self.h,
            gap=_GAP,
            follow=self.h / _FOLLOW_S,
        )

    def beginning(self) -> KalmanKnowledge:
        """Nothing but the prior."""
        known = prior_information(self.options.prior, None)
        P = np.zeros((STATES, STATES))
        P[:UNKNOWNS, :UNKNOWNS] = known.covariance()
        return KalmanKnowledge(
            Stream.empty(), known.mean(), Stick(), rest(), P, NormalAxis.believed(self.options.prior)
        )

    def learned(self, known: KalmanKnowledge, new: Array, broken: bool = False) -> KalmanKnowledge:
        """Knowledge with new samples (k, SAMPLE_SIZE); `broken`: time broke off before them."""
        if broken and len(known.stream.window):
            known = self._lost(known)
        if len(new) == 0:
            return known
        if len(known.stream.window) == 0 and not known.stream.interrupted:
            known = replace(known, axes=at_rest(new[0]))
        stream = known.stream.extended(new, self.h, self._bank)
        ready = stream.ready(self._bank)
        first = max(ready.start, 1)
        known = replace(known, stream=replace(stream, done=ready.stop))
        if first >= ready.stop:
            return known
        known = self._along_normal(known, ready)
        x, axes, P = known.x.copy(), known.axes.copy(), known.P.copy()
        try:
            scale, _ = filter_samples(
                samples_of(stream.window, self.h),
                (first, ready.stop),
                known.stick,
                self._tuning,
                x,
                axes,
                P,
                known.scale,
            )
        except RuntimeError:  # the body would stick and slide without end
            return known
        if not (np.isfinite(x).all() and np.isfinite(axes).all() and np.isfinite(P).all()):
            return known
        return replace(known, x=x, axes=axes, P=0.5 * (P + P.T), scale=scale)

    def compile(self) -> None:
        """Compile what learning calls."""
        samples = samples_of(Window.empty(), self.h)
        known = self.beginning()
        filter_samples(samples, (0, 0), known.stick, self._tuning, known.x, known.axes.copy(), known.P, 1.0)

    def _lost(self, known: KalmanKnowledge) -> KalmanKnowledge:
        """Time broke off: the parameters stay, where the body is is anyone's guess."""
        P, axes = known.P.copy(), known.axes.copy()
        axes[:, [VELOCITY, MODE]] = 0.0
        for i in range(2):
            own = slice(UNKNOWNS + OWN * i, UNKNOWNS + OWN * (i + 1))
            P[own, :] = P[:, own] = 0.0
            P[own, own] = np.diag(_LOST)
        return replace(known, stream=known.stream.broken(), axes=axes, P=P)

    def _along_normal(self, known: KalmanKnowledge, ready: range) -> KalmanKnowledge:
        """Fit the normal axis, and once it is known let it tell the tangential one what it may be like."""
        normal = known.normal.learned(known.stream.window, ready, math.sqrt(self._tuning.force))
        x, P = known.x, known.P
        if normal.known and not known.normal.known:
            believed = prior_information(self.options.prior, normal.values)
            mean, variance = believed.mean(), np.diag(believed.covariance())
            for j in (LOG_K2, LOG_B2):
                gain = P[:, j] / (P[j, j] + variance[j])
                x = x + gain[:UNKNOWNS] * (mean[j] - x[j])
                P = P - np.outer(gain, P[j])
        return replace(known, x=x, P=P, normal=normal)
