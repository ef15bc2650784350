"""Touches whose instant is not certain, and what of a force they may have made.

Contact begins where the probe crosses the surface, and that is seen to some tenths of a millimetre. Where it is higher,
the probe touched it sooner, and the contact spring is anchored where the probe was then: until the contact ends the
force is another one. Taken as it is seen, that became a mass that is too small and a lateness that is not there, both
told as sure. The force along the normal tells where the surface is (`along_normal`), and what that leaves unsure is a
part of the noise: one number, the height of the surface, for each contact.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.numeric.arrays import Array

LONGEST_S = 0.05
"""By which a touch is believed to have been at another time at most [s]."""
_STILL = 1e-9  # [m/s]


@njit(cache=True, error_model="numpy")
def since_touch(higher: float, rate: float) -> float:
    """How long ago [s] the surface was touched that is `higher` [m] than it is seen; `rate` of the probe's z [m/s]."""
    return math.copysign(min(abs(higher) / max(abs(rate), _STILL), LONGEST_S), higher)


def begins_and_ends(contact: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First sample of each contact, and first after it; `contact` (n,) of 0 and 1."""
    turns = np.diff(contact, prepend=0.0, append=0.0)
    return np.flatnonzero(turns > 0.0), np.flatnonzero(turns < 0.0)


@dataclass(frozen=True)
class UnsureTouches:
    """What a surface that is elsewhere by its deviation changes in a difference of forces (2 n,), over the noise.

    Attributes:
        contacts: of each contact that begins within the window: indices of its samples, along x and then along y, and
            what may be changed there.
    """

    contacts: tuple[tuple[NDArray[np.intp], Array], ...] = ()

    @classmethod
    def of(cls, contact: Array, changed: Array) -> Self:
        """Contact by contact, each of which has a height of its own: the contact spring begins anew.

        Args:
            contact: (n,) 0 or 1.
            changed: (2 n,) by all touches together.
        """
        return cls(tuple((where, changed[where]) for where in _begun(contact) if changed[where].any()))

    def taken_from(self, difference: Array) -> Array:
        """A difference over the noise (2 n,), as far as touches need not have made it.

        With u what they may have made, its covariance is I + u u'; this is multiplied by the inverse root of that.
        """
        left = difference.copy()
        for where, made in self.contacts:
            square = float(made @ made)
            left[where] -= (1.0 - 1.0 / math.sqrt(1.0 + square)) / square * float(made @ left[where]) * made
        return left


def _begun(contact: Array) -> Iterator[NDArray[np.intp]]:
    """Samples of each contact that begins here, along x and then along y."""
    n = len(contact)
    for begin, end in zip(*begins_and_ends(contact), strict=True):
        if begin > 0:
            yield np.r_[begin:end, n + begin : n + end]
