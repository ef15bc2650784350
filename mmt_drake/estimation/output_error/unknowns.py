"""The unknowns of a fit: their bounds, and what is known of them.

The unknowns are those of `TABLE`: the object's, in the order of theta, and then how late its force is measured.
Static friction, Fs - Fc and v_d of Karnopp's law, makes the force jump and is sought apart from them, by trial.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from mmt_drake.estimation.output_error.lateness import LONGEST_S
from mmt_drake.estimation.output_error.options import Prior
from mmt_drake.numeric.arrays import Array, Flags


class Unknown(NamedTuple):
    """How a number is sought.

    Attributes:
        low, high: bounds, in the number's unit; within those of all of them every set is physical and stable.
        size: natural one of the number, or of its logarithm.
        deviation: how far the truth may lie from the prior, likewise.
        log: its logarithm is sought.
    """

    low: float
    high: float
    size: float
    deviation: float
    log: bool = False


TABLE = {
    "m": Unknown(0.02, 50.0, 0.3, 1.0, log=True),
    "k1": Unknown(0.0, 1e4, 30.0, 150.0),
    "k2": Unknown(5.0, 5e4, 0.3, 1.0, log=True),
    "b1": Unknown(0.0, 1e3, 10.0, 40.0),
    "b2": Unknown(0.1, 1e3, 0.3, 1.0, log=True),
    "Fc": Unknown(0.0, 50.0, 0.1, 1.0),
    "lateness": Unknown(0.0, LONGEST_S, 0.002, 0.005),
    "lag_share": Unknown(0.0, 1.0, 0.3, 0.3),
}
UNKNOWNS = len(TABLE)
OBJECT, LATENESS = slice(0, UNKNOWNS - 2), slice(UNKNOWNS - 2, UNKNOWNS)
"""Where the numbers of the object stand, and those of the force sensor."""
PUNCTUAL = 0.0, 0.5
"""The latter where the force is not late, and believed beforehand."""
FRICTION, MATERIAL = list(TABLE).index("Fc"), [list(TABLE).index(symbol) for symbol in ("k2", "b2")]
"""Where Fc stands, and where what the normal axis tells, of an object that is one material."""
_LOW, _HIGH, SIZE, _DEVIATION = (np.array(column) for column in list(zip(*TABLE.values(), strict=True))[:4])
LOG: Flags = np.array([unknown.log for unknown in TABLE.values()])


def _sought(numbers: Iterable[float]) -> Array:
    return np.array([math.log(number) if log else number for number, log in zip(numbers, LOG, strict=True)])


LOW, HIGH = _sought(_LOW), _sought(_HIGH)
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

    @classmethod
    def of(cls, theta: Array) -> Self:
        """That of theta (10,)."""
        *_, Fc, _, _, Fs, v_d = theta.tolist()
        return cls(max(Fs - Fc, 0.0), v_d)


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

    def only(self, part: slice) -> Information:
        """What is known of some unknowns whatever the others are; nothing of those."""
        covariance = self.covariance()[part, part]
        found = Information.none(len(self.vector))
        found.matrix[part, part] = np.linalg.inv(covariance)
        found.vector[part] = found.matrix[part, part] @ self.mean()[part]
        return found

    def mean(self) -> Array:
        """The best x."""
        return np.asarray(np.linalg.solve(self.matrix, self.vector), dtype=np.float64)

    def covariance(self) -> Array:
        """Of x (k, k)."""
        return np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)


def unknowns(theta: Array) -> Array:
    """The unknowns of m, k1, k2, b1, b2, Fc (the first of theta), within their bounds; the force is not late."""
    return np.clip(_sought([*theta[OBJECT], *PUNCTUAL]), LOW, HIGH)


def theta_of(x: Array, stick: Stick, normal: Array) -> Array:
    """theta in the order of `mmt_drake.model.parameters.THETA`; `normal` is k and b of the normal axis."""
    own = [math.exp(number) if log else number for number, log in zip(x[OBJECT], LOG[OBJECT], strict=True)]
    return np.array([*own, *normal, x[FRICTION] + stick.excess, stick.speed])


def derivatives(theta: Array) -> Array:
    """d theta / d x of the object's unknowns, (6,)."""
    return np.where(LOG[OBJECT], theta[OBJECT], 1.0)


def prior_information(prior: Prior, normal: Array | None) -> Information:
    """What is believed of the unknowns beforehand; `normal` is k and b of the normal axis where they are known."""
    believed, deviation = np.array([getattr(prior, symbol) for symbol in [*TABLE][OBJECT]]), _DEVIATION.copy()
    if normal is not None:
        believed[MATERIAL], deviation[MATERIAL] = np.maximum(normal, 1e-9), ISOTROPIC_DEVIATION
    return Information.about(unknowns(believed), deviation)
