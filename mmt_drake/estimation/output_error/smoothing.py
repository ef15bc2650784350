"""The probe's motion without its noise: a bank of low-pass filters, the narrowest that takes away nothing but noise.

Noise on the motion that drives a model acts in it as a force that is not there, and a fit makes parameters of it: what
the motion does not excite, the noise seems to. So the motion is smoothed before it drives the model, by as much as it
bears at each moment. A slow slide bears 2.5 Hz, a fast stroke 13 Hz, a blow nothing.

Position and velocity come from the recorded position alone, by two filters of one pass band, hence belong to each
other. Only the newest samples, to which no filter reaches yet, are taken as they were recorded.
"""

import math
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np

from mmt_drake.numeric.arrays import Array, Flags

#: Pass bands [Hz] and how far the filters look to each side [s]; the stop bands begin at twice the pass bands.
BANDS = ((13.0, 0.1), (6.0, 0.2), (2.5, 0.5))
_MOST_OF_RATE = 0.2  # a band is at most this share of the rate
_STOP_WEIGHT = 0.05  # of the stop band against the pass band in the least squares
_NODES = 150, 450  # frequencies at which it is said what a filter should be
_MORE_THAN_NOISE = 3.0  # times its variance: over a filter's reach a variance is known no better than that


@dataclass(frozen=True)
class Filter:
    """One pass band.

    Attributes:
        position, velocity: (2 reach + 1,) taps on the recorded position, centred.
    """

    position: Array
    velocity: Array

    @property
    def reach(self) -> int:
        """Samples that it looks at on each side."""
        return len(self.position) // 2


def design(band_hz: float, reach_s: float, h: float, ticks: int) -> Filter:
    """The least-squares filter for samples h [s] apart, each the mean of a position over so many ticks.

    Up to the band its response is 1, and j w for the velocity, the droop of the mean included; from twice the band it
    is 0. A standstill and a steady motion pass exactly.
    """
    t = np.arange(1, max(1, int(reach_s / h)) + 1) * h
    low = np.linspace(0.0, band_hz, _NODES[0] + 1)[1:]
    high = np.linspace(min(2.0 * band_hz, 0.49 / h), 0.5 / h, _NODES[1])
    hz, passed = np.concatenate([low, high]), np.repeat([1.0, 0.0], _NODES)
    weight = np.repeat([1.0, _STOP_WEIGHT], _NODES) / np.sqrt(np.repeat(_NODES, _NODES))
    weight[: _NODES[0]] *= (band_hz / low) ** 2  # slow motion is large, and an error of the gain as much larger
    w, droop = 2.0 * np.pi * hz, np.sinc(hz * h) / np.sinc(hz * h / ticks)
    even = 2.0 * (np.cos(np.outer(w, t)) - 1.0) * droop[:, np.newaxis]
    g = np.linalg.lstsq(even * weight[:, np.newaxis], (passed - droop) * weight, rcond=None)[0]
    scale = weight * droop / np.where(passed > 0.0, w, 2.0 * np.pi * band_hz)
    odd = np.vstack([2.0 * np.sin(np.outer(w, t)) * scale[:, np.newaxis], 200.0 * t])
    d = np.linalg.lstsq(odd, np.append(passed * weight, 100.0), rcond=None)[0]
    d /= 2.0 * float(d @ t)
    return Filter(np.concatenate([g[::-1], [1.0 - 2.0 * g.sum()], g]), np.concatenate([-d[::-1], [0.0], d]))


@dataclass(frozen=True)
class FilterBank:
    """Filters from the widest band to the narrowest.

    Attributes:
        filters: of each band.
        differences: variance of the difference between neighbours for white noise of variance 1: first that between the
            samples and the widest band.
    """

    filters: tuple[Filter, ...]
    differences: tuple[float, ...]

    @property
    def reach(self) -> int:
        """Of the narrowest band: what is older than this is final, but for what averages over its neighbourhood add."""
        return self.filters[-1].reach

    def noise(self, position: Array) -> Array:
        """White noise that each sample's distance from the widest band stands for: its square (n,), 0 at the ends."""
        residual = np.zeros(len(position))
        reach = self.filters[0].reach
        if len(position) > 2 * reach:
            residual[reach:-reach] = position[reach:-reach] - np.correlate(position, self.filters[0].position, "valid")
        return residual**2 / self.differences[0]

    def smooth(self, position: Array, velocity: Array, noise: float) -> tuple[Array, Array]:
        """Position and velocity (n,) by the narrowest band that leaves out nothing but noise.

        Args:
            position: (n,) means over the samples [m].
            velocity: (n,) likewise [m/s].
            noise: variance of the noise on the position [m^2].
        """
        x, v = position.copy(), velocity.copy()
        wider, known = position, np.ones(len(position), dtype=bool)
        allowed = known
        for taps, variance in zip(self.filters, self.differences, strict=True):
            reach = taps.reach
            if len(position) <= 2 * reach:
                break
            inside = np.zeros(len(position), dtype=bool)
            inside[reach:-reach] = True
            here = np.where(inside, 0.0, position)
            here[inside] = np.correlate(position, taps.position, "valid")
            lost = _mean_around((here - wider) ** 2, inside & known, reach)
            limit = _MORE_THAN_NOISE * variance * noise
            allowed = allowed & inside & (lost <= limit)
            if not allowed.any():
                break
            x[allowed] = here[allowed]
            v[allowed] = np.correlate(position, taps.velocity, "valid")[allowed[reach:-reach]]
            wider, known = here, inside
        return x, v


@cache
def filter_bank(h: float, ticks: int) -> FilterBank:
    """The filters for samples h [s] apart, each the mean over so many ticks."""
    most = _MOST_OF_RATE / h
    filters = tuple(design(min(band, most), reach * max(1.0, band / most), h, ticks) for band, reach in BANDS)
    alone = np.zeros(2 * filters[0].reach + 1)
    alone[filters[0].reach] = 1.0
    differences = [_distance(alone, filters[0].position)]
    differences += [_distance(a.position, b.position) for a, b in pairwise(filters)]
    return FilterBank(filters, tuple(differences))


def _distance(a: Array, b: Array) -> float:
    """Squared distance of two centred impulse responses."""
    size = max(len(a), len(b))
    a, b = (np.pad(taps, (size - len(taps)) // 2) for taps in (a, b))
    return float((a - b) @ (a - b))


def _mean_around(values: Array, known: Flags, reach: int) -> Array:
    """Mean (n,) of the known values within `reach` samples of each; infinite where there are none."""
    sums = np.concatenate([[0.0], np.cumsum(np.where(known, values, 0.0))])
    counts = np.concatenate([[0], np.cumsum(known)])
    i = np.arange(len(values))
    low, high = np.maximum(i - reach, 0), np.minimum(i + reach + 1, len(values))
    count = counts[high] - counts[low]
    return np.where(count > 0, (sums[high] - sums[low]) / np.maximum(count, 1), math.inf)
