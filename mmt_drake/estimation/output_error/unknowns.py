"""What a fit seeks, within which bounds, and what is known of it.

The unknowns are log m, k1, log k2, b1, log b2 and Fc, within bounds inside which every set is physical and stable.
Static friction, Fs - Fc and v_d of Karnopp's law, makes the force jump and is sought apart from them, by trial.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.model.parameters import THETA

Array = NDArray[np.float64]

# The unknowns, their bounds, their natural sizes, and how far the truth may lie from the prior.
LOG_M, K1_, LOG_K2, B1_, LOG_B2, FC_ = range(6)
UNKNOWNS = 6
LOW = np.array([math.log(0.02), 0.0, math.log(5.0), 0.0, math.log(0.1), 0.0])
HIGH = np.array([math.log(50.0), 1e4, math.log(5e4), 1e3, math.log(1e3), 50.0])
SIZE = np.array([0.3, 30.0, 0.3, 10.0, 0.3, 0.1])
PRIOR_DEVIATION = np.array([1.0, 150.0, 1.0, 40.0, 1.0, 1.0])
ISOTROPIC_DEVIATION = 0.5
"""Of log k2 and log b2 from those of the normal axis."""
NORMAL_DEVIATION = np.array([2000.0, 100.0])
"""Of normal k and b from their prior [N/m], [N s/m]."""


class Stick(NamedTuple):
    """Static friction beyond Coulomb's.

    Attributes:
        excess: Fs - Fc [N].
        speed: v_d [m/s].
    """

    excess: float = 0.0
    speed: float = 0.0


@dataclass(frozen=True)
class Information:
    """What a set of samples says of unknowns x, as the quadratic x' A x / 2 - b' x.

    Attributes:
        matrix: A (k, k).
        vector: b (k,).
    """

    matrix: Array
    vector: Array

    @classmethod
    def none(cls, size: int = UNKNOWNS) -> Self:
        """Nothing known."""
        return cls(np.zeros((size, size)), np.zeros(size))

    @classmethod
    def about(cls, mean: Array, deviation: Array) -> Self:
        """Independent beliefs."""
        weight = deviation**-2
        return cls(np.diag(weight), weight * mean)

    @classmethod
    def of(cls, jacobian: Array, residual: Array, x: Array) -> Self:
        """What residuals of unit variance say, linear about x."""
        return cls(jacobian.T @ jacobian, jacobian.T @ (jacobian @ x - residual))

    def plus(self, other: Information) -> Information:
        """Both."""
        return Information(self.matrix + other.matrix, self.vector + other.vector)

    def faded(self, share: float) -> Information:
        """What is left of it."""
        return Information(share * self.matrix, share * self.vector)

    def mean(self) -> Array:
        """The best x."""
        return np.asarray(np.linalg.solve(self.matrix, self.vector), dtype=np.float64)

    def covariance(self) -> Array:
        """Of x (k, k)."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)


def unknowns(theta: Array) -> Array:
    """The unknowns of m, k1, k2, b1, b2, Fc (the first of theta), within their bounds."""
    m, k1, k2, b1, b2, Fc = theta[:UNKNOWNS]
    return np.clip([math.log(m), k1, math.log(k2), b1, math.log(b2), Fc], LOW, HIGH)


def theta_of(x: Array, stick: Stick, normal: Array) -> Array:
    """theta in the order of `mmt_drake.model.parameters.THETA`; `normal` is k and b of the normal axis."""
    theta = np.empty(len(THETA))
    write_unknowns(x, stick.excess, stick.speed, theta)
    theta[UNKNOWNS:8] = normal
    return theta


@njit(cache=True)
def write_unknowns(x: Array, excess: float, speed: float, theta: Array) -> None:
    """`theta_of` for compiled code: everything but the normal axis, into theta (10,)."""
    theta[0], theta[1], theta[2] = math.exp(x[LOG_M]), x[K1_], math.exp(x[LOG_K2])
    theta[3], theta[4], theta[5] = x[B1_], math.exp(x[LOG_B2]), x[FC_]
    theta[8], theta[9] = x[FC_] + excess, speed


def derivatives(theta: Array) -> Array:
    """d theta / d x of the first six, (6,)."""
    m, _, k2, _, b2, _ = theta[:UNKNOWNS]
    return np.array([m, 1.0, k2, 1.0, b2, 1.0])


def prior_information(prior: Prior, normal: Array | None) -> Information:
    """What is believed of the unknowns beforehand; `normal` is k and b of the normal axis where they are known."""
    x = unknowns(np.array([prior.m, prior.k1, prior.k2, prior.b1, prior.b2, prior.Fc]))
    deviation = PRIOR_DEVIATION.copy()
    if normal is not None:
        x[LOG_K2] = np.clip(math.log(max(normal[0], 1e-9)), LOW[LOG_K2], HIGH[LOG_K2])
        x[LOG_B2] = np.clip(math.log(max(normal[1], 1e-9)), LOW[LOG_B2], HIGH[LOG_B2])
        deviation[[LOG_K2, LOG_B2]] = ISOTROPIC_DEVIATION
    return Information.about(x, deviation)
