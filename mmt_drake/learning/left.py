"""What the numbers of a model and the laws that are told leave of a contact."""

import math
from typing import Final, NamedTuple, Self

import numpy as np
from scipy import signal

from mmt_drake.estimation.output_error.adequacy import PART
from mmt_drake.estimation.output_error.fit import LEAST_NOISE
from mmt_drake.numeric.arrays import Array
from mmt_drake.told_laws import along_normal, remembers_along_normal

_SMOOTHED: Final = 15, 2
"""Samples, and the order of the polynomial through them, by which motion is smoothed for laws (Savitzky and Golay)."""
_EARNS: Final = 0.5
"""Of what was left without a law, beyond noise: with it no more may be left, or it goes again."""
_EDGE_S: Final = 0.02
"""About a touch or a release, which a detector sees a little late [s]."""


class Left(NamedTuple):
    """What is left of a contact, over its noise [1].

    Attributes:
        surface: along the surface, by the estimator.
        normal: along its normal, which the estimator does not watch (`left_along_normal`).
    """

    surface: float
    normal: float = 0.0

    def doubts(self, doubt: float) -> bool:
        """Whether more than so much is left on either axis."""
        return max(self) > doubt

    def earned(self, before: Self, doubt: float) -> tuple[bool, bool]:
        """Along the surface, and along the normal: whether what is told has earned its place since so much was left.

        It has where no more than the doubt is left, or half of what was, beyond noise.
        """
        first, second = (
            now <= doubt or _beyond_noise(now) <= _EARNS * _beyond_noise(then)
            for now, then in zip(self, before, strict=True)
        )
        return first, second


def _beyond_noise(left: float) -> float:
    """What is left, over the noise, without the noise that is part of it."""
    return math.sqrt(max(left**2 - 1.0, 0.0))


def left_along_normal(rows: Array, sample: float, known: Array) -> float:
    """What a spring, a damper and the surface's height leave of the force along the normal, over its noise.

    The noise is what no motion does from sample to sample, by third differences, whatever passes it on. A small part of
    the force is allowed beside it, as along the surface (`mmt_drake.estimation.output_error.adequacy`). 0 where there
    is too little.

    Args:
        rows: (n, ROW) samples (`mmt_drake.learning.answer`).
        sample: time between them [s].
        known: (TOLD_SIZE,) what is told of laws (`mmt_drake.told_laws`), whose force is taken off.
    """
    contact, force = rows[:, 9].copy(), rows[:, 8]
    counts = contact > 0.5
    for turn in (np.flatnonzero(np.diff(contact)) + 1).tolist():
        counts[max(0, turn - round(_EDGE_S / sample)) : turn + round(_EDGE_S / sample)] = False
    if np.count_nonzero(counts) * sample < _EDGE_S:
        return 0.0
    raw = rows[:, [2, 5]].T
    # A law with a memory would count noise as a way; what is linear needs no smoothing.
    smooth = signal.savgol_filter(raw, *_SMOOTHED, mode="nearest") if remembers_along_normal(known) else raw.copy()
    causes = along_normal(known, sample, smooth[0], smooth[1], contact)
    causes[:2] += smooth - raw
    causes = causes[:, counts]
    felt = force[counts] - causes[2]
    causes[2] = 1.0  # in the place of the laws' own: the surface may be higher or lower
    slopes = np.linalg.lstsq(causes @ causes.T, causes @ felt, rcond=None)[0]
    left = felt - slopes @ causes
    at = np.flatnonzero(counts)
    steps = np.diff(left, 3)[at[3:] - at[:-3] == 3]
    noise = float(np.sqrt(np.mean(steps**2) / 20.0)) if len(steps) else 0.0
    size, of_force = (float(np.sqrt(np.mean(values**2))) for values in (left, force[counts]))
    return size / max(noise, PART * of_force, LEAST_NOISE)
