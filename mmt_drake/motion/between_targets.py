"""Scripted motions between places that are drawn at random."""

import math

import numpy as np

from mmt_drake.motion.analytic import AnalyticMotion, Row, wave
from mmt_drake.motion.reaching import TOUCH_S, at_least, fitts_duration, press, reach


def press_slide_lift(
    *,
    duration: float = 30.0,
    amplitude: float = 0.06,
    depth: float = 0.004,
    clearance: float = 0.01,
    touches: int = 4,
    seed: int = 0,
) -> AnalyticMotion:
    """Touch, slide, lift, and touch again elsewhere.

    Args:
        duration: [s], at least 3 s a touch.
        amplitude: half-width of the square in which places are drawn [m]; each slide is between
            a half and all of it long.
        depth: pressing depth [m].
        clearance: height above the surface when lifted [m].
        touches: number of touches within `duration`, each at a place of its own.
        seed: of the places.
    """
    at_least("press_slide_lift", duration, 3.0 * touches)
    random = np.random.RandomState(seed)
    period = duration / touches
    here = np.zeros(2)
    steps: list[Row] = []
    for i in range(touches):
        start = i * period
        landing = np.full(2, np.inf)
        while np.abs(landing).max() > amplitude:
            slide = amplitude * random.uniform(0.5, 1.0) * _direction(random)
            landing = here + slide
        away = -landing if i == touches - 1 else random.uniform(-amplitude, amplitude, 2) - landing
        steps += press(start, start + 0.75 * period, clearance + depth)
        steps += reach(start + 0.2 * period, start + 0.6 * period, (slide[0], slide[1]))
        steps += reach(start + 0.75 * period, start + period, (away[0], away[1]))
        here = landing + away
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, cycle=duration)


def reaches(
    *,
    duration: float = 60.0,
    amplitude: float = 0.06,
    width: float = 0.005,
    depth: float = 0.004,
    clearance: float = 0.01,
    tremor: float = 1e-4,
    seed: int = 0,
) -> AnalyticMotion:
    """Minimum-jerk reaches between random places, four to a touch, with tremor of 8 to 12 Hz.

    Args:
        duration: [s], at least 6 s.
        amplitude: half-width of the square in which places are drawn [m].
        width: of the targets [m]; sets how long a reach takes (Fitts).
        depth: pressing depth [m].
        clearance: height above the surface when lifted [m].
        tremor: root-mean-square tremor of each axis [m].
        seed: of places, pauses and tremor.
    """
    at_least("reaches", duration, 6.0)
    random = np.random.RandomState(seed)
    here, now = np.zeros(2), 0.0
    steps: list[Row] = []
    home = 2.0 + fitts_duration(2.0 * math.sqrt(2.0) * amplitude, width)  # [s] kept to lift and return
    while now + home < duration:
        touch = now
        now += TOUCH_S
        for _ in range(4):
            there = random.uniform(-amplitude, amplitude, 2)
            move = there - here
            took = fitts_duration(float(np.hypot(*move)), width)
            if now + took + home > duration:
                break
            steps += reach(now, now + took, (move[0], move[1]), bow=0.05 * float(np.hypot(*move)))
            here, now = there, now + took + random.uniform(0.05, 0.4)
        now += TOUCH_S
        steps += press(touch, now, clearance + depth)
    steps += reach(now, duration, (-here[0], -here[1]))
    waves = []
    for axis in range(3):
        for _ in range(3):  # three sines beat irregularly
            waves.append(
                wave(
                    axis,
                    0.0,
                    duration,
                    tremor * math.sqrt(2.0 / 3.0),
                    random.uniform(8.0, 12.0),
                    phase=random.uniform(0.0, 2.0 * math.pi),
                    ramp=1.0,
                )
            )
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)


def _direction(random: np.random.RandomState) -> np.ndarray:
    angle = random.uniform(0.0, 2.0 * math.pi)
    return np.array([math.cos(angle), math.sin(angle)])
