"""The clock of a recording: its rate, its jitter, its gaps, and its signals on an even one."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from mmt_drake.analysis.signals import EVEN
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags

_MISSING = 2.5  # a step of so many usual ones has lost samples
_MOST_FILLED = 10.0  # times the samples that there are: an even clock with more is gaps and nothing else
_SPLINE_ERROR = 5.0 / 384.0  # Hall and Meyer 1976: |f - s| <= 5/384 h^4 max|f''''| for a cubic spline


@dataclass(frozen=True)
class Clock:
    """How a recording was sampled.

    Attributes:
        start: time of the first sample [s].
        step: the usual time between two samples [s]: the mean where the clock is even, the median otherwise.
        count: samples of the even clock over the same time.
        is_even: whether every sample lies within 1 % of a step of the even clock.
        jitter: deviation of the steps that lost no sample, over the usual step.
        gaps: (g, 2) begin and end [s] of every step that is longer than `_MISSING` usual ones.
        widest_step: the longest step that is no gap [s].
    """

    start: float
    step: float
    count: int
    is_even: bool
    jitter: float
    gaps: Array
    widest_step: float

    @property
    def rate_hz(self) -> float:
        """Samples per second of the even clock."""
        return 1.0 / self.step

    def times(self, every: int = 1) -> Array:
        """The even clock [s], or every so manieth sample of it."""
        return self.start + self.step * np.arange(0, self.count, every, dtype=np.float64)

    def spline_error(self, fourth_derivative: float) -> float:
        """Bound on what resampling adds, for a signal whose fourth derivative is at most this; 0 on an even clock."""
        return 0.0 if self.is_even else _SPLINE_ERROR * self.widest_step**4 * fourth_derivative


def clock_of(time: Array, source: str = "recording") -> Clock:
    """The clock of increasing sample times (n,) [s], n >= 3.

    Raises:
        BadInput: an even clock would have ten times as many samples and more: the times jump, or its steps are of no
            one size.
    """
    steps = np.diff(time)
    mean = float((time[-1] - time[0]) / len(steps))
    if np.max(np.abs(time - (time[0] + mean * np.arange(len(time))))) <= EVEN * mean:
        return Clock(float(time[0]), mean, len(time), True, float(np.std(steps) / mean), np.empty((0, 2)), mean)
    step = float(np.median(steps))
    lost = steps > _MISSING * step
    gaps = np.column_stack([time[:-1][lost], time[1:][lost]])
    usual = steps[~lost]
    if not (time[-1] - time[0]) / step <= _MOST_FILLED * len(time):
        longest = int(np.argmax(steps))
        found = f"{steps[longest]:g} s after {time[longest]:g} s, where the median step is {step:g} s"
        expected = f"steps of like size: an even clock would have more than {_MOST_FILLED:g} times the samples"
        raise BadInput(source, at="time", found=found, expected=expected)
    count = int(np.floor((time[-1] - time[0]) / step * (1.0 + 1e-12))) + 1
    return Clock(float(time[0]), step, count, False, float(np.std(usual) / step), gaps, float(usual.max()))


def on_clock(time: Array, values: Array, clock: Clock) -> Array:
    """A signal (n, k) on the even clock: as it is where it stands there, else by a cubic spline through the samples.

    Gaps are crossed in a straight line; nothing there is to be believed.
    """
    if clock.is_even:
        return values
    even = clock.times()
    result = np.empty((clock.count, values.shape[1]))
    ends = np.concatenate([[0], np.searchsorted(time, clock.gaps[:, 1]), [len(time)]])
    result[:] = np.column_stack([np.interp(even, time, column) for column in values.T])
    for first, stop in pairwise(ends):
        if stop - first < 4:
            continue
        inside = (even >= time[first]) & (even <= time[stop - 1])
        result[inside] = CubicSpline(time[first:stop], values[first:stop])(even[inside])
    return result


def held_on_clock(time: Array, values: Flags, clock: Clock) -> Flags:
    """A flag (n,) on the even clock: the latest value."""
    return values if clock.is_even else values[np.searchsorted(time, clock.times(), side="right") - 1]


def near(times: Array, at: Array, reach: float) -> Flags:
    """Which of `times` (n,), increasing, lie within `reach` [s] of an instant or an interval.

    Args:
        times: [s].
        at: (m,) instants or (m, 2) intervals [s].
        reach: to each side [s].
    """
    spans = at if at.ndim == 2 else np.column_stack([at, at])
    marked = np.zeros(len(times) + 1, dtype=np.int64)
    np.add.at(marked, np.searchsorted(times, spans[:, 0] - reach, side="left"), 1)
    np.add.at(marked, np.searchsorted(times, spans[:, 1] + reach, side="right"), -1)
    flags: Flags = np.cumsum(marked)[:-1] > 0
    return flags
