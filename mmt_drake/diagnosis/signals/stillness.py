"""Stretches at which the probe rests: the noise there is taken off position and velocity.

Physics that knows no rate (hysteresis, bristles, stiction) adds up every small movement. Noise that is harmless
elsewhere makes it forget, in a dwell, what it should remember. Where a smoothed axis stays within its own noise, it
is held at its mean there; the passage to and from it is smooth, and velocity stays the derivative of position.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d

from mmt_drake.analysis.signals import stretches
from mmt_drake.numeric.arrays import Array

_WINDOW_S = 0.12
_PASSAGE_S = 0.1
_SIGMAS = 2.0
"""A standstill may be this many times as loud as the noise: its RMS over so short a window scatters."""


def stilled(
    position: Array, velocity: Array, position_noise: float, velocity_noise: float, rate_hz: float
) -> tuple[Array, Array]:
    """Position and velocity (n,) of one axis with its standstills quiet.

    Args:
        position, velocity: smoothed, (n,) each, of any unit and that per second.
        position_noise, velocity_noise: deviation of what is left of their noise.
        rate_hz: samples per second.
    """
    if not velocity_noise > 0.0:
        return position, velocity
    window = 2 * int(_WINDOW_S * rate_hz / 2.0) + 1
    passage = max(1, round(_PASSAGE_S * rate_hz))
    loud = np.sqrt(np.maximum(uniform_filter1d(velocity**2, window), 0.0))
    still = loud < _SIGMAS * velocity_noise
    quiet, rate = position.copy(), velocity.copy()
    for first, last in stretches(still):
        count, part = last + 1 - first, slice(first, last + 1)
        if count < 3 * passage:
            continue
        mean = float(position[part].mean())
        if float(np.std(position[part])) > _SIGMAS * max(position_noise, velocity_noise / rate_hz):
            continue
        share, slope = _share(count, passage, first == 0, part.stop == len(position))
        rest = position[part] - mean
        quiet[part] = mean + share * rest
        rate[part] = share * velocity[part] + slope * rate_hz * rest
    return quiet, rate


def _share(count: int, passage: int, from_start: bool, to_end: bool) -> tuple[Array, Array]:
    """How much of the movement is kept at each sample of a standstill, from 1 at its ends to 0, and its slope."""
    k = np.arange(count, dtype=np.float64)
    before = np.full(count, np.inf) if from_start else k
    after = np.full(count, np.inf) if to_end else count - 1.0 - k
    phase = np.clip(np.minimum(before, after) / passage, 0.0, 1.0)
    sign = np.where(before < after, -1.0, 1.0)
    inside = (phase > 0.0) & (phase < 1.0)
    slope = np.where(inside, sign * 0.5 * np.pi / passage * np.sin(np.pi * phase), 0.0)
    return 0.5 * (1.0 + np.cos(np.pi * phase)), slope
