"""By how much one signal is later than another that is like it: from the slope of the phase between the two."""

import math

import numpy as np
from scipy import signal

from mmt_drake.numeric.arrays import Array

LONGEST_S = 1.0
"""Delays are looked for up to this, either way [s]."""
BAND_HZ = (0.3, 10.0)
"""Where a hand's motion has power, and phase is read."""

_SEGMENT_S = 4.0
_ALIKE = 0.5  # correlation at the best lag; below, there is no telling which lag it is
_FAINT = 0.01  # segments with less than this part of the largest one's power say nothing


def lateness(late: Array, early: Array, rate_hz: float) -> float | None:
    """By how much `late` comes after `early` [s]; None where the two are too unlike for a delay to be told.

    The peak of the cross-correlation gives whole samples. What is left follows from cross-spectra: a delay tau turns
    the phase by -2 pi f tau, so that in each of many overlapping segments a line through the origin is fitted to the
    phase over `BAND_HZ`, frequencies weighted by their power. The median counts: a touch, at which a force jumps
    whenever its cause arrives, spoils its own segments only. Columns are counted together, so they must be in one unit.

    Args:
        late, early: (n, k) of the same length, finite.
        rate_hz: samples per second.
    """
    late, early = late - late.mean(axis=0), early - early.mean(axis=0)
    size = math.sqrt(float(np.sum(late**2)) * float(np.sum(early**2)))
    if size == 0.0:
        return None
    reach = min(round(LONGEST_S * rate_hz), len(late) // 4)
    products = sum(signal.correlate(a, b, method="fft") for a, b in zip(late.T, early.T, strict=True))
    middle = len(early) - 1
    likeness = np.asarray(products)[middle - reach : middle + reach + 1] / size
    steps = int(np.argmax(likeness)) - reach
    if likeness[steps + reach] < _ALIKE:
        return None
    end = len(late) - abs(steps)
    return steps / rate_hz + _by_phase(late[max(steps, 0) :][:end], early[max(-steps, 0) :][:end], rate_hz)


def _by_phase(late: Array, early: Array, rate_hz: float) -> float:
    """A delay that turns no phase of `BAND_HZ` by more than half a turn [s]; 0 without any power there."""
    length = min(len(late), round(_SEGMENT_S * rate_hz))
    starts = range(0, len(late) - length + 1, max(length // 2, 1))
    window = signal.get_window("hann", length)[:, np.newaxis]
    f = np.fft.rfftfreq(length, 1.0 / rate_hz)
    chosen = (f >= BAND_HZ[0]) & (f <= BAND_HZ[1])
    f, delays, powers = f[chosen], [], []
    for start in starts:
        parts = (values[start : start + length] for values in (late, early))
        a, b = (np.fft.rfft(window * (part - part.mean(axis=0)), axis=0)[chosen] for part in parts)
        cross = np.sum(np.conj(b) * a, axis=1)
        weight = np.abs(cross) * f**2
        powers.append(float(np.sum(weight)))
        slope = float(np.sum(np.abs(cross) * f * np.angle(cross))) / powers[-1] if powers[-1] > 0.0 else 0.0
        delays.append(-slope / (2.0 * math.pi))
    enough = np.array(powers) > _FAINT * max(powers)
    return float(np.median(np.array(delays)[enough])) if enough.any() else 0.0
