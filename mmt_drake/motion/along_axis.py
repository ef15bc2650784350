"""Scripted motions along one axis: strokes, sweeps and sums of sines, pressed."""

import math

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import AnalyticMotion, Row, wave
from mmt_drake.motion.reaching import AXES, TOUCH_S, at_least, press

_RETURN_S = 0.4  # before a lift in which strokes rest, so that the object is put down where it was taken up
_MOST_SINES = 20  # the slowest of them then is ten thousand times slower than the fastest


def strokes(
    *,
    duration: float = 60.0,
    amplitude: float = 0.03,
    frequency: float = 3.6,
    depth: float = 0.004,
    clearance: float = 0.01,
    lifts: int = 2,
    axis: str = "y",
    first: str = "fast",
) -> AnalyticMotion:
    """Strokes along one axis, fast at first and then slow, like figure 8 of the thesis.

    The hand touches the object while moving, strokes it fast (three sines, the highest at
    `frequency`) for 5 s or a third of the time, then slowly, back to the middle, lifts off and touches
    again, `lifts` times. The pressing depth sways by a quarter, the other axis moves a tenth. With
    `first` = "slow" each touch begins with the slow strokes.

    Args:
        duration: [s], at least 4 s for each touch.
        amplitude: of the slowest stroke [m].
        frequency: highest frequency [Hz]; 3.6 Hz is the object's highest mode in the thesis.
        depth: mean pressing depth [m].
        clearance: height above the surface when lifted [m].
        lifts: how often contact is broken and made again within `duration`.
        axis: "x" or "y", along which it mostly slides.
        first: "fast" or "slow": the strokes that each touch begins with.
    """
    along = AXES[axis]
    block = duration / (lifts + 1)
    if block < 4.0:
        expected = f">= {4 * (lifts + 1)} s with {lifts} lifts"
        raise BadInput("strokes", at="duration", found=f"{duration} s", expected=expected)
    fast = min(5.0, block / 3.0)
    steps, waves = [], []
    for i in range(lifts + 1):
        start, end = i * block, (i + 1) * block
        steps += press(start, end - 0.2, clearance + depth)
        rest = end - 0.2 - TOUCH_S - _RETURN_S
        quick, slow = (start + 0.3, start + fast + 0.5), (start + fast, rest)
        if first == "slow":
            quick, slow = (rest - fast - 0.2, rest), (start + 0.3, rest - fast)
        for share, ratio in ((0.25, 1.0), (0.3, 0.61), (0.4, 0.37)):
            waves.append(wave(along, *quick, share * amplitude, ratio * frequency))
        for share, ratio in ((1.0, 0.031), (0.5, 0.083), (0.25, 0.23)):
            waves.append(wave(along, *slow, share * amplitude, ratio * frequency))
        waves.append(wave(1 - along, start + 0.3, rest, 0.1 * amplitude, 0.17 * frequency))
        waves.append(wave(2, start + TOUCH_S, end - TOUCH_S - 0.2, 0.25 * depth, 0.11 * frequency))
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)


def chirp(
    *,
    duration: float = 60.0,
    amplitude: float = 0.02,
    end_amplitude: float = 0.002,
    frequency: float = 0.1,
    end_frequency: float = 10.0,
    depth: float = 0.004,
    clearance: float = 0.01,
    axis: str = "y",
) -> AnalyticMotion:
    """An exponential sweep of frequency along one axis while pressed.

    Args:
        duration: [s], more than 4 s.
        amplitude, end_amplitude: at the low and at the high end [m]; it shrinks as a hand's does.
        frequency, end_frequency: from, to [Hz].
        depth: pressing depth [m].
        clearance: height above the surface before and after [m].
        axis: "x" or "y".
    """
    at_least("chirp", duration, 4.0)
    sweep = wave(
        AXES[axis],
        TOUCH_S,
        duration - TOUCH_S - 0.2,
        amplitude,
        frequency,
        end_amplitude=end_amplitude,
        end_frequency=end_frequency,
    )
    return _pressed(duration, depth, clearance, [sweep])


def sines(
    *,
    duration: float = 60.0,
    amplitude: float = 0.04,
    frequency: float = 3.0,
    count: int = 5,
    depth: float = 0.004,
    clearance: float = 0.01,
    axis: str = "y",
    seed: int = 0,
) -> AnalyticMotion:
    """A sum of sines whose frequencies have no common multiple, while pressed.

    Neighbouring frequencies stand in the ratio 1.6180... (the golden section), and each sine has the
    same peak velocity.

    Args:
        duration: [s], more than 4 s.
        amplitude: of all sines together, at most [m].
        frequency: the highest [Hz].
        count: number of sines, 20 at most.
        depth: pressing depth [m].
        clearance: height above the surface before and after [m].
        axis: "x" or "y".
        seed: of the phases.
    """
    at_least("sines", duration, 4.0)
    if count > _MOST_SINES:
        raise BadInput("sines", at="count", found=count, expected=f"at most {_MOST_SINES}")
    random = np.random.RandomState(seed)
    ratios = [((1.0 + math.sqrt(5.0)) / 2.0) ** -i for i in range(count)]
    share = amplitude / sum(1.0 / ratio for ratio in ratios)
    waves = [
        wave(
            AXES[axis], 0.3, duration - 0.3, share / ratio, ratio * frequency, phase=random.uniform(0.0, 2.0 * math.pi)
        )
        for ratio in ratios
    ]
    return _pressed(duration, depth, clearance, waves)


def stroke_and_hold(
    *,
    duration: float = 60.0,
    stroking: float = 25.0,
    amplitude: float = 0.02,
    frequency: float = 2.0,
    depth: float = 0.005,
    clearance: float = 0.01,
    axis: str = "y",
) -> AnalyticMotion:
    """Strokes along one axis, then stillness in contact: what still moves then, moves by itself.

    The hand touches, strokes with three sines, the highest at `frequency`, rests half a second, lifts and touches
    again, and holds still, pressed, until just before the end.

    Args:
        duration: [s], at least 6 s more than `stroking`.
        stroking: time before the hand lifts and touches again [s], at least 3 s.
        amplitude: of the slowest sine [m].
        frequency: highest frequency [Hz].
        depth: pressing depth [m].
        clearance: height above the surface when lifted [m].
        axis: "x" or "y", along which it strokes.
    """
    at_least("stroke_and_hold", duration, stroking + 6.0)
    if stroking < 3.0:
        raise BadInput("stroke_and_hold", at="stroking", found=f"{stroking} s", expected=">= 3 s")
    steps = press(0.0, stroking + TOUCH_S, clearance + depth)
    steps += press(stroking + 2.0 * TOUCH_S, duration - 0.2, clearance + depth)
    waves = [
        wave(AXES[axis], 0.3, stroking - 0.5, share * amplitude, ratio * frequency)
        for share, ratio in ((0.25, 1.0), (0.4, 0.61), (1.0, 0.23))
    ]
    waves.append(wave(1 - AXES[axis], 0.3, stroking - 0.5, 0.2 * amplitude, 0.37 * frequency))
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)


def holding_since(stroking: float) -> float:
    """When `stroke_and_hold` begins to hold still in contact [s]."""
    return stroking + 3.0 * TOUCH_S


def _pressed(duration: float, depth: float, clearance: float, waves: list[Row]) -> AnalyticMotion:
    """These waves on one touch that lasts nearly to the end."""
    steps = press(0.0, duration - 0.2, clearance + depth)
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)
