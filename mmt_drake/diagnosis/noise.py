"""How much noise a recorded signal carries, and of what colour."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from mmt_drake.analysis.signals import stretches

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_SEGMENT = 1024  # samples: bins of 1 Hz at 1 kHz
_BLOCKS = 8  # parts of the upper half of the spectrum, the quietest of which counts
_TOP = 0.48  # of the rate: what lies above is the anti-aliasing filter's
_FEWEST = 128  # samples, for a spectrum
_RMS_OF_THIRD_DIFFERENCE = math.sqrt(20.0)  # 1, -3, 3, -1
WHITE_DB = 3.0


@dataclass(frozen=True)
class Noise:
    """The noise of one channel, as sampled.

    Attributes:
        std: its deviation, white at the sensor or not [unit of the signal].
        density: one-sided power spectral density just above the band of the motion [unit^2/Hz].
        colour_db: density there over the density at high frequencies [dB]; 0 for white noise, None where the
            signal is too short or fills the spectrum.
        source: `free space` or `high frequencies`.
    """

    std: float
    density: float
    colour_db: float | None
    source: str

    @property
    def is_white(self) -> bool:
        """Whether nothing speaks against white noise."""
        return self.colour_db is None or abs(self.colour_db) < WHITE_DB

    def white_std(self, rate_hz: float) -> float:
        """Deviation of the white noise at this rate that has the same density in the band."""
        return math.sqrt(self.density * rate_hz / 2.0)

    def after(self, white_gain: float, rate_hz: float) -> float:
        """Deviation after a low-pass that multiplies white noise at `rate_hz` by `white_gain`."""
        return self.white_std(rate_hz) * white_gain


def spectrum(values: Array, rate_hz: float, segment: int = _SEGMENT) -> tuple[Array, Array]:
    """Frequencies (m,) [Hz] and one-sided power spectral density (m,) of (n,), a median over segments.

    Nuttall's window, because the motion stands 100 dB above the noise of its sensor; the median, because jumps at
    touch fill the whole spectrum of the few segments that hold one.
    """
    length = min(segment, len(values))
    frequency, density = signal.welch(
        values, rate_hz, window="nuttall", nperseg=length, detrend="linear", average="median"
    )
    return frequency, density


def noise_of(values: Array, rate_hz: float) -> NoiseSpectrum:
    """The spectrum of a signal (n,) on an even clock, to read its noise off."""
    if len(values) < _FEWEST:
        # White noise through a third difference; what is left of a slow motion only adds.
        std = float(np.std(np.diff(values, 3))) / _RMS_OF_THIRD_DIFFERENCE if len(values) > 3 else 0.0
        return NoiseSpectrum(np.empty(0), np.empty(0), rate_hz, 1.0, 2.0 * std**2 / rate_hz)
    frequency, density = spectrum(values, rate_hz)
    averaged = 2.0 * len(values) / min(_SEGMENT, len(values)) - 1.0
    upper = (frequency >= rate_hz / 4.0) & (frequency <= _TOP * rate_hz)
    high = min(_typical(block, averaged) for block in np.array_split(density[upper], _BLOCKS))
    return NoiseSpectrum(frequency, density, rate_hz, averaged, high)


@dataclass(frozen=True)
class NoiseSpectrum:
    """The spectrum of a signal, of which the frequencies that its motion does not reach are its noise.

    Attributes:
        frequency, density: (m,) [Hz], [unit^2/Hz]; empty where the signal is too short for a spectrum.
        rate_hz: of the signal.
        averaged: segments in the median.
        high: density in the quietest eighth of the upper half of the spectrum [unit^2/Hz].
    """

    frequency: Array
    density: Array
    rate_hz: float
    averaged: float
    high: float

    def above(self, band_hz: float = math.inf) -> Noise:
        """The noise of a signal whose motion stays below a band.

        The density counts from twice to four times the band; without a band, or where that does not fit
        below half the rate, high frequencies stand for it.
        """
        rate = self.rate_hz
        just_above = (self.frequency >= 2.0 * band_hz) & (self.frequency <= 4.0 * band_hz)
        if just_above.sum() < _BLOCKS or 4.0 * band_hz > _TOP * rate:
            return Noise(math.sqrt(self.high * rate / 2.0), self.high, None, "high frequencies")
        near = _typical(self.density[just_above], self.averaged)
        colour = 10.0 * math.log10(near / self.high) if near > 0.0 and self.high > 0.0 else None
        if colour is not None and abs(colour) < WHITE_DB:
            upper = (self.frequency >= rate / 4.0) & (self.frequency <= _TOP * rate)
            white = _typical(self.density[upper], self.averaged)
            return Noise(math.sqrt(white * rate / 2.0), white, colour, "high frequencies")
        step = self.frequency[1] - self.frequency[0]
        power = 2.0 * band_hz * near + step * float(self.density[self.frequency > 2.0 * band_hz].sum())
        return Noise(math.sqrt(power), near, colour, "high frequencies")


def _typical(density: Array, averaged: float) -> float:
    """The median over frequencies, which leaves out lines, as an estimate of the mean.

    Each bin is a median of `averaged` half-overlapping segments, near enough a chi-squared number of as many degrees.
    """
    freedom = max(2.0, averaged)
    return float(np.median(density)) * freedom / float(stats.chi2.median(freedom))


@dataclass(frozen=True)
class Rest:
    """What a force sensor shows where nothing touches it.

    Attributes:
        mean: its bias [N], (k,).
        standard_error: of the bias, colour taken into account [N], (k,).
        std: of the noise [N], (k,).
        density: one-sided power spectral density of the noise below the band [N^2/Hz], (k,).
        colour_db: that density over the one of the upper half of the spectrum [dB], (k,).
        seconds: how much free space there was.
    """

    mean: Array
    standard_error: Array
    std: Array
    density: Array
    colour_db: Array
    seconds: float

    def noise(self, axis: int) -> Noise:
        """The noise of one axis."""
        return Noise(float(self.std[axis]), float(self.density[axis]), float(self.colour_db[axis]), source="free space")


def at_rest(values: Array, rate_hz: float, free: Flags, band_hz: float = math.inf, least_s: float = 0.2) -> Rest | None:
    """Bias and noise of forces (n, k) in free space, or None where there is too little of it.

    The standard error comes from means over blocks of 0.1 s, which are nearly independent whatever
    the colour above 10 Hz (the method of batch means); deviation and densities from each stretch about its own line.

    Args:
        values: [N], on an even clock.
        rate_hz: of that clock.
        free: (n,) where the probe is surely off the object.
        band_hz: below which the density counts.
        least_s: shorter stretches do not count [s].
    """
    block = max(1, round(0.1 * rate_hz))
    parts = [
        values[first : last + 1] for first, last in stretches(free) if last - first + 1 >= max(least_s * rate_hz, 16)
    ]
    if not parts:
        return None
    left = [signal.detrend(part, axis=0) for part in parts]
    lengths = np.array([len(part) for part in parts])
    std = np.sqrt(sum((part**2).sum(axis=0) for part in left) / (lengths - 2).sum())
    means = np.concatenate(
        [part[: len(part) // block * block].reshape(-1, block, values.shape[1]).mean(axis=1) for part in parts]
    )
    error = np.std(means, axis=0, ddof=1) / math.sqrt(len(means)) if len(means) > 1 else np.full(len(std), np.inf)
    segment = min(256, int(lengths.min()))
    pieces = [signal.welch(part, rate_hz, nperseg=segment, detrend="linear", axis=0) for part in left]
    frequency = pieces[0][0]
    density = np.average([piece[1] for piece in pieces], axis=0, weights=lengths)
    upper = (frequency >= rate_hz / 4.0) & (frequency <= _TOP * rate_hz)
    low = (frequency <= min(band_hz, rate_hz / 4.0)) & (frequency >= frequency[min(2, len(frequency) - 1)])
    high = density[upper].mean(axis=0)
    below = density[low].mean(axis=0) if low.any() else high
    ratio = np.divide(below, high, out=np.ones_like(high), where=(high > 0.0) & (below > 0.0))
    return Rest(
        np.average([part.mean(axis=0) for part in parts], axis=0, weights=lengths),
        error,
        std,
        below,
        10.0 * np.log10(ratio),
        float(lengths.sum()) / rate_hz,
    )
