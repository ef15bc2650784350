"""What the numbers of a model and the laws that are told leave of a contact."""

import math
from operator import itemgetter
from typing import Final, NamedTuple, Self

import numpy as np
from scipy import signal

from mmt_drake.estimation.output_error.adequacy import PART
from mmt_drake.estimation.output_error.fit import LEAST_NOISE
from mmt_drake.estimation.output_error.lateness import late_means
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.told_laws import along_normal, remembers_along_normal

_SMOOTHED: Final = 15, 2
"""Samples, and the order of the polynomial through them, by which motion is smoothed for laws (Savitzky and Golay)."""
_EARNS: Final = 0.5
"""Of what was left without a law, beyond noise: with it no more may be left, or it goes again."""
_EDGE_S: Final = 0.02
"""About a touch or a release, which a detector sees a little late [s]."""
NOT_LATE: Final = np.zeros(2)
"""Delay and time constant of a force that is not late [s]."""


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
        return any(value > doubt for value in self)  # whatever is not known on the other one

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


def left_along_normal(rows: Array, sample: float, known: Array, late: Array = NOT_LATE) -> float:
    """What a spring, a damper and the surface's height leave of the force along the normal, over its noise.

    Of a force that is late as much is left as of one that is not, or less: how late it is may be a mistake.

    The noise is what no motion does from sample to sample, by third differences, whatever passes it on. A small part of
    the force is allowed beside it, as along the surface (`mmt_drake.estimation.output_error.adequacy`). 0 where there
    is too little.

    Args:
        rows: (n, ROW) samples (`mmt_drake.learning.answer`).
        sample: time between them [s].
        known: (TOLD_SIZE,) what is told of laws (`mmt_drake.told_laws`), whose force is taken off.
        late: (2,) delay and time constant of the low pass by which the force is believed to be late [s].
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
    size, steps = _left_of(force, causes, counts)
    if (lateness := float(late.sum())) > 0.0:
        passed_on = np.empty_like(causes)
        late_means(causes, sample, 1, np.array([lateness, late[1] / lateness]), passed_on)
        size, steps = min((size, steps), _left_of(force, passed_on, counts), key=itemgetter(0))
    noise = float(np.sqrt(np.mean(steps**2) / 20.0)) if len(steps) else 0.0
    return size / max(noise, PART * _size(force[counts]), LEAST_NOISE)


def _left_of(force: Array, causes: Array, counts: Flags) -> tuple[float, Array]:
    """What least squares leave of a force [N], and its third differences from sample to sample.

    Args:
        force: (n,) [N].
        causes: (3, n) force of each unit of a spring and a damper, and of laws.
        counts: (n,) samples that are compared.
    """
    used = causes[:, counts]
    felt = force[counts] - used[2]
    used[2] = 1.0  # in the place of the laws' own: the surface may be higher or lower
    slopes = np.linalg.lstsq(used @ used.T, used @ felt, rcond=None)[0]
    left, at = felt - slopes @ used, np.flatnonzero(counts)
    return _size(left), np.diff(left, 3)[at[3:] - at[:-3] == 3]


def _size(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
