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
    return left_out_linear(problem, fitted.minimum.jacobian[:, free], fitted.minimum.residual)


def left_out_linear(problem: Problem, jacobian: Array, residual: Array) -> Array:
    """The same from the derivatives (n + 1, q) of an objective (n + 1,) at its minimum, its last row that of clocks."""
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


def by_chance(numbers: NDArray[np.intp], worse: Array, better: Array, noise: float = 1.0) -> float:
    """Probability that chance alone makes one explanation look so much better than another that is as good.

    The better of two tests, times two (Bonferroni). One asks for a gain in all: it sees a great one in few blocks. The
    other asks for a gain in every block, in proportion: where one transient leaves more than all the rest together,
    sums are that transient alone, and this one still counts the rest. Within a block, and with the next one, residuals
    may depend on each other as they like in both.

    Args:
        numbers: (n,) block of each sample.
        worse, better: (n,) residuals of both (`left_out`).
        noise: mean square of noise alone.
    """
    if not worse @ worse > better @ better:
        return 1.0
    return min(1.0, 2.0 * min(_in_all(numbers, worse, better), _in_every_block(numbers, worse, better, noise)))


def in_most_blocks(numbers: NDArray[np.intp], one: Array, other: Array, noise: float = 1.0) -> float:
    """Probability that chance alone makes one explanation the better one in so many more blocks than the other.

    A sign test of the blocks in which one leaves less than half as much as the other, or more than twice as much. A
    body that sticks once more or less than it did leaves more in that block than all others together, however right
    its law is in these.

    Args:
        numbers, noise: as for `by_chance`.
        one, other: (n,) residuals of both.
    """
    counts = np.bincount(numbers)
    mine, theirs = (np.bincount(numbers, r**2) + noise * counts for r in (one, other))
    won, lost = int(np.count_nonzero(2.0 * mine < theirs)), int(np.count_nonzero(mine > 2.0 * theirs))
    return float(stats.binom.sf(won - 1, won + lost, 0.5))


def jointly(*chances: float) -> float:
    """Probability of independent tests together (Fisher 1932, Statistical Methods for Research Workers, 21.1)."""
    return float(stats.combine_pvalues(chances, "fisher").pvalue)


def gained_by_chance(problem: Problem, before: Fitted, after: Fitted) -> float:
    """`by_chance` of two fits of a problem, their derivatives those of their ends."""
    numbers = problem.blocks()
    worse, better = left_out(problem, before), left_out(problem, after)
    return by_chance(numbers, worse, better, problem.samples() / len(numbers))


def _in_all(numbers: NDArray[np.intp], worse: Array, better: Array) -> float:
    """One-sided t test of the sum of the differences of the squares.

    What chance does to it is taken from how the difference of the two happens to agree with what the better one
    leaves, block by block. An effect that shows in few blocks only has as few degrees of freedom (Satterthwaite 1946,
    Biometrics Bulletin 2).
    """
    apart = np.bincount(numbers, (worse - better) ** 2)
    agreement = np.bincount(numbers, (worse - better) * better)
    squares = agreement**2
    variance = max(float(squares.sum()), float(squares.sum() + agreement[:-1] @ agreement[1:]))
    if variance == 0.0:
        return 0.0
    freedom = float(apart.sum()) ** 2 / float(apart @ apart)
    gain = float(worse @ worse - better @ better)
    return float(stats.t.sf(gain / (2.0 * math.sqrt(variance)), freedom))


def _in_every_block(numbers: NDArray[np.intp], worse: Array, better: Array, noise: float) -> float:
    """One-sided t test of the mean of the logarithm of the ratio of the sums of squares of each block.

    To both sums what noise leaves in that block is added: of two that leave less, neither is the better one.
    """
    counts = np.bincount(numbers)
    one, other = (np.bincount(numbers, r**2) + noise * counts for r in (worse, better))
    filled = counts > 0
    count = int(np.count_nonzero(filled))
    ratio = np.log(one[filled] / other[filled])
    off = np.zeros(len(counts))
    off[filled] = ratio - ratio.mean()
    variance = float(off @ off) + 2.0 * max(float(off[:-1] @ off[1:]), 0.0)
    if count < 2 or variance == 0.0:
        return 1.0
    return float(stats.t.sf(ratio.mean() / math.sqrt(variance / (count * (count - 1))), count - 1))
