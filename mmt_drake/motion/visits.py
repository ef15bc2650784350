"""A scripted motion from one object to the next and back to the first, which may be lifted and carried."""

import math

import numpy as np

from mmt_drake.motion.analytic import AnalyticMotion, Row, step, wave
from mmt_drake.motion.reaching import TOUCH_S, at_least, press, reach

_TRAVEL_S, _STROKES_S = 0.9, 3.4  # of a visit: on the way there; of strokes before the push
_BEFORE_S = 0.5  # strokes begin before the hand is all the way down: it touches while it moves
_LEAST_S = 7.0
_CARRIED_S = 14.8  # the visit in which the first is carried


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
    given = amplitude, frequency, push, depth, clearance, seed
    return _visits(duration, each, apart, first_low, last_low, *given, (0.0, 0.0, 0.0))


def carry_over(
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
    lift: float = 0.09,
    aside: float = 0.12,
    swing: float = 0.008,
) -> AnalyticMotion:
    """`visits`, but when the hand comes back to the first it lifts that over the middle one and puts it down beside it.

    A grip that closes 5.1 s after the start of that visit, the fourth, and opens 13.9 s after it has it lifted, swung,
    carried over the middle one and put down beside that, along y.

    Args:
        duration: [s]; as many visits as there is time for, 38.2 s at least.
        each, apart, first_low, last_low, amplitude, frequency, push, depth, clearance: as for `visits`.
        lift: by which the first is lifted [m].
        aside: from the middle one to where it is put down [m].
        swing: amplitude of the sines that make it swing [m].
    """
    at_least("carry_over", duration, 3.0 * each + _CARRIED_S + _TRAVEL_S)
    given = amplitude, frequency, push, depth, clearance, 0
    return _visits(duration, each, apart, first_low, last_low, *given, (lift, aside, swing))


def _visits(
    duration: float,
    each: float,
    apart: float,
    first_low: float,
    last_low: float,
    amplitude: float,
    frequency: float,
    push: float,
    depth: float,
    clearance: float,
    seed: int,
    carried: tuple[float, float, float],
) -> AnalyticMotion:
    """As `visits`; `carried`: lift, aside and swing of `carry_over`."""
    lift, aside, swing = carried
    at_least("visits", each, _LEAST_S)
    at_least("visits", duration, each)
    random = np.random.RandomState(seed)
    places, low = (-apart, 0.0, apart), (first_low, 0.0, last_low)
    x, y, steps, waves = 0.0, 0.0, list[Row](), list[Row]()
    start, i = 0.0, 0
    while start + (lasts := _CARRIED_S if lift > 0.0 and i == 3 else each) <= duration - _TRAVEL_S:
        which = i % 3
        steps += reach(start, start + _TRAVEL_S, (places[which] - x, -y))
        x, y = places[which], 0.0
        begin, end = start + _TRAVEL_S, start + lasts
        steps += press(begin, end, clearance + low[which] + depth)
        begin += TOUCH_S
        for share, ratio in ((0.4, 1.0), (0.5, 0.61), (1.0, 0.37)):
            waves.append(wave(1, begin - _BEFORE_S, begin + _STROKES_S, share * amplitude, ratio * frequency))
        waves.append(wave(0, begin - _BEFORE_S, begin + _STROKES_S, 0.5 * amplitude, 0.5 * frequency))
        start, i = end, i + 1
        if lasts == _CARRIED_S and i == 4:
            lifted = end - _CARRIED_S + 5.4
            steps += [step(2, lifted, lifted + 1.2, lift), step(2, lifted + 6.4, lifted + 7.8, -lift)]
            steps += reach(lifted + 3.6, lifted + 5.2, (apart, 0.0)) + reach(lifted + 5.2, lifted + 6.2, (0.0, aside))
            waves.append(wave(0, lifted + 1.2, lifted + 3.6, swing, 1.3, end_frequency=2.2))
            waves.append(wave(1, lifted + 1.2, lifted + 3.6, 0.6 * swing, 0.9, end_frequency=1.8))
            x, y = x + apart, aside
            continue
        angle = math.pi if which == 2 else 0.0
        if seed:
            angle = random.uniform(0.0, 2.0 * math.pi)
        there = push * math.cos(angle), push * math.sin(angle)
        pushed, back = begin + _STROKES_S + 0.9, end - TOUCH_S - 0.3
        steps += reach(begin + _STROKES_S, pushed, there)
        steps += reach(pushed, back, (-there[0], -there[1]))
    steps += reach(duration - _TRAVEL_S, duration, (-x, -y)) if x or y else []
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)
