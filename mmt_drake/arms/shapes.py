"""Shapes of effects that logs suggest: periods of ripples, a delay, joints that may be geared together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline

from mmt_drake.arms.believed import PreparedLog
from mmt_drake.numeric.arrays import Array

_FEWEST_CYCLES, _MOST_CYCLES, PEAKS = 2.0, 60.0, 3
"""Periods of a ripple within the way of a joint, and how many of the strongest are tried."""
_DELAYS: Final = np.linspace(-0.04, 0.04, 81)
"""[s]"""
_NEIGHBOURS: Final = 2
"""Joints whose drives may be geared together are no farther apart in the chain ..."""
_ALIKE: Final = 0.95
"""... and move each for itself: where one joint's speed is to this part that of another, all that the other's torque
depends on is known of its own motion, and a coupling would imitate its own friction."""


def _smooth(one: PreparedLog, j: int) -> Array:
    """What any joint may have, in the band: friction, a rotor, gravity, other links, an offset (n, 7)."""
    own = one.joint(j)
    columns = [own.direction, own.v, own.a, np.cos(own.q), np.sin(own.q), np.ones(len(own.q)), own.rigid]
    return one.motion.filtered(np.column_stack(columns))


def likely_ripples(every: Sequence[PreparedLog], j: int) -> tuple[float, ...]:
    """Periods over the way at which the unexplained torque of a joint is strongest [rad].

    Args:
        every: logs.
        j: the joint.
    """
    one = max(every, key=lambda each: len(each.motion.time))
    own, columns = one.joint(j), _smooth(one, j)
    left = own.others[:, j] - one.motion.filtered(one.believed[:, j])
    left = left - columns @ np.linalg.lstsq(columns, left, rcond=None)[0]
    # Where it moves fast a ripple is above the band; half of the time must show it.
    highest = min(_MOST_CYCLES / own.reach, one.motion.band_hz / max(float(np.median(np.abs(own.v))), 1e-9))
    cycles = np.arange(_FEWEST_CYCLES / own.reach, highest, 0.25 / own.reach)  # [1/rad]
    if len(cycles) < 3:
        return ()
    thin = one.motion.thinning
    power = np.abs(np.exp(-2j * np.pi * np.outer(cycles, own.q[thin])) @ left[thin])
    peaks, _ = signal.find_peaks(power)
    return tuple(float(1.0 / cycles[i]) for i in sorted(peaks, key=lambda i: -power[i])[:PEAKS])


def likely_delay(every: Sequence[PreparedLog], moving: Sequence[int]) -> float:
    """The time that all torques may be late, by which the motion explains them best [s].

    Args:
        every: logs.
        moving: joints that move.
    """
    one = max(every, key=lambda each: len(each.motion.time))
    time, thin = one.motion.time, one.motion.thinning
    inside = (time[thin] > time[0] + _DELAYS[-1]) & (time[thin] < time[-1] - _DELAYS[-1])
    at = time[thin][inside]
    left = np.zeros(len(_DELAYS))
    for j in moving:
        basis, _ = np.linalg.qr(_smooth(one, j)[thin][inside])
        course, believed = CubicSpline(time, one.motion.torque[:, j]), one.motion.filtered(one.believed[:, j])
        later = np.stack([course(at + delay) for delay in _DELAYS], 1) - believed[thin][inside][:, None]
        later = later - basis @ (basis.T @ later)
        left += np.log(np.maximum((later**2).sum(axis=0), 1e-300))
    return float(_DELAYS[np.argmin(left)])


def likely_geared(every: Sequence[PreparedLog], j: int) -> tuple[int, ...]:
    """Joints whose drives may be geared with that of a joint, as far as the motion can tell.

    Args:
        every: logs.
        j: the joint.
    """
    v = np.concatenate([one.motion.v for one in every])
    along = v.T @ v[:, j]
    alike = along**2 > _ALIKE * (v**2).sum(axis=0) * along[j]
    return tuple(k for k in range(v.shape[1]) if 0 < abs(k - j) <= _NEIGHBOURS and not alike[k])
