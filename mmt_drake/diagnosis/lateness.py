"""By how much one signal is later than another that is like it: from the slope of the phase between the two."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

LONGEST_S = 1.0
"""Delays are looked for up to this, either way [s]."""
BAND_HZ = (0.3, 10.0)
"""Where a hand's motion has power, and phase is read."""

_SEGMENT_S = 4.0
_ALIKE = 0.5  # correlation at the best lag; below, there is no telling which lag it is
_COHERENT = 1.0 - 1e-12  # of signals that are equal: the weight of a frequency stays finite


def lateness(late: Array, early: Array, rate_hz: float) -> float | None:
    """By how much `late` comes after `early` [s]; None where the two are too unlike for a delay to be told.

    The peak of the cross-correlation gives whole samples. What is left follows from the cross-spectrum: a delay tau
    turns the phase by -2 pi f tau. A line through the origin is fitted to the phase over `BAND_HZ`, each frequency
    weighted by gamma²/(1 - gamma²), the inverse variance of a phase at coherence gamma (Bendat and Piersol, Random
    Data, section 9.2). Columns are counted together, so they must be in one unit.

    Args:
        late, early: (n, k) of the same length, finite.
        rate_hz: samples per second.
    """
    late, early = late - late.mean(axis=0), early - early.mean(axis=0)
    size = math.sqrt(float(np.sum(late**2)) * float(np.sum(early**2)))
    if size == 0.0:
        return None
    reach = min(round(LONGEST_S * rate_hz), len(late) // 4)
    likeness = sum(signal.correlate(a, b, method="fft") for a, b in zip(late.T, early.T, strict=True)) / size
    middle = len(early) - 1
    likeness = likeness[middle - reach : middle + reach + 1]
    steps = int(np.argmax(likeness)) - reach
    if likeness[steps + reach] < _ALIKE:
        return None
    late, early = (late[steps:], early[: len(early) - steps]) if steps >= 0 else (late[:steps], early[-steps:])
    return steps / rate_hz + _by_phase(late, early, rate_hz)


def _by_phase(late: Array, early: Array, rate_hz: float) -> float:
    """A delay of a few samples at most [s]."""
    length = min(len(late), round(_SEGMENT_S * rate_hz))
    frequency, cross = signal.csd(early, late, rate_hz, nperseg=length, axis=0)
    _, of_early = signal.welch(early, rate_hz, nperseg=length, axis=0)
    _, of_late = signal.welch(late, rate_hz, nperseg=length, axis=0)
    cross, power = cross.sum(axis=1), of_early.sum(axis=1) * of_late.sum(axis=1)
    chosen = (frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1]) & (power > 0.0)
    if not chosen.any():
        return 0.0
    f, cross, power = frequency[chosen], cross[chosen], power[chosen]
    coherence = np.minimum(np.abs(cross) ** 2 / power, _COHERENT)
    weight = coherence / (1.0 - coherence)
    slope = float(np.sum(weight * f * np.angle(cross)) / np.sum(weight * f**2))
    return -slope / (2.0 * math.pi)
