"""The rules that turn fits into a verdict. A wrong name is worse than none."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mmt_drake.diagnosis.decide.budget import NAMELESS as NAMELESS_PART
from mmt_drake.diagnosis.decide.budget import NO_EFFECTS, NOISE, SHARED, BudgetPart
from mmt_drake.diagnosis.decide.verdict import Verdict
from mmt_drake.diagnosis.fit.problem import Fitted, Problem

NO_MISMATCH = 0.5
"""A nominal model is right if what it leaves beyond the noise is below this part of the sensor's own noise."""
NOTHING_LEFT = 0.35
"""A fit explains everything if what it leaves beyond the noise is below this part of the sensor's own noise."""
COLOURED = 1.0
"""Where it follows nothing, noise that is not white may leave so much of right equations beyond the floor."""
GAIN = 0.35
"""An effect is worth naming if it removes a mismatch of at least this part of the sensor's own noise ..."""
MOST_OF_IT = 0.5
"""... or at least this part of what a refit leaves, where that is something and the effect leaves nothing."""
NAMELESS = 0.02
"""Effects explain everything if nobody has named at most this share of the nominal model's mean squared error ..."""
WHOLE, REMAINS = 0.9, 5.0
"""... and they take this part off what a refit leaves beyond the noise: beside a first model that was far off all is
next to nothing. So are wrong numbers the whole answer only where they leave no more than so many times the noise."""
NAMED, OF_REFIT = 0.2, 0.5
"""Effects explain a part of it if they have this share, or take this part off what a refit leaves ..."""
LEAST = 0.3
"""... and this at least: a share that other numbers would have taken as well is none."""
MOST_BESIDE_THE_UNSURE = 0.25
"""Effects of different blocks that may stand for one another are no answer if they leave more than this part of what
they take: each may be no more than the law that comes nearest to one outside the library."""
SIGNIFICANT = 0.01
"""Of what is named, on blocks that no choice has seen."""


@dataclass(frozen=True)
class NoiseReference:
    """What the residuals of a problem are held against.

    Attributes:
        problem: what was fitted.
        sensor: axis -> the sensor's own noise over the noise within the band, the mean of its tracks.
    """

    problem: Problem
    sensor: Mapping[str, float]

    @classmethod
    def of(cls, problem: Problem) -> NoiseReference:
        """The standard of a problem."""
        ratios: dict[str, list[float]] = {}
        for track in problem.tracks:
            s = track.smoothed
            gain = s.low_pass.white_noise_gain(s.clock.rate_hz)
            own = max(float(s.output_noise[track.column]) / gain / track.floor, 1.0)
            ratios.setdefault(track.axis, []).append(own)
        return cls(problem, {axis: float(np.mean(some)) for axis, some in ratios.items()})

    def excess(self, ratios: Mapping[str, float]) -> dict[str, float]:
        """What is left beyond the noise, over the sensor's own noise, for an RMS of so many noise floors; by axis."""
        return {axis: math.sqrt(max(ratio**2 - 1.0, 0.0)) / self.sensor[axis] for axis, ratio in ratios.items()}

    def left(self, fitted: Fitted) -> float:
        """What a fit leaves beyond the noise, over the sensor's own noise: the worst of its axes.

        Of each the worse of fitted and held-out data.
        """
        seen = self.excess(self.problem.ratios(fitted.minimum.residual))
        return max(*seen.values(), *self._unforeseen(fitted).values())

    def gain(self, before: Fitted, after: Fitted) -> float:
        """By how much less a fit leaves than one before it, of the axis that it helps most, on held-out data."""
        known = self._unforeseen(after)
        return max(excess - known[axis] for axis, excess in self._unforeseen(before).items())

    def _unforeseen(self, fitted: Fitted) -> dict[str, float]:
        """`excess` on held-out data."""
        residual = self.problem.residual(fitted.model, fitted.skew, heldout=True, coarse=1.0)
        return self.excess(self.problem.ratios(residual, heldout=True))

    def heldout(self, fitted: Fitted) -> float:
        """RMS of the residual over the noise floor on held-out data."""
        return self.problem.ratio(fitted.model, fitted.skew, heldout=True)


def ranked(problem: Problem, fits: Sequence[Fitted]) -> list[Fitted]:
    """Fits of a problem, best first.

    By -2 ln(likelihood), with the noise as strong as what the best one leaves, plus ln(samples) a free number.
    """
    samples = problem.samples()
    strength = max(1.0, min((f.cost for f in fits), default=0.0) / samples)
    return sorted(fits, key=lambda f: f.cost / strength + len(f.x) * math.log(samples))


def without_physics(nominal_left: float, refit_left: float) -> Verdict | None:
    """The verdict where no physics need be missing; None where some is."""
    if nominal_left <= NO_MISMATCH:
        return "no_mismatch"
    return "parameters" if refit_left <= NOTHING_LEFT else None


def without_names(
    shares: Sequence[BudgetPart], nominal_left: float, refit_left: float, changed: bool, late: bool = False
) -> Verdict:
    """The verdict where no effect of the library explains what a refit leaves by more than chance, nor a table does.

    Noise of sensors is seldom white, so that a right model leaves more than the floor. What follows no signal, and is
    next to nothing of the error or no more than the noise itself, is no reason to doubt the structure.

    Args:
        shares: the budget of what predicts better, the refit or what was handed in.
        nominal_left, refit_left: what either leaves, see `NoiseReference.left`.
        changed: whether the refit predicts better, and its numbers are others than those handed in.
        late: whether touches show that force and position share no clock. Then what is left is no colour of the noise.
    """
    least = min(nominal_left, refit_left)
    if late and least > COLOURED:
        return "unexplained"
    if least > REMAINS or (least > COLOURED and _share(shares, NAMELESS_PART) > NAMELESS):
        return "unexplained"
    gain = nominal_left**2 - refit_left**2
    if changed and gain > NO_MISMATCH**2:
        return "parameters"
    return "no_mismatch" if gain <= COLOURED**2 else "unexplained"


def is_worth_naming(gain: float, refit_left: float, left: float) -> bool:
    """Whether effects take enough off what a refit leaves.

    Args:
        gain: by how much less they leave on held-out data, see `NoiseReference.gain`.
        refit_left, left: what the refit and what the fit with them leaves, see `NoiseReference.left`.
    """
    return gain >= GAIN or (left <= NOTHING_LEFT < refit_left and gain >= MOST_OF_IT * refit_left)


def with_physics(left: float, shares: Sequence[BudgetPart], of_refit: float) -> Verdict:
    """The verdict on effects that are all more or less certain.

    Args:
        left: what the delivered model leaves, see `NoiseReference.left`.
        shares: its budget.
        of_refit: what part the effects take off what a refit leaves beyond the noise, on held-out data.
    """
    nameless, noise, named = _share(shares, NAMELESS_PART), _share(shares, NOISE), _named(shares)
    # Noise that counts in the budget may hide a rest of its size: within the band, where it is small, that would stand.
    is_all = nameless <= NAMELESS and of_refit >= WHOLE and (noise <= NAMELESS or left <= REMAINS)
    if left <= NOTHING_LEFT or is_all:
        return "missing_physics"
    is_part = (named >= NAMED and of_refit >= LEAST) or of_refit >= OF_REFIT
    return "partly_explained" if is_part else "unexplained"


def leaves_much(shares: Sequence[BudgetPart], of_refit: float) -> bool:
    """Whether effects that may stand for one another leave much of what they take, of the budget or of a refit's rest.

    Args:
        shares: the budget.
        of_refit: as for `with_physics`.
    """
    nameless, taken = _share(shares, NAMELESS_PART), _named(shares) + _share(shares, SHARED)
    return nameless > MOST_BESIDE_THE_UNSURE * taken or leaves_much_of(of_refit)


def leaves_much_of(of_refit: float) -> bool:
    """Whether effects leave much of what a refit does, beside what they take: no law is then surer than its family."""
    return 1.0 - of_refit > MOST_BESIDE_THE_UNSURE * of_refit


def _named(shares: Sequence[BudgetPart]) -> float:
    return math.fsum(part.share for part in shares if part.part not in NO_EFFECTS)


def _share(shares: Sequence[BudgetPart], name: str) -> float:
    return next(part.share for part in shares if part.part == name)
