"""The topics of a bag: which are read, and what their messages carry."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mmt_drake.errors import BadInput, suggest
from mmt_drake.recording.growing import GrowingColumns
from mmt_drake.recording.messages import ACCEPTED, Bytes, Integers, MessageBatch, read_block, read_one
from mmt_drake.recording.signals import CLOUD, CLOUD_TOPIC, SIGNALS, Signal, signal_names
from mmt_drake.recording.stored import Column, as_array, stored

_SAME_CLOCK = 1_000_000_000
"""Header stamps are used where they stay this close [ns] to the log times."""


def wanted_topics(available: Mapping[str, str], topics: Mapping[str, str], source: str) -> dict[str, list[Signal]]:
    """The topics of a bag that are to be read, and what they carry.

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


@dataclass(frozen=True)
class SignalTrack:
    """One signal on its own clock.

    Attributes:
        signal: what it is.
        topic: where it stood in the bag.
        frame: the headers' frame_id; empty without headers.
        clock: (n,) [ns], increasing; the very array of every other track that has the same times.
        columns: (n,) each, in the order of the signal's columns.
    """

    signal: Signal
    topic: str
    frame: str
    clock: Integers
    columns: list[Column]


class TopicStream:
    """The messages of one topic, gathered piece by piece. Of each, only the numbers that its signal needs are kept.

    Attributes:
        topic: its name in the bag.
        msgtype: message type in the naming of ROS 2.
        parse: deserialises the bytes of one message, for the layouts that ``read_block`` leaves.
        signals: those that it may carry; they differ in their number of columns.
        ros1: whether the bytes are ROS 1's.
    """

    def __init__(
        self, topic: str, msgtype: str, parse: Callable[[bytes], Any], signals: Sequence[Signal], ros1: bool = False
    ):
        self.topic, self.msgtype, self.parse, self.signals, self.ros1 = topic, msgtype, parse, signals, ros1
        self._logs: list[Integers] = []
        self._stamps: list[Integers] = []
        self._stamped = True
        # What the first messages settle for the others, and the numbers of all.
        self._signal: Signal | None = None
        self._width, self._frame, self._columns = 0, "", GrowingColumns(0)

    def add(self, logs: Integers, data: Bytes, starts: Integers, sizes: Integers, source: str) -> None:
        """Take in messages: their log times [ns], (n,), and where their bytes stand in ``data``.

        ``logs`` is kept as it is: topics that are given the same array share it.

        Raises:
            BadInput: messages whose number of values is no signal's or changes, or whose frame changes.
        """
        if len(logs) == 0:
            return
        block = read_block(self.msgtype, data, starts, sizes, self.ros1) or self._read_singly(
            data, starts, sizes, source
        )
        width = block.values.shape[1]
        if self._signal is None:
            self._signal = _carried(self.signals, width, self.topic, source)
            self._width, self._frame, self._columns = width, block.frame, GrowingColumns(self._signal.size)
        if width != self._width:
            widths = sorted({width, self._width})
            raise BadInput(source, at=self.topic, found=f"messages of {widths} numbers", expected="always as many")
        if block.frame != self._frame:
            raise BadInput(source, at=self.topic, found=f"frames {[self._frame, block.frame]}", expected="one frame")
        self._columns.add(block.values)
        self._logs.append(logs)
        self._stamped = self._stamped and block.stamps is not None
        if self._stamped and block.stamps is not None:
            self._stamps.append(shared(block.stamps, [logs]))

    def _read_singly(self, data: Bytes, starts: Integers, sizes: Integers, source: str) -> MessageBatch:
        """Messages whose numbers do not stand at the same places in all of them."""
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
        return MessageBatch(
            values, np.array(stamps, dtype=np.int64) if len(stamps) == len(read) else None, frames.pop()
        )

    def track(self, clocks: list[Integers], source: str) -> SignalTrack | None:
        """All that came, in the order of its clock; None if nothing came. It is handed over: nothing is left here.

        Args:
            clocks: those of other topics; this one's is taken from them or added (``shared``).
            source: for messages.

        Raises:
            BadInput: a time that is there twice.
        """
        if self._signal is None:
            return None
        clock, columns = self._clock(), self._columns.take()
        if not (clock[1:] > clock[:-1]).all():
            order = np.argsort(clock, kind="stable")
            clock = clock[order]
            if (np.diff(clock) <= 0).any():
                at = int(np.argmax(np.diff(clock) <= 0)) + 2
                found = f"the stamp {clock[at - 1]} ns twice"
                raise BadInput(source, at=f"{self.topic}, message {at}", found=found, expected="each stamp once")
            for i, column in enumerate(columns):
                columns[i] = stored(as_array(column)[order])
        return SignalTrack(self._signal, self.topic, self._frame, shared(clock, clocks), columns)

    def _clock(self) -> Integers:
        """(n,) when each message's content was measured [ns], in the order in which they came.

        The header's stamp where every message has one, they increase, and they belong to the
        clock of the log times; otherwise the log time.
        """
        logs, stamps = self._logs, self._stamps
        self._logs, self._stamps = [], []
        times = np.concatenate(logs)
        if not self._stamped or all(stamp is log for stamp, log in zip(stamps, logs, strict=True)):
            return times
        own = np.concatenate(stamps)
        usable = (own > 0).any() and (np.diff(own) > 0).all() and (np.abs(own - times) < _SAME_CLOCK).all()
        return own if usable else times


def shared(clock: Integers, clocks: list[Integers]) -> Integers:
    """The one of ``clocks`` that equals this clock; this one, added to them, if there is none.

    The topics of a recording mostly tick together: one clock then stands in memory once, not once per topic.
    """
    for known in clocks:
        if np.array_equal(known, clock):
            return known
    clocks.append(clock)
    return clock


def _carried(signals: Sequence[Signal], width: int, topic: str, source: str) -> Signal:
    """The signal that messages of this many numbers carry."""
    for signal in signals:
        # Poses carry an orientation, twists and wrenches an angular part: the first three numbers count.
        longer = signal.quantity in ("position", "velocity", "force") and (width == 3 or width >= 6)
        if width == signal.size or longer:
            return signal
    sizes = sorted({3 if signal.quantity == "position" else signal.size for signal in signals})
    more = " (or 6 and more)" if 3 in sizes else ""
    *others, last = map(str, sizes)
    expected = f"{', '.join(others)} or {last}{more}" if others else f"{last}{more}"
    raise BadInput(source, at=topic, found=f"messages of {width} numbers", expected=expected)
