"""Samples that may be used: a NaN that enters a filter or an energy would stay there for good."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def all_finite(values: NDArray[np.float64]) -> bool:
    """Whether no number is NaN or infinite; allocates nothing."""
    for i in range(values.size):  # noqa: SIM110 - all() of a generator does not compile
        if not math.isfinite(values[i]):
            return False
    return True
