"""Named motions of the operator's hand, in closed form.

Every motion begins and ends at rest at (0, 0, clearance) [m], above the object, and begins again
after `duration` seconds. Contact is z < 0. With the default parameters the hand stays below 1 m/s and
within 0.1 m of the middle.
"""

from __future__ import annotations

import inspect
import math
import numbers
from collections.abc import Callable

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.motion.analytic import AnalyticMotion, Row, step, wave
from mmt_drake.motion.reaching import fitts_duration, reach

_TOUCH = 0.6  # [s] that the hand takes from above the surface into the object, and back
_RETURN = 0.4  # [s] before a lift in which strokes rest, so that the object is put down where it was taken up
_AXES = {"x": 0, "y": 1}
_CHOICES = {"axis": tuple(_AXES), "first": ("fast", "slow")}
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
    along = _AXES[axis]
    block = duration / (lifts + 1)
    if block < 4.0:
        expected = f">= {4 * (lifts + 1)} s with {lifts} lifts"
        raise BadInput("strokes", at="duration", found=f"{duration} s", expected=expected)
    fast = min(5.0, block / 3.0)
    steps, waves = [], []
    for i in range(lifts + 1):
        start, end = i * block, (i + 1) * block
        steps += _press(start, end - 0.2, clearance + depth)
        rest = end - 0.2 - _TOUCH - _RETURN
        quick, slow = (start + 0.3, start + fast + 0.5), (start + fast, rest)
        if first == "slow":
            quick, slow = (rest - fast - 0.2, rest), (start + 0.3, rest - fast)
        for share, ratio in ((0.25, 1.0), (0.3, 0.61), (0.4, 0.37)):
            waves.append(wave(along, *quick, share * amplitude, ratio * frequency))
        for share, ratio in ((1.0, 0.031), (0.5, 0.083), (0.25, 0.23)):
            waves.append(wave(along, *slow, share * amplitude, ratio * frequency))
        waves.append(wave(1 - along, start + 0.3, rest, 0.1 * amplitude, 0.17 * frequency))
        waves.append(wave(2, start + _TOUCH, end - _TOUCH - 0.2, 0.25 * depth, 0.11 * frequency))
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
    _at_least("chirp", duration, 4.0)
    sweep = wave(
        _AXES[axis],
        _TOUCH,
        duration - _TOUCH - 0.2,
        amplitude,
        frequency,
        end_amplitude=end_amplitude,
        end_frequency=end_frequency,
    )
    steps = _press(0.0, duration - 0.2, clearance + depth)
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=[sweep], cycle=duration)


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
    _at_least("press_slide_lift", duration, 3.0 * touches)
    random = np.random.RandomState(seed)
    period = duration / touches
    here = np.zeros(2)
    steps: list[Row] = []
    for i in range(touches):
        start = i * period
        slide = amplitude * random.uniform(0.5, 1.0) * _direction(random)
        landing = here + slide
        while np.abs(landing).max() > amplitude:
            slide = amplitude * random.uniform(0.5, 1.0) * _direction(random)
            landing = here + slide
        away = -landing if i == touches - 1 else random.uniform(-amplitude, amplitude, 2) - landing
        steps += _press(start, start + 0.75 * period, clearance + depth)
        steps += reach(start + 0.2 * period, start + 0.6 * period, (slide[0], slide[1]))
        steps += reach(start + 0.75 * period, start + period, (away[0], away[1]))
        here = landing + away
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, cycle=duration)


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
    _at_least("sines", duration, 4.0)
    if count > _MOST_SINES:
        raise BadInput("sines", at="count", found=count, expected=f"at most {_MOST_SINES}")
    random = np.random.RandomState(seed)
    ratios = [((1.0 + math.sqrt(5.0)) / 2.0) ** -i for i in range(count)]
    share = amplitude / sum(1.0 / ratio for ratio in ratios)
    waves = [
        wave(
            _AXES[axis],
            0.3,
            duration - 0.3,
            share / ratio,
            ratio * frequency,
            phase=random.uniform(0.0, 2.0 * math.pi),
        )
        for ratio in ratios
    ]
    steps = _press(0.0, duration - 0.2, clearance + depth)
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)


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
    _at_least("reaches", duration, 6.0)
    random = np.random.RandomState(seed)
    here, now = np.zeros(2), 0.0
    steps: list[Row] = []
    home = 2.0 + fitts_duration(2.0 * math.sqrt(2.0) * amplitude, width)  # [s] kept to lift and return
    while now + home < duration:
        touch = now
        now += _TOUCH
        for _ in range(4):
            there = random.uniform(-amplitude, amplitude, 2)
            move = there - here
            took = fitts_duration(float(np.hypot(*move)), width)
            if now + took + home > duration:
                break
            steps += reach(now, now + took, (move[0], move[1]), bow=0.05 * float(np.hypot(*move)))
            here, now = there, now + took + random.uniform(0.05, 0.4)
        now += _TOUCH
        steps += _press(touch, now, clearance + depth)
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
    _at_least("stroke_and_hold", duration, stroking + 6.0)
    if stroking < 3.0:
        raise BadInput("stroke_and_hold", at="stroking", found=f"{stroking} s", expected=">= 3 s")
    steps = _press(0.0, stroking + _TOUCH, clearance + depth)
    steps += _press(stroking + 2.0 * _TOUCH, duration - 0.2, clearance + depth)
    waves = [
        wave(_AXES[axis], 0.3, stroking - 0.5, share * amplitude, ratio * frequency)
        for share, ratio in ((0.25, 1.0), (0.4, 0.61), (1.0, 0.23))
    ]
    waves.append(wave(1 - _AXES[axis], 0.3, stroking - 0.5, 0.2 * amplitude, 0.37 * frequency))
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)


def holding_since(stroking: float) -> float:
    """When `stroke_and_hold` begins to hold still in contact [s]."""
    return stroking + 3.0 * _TOUCH


#: Every scripted motion by its name.
SCRIPTED: dict[str, Callable[..., AnalyticMotion]] = {
    builder.__name__: builder for builder in (strokes, chirp, press_slide_lift, sines, reaches, stroke_and_hold)
}

_MAY_BE_ZERO = {"seed", "lifts", "tremor"}


def scripted_parameters(name: str) -> dict[str, float | int | str]:
    """Parameters of a scripted motion and their defaults.

    Raises:
        BadInput: no motion has that name.
    """
    if name not in SCRIPTED:
        raise BadInput("scripted motion", found=repr(name), expected=f"one of {', '.join(SCRIPTED)}")
    return {key: item.default for key, item in inspect.signature(SCRIPTED[name]).parameters.items()}


def scripted_motion(name: str, **parameters: float | int | str) -> AnalyticMotion:
    """A scripted motion by its name.

    Args:
        name: one of `SCRIPTED`.
        parameters: those of the builder of that name.

    Raises:
        BadInput: an unknown name or parameter, or a value that makes no sense.
    """
    defaults = scripted_parameters(name)
    for key, value in parameters.items():
        if key not in defaults:
            raise BadInput(name, at=key, found="an unknown parameter", expected=f"one of {', '.join(defaults)}")
        _check(name, key, value, like=defaults[key])
    return SCRIPTED[name](**parameters)


def _check(name: str, key: str, value: object, like: float | int | str) -> None:
    if isinstance(like, str):
        if value not in _CHOICES[key]:
            raise BadInput(name, at=key, found=repr(value), expected=" or ".join(_CHOICES[key]))
        return
    kind = numbers.Integral if isinstance(like, int) else numbers.Real
    least = "an integer" if isinstance(like, int) else "a finite number"
    zero = key in _MAY_BE_ZERO
    if not isinstance(value, kind) or isinstance(value, bool) or not math.isfinite(value):
        raise BadInput(name, at=key, found=repr(value), expected=least)
    if value < 0 or (value == 0 and not zero):
        raise BadInput(name, at=key, found=value, expected=f"{least}, {'>= 0' if zero else '> 0'}")


def _at_least(name: str, duration: float, least: float) -> None:
    if duration < least:
        raise BadInput(name, at="duration", found=f"{duration} s", expected=f">= {least} s")


def _press(start: float, end: float, height: float) -> list[Row]:
    """Down by `height` from `start` on, and up again until `end`."""
    return [step(2, start, start + _TOUCH, -height), step(2, end - _TOUCH, end, height)]


def _direction(random: np.random.RandomState) -> np.ndarray:
    angle = random.uniform(0.0, 2.0 * math.pi)
    return np.array([math.cos(angle), math.sin(angle)])
