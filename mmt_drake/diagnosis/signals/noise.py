"""Noise of a recorded signal: how much, and of what colour."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import fft, signal, stats

from mmt_drake.numeric.arrays import Array

_SEGMENT = 1024  # samples: bins of 1 Hz at 1 kHz
_BLOCKS = 8  # parts of the upper half of the spectrum, the quietest of which counts
TOP = 0.48  # of the rate: what lies above is the anti-aliasing filter's
_FEWEST = 128  # samples, for a spectrum
_BRIEF = 32  # samples of a segment that a jump now and then leaves alone
_JUMPS_DB = 6.0  # that high frequencies lose between jumps, where jumps fill the spectrum
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

    def white_std(self, rate_hz: float) -> float:
        """Deviation of the white noise at this rate that has the same density in the band."""
        return math.sqrt(self.density * rate_hz / 2.0)


def spectrum(values: Array, rate_hz: float, segment: int = _SEGMENT) -> tuple[Array, Array]:
    """Frequencies (m,) [Hz] and one-sided power spectral density (m,) of (n,), a median over segments.

    Nuttall's window, because the motion stands 100 dB above the noise of its sensor; the median, because jumps at
    touch fill the whole spectrum of the few segments that hold one.
    """
    length = min(segment, len(values))
    # As `scipy.signal.welch`, which takes half a second for the brief segments of a recording, one at a time.
    parts = sliding_window_view(values, length)[:: length - length // 2]
    window = signal.get_window("nuttall", length)
    parts = parts - parts[:, :1]  # to the last bit without noise where an encoder stands on one count
    power = np.abs(fft.rfft(window * signal.detrend(parts), axis=-1)) ** 2
    power[:, 1 : (length + 1) // 2] *= 2.0  # one-sided: all but what stands at 0 and at half the rate
    density = np.median(power, axis=0) / (_median_over_mean(len(parts)) * rate_hz * float(window @ window))
    return fft.rfftfreq(length, 1.0 / rate_hz), density


def _median_over_mean(count: int) -> float:
    """Median over mean of so many periodograms of noise (Allen et al. 2012, FINDCHIRP, appendix B)."""
    pairs = 2.0 * np.arange(1.0, (count - 1) // 2 + 1.0)
    return 1.0 + float(np.sum(1.0 / (pairs + 1.0) - 1.0 / pairs))


def noise_of(values: Array, rate_hz: float) -> NoiseSpectrum:
    """The spectrum of a signal (n,) on an even clock, to read its noise off.

    Friction that turns jumps in every segment of a signal that is sampled slowly. Then the noise is taken for white,
    and read off brief segments: most of them hold no jump.
    """
    if len(values) < _FEWEST:
        # White noise through a third difference; what is left of a slow motion only adds.
        std = float(np.std(np.diff(values, 3))) / _RMS_OF_THIRD_DIFFERENCE if len(values) > 3 else 0.0
        return NoiseSpectrum(np.empty(0), np.empty(0), rate_hz, 1.0, 2.0 * std**2 / rate_hz)
    frequency, density = spectrum(values, rate_hz)
    averaged = 2.0 * len(values) / min(_SEGMENT, len(values)) - 1.0
    upper = (frequency >= rate_hz / 4.0) & (frequency <= TOP * rate_hz)
    high = min(_typical(block, averaged) for block in np.array_split(density[upper], _BLOCKS))
    between = _density_between_jumps(values, rate_hz)
    if 0.0 < between * 10.0 ** (_JUMPS_DB / 10.0) < high:
        return NoiseSpectrum(np.empty(0), np.empty(0), rate_hz, 1.0, between)
    return NoiseSpectrum(frequency, density, rate_hz, averaged, high)


def _density_between_jumps(values: Array, rate_hz: float) -> float:
    frequency, density = spectrum(values, rate_hz, _BRIEF)
    upper = (frequency >= rate_hz / 4.0) & (frequency <= TOP * rate_hz)
    return _typical(density[upper], 2.0 * len(values) / _BRIEF - 1.0)


@dataclass(frozen=True)
class NoiseSpectrum:
    """The spectrum of a signal, of which the frequencies that its motion does not reach are its noise.

    Attributes:
        frequency, density: (m,) [Hz], [unit^2/Hz]; empty where the signal is too short, or jumps fill its spectrum.
        rate_hz: of the signal.
        averaged: segments in the median.
        high: density in the quietest eighth of the upper half of the spectrum, or between jumps [unit^2/Hz].
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
        if just_above.sum() < _BLOCKS or 4.0 * band_hz > TOP * rate:
            return Noise(math.sqrt(self.high * rate / 2.0), self.high, None, "high frequencies")
        near = _typical(self.density[just_above], self.averaged)
        colour = 10.0 * math.log10(near / self.high) if near > 0.0 and self.high > 0.0 else None
        if colour is not None and abs(colour) < WHITE_DB:
            upper = (self.frequency >= rate / 4.0) & (self.frequency <= TOP * rate)
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
