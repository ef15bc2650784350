"""How well detected contact agrees with the plant's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.signals import Flags, stretches

Array = NDArray[np.float64]

_MERGED = 0.0045  # [s] from the last sample of a detection to the first of the next that still is the same
_BETWEEN = 0.05  # [s] how far from a touch a detection may lie that is its early or late part


@dataclass(frozen=True)
class Score:
    """Detections held against contacts.

    Attributes:
        contacts: of the plant.
        missed: contacts without any detection.
        false: detections further than 50 ms from every contact.
        breaks: further beginnings of a detection within or around one contact: it flickers.
        wrong: share of all samples at which the two differ (0 to 1).
        touch_lags: from each contact seen to its first detection [s]; negative is early.
        release_lags: from each end of a contact seen to the end of its last detection [s].
        touch_heights: of the tip at the first detection [m]; above 0 is early.
    """

    contacts: int
    missed: int
    false: int
    breaks: int
    wrong: float
    touch_lags: Array
    release_lags: Array
    touch_heights: Array

    @property
    def slips(self) -> int:
        """How often an operator would have felt a contact that is none, or lost one: missed, false and broken ones."""
        return self.missed + self.false + self.breaks


def score(time: Array, height: Array, contact: Flags, detected: Flags) -> Score:
    """Compare two flags.

    Args:
        time: (n) [s], evenly spaced.
        height: (n) of the tip above the undeformed surface [m].
        contact: (n) the plant's contact.
        detected: (n) the detector's.
    """
    true, seen = stretches(contact), _merged(stretches(detected), time)
    owner = [_nearest(begin, end, true, time) for begin, end in seen]
    touches, releases, heights = [], [], []
    missed = breaks = 0
    for number, (begin, end) in enumerate(true):
        own = [stretch for stretch, of in zip(seen, owner, strict=True) if of == number]
        if not any(first <= end and last >= begin for first, last in own):
            missed += 1
            continue
        breaks += len(own) - 1
        first, last = own[0][0], own[-1][1]
        touches.append(time[first] - time[begin])
        heights.append(height[first])
        if end < len(time) - 1 and last < len(time) - 1:
            releases.append(time[last] - time[end])
    return Score(
        contacts=len(true),
        missed=missed,
        false=sum(of is None for of in owner),
        breaks=breaks,
        wrong=float(np.mean(contact != detected)),
        touch_lags=np.array(touches),
        release_lags=np.array(releases),
        touch_heights=np.array(heights),
    )


def _merged(found: list[tuple[int, int]], time: Array) -> list[tuple[int, int]]:
    merged: list[tuple[int, int]] = []
    for begin, end in found:
        if merged and time[begin] - time[merged[-1][1]] <= _MERGED:
            merged[-1] = merged[-1][0], end
        else:
            merged.append((begin, end))
    return merged


def _nearest(begin: int, end: int, contacts: list[tuple[int, int]], time: Array) -> int | None:
    """The contact that a detection belongs to; None if all are further away than `_BETWEEN`."""
    if not contacts:
        return None
    gaps = [max(time[a] - time[end], time[begin] - time[b], 0.0) for a, b in contacts]
    best = int(np.argmin(gaps))
    return best if gaps[best] <= _BETWEEN else None
