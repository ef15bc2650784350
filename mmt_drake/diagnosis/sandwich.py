"""How far least squares may be off where its residuals are not white: the deviations behind every 95 % interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]

CONFIDENCE = 0.95
_LEAST_FREEDOM = 3


@dataclass(frozen=True)
class Deviations:
    """How well numbers found by least squares are known.

    Attributes:
        deviation: (k,) standard deviation of each number; infinite where no residual depends on it.
        strength: mean square of the residuals, where that is more than the noise that they are relative to; else 1.
        t: half of a 95 % interval over the deviation: Student's, for the number of blocks less that of the numbers.
    """

    deviation: Array
    strength: float
    t: float

    @property
    def half_width(self) -> Array:
        """(k,) half of each 95 % interval."""
        return self.t * self.deviation


def deviations(jacobian: Array, residual: Array, blocks: NDArray[np.intp], samples: float) -> Deviations:
    """Deviations of numbers found by least squares.

    The larger of two counts: the one of least squares with the noise as strong as the residual is, and the sandwich
    estimate with blocks as independent units (Liang and Zeger 1986, Biometrika 73), which allows for residuals that are
    alike within a block.

    Args:
        jacobian: (n, k) derivatives of the residual.
        residual: (n,) over its noise.
        blocks: (n,) number of the block that each belongs to; a prior is a block of its own, so that what it pulls the
            numbers away from the data counts as well.
        samples: how many independent samples of noise the residuals are worth.
    """
    size = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(size > 0.0, size, 1.0)
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-12)
    count = jacobian.shape[1]
    strength = max(1.0, float(residual @ residual) / max(samples - count, 1.0))
    scores = np.zeros((int(blocks.max()) + 1, count))
    np.add.at(scores, blocks, scaled * residual[:, np.newaxis])
    used = len(np.unique(blocks))
    robust = np.diag(inverse @ (scores.T @ scores) @ inverse) * used / max(used - 1, 1)
    variance = np.maximum(strength * np.diag(inverse), robust)
    deviation = np.divide(np.sqrt(variance), size, out=np.full(count, np.inf), where=size > 0.0)
    t = float(stats.t.ppf(0.5 + CONFIDENCE / 2.0, max(used - count, _LEAST_FREEDOM)))
    return Deviations(deviation, strength, t)
