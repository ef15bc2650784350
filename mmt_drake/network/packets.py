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

import math

import numpy as np
from numba import njit

from mmt_drake.model.hermite import cubic, position_at, velocity_at
from mmt_drake.network import parameters as at
from mmt_drake.network.transit import is_copied, transit
from mmt_drake.numeric.arrays import Array
from mmt_drake.numeric.layout import Layout

#: Names of the counts that open the memory: packets handed in; lost, copies included; copied; arrived, copies
#: included; arrived in vain, because they or newer ones were there before.
STATISTICS = ("sent", "lost", "duplicated", "received", "stale")
_next = Layout()
_SENT, _LOST, _DUPLICATED, _RECEIVED, _STALE = map(_next, [1] * len(STATISTICS))

# The rest of the head of the memory.
NEXT_PACKET, _NEWEST, _LINK_FREE, _LATEST_HERE = map(_next, [1] * 4)
_HEAD = _next.size


@njit(cache=True)
def arrives_at_once(p: Array, trace: Array, memory: Array) -> bool:
    """Whether the packet that is sent now, or its copy, arrives within the same tick."""
    packet = int(memory[NEXT_PACKET])
    wait = max(memory[_LINK_FREE] - packet, 0.0)
    if p[at.GAP] > 0.0 and wait > at.ROUNDING:
        return False
    if 0.0 <= transit(packet, 0, p, trace) <= at.ROUNDING:
        return True
    if is_copied(packet, p):
        return 0.0 <= transit(packet, 1, p, trace) <= at.ROUNDING
    return False


@njit(cache=True)
def _layout(size: int, p: Array) -> tuple[int, int, int, int, int]:
    """Where `due`, `link`, `here` and what is carried begin, and the number of links per packet."""
    capacity = int(p[at.CAPACITY])
    links = 2 if p[at.DUPLICATION] > 0.0 else 1
    due = _HEAD + size
    link = due + capacity
    here = link + links * capacity
    carried = here + (capacity if p[at.PLAYOUT] > 0.0 else 0)
    return due, link, here, carried, links


@njit(cache=True)
def _send(sent: Array, p: Array, trace: Array, memory: Array) -> None:
    """Hands the next packet to the network."""
    packet = int(memory[NEXT_PACKET])
    capacity, size = int(p[at.CAPACITY]), sent.shape[0]
    due, link, _, carried, links = _layout(size, p)
    memory[_SENT] += 1.0
    wait = 0.0
    if p[at.GAP] > 0.0:
        wait = max(memory[_LINK_FREE] - packet, 0.0)
        if wait > p[at.QUEUE] * p[at.GAP] + at.ROUNDING:
            memory[_LOST] += 1.0
            return
        memory[_LINK_FREE] = packet + wait + p[at.GAP]
    copies = 1
    if is_copied(packet, p):
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
        arrival = packet + math.ceil(ticks + wait - at.ROUNDING)
        memory[link + links * slot + copy] = memory[due + arrival % capacity]
        memory[due + arrival % capacity] = 2 * packet + copy + 1


@njit(cache=True)
def _receive(tick: int, size: int, p: Array, memory: Array, upto: int) -> int:
    """Takes in what arrives at a tick.

    Without a play-out buffer the newest packet so far is noted in the memory; later packets stand before
    earlier ones in the list, so one of them at most is applied, and the rest is stale.
    Returns the newest of the arrivals that goes into a play-out buffer and is no newer than `upto`, or -1.
    """
    capacity = int(p[at.CAPACITY])
    due, link, here, _, links = _layout(size, p)
    buffered = p[at.PLAYOUT] > 0.0
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


@njit(cache=True)
def _play(wanted: int, overdue: int, p: Array, memory: Array, received: Array) -> None:
    """Sets what a play-out buffer shows when it is packet `wanted`'s turn.

    `overdue` is the newest packet among the latest arrivals whose turn has come, or -1.
    """
    capacity, size = int(p[at.CAPACITY]), received.shape[0]
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
    if current == wanted or p[at.INTERPOLATION] == at.HOLD or memory[_LATEST_HERE] < wanted:
        return
    following = wanted + 1
    while memory[here + following % capacity] != following + 1:
        following += 1
    ahead = carried + (following % capacity) * size
    share = (wanted - current) / (following - current)
    if p[at.INTERPOLATION] == at.LINEAR:
        for i in range(size):
            received[i] += share * (memory[ahead + i] - memory[_HEAD + i])
        return
    h = (following - current) * p[at.PERIOD]
    half = size // 2
    for i in range(half):
        between = cubic(memory[_HEAD + i], memory[_HEAD + half + i], memory[ahead + i], memory[ahead + half + i], h)
        received[i] = position_at(between, share * h)
        received[half + i] = velocity_at(between, share * h)


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
    wanted = tick + 1 - int(p[at.PLAYOUT])
    # What arrived within this tick itself, then what arrives at the next.
    overdue = _receive(tick, size, p, memory, wanted)
    overdue = max(overdue, _receive(tick + 1, size, p, memory, wanted))
    if p[at.PLAYOUT] > 0.0:
        _play(wanted, overdue, p, memory, received)
    elif memory[_NEWEST] > before:
        _, _, _, carried, _ = _layout(size, p)
        start = carried + int(memory[_NEWEST]) % int(p[at.CAPACITY]) * size
        for i in range(size):
            received[i] = memory[start + i]


def channel_memory(p: Array, size: int) -> Array:
    """The memory of a channel before its first tick, for packets of `size` numbers."""
    words = size + 1 + (2 if p[at.DUPLICATION] > 0.0 else 1) + (1 if p[at.PLAYOUT] > 0.0 else 0)
    memory = np.zeros(_HEAD + size + words * int(p[at.CAPACITY]))
    memory[[_NEWEST, _LATEST_HERE]] = -1.0
    return memory
