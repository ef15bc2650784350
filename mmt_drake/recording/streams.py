"""From the topics of a bag, each with its own clock, to the columns of a recording with one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.recording.messages import ACCEPTED, Block, Bytes, Integers, read_block, read_one
from mmt_drake.recording.recording import Array
from mmt_drake.recording.signals import CLOUD, CLOUD_TOPIC, SIGNALS, Signal, signal_names, suggest

_WALL_CLOCK = 1_000_000 * 1_000_000_000
"""Stamps later than this [ns] are a calendar's, not a simulation's: they are counted from the first."""

_SAME_CLOCK = 1_000_000_000
"""Header stamps are used where they stay this close [ns] to the log times."""

_GAP = 20.0
"""A topic silent for more than this many of its usual steps is told of."""


def wanted_topics(available: Mapping[str, str], topics: Mapping[str, str], source: str) -> dict[str, list[Signal]]:
    """Which topics of a bag to read, and what they carry.

    Args:
        available: topic -> message type, of the bag.
        topics: base name of a signal, or topic of the contract -> topic of this bag.
        source: for messages.

    Returns:
        topic of this bag -> the signals that it may carry (they differ in their number of columns).

    Raises:
        BadInput: a name that is no signal, a topic that is not in the bag, a message type that cannot carry it.
    """
    mapped = {}
    names = {signal.topic.strip("/"): signal.name for signal in SIGNALS} | {name: name for name in signal_names()}
    names |= {CLOUD_TOPIC.strip("/"): "cloud"}
    for name, topic in topics.items():
        key = name.strip("/")
        if key not in names:
            expected = f"a signal or its topic{suggest(key, names) or ': ' + ', '.join(names.values())}"
            raise BadInput(source, at=f"--topic {name}={topic}", found=f"unknown name {name!r}", expected=expected)
        if topic not in available:
            expected = f"a topic of this bag{suggest(topic, available) or ': ' + ', '.join(available)}"
            raise BadInput(source, at=f"--topic {name}={topic}", found=f"no topic {topic!r}", expected=expected)
        mapped[names[key]] = topic
    wanted: dict[str, list[Signal]] = {}
    for signal in (*SIGNALS, _CLOUD):
        topic = mapped.get(signal.name, signal.topic)
        if topic not in available:
            continue
        accepted = ACCEPTED[signal.quantity] if signal is not _CLOUD else (CLOUD,)
        if available[topic] not in accepted:
            same_name = [other for other in SIGNALS if other.name == signal.name and signal.name in mapped]
            if any(available[topic] in ACCEPTED[other.quantity] for other in same_name):
                continue  # three axes or one: the mapped topic is the other's
            raise BadInput(source, at=topic, found=available[topic], expected=" or ".join(accepted))
        others = [other.name for other in wanted.setdefault(topic, []) if other.name != signal.name]
        if others:
            raise BadInput(source, at=topic, found=f"read as {others[0]} and as {signal.name}", expected="one signal")
        wanted[topic].append(signal)
    return wanted


_CLOUD = Signal("cloud", CLOUD_TOPIC, CLOUD, (), "number")


@dataclass
class Stream:
    """The messages of one topic, gathered piece by piece.

    Attributes:
        topic: its name in the bag.
        msgtype: message type in the naming of ROS 2.
        parse: deserialises the bytes of one message, for the layouts that ``read_block`` leaves.
        ros1: whether the bytes are ROS 1's.
    """

    topic: str
    msgtype: str
    parse: Callable[[bytes], Any]
    ros1: bool = False
    _logs: list[Integers] = field(default_factory=list)
    _blocks: list[Block] = field(default_factory=list)

    def add(self, logs: Integers, data: Bytes, starts: Integers, sizes: Integers, source: str) -> None:
        """Take in messages: their log times [ns] and where their bytes stand in ``data``.

        Raises:
            BadInput: messages whose number of values changes.
        """
        if len(logs) == 0:
            return
        block = read_block(self.msgtype, data, starts, sizes, self.ros1)
        if block is None:
            pairs = zip(starts, sizes, strict=True)
            read = [read_one(self.parse(data[start : start + size].tobytes())) for start, size in pairs]
            widths = sorted({len(values) for values, _, _ in read})
            frames = {frame for _, _, frame in read}
            if len(widths) > 1:
                raise BadInput(source, at=self.topic, found=f"messages of {widths} numbers", expected="always as many")
            if len(frames) > 1:
                raise BadInput(source, at=self.topic, found=f"frames {sorted(frames)}", expected="one frame")
            stamps = [stamp for _, stamp, _ in read if stamp is not None]
            values = np.array([values for values, _, _ in read], dtype=np.float64)
            block = Block(values, np.array(stamps, dtype=np.int64) if len(stamps) == len(read) else None, frames.pop())
        first = self._blocks[0] if self._blocks else block
        if block.values.shape[1] != first.values.shape[1]:
            widths = sorted({block.values.shape[1], first.values.shape[1]})
            raise BadInput(source, at=self.topic, found=f"messages of {widths} numbers", expected="always as many")
        if block.frame != first.frame:
            raise BadInput(source, at=self.topic, found=f"frames {[first.frame, block.frame]}", expected="one frame")
        self._logs.append(logs.astype(np.int64))
        self._blocks.append(block)

    @property
    def empty(self) -> bool:
        """Whether no message has come."""
        return not self._blocks

    @property
    def frame(self) -> str:
        """The headers' frame_id; empty without headers."""
        return self._blocks[0].frame

    @property
    def values(self) -> NDArray[np.float64]:
        """(n, k), in the order in which they were added."""
        return np.concatenate([block.values for block in self._blocks])

    def clock(self) -> Integers:
        """(n,) when each message's content was measured [ns].

        The header's stamp where every message has one, they increase, and they belong to the
        clock of the log times; otherwise the log time.
        """
        logs = np.concatenate(self._logs)
        stamps = [block.stamps for block in self._blocks if block.stamps is not None]
        if len(stamps) < len(self._blocks):
            return logs
        times = np.concatenate(stamps)
        own = (times > 0).any() and (np.diff(times) > 0).all() and (np.abs(times - logs) < _SAME_CLOCK).all()
        return times if own else logs


@dataclass(frozen=True)
class _Track:
    """One signal on its own clock."""

    signal: Signal
    topic: str
    frame: str
    clock: Integers
    values: NDArray[np.float64]


def joined(
    streams: Iterable[Stream], wanted: Mapping[str, Sequence[Signal]], source: str
) -> tuple[Array, dict[str, Array], list[str], int]:
    """Bring the topics of a bag onto one clock.

    The base clock is that of ``position`` or ``force``, whichever has more messages (without these,
    of the signal with the most). Columns exist where every signal has a value (theta apart): moving
    signals are interpolated linearly, flags and theta keep their last value. A theta before
    the first one is NaN, not known yet. Topics that share the base clock are taken as they are.

    Returns:
        time [s] (counted from the first stamp if that is a calendar's), columns, notes, and the
        stamp [ns] that was taken as zero.

    Raises:
        BadInput: no message at all, clocks that do not overlap or do not increase, frames that differ.
    """
    tracks = [_track(stream, wanted[stream.topic], source) for stream in streams if not stream.empty]
    if not tracks:
        raise BadInput(source, found="no message on any known topic", expected="the topics of a recording")
    notes = _frame_notes(tracks, source)
    probe = [track for track in tracks if track.signal.name in ("position", "force")]
    base = max(probe or tracks, key=lambda track: len(track.clock)).clock
    start = max(int(track.clock[0]) for track in tracks if track.signal.name != "theta")
    end = min(int(track.clock[-1]) for track in tracks if not track.signal.held)
    inside = (base >= start) & (base <= end)
    if not inside.any():
        spans = ", ".join(
            f"{track.topic} {track.clock[0] * 1e-9:.3f} to {track.clock[-1] * 1e-9:.3f} s" for track in tracks
        )
        raise BadInput(source, found=f"topics that do not overlap: {spans}", expected="one span of time in all of them")
    if not inside.all():
        notes.append(f"left out {int((~inside).sum())} of {len(base)} samples where not every topic has a message")
    clock = base[inside]
    columns: dict[str, Array] = {}
    for track in tracks:
        values = track.values[inside] if np.array_equal(track.clock, base) else _resampled(track, clock)
        columns |= {name: values[:, i].copy() for i, name in enumerate(track.signal.columns)}
        notes += _clock_notes(track, base)
    zero = int(clock[0]) if clock[0] > _WALL_CLOCK else 0
    if zero:
        notes.append(f"time is counted from the first sample, at {zero} ns")
    return (clock - zero) / 1e9, columns, notes, zero


def _track(stream: Stream, signals: Sequence[Signal], source: str) -> _Track:
    values, clock = stream.values, stream.clock()
    order = np.argsort(clock, kind="stable")
    values, clock = values[order], clock[order]
    if (np.diff(clock) <= 0).any():
        at = int(np.argmax(np.diff(clock) <= 0)) + 2
        raise BadInput(
            source,
            at=f"{stream.topic}, message {at}",
            found=f"the stamp {clock[at - 1]} ns twice",
            expected="each stamp once",
        )
    width = values.shape[1]
    for signal in signals:
        # Poses carry an orientation, twists and wrenches an angular part: the first three numbers count.
        longer = signal.quantity in ("position", "velocity", "force") and (width == 3 or width >= 6)
        if width == signal.size or longer:
            return _Track(signal, stream.topic, stream.frame, clock, values[:, : signal.size])
    sizes = sorted({3 if signal.quantity == "position" else signal.size for signal in signals})
    more = " (or 6 and more)" if 3 in sizes else ""
    raise BadInput(
        source, at=stream.topic, found=f"messages of {width} numbers", expected=f"{' or '.join(map(str, sizes))}{more}"
    )


def _resampled(track: _Track, clock: Integers) -> NDArray[np.float64]:
    if track.signal.held:
        before = np.searchsorted(track.clock, clock, side="right") - 1
        values = track.values[np.maximum(before, 0)]
        if track.signal.name == "theta":
            values[before < 0] = np.nan
        return values
    zero = int(clock[0])  # float64 holds nanoseconds since 1970 only to 256 ns
    own, wanted = (track.clock - zero).astype(np.float64), (clock - zero).astype(np.float64)
    return np.column_stack([np.interp(wanted, own, column) for column in track.values.T])


def _frame_notes(tracks: Sequence[_Track], source: str) -> list[str]:
    """What the probe feels and where it is must be told in one frame; say which one it is."""
    probe = {
        track.topic: track.frame
        for track in tracks
        if track.signal.name in ("position", "velocity", "force") and track.frame
    }
    if len(set(probe.values())) > 1:
        told = ", ".join(f"{frame!r} on {topic}" for topic, frame in probe.items())
        raise BadInput(source, at="frame_id", found=told, expected="one frame, the table's")
    frames = sorted({track.frame for track in tracks} - {"", "table"})
    return [f"frame {', '.join(map(repr, frames))} taken for the table frame"] if frames else []


def _clock_notes(track: _Track, base: Integers) -> list[str]:
    if track.signal.held or len(track.clock) < 3:
        return []
    notes = []
    steps = np.diff(track.clock)
    longest, usual = int(steps.max()), float(np.median(steps))
    if longest > _GAP * usual:
        notes.append(
            f"{track.topic}: silent for {longest * 1e-9:.3f} s, usual step {usual * 1e-9:.6f} s; bridged by a line"
        )
    if not np.array_equal(track.clock, base):
        notes.append(f"{track.topic}: interpolated from its own clock, usual step {usual * 1e-9:.6f} s")
    return notes
