"""The compiled path of packets through a network: one call per tick, nothing allocated.

Time is counted in ticks from the first one; packet k is sent at tick k. Whatever is random is a function
of the seed and the packet's number, so nothing but the arrays below carries state: who copies them goes
on with the same numbers.

`memory` holds `_HEAD` scalars (the counts first), what the play-out buffer stands at, and then, for each of
`capacity` ticks or packets in turn:

- `due`: a list of the packets that arrive at that tick, headed here and chained through
- `link`: an entry per packet and, where the network makes copies, one for its copy. An entry is 2 k + copy + 1,
  or 0 where a list ends;
- `here`, only with a play-out buffer: 1 + the number of the packet in this place, once it has arrived;
- what the packet carries.

It is kept small because Drake copies it twice per tick.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mmt_drake.model.hermite import hermite_coefficients, hermite_position, hermite_velocity
from mmt_drake.network.config import JITTER_LAWS, ChannelConfig, load_trace

Array = NDArray[np.float64]

#: Names of the counts that open the memory: packets handed in; lost, copies included; copied; arrived, copies
#: included; arrived in vain, because they or newer ones were there before.
STATISTICS = ("sent", "lost", "duplicated", "received", "stale")
_SENT, _LOST, _DUPLICATED, _RECEIVED, _STALE = range(5)

#: How a play-out buffer bridges a gap: with the value before it, on a straight line, or, for position and
#: velocity of equal size one after the other, along the cubic through both ends.
INTERPOLATIONS = ("hold", "linear", "motion")
_HOLD, _LINEAR, _MOTION = range(3)

# Indices into the parameters; durations in ticks.
(
    _PERIOD, _DELAY, _JITTER, _LAW, _LOSS, _DUPLICATION, _REORDERING, _REORDERING_DELAY,
    _GAP, _QUEUE, _PLAYOUT, _INTERPOLATION, _CAPACITY, _SEED,
) = range(14)  # fmt: skip
_PARAMETERS = 14
_UNIFORM, _NORMAL, _GAMMA = range(3)

# Indices into the head of the memory.
NEXT_PACKET, _NEWEST, _LINK_FREE, _LATEST_HERE = range(5, 9)
_HEAD = 9

_ROUNDING = 1e-6  # ticks by which an arrival may miss a tick and still count as on time
# Delays beyond these have a probability of 1e-6 and are cut off, so that the memory is bounded.
_NORMAL_LIMIT = 4.9  # standard deviations
_GAMMA_LIMIT = 16.7  # of the two exponentials' common scale

# Streams of random numbers of one packet.
_TO_LOSE, _TO_COPY, _TO_HOLD, _JITTER_A, _JITTER_B = range(5)


@njit(inline="always")
def splitmix64(seed: int, counter: int) -> np.uint64:
    """The random word number `counter` (from 0) of a seed: 64 bits.

    Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
    """
    z = np.uint64(seed) + (np.uint64(counter) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit(inline="always")
def _uniform(p: Array, packet: int, copy: int, stream: int) -> float:
    """A number within (0, 1)."""
    key = splitmix64(int(p[_SEED]), 0)  # neighbouring seeds must not give shifted sequences
    word = splitmix64(key, 16 * packet + 8 * copy + stream)
    return (float(word >> np.uint64(11)) + 0.5) * 2.0**-53


@njit(inline="always")
def _trace_delay(seconds: float, trace: Array) -> float:
    """Delay [s] of a packet sent at a time [s], NaN if it is lost."""
    seconds = seconds % trace[-1, 0]
    low, high = 0, trace.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if trace[middle, 0] <= seconds:
            low = middle
        else:
            high = middle
    return trace[low, 1]


@njit(cache=True)
def transit(packet: int, copy: int, p: Array, trace: Array) -> float:
    """Ticks that a packet, or its copy, spends in the network; negative if it is lost there."""
    if p[_LOSS] > 0.0 and _uniform(p, packet, copy, _TO_LOSE) < p[_LOSS]:
        return -1.0
    ticks = p[_DELAY]
    if trace.shape[0] > 0:
        seconds = _trace_delay((packet + _ROUNDING) * p[_PERIOD], trace)
        if math.isnan(seconds):
            return -1.0
        ticks = seconds / p[_PERIOD]
    if p[_JITTER] > 0.0:
        u = _uniform(p, packet, copy, _JITTER_A)
        if p[_LAW] == _UNIFORM:
            ticks += p[_JITTER] * (2.0 * u - 1.0)
        else:
            w = _uniform(p, packet, copy, _JITTER_B)
            if p[_LAW] == _NORMAL:
                z = math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * w)  # Box and Muller
                ticks += p[_JITTER] * min(max(z, -_NORMAL_LIMIT), _NORMAL_LIMIT)
            else:
                ticks += p[_JITTER] / math.sqrt(2.0) * min(-math.log(u * w), _GAMMA_LIMIT)
    if p[_REORDERING] > 0.0 and _uniform(p, packet, copy, _TO_HOLD) < p[_REORDERING]:
        ticks += p[_REORDERING_DELAY]
    return max(ticks, 0.0)


@njit(cache=True)
def arrives_at_once(p: Array, trace: Array, memory: Array) -> bool:
    """Whether the packet that is sent now, or its copy, arrives within the same tick."""
    packet = int(memory[NEXT_PACKET])
    wait = max(memory[_LINK_FREE] - packet, 0.0)
    if p[_GAP] > 0.0 and wait > _ROUNDING:
        return False
    if 0.0 <= transit(packet, 0, p, trace) <= _ROUNDING:
        return True
    if p[_DUPLICATION] > 0.0 and _uniform(p, packet, 0, _TO_COPY) < p[_DUPLICATION]:
        return 0.0 <= transit(packet, 1, p, trace) <= _ROUNDING
    return False


@njit(inline="always")
def _layout(size: int, p: Array) -> tuple[int, int, int, int, int]:
    """Where `due`, `link`, `here` and what is carried begin, and the number of links per packet."""
    capacity = int(p[_CAPACITY])
    links = 2 if p[_DUPLICATION] > 0.0 else 1
    due = _HEAD + size
    link = due + capacity
    here = link + links * capacity
    carried = here + (capacity if p[_PLAYOUT] > 0.0 else 0)
    return due, link, here, carried, links


@njit(inline="always")
def _send(sent: Array, p: Array, trace: Array, memory: Array) -> None:
    """Hands the next packet to the network."""
    packet = int(memory[NEXT_PACKET])
    capacity, size = int(p[_CAPACITY]), sent.shape[0]
    due, link, _, carried, links = _layout(size, p)
    memory[_SENT] += 1.0
    wait = 0.0
    if p[_GAP] > 0.0:
        wait = max(memory[_LINK_FREE] - packet, 0.0)
        if wait > p[_QUEUE] * p[_GAP] + _ROUNDING:
            memory[_LOST] += 1.0
            return
        memory[_LINK_FREE] = packet + wait + p[_GAP]
    copies = 1
    if p[_DUPLICATION] > 0.0 and _uniform(p, packet, 0, _TO_COPY) < p[_DUPLICATION]:
        memory[_DUPLICATED] += 1.0
        copies = 2
    slot = packet % capacity
    for i in range(size):
        memory[carried + slot * size + i] = sent[i]
    for copy in range(copies):
        ticks = transit(packet, copy, p, trace)
        if ticks < 0.0:
            memory[_LOST] += 1.0
            continue
        arrival = packet + int(math.ceil(ticks + wait - _ROUNDING))
        memory[link + links * slot + copy] = memory[due + arrival % capacity]
        memory[due + arrival % capacity] = 2 * packet + copy + 1


@njit(inline="always")
def _receive(tick: int, size: int, p: Array, memory: Array, upto: int) -> int:
    """Takes in what arrives at a tick.

    Without a play-out buffer the newest packet so far is noted in the memory; later packets stand before
    earlier ones in the list, so one of them at most is applied, and the rest is stale.
    Returns the newest of the arrivals that goes into a play-out buffer and is no newer than `upto`, or -1.
    """
    capacity = int(p[_CAPACITY])
    due, link, here, _, links = _layout(size, p)
    buffered = p[_PLAYOUT] > 0.0
    entry = int(memory[due + tick % capacity])
    memory[due + tick % capacity] = 0.0
    newest = -1
    while entry > 0:
        packet, copy = (entry - 1) // 2, (entry - 1) % 2
        slot = packet % capacity
        memory[_RECEIVED] += 1.0
        if packet <= memory[_NEWEST] or (buffered and memory[here + slot] == packet + 1):
            memory[_STALE] += 1.0
        elif buffered:
            memory[here + slot] = packet + 1
            memory[_LATEST_HERE] = max(memory[_LATEST_HERE], packet)
            if packet <= upto:
                newest = max(newest, packet)
        else:
            memory[_NEWEST] = packet
        entry = int(memory[link + links * slot + copy])
    return newest


@njit(inline="always")
def _play(wanted: int, overdue: int, p: Array, memory: Array, received: Array) -> None:
    """Sets what a play-out buffer shows when it is packet `wanted`'s turn.

    `overdue` is the newest packet among the latest arrivals whose turn has come, or -1.
    """
    capacity, size = int(p[_CAPACITY]), received.shape[0]
    _, _, here, carried, _ = _layout(size, p)
    if wanted < 0:
        return
    held = int(memory[_NEWEST])
    current = max(held, overdue)
    if memory[here + wanted % capacity] == wanted + 1:
        current = wanted
    if current > held:
        memory[_NEWEST] = current
        for i in range(size):
            memory[_HEAD + i] = memory[carried + (current % capacity) * size + i]
    if current < 0:
        return
    for i in range(size):
        received[i] = memory[_HEAD + i]
    if current == wanted or p[_INTERPOLATION] == _HOLD or memory[_LATEST_HERE] < wanted:
        return
    following = wanted + 1
    while memory[here + following % capacity] != following + 1:
        following += 1
    ahead = carried + (following % capacity) * size
    share = (wanted - current) / (following - current)
    if p[_INTERPOLATION] == _LINEAR:
        for i in range(size):
            received[i] += share * (memory[ahead + i] - memory[_HEAD + i])
        return
    h = (following - current) * p[_PERIOD]
    half = size // 2
    for i in range(half):
        x0, v0 = memory[_HEAD + i], memory[_HEAD + half + i]
        c2, c3 = hermite_coefficients(x0, v0, memory[ahead + i], memory[ahead + half + i], h)
        received[i] = hermite_position(x0, v0, c2, c3, share * h)
        received[half + i] = hermite_velocity(v0, c2, c3, share * h)


@njit(cache=True)
def step_channel(sent: Array, p: Array, trace: Array, memory: Array, received: Array) -> None:
    """Sends one packet and moves on to the next tick.

    Args:
        sent: (size) what the packet carries.
        p: `channel_parameters`.
        trace: `load_trace`, or (0, 2) without one.
        memory: `channel_memory`, updated.
        received: (size) what the receiver has at this tick; set to what it has at the next.
    """
    tick, size = int(memory[NEXT_PACKET]), sent.shape[0]
    _send(sent, p, trace, memory)
    memory[NEXT_PACKET] = tick + 1
    before = memory[_NEWEST]
    wanted = tick + 1 - int(p[_PLAYOUT])
    # What arrived within this tick itself, then what arrives at the next.
    overdue = _receive(tick, size, p, memory, wanted)
    overdue = max(overdue, _receive(tick + 1, size, p, memory, wanted))
    if p[_PLAYOUT] > 0.0:
        _play(wanted, overdue, p, memory, received)
    elif memory[_NEWEST] > before:
        _, _, _, carried, _ = _layout(size, p)
        start = carried + int(memory[_NEWEST]) % int(p[_CAPACITY]) * size
        for i in range(size):
            received[i] = memory[start + i]


def whole_ticks(seconds: float, period: float) -> int:
    """Whole ticks that cover a time."""
    return max(0, math.ceil(seconds / period - _ROUNDING))


def channel_parameters(config: ChannelConfig, period: float, interpolation: str = "hold") -> tuple[Array, Array]:
    """A configuration in the units of the kernels: (14) parameters and the (n, 2) trace.

    Args:
        config: of the channel.
        period: of its tick [s].
        interpolation: one of `INTERPOLATIONS`.

    Raises:
        BadInput: a trace that cannot be read.
    """
    trace = np.zeros((0, 2)) if config.trace is None else load_trace(config.trace)
    p = np.zeros(_PARAMETERS)
    p[_PERIOD], p[_DELAY], p[_JITTER] = period, config.delay / period, config.jitter / period
    p[_LAW] = JITTER_LAWS.index(config.jitter_law)
    p[_LOSS], p[_DUPLICATION], p[_REORDERING] = config.loss, config.duplication, config.reordering
    p[_REORDERING_DELAY] = config.reordering_delay / period
    p[_GAP] = 0.0 if config.rate_limit is None else 1.0 / (config.rate_limit * period)
    p[_QUEUE] = config.queue
    p[_PLAYOUT] = whole_ticks(config.playout, period)
    p[_INTERPOLATION] = INTERPOLATIONS.index(interpolation)
    p[_SEED] = config.seed
    spread = {"uniform": 1.0, "normal": _NORMAL_LIMIT, "gamma": _GAMMA_LIMIT / math.sqrt(2.0)}[config.jitter_law]
    longest = config.delay if config.trace is None else float(np.nanmax(trace[:, 1]))
    longest += spread * config.jitter + (config.reordering_delay if config.reordering > 0.0 else 0.0)
    longest += p[_QUEUE] * p[_GAP] * period
    p[_CAPACITY] = 2 + max(whole_ticks(longest, period), p[_PLAYOUT])
    return p, trace


def may_arrive_at_once(config: ChannelConfig, trace: Array) -> bool:
    """Whether a packet can arrive within the tick in which it is sent."""
    if config.playout > 0.0:
        return False
    if len(trace):
        return bool(np.nanmin(trace[:, 1]) == 0.0)
    below = {"uniform": 1.0, "normal": _NORMAL_LIMIT, "gamma": 0.0}[config.jitter_law]
    return config.delay <= below * config.jitter


def channel_memory(p: Array, size: int) -> Array:
    """The memory of a channel before its first tick, for packets of `size` numbers."""
    words = size + 1 + (2 if p[_DUPLICATION] > 0.0 else 1) + (1 if p[_PLAYOUT] > 0.0 else 0)
    memory = np.zeros(_HEAD + size + words * int(p[_CAPACITY]))
    memory[[_NEWEST, _LATEST_HERE]] = -1.0
    return memory
