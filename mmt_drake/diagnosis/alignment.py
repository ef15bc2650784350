"""Whether forces were recorded at the times of the motion beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from mmt_drake.diagnosis.result import Finding
from mmt_drake.diagnosis.smoother import Smoothed

Array = NDArray[np.float64]

_SEARCH_S = 0.6  # offsets that are looked for
_LATEST_S = 0.25  # a force may be so late and still be a delay
_EARLIEST_S = 0.02  # a force that comes before the motion that causes it is no physics
_RESOLUTION_S = 1.5e-3  # how far off zero recordings without any offset were seen: a touch rounds off the height
_EXPLAINED = 0.9  # of the normal force, for the offset to be told
_ALIKE, _UNLIKE = 0.8, 0.3
_RIVAL = 0.9
_LONGEST_LAG_S = 2.0
_SAME_PEAK_S = 0.25


@dataclass(frozen=True)
class NormalFit:
    """F_z = -k z - b v_z in contact, fitted with the force later by an offset.

    Attributes:
        k, b: fitted [N/m], [N s/m].
        offset: of the force behind the position [s].
        standard_error: of the offset [s].
        explained: share of the power of F_z.
    """

    k: float
    b: float
    offset: float
    standard_error: float
    explained: float


def normal_fit(smoothed: Smoothed) -> NormalFit | None:
    """The normal contact and the clock offset from all touches together; None where there is no touch or release.

    Position and velocity, cut off by contact, pass the filter of the force; of all offsets to 0.6 s the one of least
    squares counts, refined by a parabola. Its error follows from the slope of the fitted force, with the
    residual counted as as many independent numbers as its band has room for.
    """
    if smoothed.kind != "contact" or len(smoothed.contact.changes) == 0 or not smoothed.in_contact.any():
        return None
    touching = smoothed.contact.share(smoothed.time, 1.0 / smoothed.rate_hz)
    force = smoothed.output[:, 2]
    height = np.column_stack([smoothed.input[:, 2], smoothed.input_rate[:, 2]])
    causes = smoothed.filter(-touching[:, np.newaxis] * height)
    scan = _scan(causes, force[:, np.newaxis], _SEARCH_S, smoothed.rate_hz)
    if scan.power == 0.0:
        return None
    coefficients = np.array(
        [np.linalg.lstsq(g, c[:, 0], rcond=None)[0] for g, c in zip(scan.gram, scan.cross, strict=True)]
    )
    left = scan.power - np.sum(coefficients * scan.cross[:, :, 0], axis=1)
    best = int(np.argmin(left))
    part = 0.0
    if 0 < best < len(left) - 1:
        before, here, after = left[best - 1 : best + 2]
        bend = before - 2.0 * here + after
        part = float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend > 0.0 else 0.0
    k, b = coefficients[best]
    slope = np.gradient(causes @ coefficients[best], 1.0 / smoothed.rate_hz)
    steepness = float(np.sum(slope**2))
    band = min(smoothed.low_pass.band_hz, smoothed.rate_hz / 2.0)
    crowding = smoothed.rate_hz / (2.0 * band)
    rest = max(float(left[best]), 0.0) / scan.count
    error = math.sqrt(rest * crowding / steepness) if steepness > 0.0 else math.inf
    offset = float(scan.lags[best]) + part / smoothed.rate_hz
    return NormalFit(float(k), float(b), offset, error, 1.0 - float(left[best]) / scan.power)


@dataclass(frozen=True)
class _Scan:
    """Products of signals over the same inner samples of a target, at all lags of the causes.

    Attributes:
        lags: (l,) by which the causes are later [s].
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


def _scan(causes: Array, targets: Array, longest_s: float, rate_hz: float) -> _Scan:
    """Products at all lags to `longest_s` each way, of causes (n, k) and targets (n, j)."""
    reach = min(round(longest_s * rate_hz), len(causes) // 4)
    inner = targets[reach : len(targets) - reach]
    squares = causes[:, :, np.newaxis] * causes[:, np.newaxis, :]
    sums = np.concatenate([np.zeros((1, *squares.shape[1:])), np.cumsum(squares, axis=0)])
    cross = np.empty((2 * reach + 1, causes.shape[1], targets.shape[1]))
    for i in range(causes.shape[1]):
        for j in range(targets.shape[1]):
            cross[:, i, j] = signal.correlate(causes[:, i], inner[:, j], mode="valid", method="fft")[::-1]
    gram = (sums[len(inner) :] - sums[: 2 * reach + 1])[::-1]
    lags = np.arange(-reach, reach + 1) / rate_hz
    return _Scan(lags, gram, cross, float(np.sum(inner**2)), len(inner))


def offset_findings(fit: NormalFit | None, step: float) -> list[Finding]:
    """The offset of the clocks of force and position, where touches tell it.

    Args:
        fit: of the normal force.
        step: of the recording [s].
    """
    if fit is None or fit.explained < _EXPLAINED or fit.k <= 0.0:
        return []
    figures = {"offset_s": fit.offset, "standard_error_s": fit.standard_error}
    said = f"{1e3 * abs(fit.offset):.2f} +- {1e3 * fit.standard_error:.2f} ms"
    if fit.offset < -_EARLIEST_S or fit.offset > _LATEST_S:
        way = "before" if fit.offset < 0.0 else "after"
        text = f"The force comes {said} {way} the motion that causes it: the two are misaligned; shift one of them."
        return [Finding("misaligned", "refuse", text, figures)]
    if abs(fit.offset) < max(_RESOLUTION_S, step, 3.0 * fit.standard_error):
        return [Finding("offset", "note", f"Force and position share a clock: touches agree to {said}.", figures)]
    way = "earlier" if fit.offset < 0.0 else "later"
    return [Finding("offset", "warn", f"At touches the force is {said} {way} than the position.", figures)]


def likeness(measured: Array, simulated: Array) -> float:
    """Correlation of two signals (n, k), their means not removed."""
    size = math.sqrt(float(np.sum(measured**2)) * float(np.sum(simulated**2)))
    return float(np.sum(measured * simulated)) / size if size > 0.0 else 0.0


def lag_findings(smoothed: Smoothed, nominal: Array | None, used: tuple[int, ...]) -> list[Finding]:
    """An output that is like the nominal model's, but at another time.

    Only where the two are unlike as recorded, much alike at one offset, and nowhere else nearly so: a periodic motion
    is like itself again a period later.
    """
    if nominal is None or smoothed.kind == "driven_body":
        return []
    measured, expected = smoothed.output[:, used], nominal[:, used]
    now = likeness(measured, expected)
    if now > _UNLIKE:
        return []
    scan = _scan(expected, measured, _LONGEST_LAG_S, smoothed.rate_hz)
    size = np.sqrt(scan.power * np.trace(scan.gram, axis1=1, axis2=2))
    alike = np.divide(np.trace(scan.cross, axis1=1, axis2=2), size, out=np.zeros_like(size), where=size > 0.0)
    best = int(np.argmax(alike))
    offset = float(scan.lags[best])
    apart = np.abs(scan.lags - offset) > _SAME_PEAK_S
    rival = float(alike[apart].max()) if apart.any() else 0.0
    if alike[best] < _ALIKE or rival > _RIVAL * alike[best]:
        return []
    if -_EARLIEST_S <= offset <= _LATEST_S:
        return []
    way = "before" if offset < 0.0 else "after"
    text = (
        f"The force looks like the model's {abs(offset):.2f} s {way} the motion (correlation {alike[best]:.2f}, "
        f"{now:.2f} as recorded): the two are misaligned; shift one of them."
    )
    return [Finding("misaligned", "refuse", text, {"offset_s": offset, "correlation": float(alike[best])})]
