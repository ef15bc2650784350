"""Lateness of the measured force against the motion: a first-order low pass and a delay, as sensors and drivers have.

A force that comes late looks like that of another object: with 4 ms m is too large and b2 too small. So the simulated
force is made as late as the fit believes before it is compared.
"""

import math

from numba import njit

from mmt_drake.numeric.arrays import Array

LONGEST_S = 0.05
"""Of the delay and the time constant of the low pass together [s]."""


@njit(cache=True, error_model="numpy", nogil=True)
def late_means(signal: Array, step: float, parts: int, lateness: Array, found: Array) -> None:
    """Means over the ticks about each sample, of signals behind a low pass and a delay.

    A sample is a mean over ticks, and so is its force: where friction stops the body, the force jumps within a sample.
    The low pass takes its input as linear from tick to tick, a delay falls on the cubic through four ticks (Catmull and
    Rom). Before its beginning a signal stood where it begins.

    Args:
        signal: (k, (n - 1) parts + 1) at ticks.
        step: between ticks [s].
        parts: ticks from the middle of one sample to that of the next, an odd number.
        lateness: (2,) delay and time constant of the low pass together [s], and the latter's share, 0 to 1.
        found: (k, n) to be filled with the means; the first and the last sample have half the ticks.
    """
    delay, lag = lateness[0] * (1.0 - lateness[1]), lateness[0] * lateness[1]
    whole, half, count, ticks = int(delay / step), parts // 2, found.shape[1], signal.shape[1]
    u = delay / step - whole
    next_, here = -0.5 * u * (1.0 - u) * (1.0 - u), 1.0 + u * u * (1.5 * u - 2.5)
    before, first = 0.5 * u * (1.0 + u * (4.0 - 3.0 * u)), 0.5 * u * u * (u - 1.0)
    kept = math.exp(-step / lag)
    ramp = lag / step * (1.0 - kept)
    for i in range(len(signal)):
        found[i] = 0.0
        last = signal[i, 0]
        a, b, c, d = last, last, last, last  # of the filtered signal, the newest first
        for tick in range(ticks):
            value = signal[i, min(max(tick - whole + 1, 0), ticks - 1)]
            d, c, b = c, b, a
            a = kept * a + (ramp - kept) * last + (1.0 - ramp) * value
            last = value
            sample = (tick + half) // parts
            found[i, sample] += next_ * a + here * b + before * c + first * d
        for sample in range(count):
            found[i, sample] /= parts if 0 < sample < count - 1 else half + 1
