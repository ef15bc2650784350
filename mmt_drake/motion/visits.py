"""A scripted motion from one object to the next and back to the first."""

import math

import numpy as np

from mmt_drake.motion.analytic import AnalyticMotion, Row, wave
from mmt_drake.motion.reaching import TOUCH_S, at_least, press, reach

_TRAVEL_S, _STROKES_S = 0.9, 3.4  # of a visit: on the way there; of strokes before the push
_BEFORE_S = 0.5  # strokes begin before the hand is all the way down: it touches while it moves
_LEAST_S = 7.0


def visits(
    *,
    duration: float = 60.0,
    each: float = 7.5,
    apart: float = 0.13,
    first_low: float = 0.02,
    last_low: float = 0.01,
    amplitude: float = 0.008,
    frequency: float = 3.6,
    push: float = 0.03,
    depth: float = 0.004,
    clearance: float = 0.015,
    seed: int = 0,
) -> AnalyticMotion:
    """Three objects on a line are touched in turn, stroked, pushed away and drawn back, again and again.

    They stand along x; the middle one's top is at z = 0. Each is stroked (three sines along y, one along x), then
    pushed, along x or in a direction that is drawn, and drawn back to where it was: the hand is blind, and finds it
    there again. In between the hand travels above the highest.

    Args:
        duration: [s]; as many visits as there is time for.
        each: time of a visit [s], at least 7 s.
        apart: between the middles of two neighbours [m].
        first_low, last_low: how much lower than the middle one's the tops of the first and the last are [m].
        amplitude: of the strokes [m].
        frequency: highest frequency of the strokes [Hz].
        push: how far an object is pushed [m].
        depth: pressing depth [m].
        clearance: height of the way above the highest top [m].
        seed: of the directions of pushes; 0: each along x, towards the middle.
    """
    at_least("visits", each, _LEAST_S)
    at_least("visits", duration, each)
    random = np.random.RandomState(seed)
    places, low = (-apart, 0.0, apart), (first_low, 0.0, last_low)
    here, steps, waves = 0.0, list[Row](), list[Row]()
    for i in range(int((duration - _TRAVEL_S) / each)):
        start, which = i * each, i % 3
        steps += reach(start, start + _TRAVEL_S, (places[which] - here, 0.0))
        here = places[which]
        begin, end = start + _TRAVEL_S, start + each
        steps += press(begin, end, clearance + low[which] + depth)
        begin += TOUCH_S
        for share, ratio in ((0.4, 1.0), (0.5, 0.61), (1.0, 0.37)):
            waves.append(wave(1, begin - _BEFORE_S, begin + _STROKES_S, share * amplitude, ratio * frequency))
        waves.append(wave(0, begin - _BEFORE_S, begin + _STROKES_S, 0.5 * amplitude, 0.5 * frequency))
        angle = math.pi if which == 2 else 0.0
        if seed:
            angle = random.uniform(0.0, 2.0 * math.pi)
        there = push * math.cos(angle), push * math.sin(angle)
        pushed, back = begin + _STROKES_S + 0.9, end - TOUCH_S - 0.3
        steps += reach(begin + _STROKES_S, pushed, there)
        steps += reach(pushed, back, (-there[0], -there[1]))
    steps += reach(duration - _TRAVEL_S, duration, (-here, 0.0)) if here else []
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)
