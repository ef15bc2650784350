"""What may be said: the rules that turn fits into a verdict. A wrong name is worse than none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.fit.comparison import RULED_OUT
from mmt_drake.diagnosis.fit.problem import Fitted, Problem

NO_MISMATCH = 0.5
"""A nominal model is right if what it leaves beyond the noise is below this part of the sensor's own noise."""
NOTHING_LEFT = 0.35
"""A fit explains everything if what it leaves beyond the noise is below this part of the sensor's own noise."""
NEARLY_ALL = 0.98
"""Real systems never come down to the sensor's noise. There an effect is named if it explains this share of the
mismatch's variance, on held-out data too ..."""
FAR_BEHIND = 3.0
"""... and every other explanation leaves at least this many times as much variance."""
ALL_BUT_NOTHING = 0.999
"""From this share on, explanations that come nearer than that are rivals: it is one of them, or all but one ..."""
NEAR = 1.5
"""... if they leave at most this many times as much variance."""
GAIN = 0.35
"""An effect is worth naming if it removes a mismatch of at least this part of the sensor's own noise."""
WORTH_ONE_MORE = 4.0
"""... and one more effect only if without it at least this many times as much variance is left."""
SIGNIFICANT = 0.01


@dataclass(frozen=True)
class Standard:
    """What the residuals of a problem are held against.

    Attributes:
        problem: what was fitted.
        sensor: the sensor's own noise over the noise within the band, the mean of all tracks.
    """

    problem: Problem
    sensor: float

    @classmethod
    def of(cls, problem: Problem) -> Standard:
        """The standard of a problem."""
        ratios = []
        for track in problem.tracks:
            s = track.smoothed
            gain = s.low_pass.white_noise_gain(s.clock.rate_hz)
            ratios.append(max(float(s.output_noise[track.column]) / gain / track.floor, 1.0))
        return cls(problem, float(np.mean(ratios)))

    def excess(self, ratio: float) -> float:
        """What is left beyond the noise, over the sensor's own noise, for an RMS of so many noise floors."""
        return math.sqrt(max(ratio**2 - 1.0, 0.0)) / self.sensor

    def left(self, fitted: Fitted) -> float:
        """What a fit leaves beyond the noise, over the sensor's own noise: the worse of fitted and held-out data."""
        fit = math.sqrt(fitted.cost / self.problem.samples())
        return max(self.excess(fit), self.excess(self.heldout(fitted)))

    def heldout(self, fitted: Fitted) -> float:
        """RMS of the residual over the noise floor on held-out data."""
        return self.problem.ratio(fitted.model, fitted.skew, heldout=True)

    def score(self, fitted: Fitted, best_cost: float) -> float:
        """-2 ln(likelihood) with the noise as strong as the best fit's residual, plus ln(samples) a free number."""
        samples = self.problem.samples()
        strength = max(1.0, best_cost / samples)
        return fitted.cost / strength + len(fitted.x) * math.log(samples)


def ranked(standard: Standard, levels: Sequence[Sequence[Fitted]]) -> list[Fitted]:
    """All candidates by their score, best first."""
    every = [fitted for level in levels for fitted in level]
    if not every:
        return []
    best_cost = min(fitted.cost for fitted in every)
    return sorted(every, key=lambda fitted: standard.score(fitted, best_cost))


def simplest(standard: Standard, ranked: Sequence[Fitted]) -> Fitted:
    """The best candidate, or the best of those with fewer effects if more effects would not be worth naming.

    Where the best leaves something, held-out data choose among those that come near to it: none of them is the truth.
    Of laws in the same place, the one with fewer numbers if it predicts held-out data as well: a law with more of them
    mostly holds it as a special case.

    Args:
        standard: what residuals are held against.
        ranked: candidates, best first; there is one.
    """
    best = ranked[0]
    if standard.left(best) > NOTHING_LEFT:
        best = min((f for f in ranked if f.cost <= NEAR * best.cost), key=standard.left)
    for other in ranked:
        fewer = len(other.hypothesis.effects) < len(best.hypothesis.effects)
        limit = max(NOTHING_LEFT, math.sqrt(WORTH_ONE_MORE) * standard.left(best))
        if fewer and standard.left(other) <= limit:
            best = other
    for other in ranked:
        if len(other.x) < len(best.x) and _holds(best, other):
            if standard.left(best) <= NOTHING_LEFT:
                as_good = standard.left(other) <= NOTHING_LEFT and standard.heldout(other) <= standard.heldout(best)
            else:
                as_good = standard.left(other) ** 2 <= NEAR * standard.left(best) ** 2
            best = other if as_good else best
    return best


def _holds(best: Fitted, other: Fitted) -> bool:
    """Whether the laws in which another fit differs are simpler ones in the same places."""
    one, two = best.hypothesis.effects, other.hypothesis.effects
    own = [e for e in one if e.name not in other.hypothesis.key]
    simpler = [e for e in two if e.name not in best.hypothesis.key]
    return len(own) == len(simpler) and all(any(s.is_simpler_than(e) for e in own) for s in simpler)


def rivals(standard: Standard, best: Fitted, others: Sequence[Fitted]) -> list[Fitted]:
    """Other explanations, no more complicated, that the data do not rule out."""
    limit = standard.score(best, best.cost) + RULED_OUT
    by_share = not _is_alone(standard, best, others)
    return [
        other
        for other in others
        if other is not best
        and len(other.x) <= len(best.x)
        and (standard.score(other, best.cost) < limit or (by_share and other.cost <= NEAR * best.cost))
        and not best.hypothesis.key < other.hypothesis.key
    ]


def explains(standard: Standard, refit: Fitted, best: Fitted, others: Sequence[Fitted]) -> bool:
    """Whether a candidate explains the mismatch.

    Nothing is left; or nearly all is gone and nothing else comes near; or all but nothing is gone (`rivals` then says
    what else comes near).
    """
    if standard.left(best) <= NOTHING_LEFT:
        return True
    before, after = (max(standard.heldout(f) ** 2 - 1.0, 0.0) for f in (refit, best))
    gone = 1.0 - max(after / max(before, 1e-300), best.cost / refit.cost)
    return gone >= ALL_BUT_NOTHING or (gone >= NEARLY_ALL and _is_alone(standard, best, others))


def _is_alone(standard: Standard, best: Fitted, others: Sequence[Fitted]) -> bool:
    """Whether nothing is left, or explanations with nothing in common with this one leave much more."""
    if standard.left(best) <= NOTHING_LEFT:
        return True
    apart = [o for o in others if not o.hypothesis.key & best.hypothesis.key and len(o.x) <= len(best.x) + 1]
    return all(other.cost >= FAR_BEHIND * best.cost for other in apart)


def without_physics(nominal_left: float, refit_left: float) -> Verdict | None:
    """The verdict where no physics need be missing; None where some is."""
    if nominal_left <= NO_MISMATCH:
        return "no_mismatch"
    return "parameters" if refit_left <= NOTHING_LEFT else None
