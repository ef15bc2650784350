"""A low-pass without phase, the same for a measured signal and for a simulated one on a slower clock."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import fft, signal

from mmt_drake.errors import BadInput, check_number
from mmt_drake.numeric.arrays import Array

ATTENUATION_DB = 80.0
"""Of ripple in the pass band and what is left in the stop band: 1e-4, and 2e-4 at the very edges."""

_LONGEST_TRANSFORM = 2**17
"""Samples beyond which a signal is transformed in pieces."""


@dataclass(frozen=True)
class LowPass:
    """Linear-phase FIR low-pass by Kaiser's window, centred, so that nothing is shifted in time.

    The impulse response is one function of time, sampled at whatever rate the signal has, so a measured force at 1 kHz
    and a simulated one at 250 Hz pass the same filter: h(t) = sinc(2 fc t) w(t / L), fc halfway between the edges of
    pass band and stop band, w Kaiser's window (Kaiser 1974, "Nonrecursive digital filter design using the
    I0-sinh window function": beta and L from the attenuation and the width of the transition).

    Attributes:
        band_hz: upper edge of the pass band [Hz]; the stop band begins at twice that. Infinity: no filter.

    Raises:
        BadInput: a band that is not positive.
    """

    band_hz: float

    def __post_init__(self) -> None:
        if not self.is_identity:
            check_number("low-pass", "band_hz", self.band_hz, least=0.0, open_interval=True)

    @property
    def is_identity(self) -> bool:
        """True where it lets everything pass."""
        return math.isinf(self.band_hz)

    @property
    def half_length_s(self) -> float:
        """Reach of the filter to each side [s]."""
        return 0.0 if self.is_identity else (ATTENUATION_DB - 7.95) / (2.0 * 14.36 * self.band_hz)

    def kernel(self, rate_hz: float) -> Array:
        """The impulse response (2 M + 1,) at a rate, of sum 1.

        Raises:
            BadInput: the stop band does not begin below half the rate.
        """
        if self.is_identity:
            return np.ones(1)
        if 4.0 * self.band_hz > rate_hz:
            expected = f"at least {4 * self.band_hz:.4g}, 4 x the band"
            raise BadInput("low-pass", found=f"{rate_hz:.4g} samples/s", expected=expected)
        return _taps(self, rate_hz)

    def gain(self, frequency_hz: Array, rate_hz: float) -> Array:
        """Factor on a sine of each frequency (m,) [Hz]: real, for there is no phase."""
        taps = self.kernel(rate_hz)
        t = (np.arange(len(taps)) - len(taps) // 2) / rate_hz
        return np.cos(2.0 * np.pi * np.multiply.outer(frequency_hz, t)) @ taps

    def white_noise_gain(self, rate_hz: float) -> float:
        """Deviation of filtered white noise over that of the noise at this rate."""
        return float(np.linalg.norm(self.kernel(rate_hz)))

    def apply(self, values: Array, rate_hz: float, every: int = 1) -> Array:
        """Filter (n,) or (n, k) at a rate; the ends are mirrored, a linear operation like the filter itself.

        Args:
            values: the signal.
            rate_hz: its rate.
            every: keep the first of every so many samples; only those are computed.

        Raises:
            BadInput: a signal that is shorter than one half of the filter.
        """
        taps = self.kernel(rate_hz)
        reach = len(taps) // 2
        if len(values) <= reach:
            raise BadInput("low-pass", found=f"{len(values)} samples", expected=f"more than {reach}")
        table = values.reshape(len(values), -1)
        return convolved(mirrored(table, reach), taps)[::every].reshape(-1, *values.shape[1:])


@lru_cache(maxsize=64)
def _taps(low_pass: LowPass, rate_hz: float) -> Array:
    """Impulse response; the same few are asked for at every simulation of a search."""
    half = low_pass.half_length_s
    count = math.floor(half * rate_hz)
    t = np.arange(-count, count + 1) / rate_hz
    beta = 0.1102 * (ATTENUATION_DB - 8.7)
    window = np.i0(beta * np.sqrt(1.0 - (t / half) ** 2))
    taps = np.sinc(3.0 * low_pass.band_hz * t) * window
    taps /= taps.sum()
    taps.flags.writeable = False
    return taps


def mirrored(values: Array, reach: int) -> Array:
    """(n, k) with `reach` rows more at both ends, mirrored about the first and the last row."""
    return np.concatenate((values[reach:0:-1], values, values[-2 : -reach - 2 : -1]))


def convolved(padded: Array, taps: Array) -> Array:
    """Each column of (n + 2 M, k) with 2 M + 1 taps: the (n, k) that need nothing from beyond."""
    if len(taps) == 1:
        return padded * taps[0]
    if len(padded) > _LONGEST_TRANSFORM:
        long: Array = signal.oaconvolve(padded, taps[:, np.newaxis], mode="valid", axes=0)
        return long
    # Every simulation of a search passes here: at these lengths SciPy's choice of a method takes longer than the work.
    size = fft.next_fast_len(len(padded), real=True)
    spectrum = fft.rfft(padded, size, axis=0) * fft.rfft(taps, size)[:, np.newaxis]
    result: Array = fft.irfft(spectrum, size, axis=0)[len(taps) - 1 : len(padded)]
    return result
