"""What a law that nobody has named may hide in numbers found by least squares, where no resampling sees it.

A law beside the model, such as a drag with |v|^1.5 beside a damper b v, is the same in every block. Most of it may be
taken on by a number; the blocks agree on it, and only what is left shows. That tells how strong the law is, if it is
known how such laws vary, and with it how far it may have moved the number.
"""

from collections.abc import Sequence

import numpy as np

from mmt_drake.numeric.arrays import Array

_RANK = 1e-6
_TURNS, _SETTLED = 300, 1e-4


def hidden_variance(jacobian: Array, residual: Array, samples: float, laws: Sequence[Array]) -> Array:
    """Variance (k,) of each number from laws of unknown shape and strength.

    A law is a Gaussian process in what it depends on, as the discrepancy of a model is in Kennedy and O'Hagan 2001
    (Journal of the Royal Statistical Society B 63); that a bias hides in the numbers unless it is allowed for is shown
    by Brynjarsdottir and O'Hagan 2014 (Inverse Problems 30). With r = J dx + sum_s G_s a_s + noise, a_s ~ N(0, v_s I),
    least squares are off by -J+ G_s a_s, of variance v_s times the row sums of squares of J+ G_s. The strengths v_s are
    taken for known (`law_strengths`): where few coefficients show, the variance is known no better than they are few.

    Args:
        jacobian: (n, k) derivatives of the residual, none of them 0 throughout.
        residual: (n,) at the minimum, over its noise.
        samples: how many independent samples of noise the residual is worth.
        laws: (n, q) each: what a law does to the residual, by its coefficients of variance 1.
    """
    strengths = law_strengths(jacobian, residual, samples, laws)
    inverse = np.linalg.pinv(jacobian, rcond=_RANK)
    return np.sum([v * np.sum((inverse @ law) ** 2, axis=1) for v, law in zip(strengths, laws, strict=True)], axis=0)


def law_strengths(jacobian: Array, residual: Array, samples: float, laws: Sequence[Array]) -> Array:
    """Variances (s,) of the coefficients of laws, the likeliest given what least squares leave.

    Of the restricted likelihood (Patterson and Thompson 1971, Biometrika 58), in which only what no number takes on
    counts. Laws compete with each other and with noise, whose variance is 1 at least. By minorisation and maximisation
    (Zhou, Hu, Zhou and Lange 2019, Journal of Computational and Graphical Statistics 28), from equal shares.

    Args:
        jacobian, residual, samples, laws: as in `hidden_variance`.
    """
    basis, size, _ = np.linalg.svd(jacobian, full_matrices=False)
    basis = basis[:, size > _RANK * size[0]]
    left = residual - basis @ (basis.T @ residual)
    seen = [law - basis @ (basis.T @ law) for law in laws]
    span, size, _ = np.linalg.svd(np.hstack(seen), full_matrices=False)
    span = span[:, size > _RANK * size[0]]
    own, shapes = span.T @ left, [span.T @ law for law in seen]
    rest = max(float(left @ left - own @ own), 0.0)
    freedom = max(samples - basis.shape[1] - len(own), 1.0)
    noise = max(rest / freedom, 1.0)
    squares = [max(float(np.sum(shape**2)), 1e-300) for shape in shapes]
    strengths = np.array([float(own @ own) / (len(shapes) * square) for square in squares])
    covariances = [shape @ shape.T for shape in shapes]
    for _ in range(_TURNS):
        whole = noise * np.eye(len(own)) + np.tensordot(strengths, covariances, 1)
        inverse = np.linalg.inv(whole)
        weighted = inverse @ own
        before = strengths
        agreement = np.array([weighted @ c @ weighted for c in covariances])
        expected = np.array([max(float(np.sum(inverse * c)), 1e-300) for c in covariances])
        strengths = strengths * np.sqrt(agreement / expected)
        told = (float(weighted @ weighted) + rest / noise**2) / (float(np.trace(inverse)) + freedom / noise)
        noise = max(noise * np.sqrt(told), 1.0)
        if np.all(np.abs(strengths - before) * squares <= _SETTLED * (noise + before * squares)):
            break
    return strengths
