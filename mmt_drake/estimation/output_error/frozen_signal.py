"""Numbers of a sample that stand still; compiled.

A number that stays the same for a while does, and so does one that stays within a band far narrower than its noise
has been so far: a sensor that is frozen or saturated still dithers a little. Without noise there is no band, since a
force that moves slowly, or an object that slides evenly, then stays within any. The noise is the median of the fourth
difference from tick to tick, of which the motion of a hand leaves next to nothing.
"""

import math

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

STILL_S = 0.02
"""For so long a number stays where it is before it counts as standing still [s]."""

_NUMBERS = 9  # position, velocity, force
# The memory, of each number: the last one; for how many ticks it has been the same, and the probe's position along its
# axis when that began; where the band lies, for how many ticks the number has been within and how often it changed
# there, the probe's position when that began; the last differences; the noise.
_next = Layout()
_LAST, _RUN, _FROM, _ANCHOR, _WITHIN, _CHANGES, _SINCE, _FIRST, _SECOND, _THIRD, _NOISE = map(_next, [_NUMBERS] * 11)
SIZE = _next.size

_BAND = 0.25  # of the noise
_MOST_CHANGES = 12  # that noise would hardly make within the band
_OF_DIFFERENCE = 5.64  # median of the fourth difference's size over the deviation: 0.674 sqrt(70)
_RATE = 0.01  # by which the noise follows at each tick
_LEAST = (1e-6, 5e-5, 1e-4)  # noise of position [m], velocity [m/s], force [N] that is told from a smooth motion
_LONGEST_STEP = 0.002  # [s]; a coarser clock does not tell them apart


def initial_history() -> Array:
    """The memory (SIZE,) before the first sample."""
    memory = np.zeros(SIZE)
    for part in (_LAST, _ANCHOR, _FIRST, _SECOND, _THIRD, _NOISE):
        memory[part : part + _NUMBERS] = np.nan  # equal to nothing
    return memory


@njit(cache=True, error_model="numpy")
def band(memory: Array, i: int, step: float) -> float:
    """Half the width of the band in which number i stands still, in its unit; 0 where it has no noise."""
    noise = memory[_NOISE + i]
    return _BAND * noise if noise > _LEAST[i // 3] and step <= _LONGEST_STEP else 0.0


@njit(cache=True, error_model="numpy")
def stood(memory: Array, i: int, step: float) -> tuple[float, float]:
    """For how many ticks number i has stood still, 0 if it does not, and where the probe was when that began [m]."""
    least = STILL_S - 1e-9
    if memory[_RUN + i] * step >= least:
        return memory[_RUN + i], memory[_FROM + i]
    if memory[_WITHIN + i] * step >= least and memory[_CHANGES + i] >= _MOST_CHANGES:
        return memory[_WITHIN + i], memory[_SINCE + i]
    return 0.0, 0.0


@njit(cache=True, error_model="numpy")
def begin_here(memory: Array, i: int, probe: float) -> None:
    """Count from `probe` on how far the probe moves while number i stands still [m]."""
    memory[_FROM + i] = memory[_SINCE + i] = probe


@njit(cache=True, error_model="numpy")
def watch(sample: Array, memory: Array, step: float) -> bool:
    """Take a sample (9) of finite numbers; whether all of it is as the one before."""
    same = True
    for i in range(_NUMBERS):
        value, probe = sample[i], sample[i % 3]
        if value == memory[_LAST + i]:
            memory[_RUN + i] += 1.0
        else:
            memory[_RUN + i] = 0.0
            memory[_FROM + i] = probe
            memory[_CHANGES + i] += 1.0
            same = False
        if abs(value - memory[_ANCHOR + i]) <= band(memory, i, step):
            memory[_WITHIN + i] += 1.0
        else:
            memory[_ANCHOR + i] = value
            memory[_WITHIN + i] = memory[_CHANGES + i] = 0.0
            memory[_SINCE + i] = probe
        _listen(value, memory, i, step)
        memory[_LAST + i] = value
    return same


@njit(cache=True, error_model="numpy")
def _listen(value: float, memory: Array, i: int, step: float) -> None:
    """Let the noise of number i follow the median of its fourth difference, but while it stands still."""
    first = value - memory[_LAST + i]
    second = first - memory[_FIRST + i]
    third = second - memory[_SECOND + i]
    heard = abs(third - memory[_THIRD + i]) / _OF_DIFFERENCE
    memory[_FIRST + i], memory[_SECOND + i], memory[_THIRD + i] = first, second, third
    if not math.isfinite(heard) or stood(memory, i, step)[0] > 0.0:
        return
    noise = memory[_NOISE + i]
    if not math.isfinite(noise):
        noise = heard
    elif heard > noise:
        noise *= 1.0 + _RATE
    else:
        noise *= 1.0 - _RATE
    memory[_NOISE + i] = max(noise, 0.1 * _LEAST[i // 3])
