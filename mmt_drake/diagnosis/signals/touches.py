"""Touches: when the probe meets and leaves the object, finer than a sample and without chatter."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit

from mmt_drake.diagnosis.signals.noise import Noise
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

_SIGMAS = 6.0  # half-width of the hysteresis: one false change in 10^8 samples
_SEARCH_S = 0.010  # a flag and the crossing of the smoothed height that it stands for are not farther apart


@dataclass(frozen=True)
class ContactTimes:
    """The probe's contact over time.

    Attributes:
        starts_in: whether it is in contact at the first sample.
        changes: (c,) times of touch and release [s], in turn.
    """

    starts_in: bool
    changes: Array

    @property
    def touches(self) -> Array:
        """Times at which contact begins [s]."""
        return self.changes[1 if self.starts_in else 0 :: 2]

    @property
    def releases(self) -> Array:
        """Times at which contact ends [s]."""
        return self.changes[0 if self.starts_in else 1 :: 2]

    def at(self, times: Array) -> Flags:
        """Whether there is contact at each of these times (n,)."""
        flags: Flags = (np.searchsorted(self.changes, times, side="right") % 2 == 1) ^ self.starts_in
        return flags

    def since(self, times: Array) -> Array:
        """How long there has been contact (n,) [s] at these times, from the first of them at most; 0 off contact."""
        starts = [times[0], *self.touches] if self.starts_in else self.touches
        if not len(starts):
            return np.zeros(len(times))
        latest = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
        return np.where(self.at(times), times - np.take(starts, latest), 0.0)

    def share(self, times: Array, width: float) -> Array:
        """Share of contact (n,) in the interval of this width [s] about each of these times."""
        switches = np.concatenate([[-np.inf], self.changes, [np.inf]])
        begins = switches[0 if self.starts_in else 1 : -1 : 2]
        ends = switches[1 if self.starts_in else 2 :: 2]
        held = np.zeros(len(times))
        for begin, end in zip(begins, ends, strict=True):
            held += np.clip(np.minimum(times + 0.5 * width, end) - np.maximum(times - 0.5 * width, begin), 0.0, None)
        return held / width


def raw_flags(recording: Recording, noise: Mapping[str, Noise]) -> Flags:
    """Contact (n,) at the recording's samples.

    A column `in_contact` of its own is taken as it is. Where there is none, contact is z < 0 with a hysteresis of
    six deviations of the noise of z to each side. One axis alone, and a driven body, are always in contact.

    Args:
        recording: of any kind with forces or an output.
        noise: of its columns; that of position_z counts.
    """
    if "in_contact" in recording and "in_contact" not in recording.derived:
        flags: Flags = recording["in_contact"] != 0.0
        return flags
    if recording.kind != "contact":
        return np.ones(len(recording), dtype=bool)
    below = _with_hysteresis(recording["position_z"], _SIGMAS * noise["position_z"].std)
    return np.asarray(below, dtype=bool)


@njit(cache=True)
def _with_hysteresis(height: Array, width: float) -> Flags:
    """z < 0, changing only beyond `width` on the other side."""
    below = np.empty(height.size, dtype=np.bool_)
    now = height[0] < 0.0
    for i in range(height.size):
        if height[i] < -width:
            now = True
        elif height[i] > width:
            now = False
        below[i] = now
    return below


def contact_of(times: Array, flags: Flags, height: Array | None, reach_s: float = _SEARCH_S) -> ContactTimes:
    """Touches and releases, each at the crossing of the smoothed height nearest to the change of the flag.

    Where the height does not cross zero within reach in the right direction, the sample counts at which the flag
    is new, as in the model.

    Args:
        times: (n,) even clock [s].
        flags: (n,) contact there.
        height: (n,) smoothed z [m], or None.
        reach_s: from the flag to the crossing [s].
    """
    new = np.flatnonzero(flags[1:] != flags[:-1]) + 1
    instants = times[new].copy()
    if height is not None and len(new):
        step = times[1] - times[0]
        reach = round(reach_s / step) + 1
        for k, i in enumerate(new):
            first, last = max(0, i - 1 - reach), min(len(height) - 1, i + reach)
            z = height[first : last + 1]
            crossings = np.flatnonzero((z[:-1] < 0.0) != (z[1:] < 0.0))
            crossings = crossings[(z[crossings + 1] < 0.0) == flags[i]]
            if len(crossings):
                at = times[first + crossings] + step * z[crossings] / (z[crossings] - z[crossings + 1])
                instants[k] = at[np.argmin(np.abs(at - (times[i] - 0.5 * step)))]
    return ContactTimes(bool(flags[0]), np.maximum.accumulate(instants))
