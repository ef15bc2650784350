"""The transit of a packet: lost, or how long it takes.

All of it is a function of the seed and the packet's number.
"""

import math

from numba import njit

from mmt_drake.lookup import row_before
from mmt_drake.network import parameters as at
from mmt_drake.numeric.arrays import Array
from mmt_drake.random import normal_pair, uniform

# Streams of random numbers: eight of a packet, then eight of its copy.
_TO_LOSE, _TO_COPY, _TO_HOLD, _JITTER_A, _JITTER_B = range(5)
_JITTER_PAIR = 2  # streams 4 and 5, which the normal law takes instead


@njit(cache=True)
def _uniform(p: Array, packet: int, copy: int, stream: int) -> float:
    """A number within (0, 1)."""
    return uniform(p[at.SEED], 16 * packet + 8 * copy + stream)


@njit(cache=True)
def _trace_delay(seconds: float, trace: Array) -> float:
    """Delay [s] of a packet sent at a time [s], NaN if it is lost."""
    seconds = seconds % trace[-1, 0]
    return trace[row_before(seconds, trace), 1]


@njit(cache=True)
def transit(packet: int, copy: int, p: Array, trace: Array) -> float:
    """Ticks that a packet, or its copy, spends in the network; negative if it is lost there."""
    if p[at.LOSS] > 0.0 and _uniform(p, packet, copy, _TO_LOSE) < p[at.LOSS]:
        return -1.0
    ticks = p[at.DELAY]
    if trace.shape[0] > 0:
        seconds = _trace_delay((packet + at.ROUNDING) * p[at.PERIOD], trace)
        if math.isnan(seconds):
            return -1.0
        ticks = seconds / p[at.PERIOD]
    if p[at.JITTER] > 0.0:
        if p[at.LAW] == at.UNIFORM:
            ticks += p[at.JITTER] * (2.0 * _uniform(p, packet, copy, _JITTER_A) - 1.0)
        elif p[at.LAW] == at.NORMAL:
            z, _ = normal_pair(p[at.SEED], 8 * packet + 4 * copy + _JITTER_PAIR)
            ticks += p[at.JITTER] * min(max(z, -at.NORMAL_LIMIT), at.NORMAL_LIMIT)
        else:
            u, w = _uniform(p, packet, copy, _JITTER_A), _uniform(p, packet, copy, _JITTER_B)
            ticks += p[at.JITTER] / math.sqrt(2.0) * min(-math.log(u * w), at.GAMMA_LIMIT)
    if p[at.REORDERING] > 0.0 and _uniform(p, packet, copy, _TO_HOLD) < p[at.REORDERING]:
        ticks += p[at.REORDERING_DELAY]
    return max(ticks, 0.0)


@njit(cache=True)
def is_copied(packet: int, p: Array) -> bool:
    """Whether the network makes a copy of a packet."""
    return p[at.DUPLICATION] > 0.0 and _uniform(p, packet, 0, _TO_COPY) < p[at.DUPLICATION]
