"""Deviations of least squares whose residuals are not white, by bootstrap: they are behind every 95 % interval."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from mmt_drake.diagnosis.fit.hidden import hidden_variance
from mmt_drake.numeric.arrays import Array, Flags

CONFIDENCE = 0.95
_LEAST_FREEDOM = 3
_DRAWS = 1000
_RANK = 1e-12
_PART = 1e-6
"""Share of a direction that the residual does not tell, below which a number has no part in it."""


@dataclass(frozen=True)
class Deviations:
    """How well numbers found by least squares are known.

    Attributes:
        deviation: (k,) standard deviation of each number; infinite where no residual depends on it, or on nothing but
            a combination of it and others.
        strength: mean square of the residuals, where that is more than the noise that they are relative to; else 1.
        t: half of a 95 % interval over the deviation: Student's, for the number of blocks less one.
    """

    deviation: Array
    strength: float
    t: float

    @property
    def half_width(self) -> Array:
        """(k,) half of each 95 % interval."""
        return self.t * self.deviation


def deviations(
    jacobian: Array, residual: Array, blocks: NDArray[np.intp], samples: float, laws: Sequence[Array] = ()
) -> Deviations:
    """Deviations of numbers found by least squares.

    The larger of two counts: the one of least squares with the noise as strong as the residual is, and the one of a
    block bootstrap, which allows for residuals that are alike within a block. To that is added what laws may hide that
    are alike in all blocks (`hidden_variance`).

    Args:
        jacobian: (n, k) derivatives of the residual.
        residual: (n,) over its noise.
        blocks: (n,) number of the block that each belongs to; a prior is a block of its own, so that what it pulls the
            numbers away from the data counts as well.
        samples: how many independent samples of noise the residuals are worth.
        laws: (n, q) each, that nobody has named and that may be there as well.
    """
    size = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(size > 0.0, size, 1.0)
    count = jacobian.shape[1]
    strength = max(1.0, float(residual @ residual) / max(samples - count, 1.0))
    white = strength * np.diag(np.linalg.pinv(scaled.T @ scaled, rcond=_RANK))
    numbers = np.unique(blocks, return_inverse=True)[1]
    variance = np.maximum(white, _resampled(scaled, residual, numbers) ** 2)
    depends = _told(scaled) & (size > 0.0)
    if laws and depends.any():
        variance[depends] += hidden_variance(scaled[:, depends], residual, samples, laws)
    deviation = np.divide(np.sqrt(variance), size, out=np.full(count, np.inf), where=depends)
    t = float(stats.t.ppf(0.5 + CONFIDENCE / 2.0, max(int(numbers.max()), _LEAST_FREEDOM)))
    return Deviations(deviation, strength, t)


def _told(jacobian: Array) -> Flags:
    """(k,) numbers that the residual tells each for itself: of those it tells only together, pinv would make one up."""
    size, directions = np.linalg.eigh(jacobian.T @ jacobian)
    lost = directions[:, size <= _RANK * size.max(initial=0.0)]
    return np.asarray(np.sum(lost**2, axis=1) < _PART)


def _resampled(jacobian: Array, residual: Array, numbers: NDArray[np.intp]) -> Array:
    """(k,) how far the numbers scatter over data sets in which the blocks weigh differently.

    The Bayesian bootstrap (Rubin 1981, Annals of Statistics 9) with blocks as its units: exponential weights never
    leave a block out altogether, as drawing with replacement does, so what shows in one block alone keeps a value.
    Each data set is fitted by one Gauss-Newton step from the minimum.
    """
    units, count = int(numbers.max()) + 1, jacobian.shape[1]
    information, slopes = np.zeros((units, count, count)), np.zeros((units, count))
    for unit in range(units):
        own = numbers == unit
        information[unit] = jacobian[own].T @ jacobian[own]
        slopes[unit] = jacobian[own].T @ residual[own]
    weights = np.random.default_rng(0).standard_exponential((_DRAWS, units))
    inverse = np.linalg.pinv(np.tensordot(weights, information, 1), rcond=_RANK, hermitian=True)
    steps = -(inverse @ (weights @ slopes)[:, :, np.newaxis])[:, :, 0]
    # The normal deviation of the middle of the draws: few far ones, where much weight fell on one block, do not count.
    low, high = np.quantile(steps, stats.norm.cdf([-1.0, 1.0]), axis=0)
    # Exponential weights scatter by 1 / (units + 1); of the blocks' variance each number found takes one unit away.
    freedom = max(units - count, _LEAST_FREEDOM)
    return np.asarray(math.sqrt((units + 1) / freedom) * (high - low) / 2.0)
