"""Finding a time in a table of increasing times, within compiled code."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True)
def row_before(t: float, table: NDArray[np.float64]) -> int:
    """Index i with table[i, 0] <= t < table[i + 1, 0], for t within the table; the last pair of rows at its end.

    Evenly spaced times are met by the first guess; others take a bisection.
    """
    low, high = 0, table.shape[0] - 1
    guess = min(int((t - table[0, 0]) / (table[high, 0] - table[0, 0]) * high), high - 1)
    if table[guess, 0] <= t < table[guess + 1, 0]:
        return guess
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= t:
            low = middle
        else:
            high = middle
    return low
