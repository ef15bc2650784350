"""Signals that a recording does not have, computed from those it has."""

import numba
import numpy as np

from mmt_drake.numeric.arrays import Array

WIDEST = 0.010
"""Half-width of the widest window of ``rate_of`` [s]: at 5 Hz it takes 1 % off the rate, at 10 Hz 4 %."""

_FEWEST = 2
_THROUGH = 3

HOW = (
    f"derived by a parabola fitted over {WIDEST * 1e3:g} ms each way or less, "
    f"or where noise is too small to matter by the polynomial through {_THROUGH} samples each way"
)
"""The method of ``rate_of``, for notes."""


def rate_of(time: Array, values: Array) -> Array:
    """Time derivative by a local polynomial, on an even or uneven clock.

    Two kinds of polynomial around each sample give the slope there:

    - the parabola of least squares through every sample within a window (two on each side at
      least), as of Savitzky and Golay. Half-widths of 10 ms, 5 ms and so on down to two samples are tried.
    - the polynomial of degree six through the sample and three on each side.

    Both look both ways, so there is no lag; at the ends they make do with the samples there are, the second with
    the seven nearest. Each column takes the one that predicts its samples best when each is left out of its
    own fit: a wide window for noisy data, a narrow one for data that are fast, the
    polynomial through the samples for data without noise.

    For white noise of deviation s on an even clock with step h and 2 M + 1 samples the slope of the parabola has
    the deviation s sqrt(3 / (M (M + 1) (2 M + 1))) / h: 0.036 s / h for M = 10 (10 ms at
    1 kHz), against 0.71 s / h for central differences. It multiplies the rate of a sine of
    angular frequency w by about 1 - (w M h)^2 / 10. The polynomial through the samples multiplies it by
    1 - (w h)^6 / 140: 4e-10 off at 10 Hz and 1 kHz.

    Args:
        time: (n,) [s], strictly increasing, n >= 3.
        values: (n,) or (n, k), any unit.

    Returns:
        The derivative, shaped like ``values``, per second.
    """
    return motion_of(time, values)[1]


def motion_of(time: Array, values: Array) -> tuple[Array, Array]:
    """Values and their rate by the same polynomials: what a noisy column says of a motion, and the rate of that.

    Values as they were recorded are not the integral of a derived rate: a path through both goes back and forth from
    sample to sample, and laws that count way add that up.

    Args:
        time, values: as of `rate_of`.

    Returns:
        What the polynomial of `rate_of` is at each sample, and its slope there, each shaped like ``values``.
    """
    clock = np.ascontiguousarray(time, dtype=np.float64)
    table = np.ascontiguousarray(values.reshape(len(values), -1), dtype=np.float64)
    best_value, best_rate, least = table.copy(), np.empty_like(table), np.zeros(table.shape[1])
    _slopes_through(clock, table, best_rate, least)
    half_width, narrowest = WIDEST, _FEWEST * float(np.median(np.diff(clock)))
    value, rate = np.empty_like(table), np.empty_like(table)
    while True:
        errors = np.zeros(table.shape[1])
        _parabolas(clock, table, half_width, value, rate, errors)
        for column in np.flatnonzero(errors < least):
            best_value[:, column], best_rate[:, column] = value[:, column], rate[:, column]
            least[column] = errors[column]
        if half_width < narrowest:
            return best_value.reshape(values.shape), best_rate.reshape(values.shape)
        half_width /= 2.0


@numba.njit(cache=True, error_model="numpy")
def _slopes_through(time: Array, values: Array, rate: Array, errors: Array) -> None:
    """Slope at each sample of the polynomial through it and its neighbours; adds up as `_parabolas` does.

    With the barycentric weights w_j of the n samples, the slope at sample i is the sum over its neighbours of
    (w_j / w_i) (y_j - y_i) / (t_i - t_j); without the divisor the sum is, but for its sign, what
    the polynomial through the neighbours alone is off at sample i.
    """
    n, width = values.shape
    weights = np.empty(2 * _THROUGH + 1)
    count = min(n, len(weights))
    for i in range(n):
        low = min(max(0, i - _THROUGH), n - count)
        for j in range(count):
            weights[j] = 1.0
            for k in range(count):
                if low + k != i:
                    weights[j] *= time[i] - time[low + k]
                if k != j:
                    weights[j] /= time[low + j] - time[low + k]
        for column in range(width):
            slope = error = 0.0
            for j in range(low, low + count):
                if j != i:
                    part = weights[j - low] * (values[j, column] - values[i, column])
                    slope += part / (time[i] - time[j])
                    error += part
            rate[i, column] = slope
            errors[column] += error * error


@numba.njit(cache=True, error_model="numpy")
def _parabolas(time: Array, values: Array, half_width: float, value: Array, rate: Array, errors: Array) -> None:
    """Value and slope at each sample of the parabola around it; adds up the squared errors of prediction, by column.

    Times are scaled by the window to keep the sums of their powers even. A sample's error
    of prediction by a fit without it is its residual over 1 - h, h its own weight in the fit.
    """
    n, width = values.shape
    first = last = 0
    reach = half_width * (1.0 + 1e-9)
    for i in range(n):
        while time[i] - time[first] > reach:
            first += 1
        while last < n - 1 and time[last + 1] - time[i] <= reach:
            last += 1
        low = min(first, max(0, i - _FEWEST))
        high = max(last, min(n - 1, i + _FEWEST))
        scale = max(time[i] - time[low], time[high] - time[i])
        s0 = float(high - low + 1)
        s1 = s2 = s3 = s4 = 0.0
        for j in range(low, high + 1):
            t = (time[j] - time[i]) / scale
            s1 += t
            s2 += t * t
            s3 += t * t * t
            s4 += t * t * t * t
        # Normal equations of c0 + c1 t + c2 t^2 by Cramer's rule; m: minors of the first row.
        m0 = s2 * s4 - s3 * s3
        m1 = s1 * s4 - s2 * s3
        m2 = s1 * s3 - s2 * s2
        determinant = s0 * m0 - s1 * m1 + s2 * m2
        weight = m0 / determinant
        for column in range(width):
            y0 = y1 = y2 = 0.0
            for j in range(low, high + 1):
                t = (time[j] - time[i]) / scale
                y = values[j, column] - values[i, column]
                y0 += y
                y1 += y * t
                y2 += y * t * t
            slope = s0 * (y1 * s4 - s3 * y2) - y0 * m1 + s2 * (s1 * y2 - s2 * y1)
            rate[i, column] = slope / (determinant * scale)
            off = (y0 * m0 - s1 * (y1 * s4 - s3 * y2) + s2 * (y1 * s3 - s2 * y2)) / determinant
            value[i, column] = values[i, column] + off
            if s0 > 3.0:
                errors[column] += (off / (1.0 - weight)) ** 2


def touches(height: Array) -> Array:
    """Contact flag by the contract's definition: 1 where the probe tip is below z = 0.

    Args:
        height: (n,) z of the probe tip [m], table frame.
    """
    return (height < 0.0).astype(np.float64)
