"""Signals for every analysis: checked columns, one even clock, shifts in time and frequency bands."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.signals import AXES, HELD
from mmt_drake.recording.two_recordings import told_delay

BANDS: Final[Mapping[str, tuple[float, float] | None]] = {
    "all": None,
    "below_0.3_hz": (0.0, 0.3),
    "0.3_to_3_hz": (0.3, 3.0),
    "3_to_10_hz": (3.0, 10.0),
}
"""Name of a band -> its edges [Hz]; `all` is the signal as it is."""

BAND_NAMES: Final = {name: name.replace("_hz", " Hz").replace("_", " ") for name in BANDS}
"""Name of a band -> how it is written for people."""

FILTER_ORDER: Final = 4
"""`N` of `scipy.signal.butter` for the band filters: 4 poles at each edge, passed forward and backward."""

EVEN: Final = 0.01  # a sample may be this fraction of a step off an even clock
LONGEST_GAP_S: Final = 0.1
SEGMENT_S: Final = 20.0  # of a signal whose spectrum is taken


def duration(value: float, name: str) -> float:
    """`value` [s] if it is a finite number, 0 or more.

    Raises:
        BadInput: it is not.
    """
    if not (isinstance(value, int | float) and math.isfinite(value) and value >= 0.0):
        raise BadInput(name, found=value, expected="a number of seconds, 0 or more")
    return float(value)


def delay_of(recording: Recording, delay_s: float | None) -> float:
    """The operator-to-telerobot delay [s]; None: as the recording tells it, 0 where it does not.

    Raises:
        BadInput: it is no time.
    """
    return told_delay(recording) if delay_s is None else duration(delay_s, "delay_s")


def vector(recording: Recording, name: str) -> Array:
    """The columns name_x, name_y, name_z as (n, 3), every value finite.

    Raises:
        BadInput: one of them is missing, has another length than the time, or holds NaN or infinity.
    """
    return np.column_stack(components(recording, name))


def components(recording: Recording, name: str) -> list[Array]:
    """The columns name_x, name_y, name_z, (n,) each, every value finite: the recording's own arrays, not a copy.

    Raises:
        BadInput: as of `vector`.
    """
    return [component(recording, name, axis) for axis in AXES]


def component(recording: Recording, name: str, axis: str) -> Array:
    """The column name_x, name_y or name_z, (n,), every value finite.

    Raises:
        BadInput: as of `vector`.
    """
    return column(recording, f"{name}_{axis}")


def column(recording: Recording, name: str) -> Array:
    """One column, (n,), every value finite.

    Raises:
        BadInput: it is missing, has another length than the time, or holds NaN or infinity.
    """
    values = recording[name]
    if values.shape != recording.time.shape:
        raise BadInput(recording.source, at=name, found=f"{values.shape}", expected=f"{recording.time.shape} values")
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise BadInput(recording.source, at=f"{name}, sample {bad[0]}", found=values[bad[0]], expected="a number")
    return values


def flag(recording: Recording, name: str) -> Flags:
    """A column of 0 and 1 as (n,) booleans. In `theta_stable`, NaN (no estimate yet) is not stable.

    Raises:
        BadInput: it is missing or holds anything else.
    """
    values = recording[name]
    unknown = np.isnan(values) if name == "theta_stable" else np.zeros(values.shape, dtype=bool)
    bad = np.flatnonzero((values != 0.0) & (values != 1.0) & ~unknown)
    if bad.size:
        raise BadInput(recording.source, at=f"{name}, sample {bad[0]}", found=values[bad[0]], expected="0 or 1")
    flags: Flags = values == 1.0
    return flags


def mean_step(recording: Recording) -> float:
    """Mean time between two samples [s].

    Raises:
        BadInput: fewer than two samples, or time that does not increase.
    """
    time = recording.time
    if len(time) < 2:
        raise BadInput(recording.source, found=f"{len(time)} samples", expected="at least 2")
    bad = np.flatnonzero(~(np.diff(time) > 0.0))
    if bad.size:
        at, expected = int(bad[0]) + 1, f"more than {time[bad[0]]:.9g}"
        raise BadInput(recording.source, at=f"time, sample {at}", found=f"{time[at]:.9g}", expected=expected)
    return float((time[-1] - time[0]) / (len(time) - 1))


def on_even_clock(recording: Recording) -> Recording:
    """The recording at a constant rate: as it is where it already is (to 1 % of a step), resampled otherwise.

    Resampled at the mean step: flags and theta hold their last value, all else is interpolated linearly. That is done
    when a column is asked for, so that a long recording does not stand in memory twice.

    Raises:
        BadInput: fewer than two samples, time that does not increase, or an uneven clock with a gap above 0.1 s,
            which interpolation would fill with invented data.
    """
    step = mean_step(recording)
    time = recording.time
    even = time[0] + step * np.arange(len(time))
    if max(np.max(time - even), np.max(even - time)) <= EVEN * step:
        return recording
    widest = int(np.argmax(np.diff(time)))
    gap = time[widest + 1] - time[widest]
    if gap > LONGEST_GAP_S:
        found, expected = f"a gap of {gap:.3g} s", f"gaps of at most {LONGEST_GAP_S} s"
        raise BadInput(recording.source, at=f"time {time[widest]:.6g} s", found=found, expected=expected)
    return replace(recording, time=even, columns=_Resampled(recording, even))


class _Resampled(Mapping[str, Array]):
    """The columns of a recording at other times."""

    def __init__(self, recording: Recording, time: Array):
        self._recording, self._time = recording, time
        self._held = np.searchsorted(recording.time, time, side="right") - 1

    def __getitem__(self, name: str) -> Array:
        values = self._recording.columns[name]
        return values[self._held] if name in HELD else np.interp(self._time, self._recording.time, values)

    def __iter__(self) -> Iterator[str]:
        return iter(self._recording.columns)

    def __len__(self) -> int:
        return len(self._recording.columns)


def delayed(values: Array, delay_s: float, step: float) -> Array:
    """The signal `delay_s` later on the same clock: (n,) or (n, k) at a constant `step` [s].

    A delay of whole steps (to 1e-6 of a step) shifts samples and is exact; any other interpolates linearly between
    the two neighbours. Before the first sample the signal is taken to stand at its first value.
    """
    steps = delay_s / step
    nearest = round(steps)
    if abs(steps - nearest) <= 1e-6:
        return _shift(values, nearest)
    whole = math.floor(steps)
    fraction = steps - whole
    return (1.0 - fraction) * _shift(values, whole) + fraction * _shift(values, whole + 1)


def _shift(values: Array, samples: int) -> Array:
    """`values` moved to later rows by `samples` >= 0, the first row repeated in front."""
    samples = min(samples, len(values))
    return np.concatenate([np.repeat(values[:1], samples, axis=0), values[: len(values) - samples]])


def in_band(values: Array, band: tuple[float, float] | None, rate: float, source: object = "signal") -> Array:
    """The part of a signal in one band: (n,) or (n, k) at `rate` [Hz], the same shape out.

    A Butterworth filter of `FILTER_ORDER` as second-order sections, low-pass where the band begins at 0 and band-pass
    otherwise, forward and backward, so that no phase is left and the amplitude response is squared (one half at an
    edge). Ends are extended by scipy's default odd reflection; both passes start in the steady state of their first
    value. `None` returns the signal.

    Raises:
        BadInput: the upper edge is not below half the rate, or the signal is too short to be filtered.
    """
    if band is None:
        return values
    low, high = band
    if high >= rate / 2:
        needed = f"more than {2 * high:g} for a band up to {high:g} Hz"
        raise BadInput(source, found=f"{rate:.6g} samples/s", expected=needed)
    sections = _sections(low, high, rate)
    least = 3 * (2 * len(sections) + 1) + 1  # scipy's padding needs more samples than it pads
    if len(values) < least:
        raise BadInput(source, found=f"{len(values)} samples", expected=f"at least {least} to filter")
    filtered: Array = signal.sosfiltfilt(sections, values, axis=0)
    return filtered


@lru_cache(maxsize=64)
def _sections(low: float, high: float, rate: float) -> Array:
    """Of a band filter; the same few are asked for over and over."""
    edges, kind = (high, "lowpass") if low == 0.0 else ((low, high), "bandpass")
    sections: Array = signal.butter(FILTER_ORDER, edges, kind, fs=rate, output="sos")
    return sections


def contact_time(contact: Flags, step: float) -> Array:
    """Accumulated contact time [s] before each sample, (n,): zero at the first, `step` more after each in contact."""
    return step * np.concatenate([[0], np.cumsum(contact[:-1])])


def rising(flags: Flags) -> NDArray[np.intp]:
    """Samples at which a flag is set and was not at the sample before; a flag set from the start has no rise there."""
    return np.flatnonzero(flags[1:] & ~flags[:-1]) + 1


def stretches(flags: Flags) -> list[tuple[int, int]]:
    """The (first, last) sample of every unbroken run of a set flag, both included."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def amplitude_spectrum(values: Array, rate: float) -> tuple[Array, Array]:
    """Frequencies [Hz] above 0 and the signal's amplitude there, in its own unit: two (m,) arrays.

    Welch's method: Hann windows of `SEGMENT_S` (or the whole signal where that is shorter), half overlapping, means
    removed, mean-square averaged and scaled so that a lasting sine of amplitude A shows a peak of A.
    """
    length = min(len(values), max(8, round(SEGMENT_S * rate)))
    frequency, power = signal.welch(values, rate, nperseg=length, scaling="spectrum")
    return frequency[1:], np.sqrt(2.0 * power[1:])
