"""Least squares of one signal by others that may all be recorded earlier or later than it."""

import math
from dataclasses import dataclass

import numpy as np
from scipy import signal

from mmt_drake.numeric.arrays import Array, Flags

_LEAST = 0.3  # share of samples that count, for an offset to be told


@dataclass(frozen=True)
class LagFit:
    """A signal as a sum of its causes, fitted with the signal later by an offset.

    Attributes:
        coefficients: (k,) of the causes at that offset.
        offset: of the signal behind its causes [s]; negative where it comes first.
        standard_error: of the offset [s].
        explained: share of the signal's power.
        unshifted: (k,) coefficients with no offset.
        explained_unshifted: share of the power with no offset.
    """

    coefficients: Array
    offset: float
    standard_error: float
    explained: float
    unshifted: Array
    explained_unshifted: float


@dataclass(frozen=True)
class Products:
    """Products of causes and targets over the same samples of the targets, at all lags.

    Attributes:
        lags: (l,) by which the targets are later [s].
        gram: (l, k, k) sums of products of the causes.
        cross: (l, k, j) sums of products of causes and targets.
        power: sum of squares of the targets.
        count: samples that are summed over.
    """

    lags: Array
    gram: Array
    cross: Array
    power: float
    count: int


def products(causes: Array, targets: Array, longest_s: float, rate_hz: float, counts: Flags | None = None) -> Products:
    """Products at all lags to `longest_s` each way, or to a quarter of the recording.

    Args:
        causes: (n, k).
        targets: (n, j).
        longest_s: lags looked at [s].
        rate_hz: of both.
        counts: (n,) samples of the targets that count; all unless given.
    """
    reach = min(round(longest_s * rate_hz), len(causes) // 4)
    inside = slice(reach, len(targets) - reach)
    weight = (np.ones(len(targets)) if counts is None else counts.astype(np.float64))[inside]
    inner = targets[inside] * weight[:, np.newaxis]
    width = causes.shape[1]
    gram = np.empty((2 * reach + 1, width, width))
    cross = np.empty((2 * reach + 1, width, targets.shape[1]))
    for i in range(width):
        for j in range(i + 1):
            gram[:, i, j] = gram[:, j, i] = _slid(causes[:, i] * causes[:, j], weight)
        for j in range(targets.shape[1]):
            cross[:, i, j] = _slid(causes[:, i], inner[:, j])
    lags = np.arange(-reach, reach + 1) / rate_hz
    return Products(lags, gram, cross, float(np.sum(inner**2)), int(weight.sum()))


def _slid(long: Array, short: Array) -> Array:
    """Sums of products at all places of the short signal within the long one, the last place first."""
    slid: Array = signal.correlate(long, short, mode="valid", method="fft")[::-1]
    return slid


def best_lag(
    causes: Array, target: Array, longest_s: float, rate_hz: float, band_hz: float, counts: Flags | None = None
) -> LagFit | None:
    """The offset of least squares, refined by a parabola; None if a signal is nil or too few samples count.

    The error of the offset follows from what no change of the coefficients can do of the fitted target's slope, with
    the residual counted as as many independent numbers as its band has room for.

    Args:
        causes: (n, k), of any size each.
        target: (n,).
        longest_s: offsets looked at [s].
        rate_hz: of both.
        band_hz: of the residual.
        counts: (n,) samples of the target that count; all unless given.
    """
    scale = np.sqrt(np.mean(causes**2, axis=0))
    if not scale.all() or (counts is not None and np.mean(counts) < _LEAST):
        return None
    scan = products(causes / scale, target[:, np.newaxis], longest_s, rate_hz, counts)
    if scan.power == 0.0:
        return None
    coefficients = np.array(
        [np.linalg.lstsq(g, c[:, 0], rcond=None)[0] for g, c in zip(scan.gram, scan.cross, strict=True)]
    )
    left = scan.power - np.sum(coefficients * scan.cross[:, :, 0], axis=1)
    best, middle = int(np.argmin(left)), len(left) // 2
    terms = causes / scale
    slope = np.gradient(terms @ coefficients[best], 1.0 / rate_hz)
    terms, slope = (terms, slope) if counts is None else (terms[counts], slope[counts])
    steepness = float(np.sum((slope - terms @ np.linalg.lstsq(terms, slope, rcond=None)[0]) ** 2))
    crowding = rate_hz / (2.0 * min(band_hz, rate_hz / 2.0))
    rest = max(float(left[best]), 0.0) / scan.count
    return LagFit(
        coefficients=coefficients[best] / scale,
        offset=float(scan.lags[best]) + _vertex(left, best) / rate_hz,
        standard_error=math.sqrt(rest * crowding / steepness) if steepness > 0.0 else math.inf,
        explained=1.0 - float(left[best]) / scan.power,
        unshifted=coefficients[middle] / scale,
        explained_unshifted=1.0 - float(left[middle]) / scan.power,
    )


def _vertex(values: Array, at: int) -> float:
    """How far off the least of these values the parabola through it and its neighbours has its vertex, in samples."""
    if not 0 < at < len(values) - 1:
        return 0.0
    before, here, after = values[at - 1 : at + 2]
    bend = before - 2.0 * here + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend > 0.0 else 0.0
