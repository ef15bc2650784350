"""A channel's configuration in the units of its kernels: ticks."""

import math

import numpy as np

from mmt_drake.errors import BadInput
from mmt_drake.network.config import JITTER_LAWS, ChannelConfig, load_trace
from mmt_drake.numeric.arrays import Array

#: How a play-out buffer bridges a gap: with the value before it, on a straight line, or, for position and
#: velocity of equal size one after the other, along the cubic through both ends.
INTERPOLATIONS = ("hold", "linear", "motion")
HOLD, LINEAR, _ = range(3)

# Indices into the parameters; durations in ticks.
(
    PERIOD, DELAY, JITTER, LAW, LOSS, DUPLICATION, REORDERING, REORDERING_DELAY,
    GAP, QUEUE, PLAYOUT, INTERPOLATION, CAPACITY, SEED,
) = _NUMBERS = range(14)  # fmt: skip
UNIFORM, NORMAL, _ = range(3)

ROUNDING = 1e-6  # ticks by which an arrival may miss a tick and still count as on time
# Delays beyond these have a probability of 1e-6 and are cut off, so that the memory is bounded.
NORMAL_LIMIT = 4.9  # standard deviations
GAMMA_LIMIT = 16.7  # of the two exponentials' common scale

_MOST_TICKS = 100_000


def whole_ticks(seconds: float, period: float) -> int:
    """Whole ticks that cover a time.

    Raises:
        BadInput: more than 100 000, which a channel would have to remember.
    """
    ticks = seconds / period - ROUNDING
    if ticks > _MOST_TICKS:
        raise BadInput(
            "network channel",
            found=f"{seconds} s at {period} s a tick",
            expected=f"at most {_MOST_TICKS} ticks in flight",
        )
    return max(0, math.ceil(ticks))


def usual_delay(config: ChannelConfig, period: float) -> float:
    """The delay that most packets of a direction have [s].

    That of the play-out buffer if there is one, else the median of the trace if there is one, else `delay`. A channel
    delivers at its ticks, `period` [s] apart, so this is a multiple of it.

    Raises:
        BadInput: the trace cannot be read, or the delay is of more than 100 000 ticks.
    """
    delay = config.playout or config.delay
    if config.trace is not None and not config.playout:
        delay = float(np.nanmedian(load_trace(config.trace)[:-1, 1]))
    return whole_ticks(delay, period) * period


def channel_parameters(config: ChannelConfig, period: float, interpolation: str = "hold") -> tuple[Array, Array]:
    """A configuration in the units of the kernels: (14) parameters and the (n, 2) trace.

    Args:
        config: of the channel.
        period: of its tick [s].
        interpolation: one of `INTERPOLATIONS`.

    Raises:
        BadInput: a trace that cannot be read, or more than 100 000 packets in flight.
    """
    trace = np.zeros((0, 2)) if config.trace is None else load_trace(config.trace)
    p = np.zeros(len(_NUMBERS))
    p[PERIOD], p[DELAY], p[JITTER] = period, config.delay / period, config.jitter / period
    p[LAW] = JITTER_LAWS.index(config.jitter_law)
    p[LOSS], p[DUPLICATION], p[REORDERING] = config.loss, config.duplication, config.reordering
    p[REORDERING_DELAY] = config.reordering_delay / period
    p[GAP] = 0.0 if config.rate_limit is None else 1.0 / (config.rate_limit * period)
    p[QUEUE] = config.queue
    p[PLAYOUT] = whole_ticks(config.playout, period)
    p[INTERPOLATION] = INTERPOLATIONS.index(interpolation)
    p[SEED] = config.seed
    spread = {"uniform": 1.0, "normal": NORMAL_LIMIT, "gamma": GAMMA_LIMIT / math.sqrt(2.0)}[config.jitter_law]
    longest = config.delay if config.trace is None else float(np.nanmax(trace[:, 1]))
    longest += spread * config.jitter + (config.reordering_delay if config.reordering > 0.0 else 0.0)
    longest += p[QUEUE] * p[GAP] * period
    p[CAPACITY] = 2 + max(whole_ticks(longest, period), p[PLAYOUT])
    return p, trace


def may_arrive_at_once(p: Array, trace: Array) -> bool:
    """Whether a packet can arrive, and be applied, within the tick in which it is sent."""
    if p[PLAYOUT] > 0.0:
        return False
    if len(trace):
        return bool(np.nanmin(trace[:, 1]) <= ROUNDING * p[PERIOD])
    below = {UNIFORM: 1.0, NORMAL: NORMAL_LIMIT}.get(int(p[LAW]), 0.0)
    return bool(p[DELAY] - below * p[JITTER] <= ROUNDING)
