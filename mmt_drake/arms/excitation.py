"""A motion that tells an arm's inertial numbers, within the limits of its joints.

Each joint's velocity is a finite Fourier series, v = sum_k a_k cos k w t + b_k sin k w t, over a period that comes
again (Swevers et al. 1997, IEEE Trans. Robotics and Automation 13(5)); sum a_k = 0 and sum k b_k = 0, so that it begins
and ends at rest, with no acceleration. The series that make log det W'W greatest are sought, W being the regressor of
base parameters and of Coulomb and viscous friction: least volume of the estimate's covariance, whatever their scales.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final

import numpy as np
from scipy import optimize

from mmt_drake.arms.base_parameters import BaseParameters, BaseStructure
from mmt_drake.arms.joint_limits import JointLimits
from mmt_drake.arms.joint_log import JointLog
from mmt_drake.arms.motion import ArmMotion
from mmt_drake.arms.self_collision import SelfCollision
from mmt_drake.errors import BadInput, MmtError
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.atomic import replacing

SHARE: Final = 0.9
"""Of each limit of position, velocity and acceleration is used ..."""
EFFORT_SHARE: Final = 0.75
"""... and of effort: friction, which the robot's file does not know, takes the rest."""
NOISE: Final = 0.05
"""Of each joint's torque is taken for noise where none was recorded."""
_STARTS, _SLOPES, _STEP = 60, 50, 1e-4
"""Random motions tried, gradients of the search, and the step of their differences."""
_A_CYCLE: Final = 12
"""Samples of the fastest harmonic while a motion is sought."""
_PENALTY: Final = 1e3
_HZ: Final = 1000.0
"""Grid on which limits, efforts and distances are checked at the end, or finer where the file is."""
_SMALLEST: Final = 0.01
"""Of a joint's whole way, at least; a motion that has to be smaller tells next to nothing."""


@dataclass(frozen=True)
class PlannedMotion:
    """A motion, sample by sample.

    Attributes:
        time: (n,) [s].
        q, v, a: (n, joints) [rad], [rad/s], [rad/s^2], or in m.
    """

    time: Array
    q: Array
    v: Array
    a: Array


def motion_told(structure: BaseStructure, motion: PlannedMotion | JointLog, band_hz: float) -> BaseParameters:
    """What a motion tells, were the noise of every joint `NOISE` of its torque, whatever was recorded.

    Args:
        structure: of the arm.
        motion: planned or recorded; its torques do not count.
        band_hz: edge of the band [Hz].

    Raises:
        BadInput: it was sampled too slowly for that.
    """
    log = JointLog(getattr(motion, "source", "motion"), motion.time, motion.q, np.zeros_like(motion.q), "")
    return structure.told([ArmMotion.of(log, band_hz)], NOISE * structure.torque)


@dataclass(frozen=True)
class FourierSeries:
    """Fourier series of all joints.

    Attributes:
        period: [s].
        numbers: (joints, 2 (harmonics - 1)) of each joint's velocity: of every harmonic above the first one.
        start: (joints,) position at the beginning, and after each period.
    """

    period: float
    numbers: Array
    start: Array

    def at(self, time: Array, size: float = 1.0) -> PlannedMotion:
        """The motion at times (n,) [s], every joint's way in parts of its own."""
        bases = fourier_bases(time, self.period, self.numbers.shape[1] // 2 + 1)
        q, v, a = (size * basis @ self.numbers.T for basis in bases)
        return PlannedMotion(time, self.start + q, v, a)


def fourier_bases(time: Array, period: float, harmonics: int) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration for one unit of each number, (n, 2 (harmonics - 1)) each.

    Args:
        time: (n,) [s]; at 0 and after each period there is neither velocity nor acceleration.
        period: [s].
        harmonics: 2 or more.
    """
    w = 2.0 * np.pi / period
    rates = w * np.arange(1.0, harmonics + 1.0)
    angle = np.outer(time, rates)
    cosine, sine = np.cos(angle), np.sin(angle)
    parts = ((sine / rates, (1.0 - cosine) / rates), (cosine, sine), (-rates * sine, rates * cosine))
    more = rates[1:] / w
    q, v, a = (np.hstack([even[:, 1:] - even[:, :1], odd[:, 1:] - more * odd[:, :1]]) for even, odd in parts)
    return q, v, a


class Excitation:
    """The search for a motion.

    Args:
        structure: base parameters of the arm.
        limits: of its joints.
        period: that is repeated [s].
        harmonics: of the series, 2 or more.
        collision: by which links are kept apart; None: they are not.
    """

    def __init__(
        self,
        structure: BaseStructure,
        limits: JointLimits,
        period: float,
        harmonics: int,
        collision: SelfCollision | None = None,
    ) -> None:
        self._structure, self._limits, self._collision = structure, limits, collision
        self._period, self._width = period, 2 * (harmonics - 1)
        self._grid = np.linspace(0.0, period, _A_CYCLE * harmonics, endpoint=False)
        self._bases = fourier_bases(np.linspace(0.0, period, 40 * harmonics + 1), period, harmonics)

    def best(self, seed: int, on_progress: Callable[[float], None] = lambda _: None) -> FourierSeries:
        """The best of some random motions, improved by L-BFGS-B.

        Args:
            seed: of the random motions.
            on_progress: called with the part of the work that is done.
        """
        rng, joints = np.random.default_rng(seed), len(self._limits.low)
        starts = rng.standard_normal((_STARTS, joints, self._width + 2))
        starts[:, :, -2] *= 0.5
        first = min((start.ravel() for start in starts), key=self._cost)
        most, asked = _SLOPES * (first.size + 1), count(1)

        def cost(x: Array) -> float:
            on_progress(min(next(asked) / most, 1.0))
            return self._cost(x)

        options = {"maxfun": most, "maxiter": most, "eps": _STEP}
        found = optimize.minimize(cost, first, method="L-BFGS-B", options=options)
        return self.series(found.x)

    def series(self, x: Array) -> FourierSeries:
        """The series of free numbers: of each joint its series, where it lies within its way, and how large it is.

        Args:
            x: (joints * 2 harmonics,), any; whatever they are, the limits hold.
        """
        free = x.reshape(len(self._limits.low), -1)
        shape, (place, part) = free[:, :-2], 0.5 + 0.5 * np.tanh(free[:, -2:].T)
        q, v, a = (basis @ shape.T for basis in self._bases)
        limits, half = self._limits, 0.5 * SHARE * (self._limits.high - self._limits.low)
        way, low, high = np.ptp(q, axis=0), q.min(axis=0), q.max(axis=0)
        fastest, hardest = np.abs(v).max(axis=0), np.abs(a).max(axis=0)
        tiny = 1e-12
        size = np.minimum(2.0 * half / (way + tiny), SHARE * limits.speed / (fastest + tiny))
        size = part * np.minimum(size, SHARE * limits.acceleration / (hardest + tiny))
        centre = 0.5 * (limits.low + limits.high)
        lowest, highest = centre - half - size * low, centre + half - size * high
        return FourierSeries(self._period, shape * size[:, None], lowest + place * (highest - lowest))

    def _cost(self, x: Array) -> float:
        course = self.series(x).at(self._grid)
        rows = self._structure.regressor(course.q, course.v, course.a)
        whole = rows.whole
        _, size = np.linalg.slogdet(whole.T @ whole + 1e-12 * np.eye(whole.shape[1]))
        return float(-size) + _PENALTY * self._excess(course.q, rows.torque)

    def _excess(self, q: Array, torque: Array) -> float:
        """How far samples (n, joints) are beyond the efforts, squared, and how near links come, added up."""
        over = np.maximum(np.abs(torque) / (EFFORT_SHARE * self._limits.effort) - 1.0, 0.0)
        return float((over**2).sum()) + (float(self._collision.depths(q).sum()) if self._collision else 0.0)

    def _needs(self, course: PlannedMotion) -> float:
        return self._excess(course.q, self._structure.regressor(course.q, course.v, course.a).torque)

    def admitted(self, series: FourierSeries, seconds: float, rate: float) -> tuple[PlannedMotion, float]:
        """The motion on an even clock, as large as efforts and distances of links allow.

        Args:
            series: of the joints.
            seconds: length; whole periods [s].
            rate: samples in a second [Hz].

        Returns:
            The motion, and its size: 1, or the part of each joint's way that is left.

        Raises:
            BadInput: next to no motion is left, because links meet or drives are too weak.
        """
        fine = np.linspace(0.0, self._period, int(np.ceil(self._period * max(rate, _HZ))) + 1)

        def fits(size: float) -> bool:
            return self._needs(series.at(fine, size)) <= 0.0

        low, high = (1.0, 1.0) if fits(1.0) else (0.0, 1.0)
        while high - low > 0.01:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fits(middle) else (low, middle)
        way = low * np.ptp(series.at(fine).q, axis=0)
        if not (way > _SMALLEST * (self._limits.high - self._limits.low)).all():
            places = ", ".join(f"{place:.2f}" for place in series.start)
            found = f"links that meet, or more effort than the drives have, around {places}"
            raise BadInput("motion", found=found, expected="room to move: other limits (--position), or --seed")
        self.check(series.at(fine, low))
        return series.at(np.linspace(0.0, seconds, round(seconds * rate) + 1), low), low

    def check(self, course: PlannedMotion) -> None:
        """Refuse a motion that goes beyond a limit, which none that was planned here does.

        Raises:
            MmtError: it does.
        """
        limits = self._limits
        within = (course.q >= limits.low) & (course.q <= limits.high) & (np.abs(course.v) <= limits.speed)
        if not (within & (np.abs(course.a) <= limits.acceleration)).all() or self._needs(course) > 0.0:
            raise MmtError("the motion goes beyond the joints' limits; nothing is written")


def period_of(seconds: float, limits: JointLimits, harmonics: int, band_hz: float) -> float:
    """The period that a motion of so many seconds repeats [s].

    In it the slowest joint can go to and fro over its whole way as a sine; no harmonic is above half the band.

    Args:
        seconds: length of the motion [s].
        limits: of the joints.
        harmonics: of the motion.
        band_hz: edge of the band in which a diagnosis compares torques [Hz].

    Raises:
        BadInput: there is not time for one period.
    """
    half = 0.5 * SHARE * (limits.high - limits.low)
    by_speed, by_acceleration = half / (SHARE * limits.speed), np.sqrt(half / (SHARE * limits.acceleration))
    least = 2.0 * harmonics / band_hz
    if seconds < least:
        raise BadInput("--seconds", found=f"{seconds:g}", expected=f"{least:g} or more, for {harmonics} harmonics")
    period = max(least, 2.0 * np.pi * float(np.maximum(by_speed, by_acceleration).max()))
    return seconds / max(1, int(seconds / period))


def write_course(course: PlannedMotion, path: str | Path) -> None:
    """Write a motion as CSV: `t`, then `q_0` ... `v_0` ... `a_0` ... of each joint, in the order of the model.

    Raises:
        BadInput: it cannot be written.
    """
    names = [f"{what}_{j}" for what in "qva" for j in range(course.q.shape[1])]
    table = np.column_stack([course.time, course.q, course.v, course.a])
    with replacing(path) as partial:
        np.savetxt(partial, table, delimiter=",", header=",".join(["t", *names]), comments="", fmt="%.9g")
