"""Errors of a fit on blocks that it is taken not to have seen: on these explanations are compared.

No block is lost to the fit for it, and the blocks that are held out choose no name: what they show is reported.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from mmt_drake.diagnosis.fit.problem import Fitted, Problem
from mmt_drake.numeric.arrays import Array

_KNOWN_BEFORE = 1e-3
"""What counts as known of each number before, over what all blocks say of it: none is left to one block alone."""


def left_out(problem: Problem, fitted: Fitted) -> Array:
    """Residuals (n,) of the fitted samples, each block's as if the fit had not seen it.

    From the minimum by one Gauss-Newton step, as in the jackknife (Efron 1982, The Jackknife, the Bootstrap and Other
    Resampling Plans). A number at a bound stays there.

    Args:
        problem: what was fitted.
        fitted: the fit, its derivatives those of its end.
    """
    low, high, scale = fitted.hypothesis.limits(fitted.x)
    free = (fitted.x > low + 1e-9 * scale) & (fitted.x < high - 1e-9 * scale)
    jacobian, residual = fitted.minimum.jacobian[:, free], fitted.minimum.residual
    size = np.linalg.norm(jacobian, axis=0)
    jacobian = jacobian[:, size > 0.0] / size[size > 0.0]
    information, slope = jacobian.T @ jacobian, jacobian.T @ residual
    known = _KNOWN_BEFORE * np.eye(len(slope))
    result = residual.copy()
    numbers = problem.objective_blocks()
    for number in np.unique(numbers[:-1]):
        own = numbers == number
        J, r = jacobian[own], residual[own]
        step = np.linalg.solve(information - J.T @ J + known, J.T @ r - slope)
        result[own] += J @ step
    return result[:-1]  # the last is what is expected of the clocks, and no sample


def by_chance(numbers: NDArray[np.intp], worse: Array, better: Array) -> float:
    """Probability that chance alone makes one explanation look so much better than another that is as good.

    A one-sided t test of the paired differences of the squares. What chance does to their sum is taken from how the
    difference of the two happens to agree with what the better one leaves, block by block: within a block, and with
    the next one, residuals may depend on each other as they like. An effect that shows in few blocks only has as few
    degrees of freedom (Satterthwaite 1946, Biometrics Bulletin 2).

    Args:
        numbers: (n,) block of each sample.
        worse, better: (n,) residuals of both (`left_out`).
    """
    gain = float(worse @ worse - better @ better)
    if gain <= 0.0:
        return 1.0
    apart = np.bincount(numbers, (worse - better) ** 2)
    agreement = np.bincount(numbers, (worse - better) * better)
    squares = agreement**2
    variance = max(float(squares.sum()), float(squares.sum() + agreement[:-1] @ agreement[1:]))
    if variance == 0.0:
        return 0.0
    freedom = float(apart.sum()) ** 2 / float(apart @ apart)
    return float(stats.t.sf(gain / (2.0 * math.sqrt(variance)), freedom))
