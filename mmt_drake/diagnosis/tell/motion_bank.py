"""Motions, and inputs, that bring out what one recording alone may not show.

Every motion begins and ends at rest above the object and opens with eight seconds of strokes, which determine the
parameters that the model has anyway; what follows is for the physics in doubt.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import signal

from mmt_drake.motion.along_axis import chirp, sines, strokes
from mmt_drake.motion.analytic import AnalyticMotion, Row, step, wave
from mmt_drake.motion.between_targets import press_slide_lift
from mmt_drake.motion.reaching import TOUCH_S, press
from mmt_drake.numeric.arrays import Array

_OPENING_S = 8.0
_WIDEST = 0.1  # m to each side
_DEEPEST = 0.02  # m
_SWEEP_TO_HZ = 8.0
_OVERLAP = 8  # minimum-jerk steps that make one steady slide
_STROKE_RATE = 0.25 + 0.3 * 0.61 + 0.4 * 0.37  # peak velocity of scripted strokes over amplitude and top frequency


@dataclass(frozen=True)
class Reach:
    """What a hand may do.

    Attributes:
        axis: x or y, along which it slides.
        amplitude: how far to each side [m].
        speed: how fast [m/s].
        depth: how deep it presses [m].
        duration: how long a motion takes [s].
        top_hz: highest frequency of its strokes.
        clearance: height above the surface when lifted [m].
    """

    axis: str
    amplitude: float
    speed: float
    depth: float
    duration: float
    top_hz: float = 3.6
    clearance: float = 0.01

    @property
    def along(self) -> int:
        """The number of the axis."""
        return "xy".index(self.axis)

    @property
    def heights(self) -> dict[str, Any]:
        """Depth and clearance, as motions take them."""
        return {"depth": self.depth, "clearance": self.clearance}

    @property
    def stroke(self) -> float:
        """How far strokes with the highest frequency in them go to each side [m], for all that speed allows."""
        return min(self.amplitude, self.speed / (_STROKE_RATE * 2.0 * math.pi * self.top_hz))


@dataclass(frozen=True)
class BankMotion:
    """One motion of the bank.

    Attributes:
        name: a few words.
        text: how to make it by hand, a sentence without its full stop.
        parts: one after another, each from rest to rest at (0, 0, clearance).
        of_surface: whether it is its presses and lifts that matter, which one axis alone does not have.
    """

    name: str
    text: str
    parts: tuple[AnalyticMotion, ...]
    of_surface: bool = False

    @property
    def duration(self) -> float:
        """[s]."""
        return math.fsum(part.cycle for part in self.parts)

    def sample(self, rate_hz: float) -> tuple[Array, Array, Array]:
        """Times (n,) [s], positions (n, 3) [m] and velocities (n, 3) [m/s]."""
        time = np.arange(round(self.duration * rate_hz)) / rate_hz
        position, velocity = np.empty((len(time), 3)), np.empty((len(time), 3))
        start = 0.0
        for part in self.parts:
            own = (time >= start) & (time < start + part.cycle)
            position[own], velocity[own] = part.sample(time[own] - start)
            start += part.cycle
        return time, position, velocity


def motions(reach: Reach) -> list[BankMotion]:
    """The bank for a hand, each motion within its reach."""
    rest = max(reach.duration - _OPENING_S, 12.0)
    opening, again = _strokes(reach, _OPENING_S, lifts=0), _strokes(reach, rest, lifts=1)

    def after(name: str, text: str, *parts: AnalyticMotion, of_surface: bool = False) -> BankMotion:
        return BankMotion(name, text, (opening, *parts), of_surface)

    return [
        after("strokes", "strokes fast and slow", again),
        after(
            "slow strokes with dwells",
            "slow strokes of different speed, standing still for a second after each",
            _slow_with_dwells(reach, rest),
        ),
        after("steady slides", "slides of steady speed, each twice as fast as the one before", _steady(reach, rest)),
        after("growing strokes", "strokes that grow from a fifth of a millimetre to full size", _growing(reach, rest)),
        after(
            "presses of several depths",
            "the same strokes pressed lightly, as before, and twice and three times as deep",
            *(_pressed(reach, 0.25 * rest, min(share * reach.depth, _DEEPEST)) for share in (0.4, 1.0, 2.0, 3.0)),
            of_surface=True,
        ),
        after(
            "a sweep of frequency",
            "strokes from one in ten seconds up to eight a second, smaller as they get faster",
            _sweep(reach, rest),
        ),
        after("large fast strokes", "strokes half as far and half as fast again", _large(reach, rest)),
        after(
            "touches with free space between",
            "short slides with seconds in the air between them",
            _touches(reach, rest),
            of_surface=True,
        ),
        BankMotion("twice as long", "strokes as before for twice the time", (opening, again, opening, again)),
    ]


def _strokes(reach: Reach, duration: float, lifts: int) -> AnalyticMotion:
    return strokes(
        duration=duration, amplitude=reach.stroke, frequency=reach.top_hz, lifts=lifts, axis=reach.axis, **reach.heights
    )


def _sweep(reach: Reach, duration: float) -> AnalyticMotion:
    far, hz = reach.amplitude, _SWEEP_TO_HZ
    end = min(0.1 * far, reach.speed / (2.0 * math.pi * hz))
    return chirp(
        duration=duration, amplitude=far, end_amplitude=end, end_frequency=hz, axis=reach.axis, **reach.heights
    )


def _large(reach: Reach, duration: float) -> AnalyticMotion:
    far = min(1.5 * reach.amplitude, _WIDEST)
    hz = min(1.5 * reach.speed / (math.pi * far), reach.top_hz)
    return sines(duration=duration, amplitude=far, frequency=hz, axis=reach.axis, **reach.heights)


def _touches(reach: Reach, duration: float) -> AnalyticMotion:
    touches = max(2, int(duration / 5.0))
    return press_slide_lift(duration=duration, amplitude=reach.amplitude, touches=touches, **reach.heights)


def _pressed(reach: Reach, duration: float, depth: float) -> AnalyticMotion:
    """One touch with strokes of three frequencies."""
    waves = [
        wave(reach.along, TOUCH_S, duration - TOUCH_S, share * reach.stroke, ratio * reach.top_hz)
        for share, ratio in ((0.5, 0.61), (1.0, 0.2), (0.6, 0.083))
    ]
    return _touching(reach, duration, [(0.0, duration)], [], waves, depth)


def _slow_with_dwells(reach: Reach, duration: float) -> AnalyticMotion:
    """Four moves a touch between points, from 0.5 s to 4 s long, each followed by a second's rest."""
    moves: list[Row] = []
    contacts, here, now, k = [], 0.0, 0.0, 0
    points, lengths = (0.6, -0.3, 1.0, 0.2, -0.8, 0.5, -1.0), (1.5, 0.7, 3.0, 0.5, 2.0, 4.0)
    while now + 10.0 < duration:
        begin = now
        now += TOUCH_S + 0.4
        for _ in range(4):
            there, length = points[k % len(points)] * reach.amplitude, lengths[k % len(lengths)]
            if now + length + 1.0 + 3.0 > duration:
                break
            moves.append(step(reach.along, now, now + length, there - here))
            here, now, k = there, now + length + 1.0, k + 1
        now += TOUCH_S
        contacts.append((begin, now))
        now += 1.0
    moves.append(step(reach.along, contacts[-1][1], duration, -here))
    return _touching(reach, duration, contacts, moves, [], reach.depth)


def _steady(reach: Reach, duration: float) -> AnalyticMotion:
    """Slides there and back, one touch, the time of each in geometric progression."""
    room = duration - 2.0 * TOUCH_S - 1.0
    speeds = [2.0**k for k in range(6)]
    times = np.array([1.0 / speed for speed in speeds])
    shortest = 2.0 * (1.0 + 1.0 / _OVERLAP) * reach.amplitude / reach.speed
    times = np.maximum(times * (room - 12 * 0.3) / (2.0 * times.sum()), shortest)
    moves, now, here = [], TOUCH_S + 0.2, 0.0
    for length in times:
        for there in (reach.amplitude, -reach.amplitude):
            if now + length + 0.3 > duration - TOUCH_S:
                break
            moves += _slide(reach.along, now, now + length, there - here)
            here, now = there, now + length + 0.3
    moves.append(step(reach.along, duration - 2.0 * TOUCH_S, duration, -here))
    return _touching(reach, duration, [(0.0, duration - 2.0 * TOUCH_S)], moves, [], reach.depth)


def _slide(axis: int, start: float, end: float, displacement: float) -> list[Row]:
    """A slide of nearly steady speed: overlapping steps."""
    pace = (end - start) / (_OVERLAP + 1)
    return [step(axis, start + k * pace, start + (k + 2) * pace, displacement / _OVERLAP) for k in range(_OVERLAP)]


def _growing(reach: Reach, duration: float) -> AnalyticMotion:
    """One touch, a sine that grows."""
    frequency = min(0.8, reach.top_hz, reach.speed / (2.0 * math.pi * reach.amplitude))
    grown = wave(reach.along, TOUCH_S, duration - TOUCH_S - 0.2, 2e-4, frequency, end_amplitude=reach.amplitude)
    return _touching(reach, duration, [(0.0, duration)], [], [grown], reach.depth)


def _touching(
    reach: Reach, duration: float, contacts: list[tuple[float, float]], moves: list[Row], waves: list[Row], depth: float
) -> AnalyticMotion:
    """Moves and waves with the object touched from the first to the second time of each pair."""
    height = reach.clearance + depth
    presses = [row for start, end in contacts for row in press(start, end, height)]
    return AnalyticMotion((0.0, 0.0, reach.clearance), steps=[*moves, *presses], waves=waves, cycle=duration)


@dataclass(frozen=True)
class BankInput:
    """An input for a driven body.

    Attributes:
        name: a few words.
        text: what it is, a sentence without its full stop; `{top}` is its highest frequency [Hz].
        shape: (n,) times [s] from 0 and the highest frequency [Hz] -> (n,) values, at most 1 in size.
    """

    name: str
    text: str
    shape: Callable[[Array, float], Array]


def _several_sines(t: Array, top_hz: float) -> Array:
    ratios = ((1.0 + math.sqrt(5.0)) / 2.0) ** -np.arange(4.0)
    summed = np.sin(2.0 * math.pi * top_hz * np.outer(t, ratios)).sum(axis=1)
    return np.asarray(summed / np.abs(summed).max())


def _pulses(t: Array, top_hz: float) -> Array:
    """There, back, rest, in three sizes by turns."""
    period = 2.0 / top_hz
    sizes = np.array([0.5, 0.75, 1.0])[(t / period).astype(np.intp) % 3]
    phase = t / period % 1.0
    return np.asarray(sizes * np.where(phase < 0.25, 1.0, np.where(phase < 0.5, -1.0, 0.0)))


INPUTS = (
    BankInput("several sines", "four sines at once, the fastest of {top:.2g} Hz", _several_sines),
    BankInput("pulses", "pulses to both sides in three sizes, with rests between, {top:.2g} Hz", _pulses),
    BankInput(
        "triangle",
        "a triangle of {top:.2g} Hz",
        lambda t, hz: signal.sawtooth(2.0 * math.pi * hz * t + 0.5 * math.pi, width=0.5),
    ),
    BankInput(
        "growing sine",
        "a sine of {top:.2g} Hz that grows thirtyfold",
        lambda t, hz: 10.0 ** (1.5 * (t / t[-1] - 1.0)) * np.sin(2.0 * math.pi * hz * t),
    ),
    BankInput(
        "a sweep of frequency",
        "a sine whose frequency falls twentyfold from twice {top:.2g} Hz",
        lambda t, hz: signal.chirp(t, 2.0 * hz, t[-1], 0.1 * hz, method="logarithmic", phi=-90.0),
    ),
)
"""The bank for a driven body."""
