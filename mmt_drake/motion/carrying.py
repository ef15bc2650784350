"""A scripted motion that pushes an object, lifts it over something, swings it and puts it down elsewhere."""

from mmt_drake.motion.analytic import AnalyticMotion, step, wave
from mmt_drake.motion.reaching import at_least, press, reach

_PUSHED_S = 5.0


def carry(
    *,
    duration: float = 20.0,
    amplitude: float = 0.02,
    height: float = 0.06,
    swing: float = 0.008,
    depth: float = 0.003,
    clearance: float = 0.01,
) -> AnalyticMotion:
    """Push, lift, swing, carry across, put down.

    In contact from 0.8 s on it pushes for 5 s. A grip that closes at 7 s has something to lift, from 8 to 9.5 s; what
    hangs from it swings until 13 s, is carried across until 14.5 s, and is put down from 15 to 16.5 s. The hand leaves
    it at 18 s.

    Args:
        duration: [s], at least 20 s.
        amplitude: of the strokes that push [m]; it is carried three times as far.
        height: by which it is lifted [m].
        swing: amplitude of the sines that make it swing [m].
        depth: pressing depth [m].
        clearance: height above the surface when lifted [m].
    """
    at_least("carry", duration, 20.0)
    there = (3.0 * amplitude, 1.5 * amplitude)
    steps = press(0.2, 18.6, clearance + depth)
    steps += [step(2, 8.0, 9.5, height), step(2, 15.0, 16.5, -height)]
    steps += reach(13.0, 14.5, there, bow=0.3 * amplitude)
    steps += reach(18.8, duration, (-there[0], -there[1]))
    waves = [
        wave(0, 1.0, 1.0 + _PUSHED_S, amplitude, 0.7),
        wave(1, 1.0, 1.0 + _PUSHED_S, 0.7 * amplitude, 1.1),
        wave(2, 1.0, 1.0 + _PUSHED_S, 0.2 * depth, 2.0),
        wave(0, 9.5, 13.0, swing, 1.3),
        wave(1, 9.5, 13.0, 0.6 * swing, 0.9, end_frequency=1.8),
        wave(2, 9.5, 13.0, 0.5 * swing, 2.1),
    ]
    return AnalyticMotion((0.0, 0.0, clearance), steps=steps, waves=waves, cycle=duration)
