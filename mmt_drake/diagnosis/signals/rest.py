"""A force sensor in free space: its bias, its noise, and what hums."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import fft, signal, stats

from mmt_drake.analysis.signals import stretches
from mmt_drake.diagnosis.signals.noise import TOP, Noise
from mmt_drake.numeric.arrays import Array, Flags

_SEGMENT = 256  # samples, of the spectrum
_BLOCK_S = 0.1
_SHORTEST_S = 0.2  # a stretch that counts
_CRESTS = 16
_AS_WHITE = (0.025, 0.975)  # quantiles of the density below the band within which noise is taken for white
_LOWEST_HUM_HZ = 0.3
_HUM_SHARE = 0.15  # of the power in free space, or it is noise: one line of noise has a hundredth


@dataclass(frozen=True)
class Hum:
    """A sine in the force: its `frequency` [Hz], its `amplitude` [N], the `share` of the power in free space it has."""

    frequency: float
    amplitude: float
    share: float


@dataclass(frozen=True)
class Rest:
    """What a force sensor shows where nothing touches it.

    A hum is no noise: it can be told beforehand. Nor is what follows the acceleration of the probe: the sensor carries
    a mass there. Noise and bias are those without both.

    Attributes:
        mean: its bias [N], (k,).
        standard_error: of the bias, colour taken into account [N], (k,).
        noise: of each axis, its density that below the band, its colour over the upper half of the spectrum.
        hum: of each axis, or None.
        seconds: how much free space there was.
    """

    mean: Array
    standard_error: Array
    noise: tuple[Noise, ...]
    hum: tuple[Hum | None, ...]
    seconds: float


def at_rest(values: Array, acceleration: Array, rate_hz: float, free: Flags, band_hz: float = math.inf) -> Rest | None:
    """Bias and noise of forces (n, k) in free space, or None where there is too little of it.

    The standard error comes from means over blocks of 0.1 s, which are nearly independent whatever
    the colour above 10 Hz (the method of batch means); deviation and densities from each stretch about its own line.

    Args:
        values: [N], on an even clock.
        acceleration: (n, k) of the probe along each of their axes, in any unit.
        rate_hz: of that clock.
        free: (n,) where the probe is surely off the object.
        band_hz: below which the density counts.
    """
    least = max(_SHORTEST_S * rate_hz, 16)
    spans = [slice(first, last + 1) for first, last in stretches(free) if last - first + 1 >= least]
    if not spans:
        return None
    quiet, hums = values.copy(), []
    for column, carried in zip(quiet.T, acceleration.T, strict=True):  # views: what is no noise is taken out in place
        hum, sine = _hum_of(column, spans, rate_hz)
        following, share = _following(column, carried, spans)
        if share > max(_HUM_SHARE, 0.0 if hum is None else hum.share):
            column -= following
            hum, sine = _hum_of(column, spans, rate_hz)
        hums.append(hum)
        if sine is not None:
            column -= sine
    parts = [quiet[span] for span in spans]
    lengths = np.array([len(part) for part in parts])
    left = [signal.detrend(part, axis=0) for part in parts]
    std = np.sqrt(sum((part**2).sum(axis=0) for part in left) / (lengths - 2).sum())
    known = zip(std, *_densities(left, lengths, rate_hz, band_hz), strict=True)
    noise = tuple(Noise(float(s), float(d), float(c), "free space") for s, d, c in known)
    mean = np.average([part.mean(axis=0) for part in parts], axis=0, weights=lengths)
    return Rest(mean, _batch_error(parts, rate_hz), noise, tuple(hums), float(lengths.sum()) / rate_hz)


def _following(values: Array, cause: Array, spans: list[slice]) -> tuple[Array, float]:
    """What of the values (n,) follows a cause (n,) in proportion, and its share of their power, about each line."""
    force, by = (np.concatenate([signal.detrend(signals[span]) for span in spans]) for signals in (values, cause))
    both, size, power = float(by @ force), float(by @ by), float(force @ force)
    if size == 0.0 or power == 0.0:
        return np.zeros_like(cause), 0.0
    return cause * (both / size), both**2 / (size * power)


def _batch_error(parts: list[Array], rate_hz: float) -> Array:
    """Standard error (k,) of the mean of all parts."""
    block = max(1, round(_BLOCK_S * rate_hz))
    means = np.concatenate(
        [part[: len(part) // block * block].reshape(-1, block, part.shape[1]).mean(axis=1) for part in parts]
    )
    if len(means) < 2:
        return np.full(parts[0].shape[1], np.inf)
    return np.asarray(np.std(means, axis=0, ddof=1) / math.sqrt(len(means)))


def _densities(parts: list[Array], lengths: Array, rate_hz: float, band_hz: float) -> tuple[Array, Array]:
    """Density below the band, and that over the one of the upper half of the spectrum in dB, (k,) each.

    Little free space tells little of so narrow a band: noise that may be white there is as dense as above it.
    """
    segment = min(_SEGMENT, int(lengths.min()))
    pieces = [signal.welch(part, rate_hz, nperseg=segment, detrend="linear", axis=0) for part in parts]
    frequency = pieces[0][0]
    density = np.average([piece[1] for piece in pieces], axis=0, weights=lengths)
    upper = (frequency >= rate_hz / 4.0) & (frequency <= TOP * rate_hz)
    # The line that is taken out of each stretch takes the lowest bins with it.
    low = (frequency <= min(band_hz, rate_hz / 4.0)) & (frequency >= frequency[2])
    high = density[upper].mean(axis=0)
    below = density[low].mean(axis=0) if low.any() else high
    freedom = 2.0 * float(lengths.sum() * frequency[1] * max(low.sum(), 1)) / rate_hz
    least, most = (float(stats.chi2.ppf(quantile, freedom)) / freedom for quantile in _AS_WHITE)
    below = np.where((least * high <= below) & (below <= most * high), high, below)
    ratio = np.divide(below, high, out=np.ones_like(high), where=(high > 0.0) & (below > 0.0))
    return below, 10.0 * np.log10(ratio)


def _hum_of(values: Array, spans: list[slice], rate_hz: float) -> tuple[Hum | None, Array | None]:
    """The strongest sine that runs through all of free space, if it is strong enough, and its course (n,)."""
    left = np.zeros(len(values))
    for span in spans:
        left[span] = signal.detrend(values[span])
    power = float(np.sum(left**2))
    longest = max(span.stop - span.start for span in spans) / rate_hz
    size = fft.next_fast_len(4 * len(values), real=True)
    frequency = fft.rfftfreq(size, 1.0 / rate_hz)
    allowed = (frequency >= max(_LOWEST_HUM_HZ, 1.0 / longest)) & (frequency <= TOP * rate_hz)
    if power == 0.0 or not allowed.any():
        return None, None
    strength = np.where(allowed, np.abs(fft.rfft(left, size)), 0.0)
    # Free space comes in pieces, each without its line: the true peak may be a lower one among its neighbours.
    crests = np.flatnonzero((strength[1:-1] >= strength[:-2]) & (strength[1:-1] > strength[2:])) + 1
    crests = crests[np.argsort(strength[crests])[-_CRESTS:]]
    if not len(crests):
        return None, None
    step = float(frequency[1])
    found = [_steepest(left, spans, float(frequency[i]), step, rate_hz) for i in crests]
    best, centre = max(found)
    explained, cosine, sine = best
    if explained < _HUM_SHARE * power:
        return None, None
    angle = 2.0 * np.pi * centre / rate_hz * np.arange(len(values))
    return Hum(centre, math.hypot(cosine, sine), explained / power), cosine * np.cos(angle) + sine * np.sin(angle)


def _steepest(
    left: Array, spans: list[slice], frequency: float, step: float, rate_hz: float
) -> tuple[tuple[float, float, float], float]:
    """The best sine (`_sine`) within two steps [Hz] of a frequency, by halving the step, and its frequency."""
    best = _sine(left, spans, frequency, rate_hz)
    if best[0] < 0.5 * _HUM_SHARE * float(np.sum(left**2)):
        return best, frequency
    least = 1e-3 * step
    while step > least:
        for tried in (frequency - step, frequency + step):
            found = _sine(left, spans, tried, rate_hz)
            if found[0] > best[0]:
                best, frequency = found, tried
        step /= 2.0
    return best, frequency


def _sine(left: Array, spans: list[slice], frequency: float, rate_hz: float) -> tuple[float, float, float]:
    """The power that a sine explains of what is left about the line of each stretch, and its two amplitudes."""
    angle = 2.0 * np.pi * frequency / rate_hz
    waves = [angle * np.arange(span.start, span.stop) for span in spans]
    c = np.concatenate([signal.detrend(np.cos(wave)) for wave in waves])
    s = np.concatenate([signal.detrend(np.sin(wave)) for wave in waves])
    y = np.concatenate([left[span] for span in spans])
    cc, cs, ss, cy, sy = (float(np.sum(product)) for product in (c * c, c * s, s * s, c * y, s * y))
    determinant = cc * ss - cs * cs
    if determinant <= 1e-12 * cc * ss:
        return 0.0, 0.0, 0.0
    cosine, sine = (ss * cy - cs * sy) / determinant, (cc * sy - cs * cy) / determinant
    return cosine * cy + sine * sy, cosine, sine
