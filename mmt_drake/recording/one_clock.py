"""From the topics of a bag, each with its own clock, to the columns of a recording with one."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.messages import Integers
from mmt_drake.recording.stored import MOST_IN_MEMORY, Column, LongColumns, as_array, return_freed, stored
from mmt_drake.recording.streams import SignalTrack, TopicStream

_WALL_CLOCK = 1_000_000 * 1_000_000_000
"""Stamps later than this [ns] are a calendar's, not a simulation's: they are counted from the first."""

_GAP = 20.0
"""A topic silent for more than this many of its usual steps is reported."""


def joined(streams: Iterable[TopicStream], source: str) -> tuple[Array, LongColumns, list[str], int]:
    """Bring the topics of a bag onto one clock. What the streams hold is handed over, not copied.

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
    clocks: list[Integers] = []
    tracks = [track for stream in streams if (track := stream.track(clocks, source)) is not None]
    if not tracks:
        raise BadInput(source, found="no message on any known topic", expected="the topics of a recording")
    notes = _frame_notes(tracks, source)
    probe = [track for track in tracks if track.signal.name in ("position", "force")]
    base = max(probe or tracks, key=lambda track: len(track.clock)).clock
    start = max(int(track.clock[0]) for track in tracks if track.signal.quantity != "theta")
    end = min(int(track.clock[-1]) for track in tracks if not track.signal.held)
    inside = (base >= start) & (base <= end)
    if not inside.any():
        spans = ", ".join(
            f"{track.topic} {track.clock[0] * 1e-9:.3f} to {track.clock[-1] * 1e-9:.3f} s" for track in tracks
        )
        raise BadInput(source, found=f"topics that do not overlap: {spans}", expected="one span of time in all of them")
    if not inside.all():
        notes.append(f"left out {int((~inside).sum())} of {len(base)} samples where not every topic has a message")
    clock = base if inside.all() else base[inside]
    columns: dict[str, Column] = {}
    for track in tracks:
        brought = _onto(clock, track, base, inside)
        for name in track.signal.columns:  # one column at a time is let go and made anew
            columns[name] = brought(track.columns.pop(0))
        notes += _clock_notes(track, base)
    zero = int(clock[0]) if clock[0] > _WALL_CLOCK else 0
    if zero:
        notes.append(f"time is counted from the first sample, at {zero} ns")
    time = (clock - zero) / 1e9
    if len(time) >= MOST_IN_MEMORY:
        return_freed()
    return time, LongColumns(columns), notes, zero


def _onto(clock: Integers, track: SignalTrack, base: Integers, inside: NDArray[np.bool_]) -> Callable[[Column], Column]:
    """The function that brings a column of a track onto ``clock``, the part of the base clock that is inside."""
    if track.clock is clock:
        return lambda column: column
    if track.clock is base:
        return lambda column: stored(as_array(column)[inside])
    if track.signal.held:
        last = np.searchsorted(track.clock, clock, side="right") - 1
        unknown = last < 0 if track.signal.quantity == "theta" else np.zeros(len(clock), dtype=bool)
        return lambda column: stored(np.where(unknown, np.nan, as_array(column)[np.maximum(last, 0)]))
    zero = int(clock[0])  # float64 holds nanoseconds since 1970 only to 256 ns
    own, wanted = (track.clock - zero).astype(np.float64), (clock - zero).astype(np.float64)
    return lambda column: stored(np.interp(wanted, own, as_array(column)))


def _frame_notes(tracks: Sequence[SignalTrack], source: str) -> list[str]:
    """Notes of the frame; what the probe feels and where it is must be recorded in one."""
    probe = {
        track.topic: track.frame
        for track in tracks
        if track.signal.name in ("position", "velocity", "force") and track.frame
    }
    if len(set(probe.values())) > 1:
        named = ", ".join(f"{frame!r} on {topic}" for topic, frame in probe.items())
        raise BadInput(source, at="frame_id", found=named, expected="one frame, the table's")
    frames = sorted({track.frame for track in tracks} - {"", "table"})
    return [f"frame {', '.join(map(repr, frames))} taken for the table frame"] if frames else []


def _clock_notes(track: SignalTrack, base: Integers) -> list[str]:
    if track.signal.held or len(track.clock) < 3:
        return []
    notes = []
    steps = np.diff(track.clock)
    longest, usual = int(steps.max()), float(np.median(steps))
    if longest > _GAP * usual:
        notes.append(
            f"{track.topic}: silent for {longest * 1e-9:.3f} s, usual step {usual * 1e-9:.6f} s; bridged by a line"
        )
    if track.clock is not base:
        notes.append(f"{track.topic}: interpolated from its own clock, usual step {usual * 1e-9:.6f} s")
    return notes
