"""Operators' motions for the trial: strokes, dwells, slow slides and presses, every one different."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array

_CLEARANCE = 0.012  # [m] above the surface when lifted
_HAND_S = 0.033  # [s] width of the Gaussian that smooths strokes: little is left above 5 Hz
_PRESS_S = 0.05  # [s] of that for presses
_RUN_UP_S = 1.5  # [s] in the air before the first touch


@dataclass(frozen=True)
class ProbeMotion:
    """A probe's true motion; between samples it is the cubic spline through them.

    Attributes:
        time: (n,) [s], even.
        position, velocity: (n, 3) [m], [m/s], table frame.
        moves_x: whether the probe moves along x too.
    """

    time: Array
    position: Array
    velocity: Array
    moves_x: bool

    @property
    def contact(self) -> NDArray[np.bool_]:
        """Whether the tip is below the surface (n,)."""
        return self.position[:, 2] < 0.0


def draw_motion(
    rng: np.random.Generator, *, duration: float = 30.0, rate_hz: float = 1000.0, along_x: float = 0.2
) -> ProbeMotion:
    """The motion of an operator who knows what excites an object.

    Args:
        rng: what makes it different from all others.
        duration: [s], at least 10.
        rate_hz: samples per second.
        along_x: probability that it moves along x too.

    Raises:
        BadInput: too short a duration.
    """
    if duration < 10.0:
        raise BadInput("motion", at="duration", found=f"{duration} s", expected="10 s or more")
    time = np.arange(round(duration * rate_hz)) / rate_hz
    y = strokes(rng, time)
    moves_x = bool(rng.random() < along_x)
    x = np.full_like(time, rng.uniform(-0.4, 0.4))
    if moves_x:
        x += rng.uniform(0.3, 0.8) * strokes(rng, time)
    z = _presses(rng, time, int(rng.integers(2, 4)))
    position = np.column_stack([x, y, z])
    return ProbeMotion(time, position, CubicSpline(time, position)(time, 1), moves_x)


def _smooth(time: Array, values: Array, width_s: float) -> Array:
    smoothed: Array = gaussian_filter1d(values, width_s / (time[1] - time[0]), mode="nearest")
    return smoothed


def strokes(rng: np.random.Generator, time: Array) -> Array:
    """A hand's motion along one axis (n,) [m] at even times [s]."""
    duration = time[-1]
    # Strokes: more than a decade of frequencies, their velocities about even; then the hand holds still or slides
    # slowly now and then, and goes on from there, so that its position wanders without running away.
    top = rng.uniform(3.0, 4.8)
    rate = np.zeros_like(time)
    for f in np.geomspace(rng.uniform(0.12, 0.2), top, 9) * rng.uniform(0.93, 1.07, 9):
        amplitude = rng.uniform(0.4, 1.0) * min(0.012, 0.0075 / f**0.75)
        swell = 1.0 + 0.7 * np.sin(2.0 * np.pi * time / rng.uniform(5.0, 12.0) + rng.uniform(0.0, 6.3))
        rate += 2.0 * np.pi * f * amplitude * swell * np.cos(2.0 * np.pi * f * time + rng.uniform(0.0, 6.3))
    at = rng.uniform(2.5, 5.0)
    while at < duration - 1.5:
        length = float(rng.choice([0.4, 0.8, 1.2, 2.0]) * rng.uniform(0.8, 1.2))
        held = (time >= at) & (time < at + length)
        slow = rng.choice([-1.0, 1.0]) * rng.uniform(0.004, 0.025) if rng.random() < 0.4 else 0.0
        rate[held] = slow
        at += length + rng.uniform(2.0, 5.0)
    step = time[1] - time[0]
    coarse = slice(None, None, round(0.05 / step))  # enough for what varies over seconds
    drift = np.interp(time, time[coarse], _smooth(time[coarse], np.cumsum(rate)[coarse] * step, 4.0))
    moving = np.abs(rate) > 0.03
    pull = np.where(moving, np.gradient(drift, step), 0.0)  # back towards the middle, while the hand moves anyway
    y = np.cumsum(rate - 0.8 * pull) * step
    y -= np.mean(y)
    y *= min(1.0, 0.09 / np.max(np.abs(y)))
    return _smooth(time, y, _HAND_S)


def _presses(rng: np.random.Generator, time: Array, count: int) -> Array:
    """Height of the probe (n,) [m]: `count` presses, each modulated, with lifts between them."""
    duration = time[-1]
    depth = rng.uniform(0.006, 0.011)
    pressed = np.full_like(time, -depth)
    for low, high, part in ((0.1, 0.4, 0.3), (0.5, 1.2, 0.22), (1.5, 2.5, 0.08)):
        amplitude = part * depth * rng.uniform(0.5, 1.0)
        pressed += amplitude * np.sin(2.0 * np.pi * rng.uniform(low, high) * time + rng.uniform(0.0, 6.3))
    lifted = np.zeros(len(time), dtype=bool)
    first = min(_RUN_UP_S, 0.15 * duration) * rng.uniform(0.8, 1.1)
    lifted |= (time < first) | (time > duration - rng.uniform(0.5, 1.2))
    for i in range(1, count):
        middle = duration * i / count + rng.uniform(-1.0, 1.0)
        lifted |= np.abs(time - middle) < rng.uniform(0.4, 0.9)
    return _smooth(time, np.where(lifted, _CLEARANCE, pressed), _PRESS_S)
