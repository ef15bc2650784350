"""The band in which model and recording are compared."""

import math
from itertools import pairwise

import numpy as np
from scipy import signal

from mmt_drake.numeric.arrays import Array

_POWER_SHARE = 0.99
_LONGEST_SEGMENT_S = 20.0
_FEWEST_SEGMENT = 64
_BLOCK = 1.5  # upper over lower edge of the blocks in which a spectrum is averaged
_ABOVE_NOISE = 2.0  # times the noise: the least that a block with motion has
_LINE = 20.0  # times the median of its block: a line

NARROWEST, WIDEST = 4.0, 12.0
"""The band over the top excitation: never narrower than the first, never wider than the second."""

_NOISE_SHARE = 3e-4


def motion_spectrum(values: Array, rate_hz: float, noise_density: float) -> tuple[Array, Array]:
    """Frequencies [Hz] and power spectral density of the rate of (n,), without that of its noise.

    Above its peak the rate's spectrum falls until the noise of the position, differentiated, lets it rise again. The
    position's density where it is least is taken for the noise below; above, only lines count as motion.

    Args:
        values: position.
        rate_hz: its rate.
        noise_density: the least that is noise [unit^2/Hz].
    """
    segment = min(len(values), max(_FEWEST_SEGMENT, min(len(values) // 2, round(_LONGEST_SEGMENT_S * rate_hz))))
    frequency, density = signal.welch(values, rate_hz, window="nuttall", nperseg=segment, detrend="linear")
    omega = 2.0 * np.pi * frequency
    edges = np.unique(np.round(_BLOCK ** np.arange(np.log(len(frequency)) / np.log(_BLOCK))).astype(int))
    edges = np.append(edges[edges < len(frequency)], len(frequency))
    blocks = [slice(first, last) for first, last in pairwise(edges)]
    rates = np.array([np.mean(omega[block] ** 2 * density[block]) for block in blocks])
    medians = np.array([np.median(density[block]) for block in blocks])
    peak = int(np.argmax(rates))
    least = peak + int(np.argmin(rates[peak:]))
    floor = np.full(len(frequency), max(noise_density, float(medians[least])))
    for k, block in enumerate(blocks):
        if k >= least:
            floor[block] = np.maximum(floor[block], _LINE * medians[k])
        if np.mean(density[block]) < _ABOVE_NOISE * noise_density:
            floor[block] = np.inf
    return frequency, omega**2 * np.maximum(density - floor, 0.0)


def top_excitation(values: Array, rate_hz: float, noise_density: float) -> tuple[float, float]:
    """The frequency [Hz] below which 99 % of the power of the rate of (n,) lies, and the rate's RMS.

    Both are 0 for a signal that does not stand out of its noise.
    """
    frequency, density = motion_spectrum(values, rate_hz, noise_density)
    power = np.cumsum(density)
    if power[-1] <= 0.0:
        return 0.0, 0.0
    top = float(frequency[np.searchsorted(power, _POWER_SHARE * power[-1])])
    return top, math.sqrt(power[-1] * (frequency[1] - frequency[0]))


def rate_noise(position_density: float, velocity_density: float, band_hz: float) -> float:
    """Deviation of the rate that position and velocity of these noise densities (one-sided) give below a band.

    The least that any unbiased estimate has: the integral of w^2 / (1/S_p + w^2/S_u). An
    infinite velocity density stands for no velocity, none for one without noise.
    """
    if velocity_density == 0.0:
        return 0.0
    if math.isinf(velocity_density) or position_density == 0.0:
        return 2.0 * math.pi * math.sqrt(position_density * band_hz**3 / 3.0)
    corner = math.sqrt(velocity_density / position_density) / (2.0 * math.pi)
    return math.sqrt(max(0.0, velocity_density * (band_hz - corner * math.atan(band_hz / corner))))


def comparison_band(top_hz: float, rate_rms: float, position_density: float, velocity_density: float) -> float:
    """Four times the top excitation [Hz]; up to twelve times as long as the noise of the rate stays negligible.

    Negligible is 3e-4 of the rate's RMS: a stiff friction law has harmonics, and where they cost nothing they count.
    """
    factor = WIDEST
    while factor > NARROWEST:
        if rate_noise(position_density, velocity_density, 1.5 * factor * top_hz) <= _NOISE_SHARE * rate_rms:
            return factor * top_hz
        factor -= 1.0
    return NARROWEST * top_hz
