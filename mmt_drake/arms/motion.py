"""Smooth motion and torque of a log, on an even clock."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import signal

from mmt_drake.arms.joint_log import JointLog
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags

_OVERSAMPLING = 20.0
"""Samples of the even clock in a period of the band's edge."""
_FEWEST = 4.0
"""The same of a log, at least."""
MARGIN_S = 0.3
"""At each end, where a filter has nothing to go by, nothing is compared."""
_SLOWEST_S = 0.5
"""A clock that is slower than this may be in milliseconds."""
_GAP_STEPS, _GAP_PERIODS = 3.0, 0.25
"""A step of the clock that is longer than so many others, and than this part of a period of the band, is a gap."""
_ORDER = 4
"""Of Butterworth's filter. `numeric.zero_phase.LowPass` reaches 0.5 s to each side, which is much of a log of 4 s."""


@dataclass(frozen=True)
class ArmMotion:
    """What was recorded, without phase below the edge of a band.

    Attributes:
        step: sampling interval [s].
        time: (n,) [s].
        q, v, a: (n, joints).
        torque: (n, joints).
        recorded: (n,) samples that no gap of the log reaches.
        band_hz: edge of the band; torque and whatever it is compared with are filtered alike (`filtered`).
    """

    step: float
    time: Array
    q: Array
    v: Array
    a: Array
    torque: Array
    recorded: Flags
    band_hz: float

    @classmethod
    def of(cls, log: JointLog, band_hz: float) -> ArmMotion:
        """The motion of a log.

        Args:
            log: what was recorded.
            band_hz: below which it is compared.

        Raises:
            BadInput: it was sampled too slowly for that.
        """
        own = float(np.median(np.diff(log.time)))
        if own * band_hz > 1.0 / _FEWEST:
            expected = f"{_FEWEST * band_hz:g} Hz or more for a band of {band_hz:g} Hz (`band_hz:` of the model)"
            expected += "; times are in seconds" if own > _SLOWEST_S else ""
            raise BadInput(log.source, at="time", found=f"{1.0 / own:.3g} Hz", expected=expected)
        time = np.arange(log.time[0], log.time[-1], own)
        q, torque = (
            _low_pass(np.stack([np.interp(time, log.time, column) for column in values.T], 1), own, band_hz)
            for values in (log.q, log.torque)
        )
        v = np.gradient(q, own, axis=0)
        a = np.gradient(v, own, axis=0)
        every = max(1, int(1.0 / (own * _OVERSAMPLING * band_hz)))
        taken = slice(None, None, every)
        recorded = np.ones(len(time), dtype=bool)
        for begins, length in gaps(log.time, band_hz):
            reach = 1.0 / band_hz  # of the filter
            recorded &= (time < begins - reach) | (time > begins + length + reach)
        return cls(own * every, time[taken], q[taken], v[taken], a[taken], torque[taken], recorded[taken], band_hz)

    @cached_property
    def jerk(self) -> Array:
        """Rate of the torque, (n, joints) [N m/s]."""
        return np.gradient(self.torque, self.step, axis=0)

    def filtered(self, values: Array) -> Array:
        """Values of each sample (n, ...) in the band, as the torque is."""
        return _low_pass(values, self.step, self.band_hz)

    @property
    def thinning(self) -> slice:
        """Samples that say all there is in the band, without the margins."""
        edge = int(MARGIN_S / self.step)
        return slice(edge, len(self.time) - edge, max(1, int(1.0 / (4.0 * self.band_hz * self.step))))


def gaps(time: Array, band_hz: float) -> Array:
    """Where a clock has a gap that a straight line does not bridge in the band: (gaps, 2), its begin and length [s].

    Args:
        time: (n,) of the samples [s].
        band_hz: edge of the band.
    """
    step = np.diff(time)
    wide = step > max(_GAP_STEPS * float(np.median(step)), _GAP_PERIODS / band_hz)
    return np.stack([time[:-1][wide], step[wide]], 1)


def _low_pass(values: Array, step: float, band_hz: float) -> Array:
    sections = signal.butter(_ORDER, band_hz, fs=1.0 / step, output="sos")
    filtered: Array = signal.sosfiltfilt(sections, values, axis=0)
    return filtered
