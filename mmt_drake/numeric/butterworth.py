"""A bank of Butterworth low-pass filters that steps many signals at once, compiled.

Sections of second order in direct form II transposed; step by step the arithmetic of `scipy.signal.sosfilt`.
"""

import numpy as np
import scipy.signal
from numba import njit

from mmt_drake.numeric.arrays import Array


def butterworth(order: int, cutoff_hz: float, step: float) -> Array:
    """Sections (n, 6: b0 b1 b2 a0 a1 a2) of the digital Butterworth low-pass; `step` is the sample time [s]."""
    return np.ascontiguousarray(scipy.signal.butter(order, cutoff_hz, fs=1.0 / step, output="sos"))


def rest_state(sos: Array) -> Array:
    """State (n, 2) of each section after an input that has been 1 for ever."""
    return np.ascontiguousarray(scipy.signal.sosfilt_zi(sos))


@njit(cache=True)
def set_at_rest(rest: Array, values: Array, state: Array) -> None:
    """Put the bank into the state that constant inputs `values` (signals) leave; `state` is (sections, 2, signals)."""
    for n in range(rest.shape[0]):
        for i in range(values.size):
            state[n, 0, i] = rest[n, 0] * values[i]
            state[n, 1, i] = rest[n, 1] * values[i]


@njit(cache=True)
def lowpass(sos: Array, values: Array, state: Array) -> None:
    """Filter one sample of every signal: `values` (signals) and `state` (sections, 2, signals) are changed in place."""
    for n in range(sos.shape[0]):
        b0, b1, b2, a1, a2 = sos[n, 0], sos[n, 1], sos[n, 2], sos[n, 4], sos[n, 5]
        for i in range(values.size):
            x = values[i]
            y = b0 * x + state[n, 0, i]
            state[n, 0, i] = b1 * x - a1 * y + state[n, 1, i]
            state[n, 1, i] = b2 * x - a2 * y
            values[i] = y
