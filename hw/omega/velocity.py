"""The hand's velocity from its positions: the slope at the latest of them of a parabola through those of a short time.

A mean over 10 ms, as the vendor's, is late by half of that: the velocity of a hand is 11 % wrong at 3.6 Hz and 31 % at
10 Hz. The parabola over 10 ms is 0.5 and 4 % off there; steps of 10 um in position leave 1 mm/s in it (0.4 mm/s in the
mean). It is no greater than it may be: what it amplifies at high frequencies a damper that is felt turns into force.
Beside a hand and a handle of 0.4 kg, two ticks behind, a damper sings from 100 N s/m on, with the mean from 118, with a
cubic over 20 ms, which is better at 3.6 Hz (0.1 %) and twice as great at 60 Hz, from 60.

Least squares on orthogonal polynomials (Forsythe 1957, J. SIAM 5), at the times that readings have. Each degree adds a
share of its own to the noise of the slope, so one that the readings cannot bear, after a gap say, is left out.
"""

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array

WINDOW_S = 0.010
"""For so long before the latest, readings count."""
MOST_READINGS = 128
"""That are looked at, the latest of them."""
MOST_APART = 0.3
"""From the vendor's velocity [m/s]: 60 m/s^2 explain that, for it is 5 ms late; more is a jump of the position."""
MOST_NOISE = 600.0
"""Greatest noise of the slope over that of a position [1/s]; 350 at 1 kHz, 430 at 500 Hz."""
_DEGREE, _AXES = 2, 3
_ALONG, _B, _A, _COUNT = range(-4, 0)  # rows behind those of the readings: room for sums, so that nothing is allocated


def velocity_memory() -> Array:
    """(MOST_READINGS + 4, 4) time [s] and position [m] of each reading, oldest first; their count in the last row."""
    return np.zeros((MOST_READINGS + 4, 1 + _AXES))


@njit(cache=True)
def take_position(memory: Array, t: float, motion: Array) -> None:
    """Remember a position, and put the velocity there beside it.

    Where the readings of the window cannot tell it, two of them close together, the velocity stays as it is.

    Args:
        memory: of `velocity_memory`.
        t: of the reading [s].
        motion: (6,) position [m], finite, and velocity [m/s], which is written.
    """
    n = int(memory[_COUNT, 0])
    first = 0
    while first < n and (memory[first, 0] < t - WINDOW_S - 1e-9 or n - first >= MOST_READINGS):
        first += 1
    if n > first and memory[n - 1, 0] >= t:  # a clock that stands still: the later reading counts
        n -= 1
    n -= first
    for i in range(n):
        for k in range(1 + _AXES):
            memory[i, k] = memory[first + i, k]
    memory[n, 0] = t
    for k in range(_AXES):
        memory[n, 1 + k] = motion[k]
    n += 1
    memory[_COUNT, 0] = n
    _slope_at_end(memory, n, motion[_AXES:])


@njit(cache=True)
def keep_near(motion: Array, reported: Array) -> None:
    """Keep the reported velocity where another one is further from it than `MOST_APART`.

    Args:
        motion, reported: (6,) position [m] and velocity [m/s]; the velocity of the first may be changed.
    """
    apart = False
    for k in range(_AXES, 2 * _AXES):
        apart = apart or abs(motion[k] - reported[k]) > MOST_APART
    for k in range(_AXES, 2 * _AXES):
        motion[k] = reported[k] if apart else motion[k]


@njit(cache=True)
def _slope_at_end(memory: Array, n: int, out: Array) -> None:
    """Write the slope (3,) of the parabola through n readings at the last of them; of a line through fewer."""
    end = memory[n - 1, 0]
    norm_before, noise = 1.0, 0.0
    value, slope, value_before, slope_before = 1.0, 0.0, 0.0, 0.0  # at the end, of this polynomial and the one before
    along, b, a = memory[_ALONG], memory[_B], memory[_A]  # the latter of the recurrence p' = (t - a) p - b p_before
    for degree in range(min(_DEGREE, n - 1) + 1):
        norm, mean = 0.0, 0.0
        along[:_AXES] = 0.0
        for i in range(n):
            t, p, before = memory[i, 0] - end, 1.0, 0.0
            for j in range(degree):
                p, before = (t - a[j]) * p - b[j] * before, p
            norm += p * p
            mean += t * p * p
            for k in range(_AXES):
                along[k] += p * (memory[i, 1 + k] - memory[n - 1, 1 + k])
        noise += slope * slope / norm
        if noise > MOST_NOISE * MOST_NOISE:
            return
        if degree == 1:
            out[:_AXES] = 0.0
        for k in range(_AXES):
            out[k] += along[k] / norm * slope
        a[degree], b[degree] = mean / norm, 0.0 if degree == 0 else norm / norm_before
        further = -a[degree] * value - b[degree] * value_before
        further_slope = value - a[degree] * slope - b[degree] * slope_before
        value_before, slope_before, value, slope = value, slope, further, further_slope
        norm_before = norm
