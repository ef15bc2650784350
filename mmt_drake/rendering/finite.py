"""Samples that may be used: a NaN that enters a filter or an energy would stay there for good; none may reach a hand.

A renderer that is given something that is not finite holds its last force for `HOLD_S`, as over a lost packet, so that
one bad sample is not felt as a kick; if nothing better comes, it lets go within `LET_GO_S` more, since a force that
nobody measures must not stand. It says so by the status `NOT_FINITE`.
"""

import math
from typing import Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

HOLD_S: Final = 0.02
"""Time after the last sample that could be used for which a force is held [s]."""
LET_GO_S: Final = 0.1
"""Time in which it then goes to zero, evenly [s]."""


@njit(cache=True)
def all_finite(values: NDArray[np.float64]) -> bool:
    """True where no number is NaN or infinite; allocates nothing."""
    for i in range(values.size):  # noqa: SIM110 - all() of a generator does not compile
        if not math.isfinite(values[i]):
            return False
    return True


@njit(cache=True)
def share_held(age: float) -> float:
    """Share of the last force that is rendered so long [s] after the last sample that could be used."""
    return min(1.0, max(0.0, 1.0 - (age - HOLD_S) / LET_GO_S))
