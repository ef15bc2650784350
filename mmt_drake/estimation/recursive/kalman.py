"""What the Kalman filter knows, and how new samples change it.

A filter is linear about where it is. From a prior that is far off the first samples would make it sure of something
wrong, so it takes them for far noisier than they are, and less so as it foretells them better. Nor can it find static
friction, by which the force jumps. So rivals run beside it for a while, on the same samples, with other static friction
and, while much is unexplained, one that is as unsure as in the beginning. One that foretells the force better takes its
place (a bank of filters: Magill 1965; here a few at a time).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.fit import other_stick, rest
from mmt_drake.estimation.output_error.learn import at_rest
from mmt_drake.estimation.output_error.normal import NormalAxis
from mmt_drake.estimation.output_error.unknowns import (
    FC_,
    LOG_B2,
    LOG_K2,
    UNKNOWNS,
    derivatives,
    prior_information,
    theta_of,
)
from mmt_drake.estimation.output_error.window import Window
from mmt_drake.estimation.recursive.belief import Belief
from mmt_drake.estimation.recursive.kalman_step import Tuning
from mmt_drake.estimation.recursive.options import KalmanOptions
from mmt_drake.estimation.recursive.samples import samples_of
from mmt_drake.estimation.recursive.stream import Stream, short_bank
from mmt_drake.model.held_body import NOT_TOLD

Array = NDArray[np.float64]

_FOLLOW_S = 0.15  # in which the noise follows the innovations
_GAP = (1e-7, 1e-4)  # variances that a body gains for each sample of a gap [m^2], [m^2/s^2]
_FIRST_NOISE = 1.0  # [N] that the first samples are taken for
_RIVALS_AFTER_S, _TRIAL_S = 1.0, 1.0  # of contact: before the first rivals, for each
_GAIN = 10.0  # of log likelihood, for a rival to be believed
_DOUBT = 2.0  # a rival with other static friction is so many times less sure
_REOPENED = 0.5  # of the prior's deviations: how unsure the rival is that begins anew
_UNEXPLAINED = 4.0  # times the variance that is known of: then there is one


@dataclass(frozen=True)
class KalmanKnowledge:
    """All that is known after some samples; never changed.

    Attributes:
        stream: the samples at hand.
        belief: the filter that is believed.
        rivals: others beside it.
        tried: how many there were.
        contact: samples in contact, and of them those since the rivals began.
        normal: the normal axis.
    """

    stream: Stream
    belief: Belief
    normal: NormalAxis
    rivals: tuple[Belief, ...] = ()
    tried: int = 0
    contact: tuple[int, int] = field(default=(0, 0))

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    @property
    def theta(self) -> Array:
        """What is handed over, in the order of `mmt_drake.model.parameters.THETA`."""
        return theta_of(self.belief.x, self.belief.stick, self.normal.values)

    @property
    def deviation(self) -> Array:
        """Standard deviations of theta; of static friction the grid on which it is sought."""
        stick, variance = self.belief.stick, np.diag(self.belief.P)[:UNKNOWNS]
        own = derivatives(self.theta) * np.sqrt(np.maximum(variance, 0.0))
        return np.array([*own, *self.normal.deviation, math.hypot(own[FC_], 0.25 * stick.excess), 0.25 * stick.speed])

    @property
    def held(self) -> Array:
        """Where friction holds the body is not told."""
        return NOT_TOLD


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
        belief = Belief.of(known.mean(), known.covariance(), rest())
        belief = replace(belief, scale=max(1.0, _FIRST_NOISE**2 / self._tuning.force))
        return KalmanKnowledge(Stream.empty(), belief, NormalAxis.believed(self.options.prior))

    def learned(self, known: KalmanKnowledge, new: Array, broken: bool = False) -> KalmanKnowledge:
        """Knowledge with new samples (k, SAMPLE_SIZE); `broken`: time broke off before them."""
        if broken and len(known.stream.window):
            known = replace(known, stream=known.stream.broken(), belief=known.belief.lost(), rivals=())
        if len(new) == 0:
            return known
        if len(known.stream.window) == 0 and not known.stream.interrupted:
            known = replace(known, belief=replace(known.belief, axes=at_rest(new[0])))
        stream = known.stream.extended(new, self.h, self._bank)
        ready = stream.ready(self._bank)
        span = max(ready.start, 1), ready.stop
        known = replace(known, stream=replace(stream, done=ready.stop))
        if span[0] >= span[1]:
            return known
        known = self._along_normal(known, ready)
        samples = samples_of(stream.window, self.h)
        belief = known.belief.after(samples, span, self._tuning)
        rivals = (rival.after(samples, span, self._tuning) for rival in known.rivals)
        touching = int(np.count_nonzero(stream.window.weight[span[0] : span[1], :2].any(axis=1)))
        known = replace(
            known,
            belief=known.belief.lost() if belief is None else belief,
            rivals=tuple(rival for rival in rivals if rival is not None),
            contact=(known.contact[0] + touching, known.contact[1] + touching),
        )
        return self._challenged(known)

    def compile(self) -> None:
        """Compile what learning calls."""
        self.beginning().belief.after(samples_of(Window.empty(), self.h), (0, 0), self._tuning)

    def _challenged(self, known: KalmanKnowledge) -> KalmanKnowledge:
        """Once rivals have had their time the best is believed, if it is better by enough, and others begin."""
        total, since = (count * self.h for count in known.contact)
        if self.options.rivals == 0 or total < _RIVALS_AFTER_S or (known.rivals and since < _TRIAL_S):
            return known
        belief = known.belief
        best = min(known.rivals, key=lambda rival: rival.unlikely, default=belief)
        if best.unlikely < belief.unlikely - _GAIN:
            belief = best
        anew, rivals, tried = replace(belief, unlikely=0.0), [], known.tried
        if anew.scale > _UNEXPLAINED:
            prior = prior_information(self.options.prior, known.normal.values if known.normal.known else None)
            rivals.append(anew.reopened(_REOPENED**2 * prior.covariance()))
        seen = {anew.stick}
        while len(rivals) < self.options.rivals:
            stick = other_stick(anew.stick, float(anew.x[FC_]), tried)
            tried += 1
            if stick not in seen:
                rivals.append(replace(anew.doubting(_DOUBT), stick=stick))
                seen.add(stick)
        return replace(known, belief=anew, rivals=tuple(rivals), tried=tried, contact=(known.contact[0], 0))

    def _along_normal(self, known: KalmanKnowledge, ready: range) -> KalmanKnowledge:
        """Fit the normal axis, and once it is known let it tell the tangential one what it may be like."""
        normal = known.normal.learned(known.stream.window, ready, math.sqrt(self._tuning.force))
        belief = known.belief
        if normal.known and not known.normal.known:
            believed = prior_information(self.options.prior, normal.values)
            mean, variance = believed.mean(), np.diag(believed.covariance())
            for j in (LOG_K2, LOG_B2):
                belief = belief.told(j, float(mean[j]), float(variance[j]))
        return replace(known, belief=belief, normal=normal)
