"""Position and velocity from one smoother, of a recorded position and, where there is one, a recorded velocity."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from mmt_drake.analysis.nrmse import rms
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.zero_phase import LowPass, convolved

_TAIL = 12.0  # an exponential's tail is cut where e^-12 = 6e-6 of it is left
_SLOWEST_CROSSOVER = 10.0  # rad/s: below it a velocity's own bias would count, and the filter would see seconds
_WINDOW = 0.3  # of the filter's half-length: what the curvature at an end is read from
_DISAGREEMENT = 2.0  # times their noise: position and velocity columns that differ by more do not belong together


@dataclass(frozen=True)
class Fusion:
    """Filters that make one position and one velocity of a recorded position p and, where there is one, velocity u.

    White noise of densities S_p and S_u on the two makes, at angular frequency w, the combination
    X = H (W p + (1 - W) u / (j w)), W = a^2 / (a^2 + w^2), a^2 = S_u / S_p the one of least variance: below a the
    position is the better source, above it the velocity. It is the Rauch-Tung-Striebel smoother of a motion of which
    nothing is assumed, in its steady state, and H the low-pass. Velocity is j w X, so the two belong to each other.

    Attributes:
        position_from_p, velocity_from_p: (2 M + 1,) taps on the recorded position.
        position_from_u, velocity_from_u: (2 M + 1,) taps on the recorded velocity, or None.
    """

    position_from_p: Array
    velocity_from_p: Array
    position_from_u: Array | None
    velocity_from_u: Array | None

    @property
    def reach(self) -> int:
        """M: samples that the filters look at on each side."""
        return len(self.position_from_p) // 2

    def noise(self, position: float, velocity: float) -> tuple[float, float]:
        """Deviations of the smoothed position and velocity for white noise of these deviations on p and u."""
        from_p = (self.position_from_p, self.velocity_from_p)
        from_u = (self.position_from_u, self.velocity_from_u)
        left = [
            math.hypot(float(np.linalg.norm(p)) * position, 0.0 if u is None else float(np.linalg.norm(u)) * velocity)
            for p, u in zip(from_p, from_u, strict=True)
        ]
        return left[0], left[1]


def fusion(low_pass: LowPass, rate_hz: float, crossover: float) -> Fusion:
    """Design the filters of `Fusion`.

    Args:
        low_pass: H, not the identity.
        rate_hz: of the recorded position and velocity.
        crossover: a [rad/s], deviation of the velocity's noise over that of the position's; infinity: position alone.
    """
    taps = low_pass.kernel(rate_hz)
    reach = len(taps) // 2 + (0 if math.isinf(crossover) else math.ceil(_TAIL / crossover * rate_hz))
    size = fft.next_fast_len(4 * reach + 2, real=True)
    centred = np.roll(np.pad(taps, (0, size - len(taps))), -(len(taps) // 2))
    response = fft.rfft(centred).real
    w = 2.0 * np.pi * rate_hz * fft.rfftfreq(size)

    def taps_of(spectrum: NDArray[np.complex128]) -> Array:
        impulse = np.roll(fft.irfft(spectrum, size), reach)
        return np.asarray(impulse[: 2 * reach + 1], dtype=np.float64)

    share = np.ones_like(w) if math.isinf(crossover) else crossover**2 / (crossover**2 + w**2)
    position_from_p, velocity_from_p = taps_of(response * share + 0j), taps_of(1j * w * response * share)
    position_from_p /= position_from_p.sum()
    t = (np.arange(2 * reach + 1) - reach) / rate_hz
    if math.isinf(crossover):
        return Fusion(position_from_p, velocity_from_p / -(velocity_from_p @ t), None, None)
    rest = np.divide(1.0 - share, 1j * w, out=np.zeros(len(w), dtype=np.complex128), where=w > 0.0)
    velocity_from_u = taps_of(response * (1.0 - share) + 0j)
    # A steady motion, p = t and u = 1, comes out with velocity 1 whatever the cut tails were.
    velocity_from_u += (1.0 + velocity_from_p @ t - velocity_from_u.sum()) * position_from_p
    return Fusion(position_from_p, velocity_from_p, taps_of(response * rest), velocity_from_u)


@dataclass(frozen=True)
class FusedMotion:
    """The smoothed motion of one axis.

    Attributes:
        position, velocity: (n,); the second is the rate of the first.
        position_noise, velocity_noise: deviations of what is left of the noise.
        crossover: a [rad/s], as of `Fusion`; infinity where the position alone was used.
    """

    position: Array
    velocity: Array
    position_noise: float
    velocity_noise: float
    crossover: float


def smoothed_motion(
    position: Array, velocity: Array | None, rate_hz: float, bands: Sequence[float], noise: Array, velocity_noise: Array
) -> tuple[list[FusedMotion], bool]:
    """Smooth every axis, with the recorded velocity where it does not contradict the recorded position.

    A velocity column of another scale or another time than the position would do harm where it is trusted. Both are
    compared after the low-pass: if their difference is more than twice what their noise explains on any
    axis, the position alone counts on all.

    Args:
        position: (n, k).
        velocity: (n, k), or None.
        rate_hz: of both.
        bands: k pass bands [Hz], or infinity on all axes: nothing is smoothed.
        noise: (k,) deviations of white noise on the position.
        velocity_noise: (k,) of that on the velocity.

    Returns:
        The k motions, and whether the velocity was used.
    """
    if all(math.isinf(band) for band in bands):
        derived = np.gradient(position, 1.0 / rate_hz, axis=0) if velocity is None else velocity
        left = noise * rate_hz / math.sqrt(2.0) if velocity is None else velocity_noise
        used = velocity is not None
        columns = zip(position.T, derived.T, noise, left, strict=True)
        return [FusedMotion(p, u, float(sp), float(su), _crossover(used, sp, su)) for p, u, sp, su in columns], used
    alone = [_axis(p, None, rate_hz, band, sp, math.inf) for p, band, sp in zip(position.T, bands, noise, strict=True)]
    if velocity is None:
        return alone, False
    axes = list(zip(position.T, velocity.T, bands, noise, velocity_noise, strict=True))
    for motion, (_, u, band, _, su) in zip(alone, axes, strict=True):
        low_pass = LowPass(band)
        ends = math.ceil(low_pass.half_length_s * rate_hz)
        difference = (low_pass.apply(u, rate_hz) - motion.velocity)[ends:-ends]
        expected = math.hypot(motion.velocity_noise, low_pass.white_noise_gain(rate_hz) * su)
        if rms(difference) > _DISAGREEMENT * expected:
            return alone, False
    return [_axis(p, u, rate_hz, band, sp, su) for p, u, band, sp, su in axes], True


def _axis(
    position: Array, velocity: Array | None, rate_hz: float, band: float, noise: float, other: float
) -> FusedMotion:
    """One axis (n,), its velocity with noise `other` used or None."""
    crossover = _crossover(velocity is not None, noise, other)
    filters = fusion(LowPass(band), rate_hz, crossover)
    reach = min(filters.reach, len(position) - 1)
    cut = slice(filters.reach - reach, filters.reach + reach + 1)
    window = max(4, round(_WINDOW * LowPass(band).half_length_s * rate_hz))
    p, u = _continued(position, velocity, rate_hz, reach, window)
    smoothed, rate = (_through(p, taps[cut]) for taps in (filters.position_from_p, filters.velocity_from_p))
    if u is not None and filters.position_from_u is not None and filters.velocity_from_u is not None:
        smoothed = smoothed + _through(u, filters.position_from_u[cut])
        rate = rate + _through(u, filters.velocity_from_u[cut])
    return FusedMotion(smoothed, rate, *filters.noise(noise, 0.0 if velocity is None else other), crossover)


def _crossover(uses_velocity: bool, position_noise: float, velocity_noise: float) -> float:
    """a of `Fusion` [rad/s]."""
    if not uses_velocity or position_noise == 0.0:
        return math.inf
    return max(_SLOWEST_CROSSOVER, float(velocity_noise / position_noise))


def _through(padded: Array, taps: Array) -> Array:
    return convolved(padded[:, np.newaxis], taps)[:, 0]


def _continued(
    position: Array, velocity: Array | None, rate_hz: float, reach: int, window: int
) -> tuple[Array, Array | None]:
    """Position and velocity (n,) continued by `reach` samples at both ends, the velocity as the rate of the position.

    The motion is turned about the point where it ends, and about its curvature there: a time s beyond the end it is
    2 (c0 + c2 s^2) - p(-s), with c0 and c2 the value and half the second derivative at the end of the cubic through
    the `window` samples before it. That goes on up to the third derivative, and a single sample's noise does not pivot
    all that is continued.
    """
    s = np.arange(1, reach + 1) / window
    count = min(window, len(position) - 1) + 1
    fit = np.linalg.pinv(np.vander(np.arange(count) / window, 4))[[3, 1]]  # c0 and c2 of a cubic
    first, first_bend = fit @ position[:count]
    last, last_bend = fit @ position[::-1][:count]
    before = 2.0 * (first + first_bend * s**2) - position[1 : reach + 1]
    after = 2.0 * (last + last_bend * s**2) - position[-reach - 1 : -1][::-1]
    longer = np.concatenate([before[::-1], position, after])
    if velocity is None:
        return longer, None
    per_step = 4.0 * s * rate_hz / window
    before = velocity[1 : reach + 1] - first_bend * per_step
    after = velocity[-reach - 1 : -1][::-1] + last_bend * per_step
    return longer, np.concatenate([before[::-1], velocity, after])
