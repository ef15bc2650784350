"""Objects on the telerobot's table that were touched in a run, and those that the tip only passed through."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mmt_drake.analysis.signals import flag, mean_step, stretches, vector
from mmt_drake.model.scene_layout import MARGIN, MOST, SeenState
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording

_PASSED_S = 0.05  # that a tip is within an object and does not touch it


@dataclass(frozen=True)
class ObjectsTouched:
    """What a scene had and what of it was touched, by identity.

    Attributes:
        touches: of each object that was seen, how often it was touched, as the telerobot detected it.
        passed: for how long the tip was below the top of each without touching it [s], where that was long.
    """

    touches: Mapping[int, int]
    passed: Mapping[int, float]

    def line(self) -> str:
        """For a terminal."""
        touched = [f"{thing} ({count}x)" for thing, count in self.touches.items() if count]
        parts = [f"{len(self.touches)} seen, touched: {', '.join(touched) or 'none'}"]
        parts += [
            f"NOT TOUCHED although the tip was within {thing} for {seconds:.2f} s: it did not come from above"
            for thing, seconds in self.passed.items()
        ]
        return f"objects: {'; '.join(parts)}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {
            "touches": {str(thing): count for thing, count in self.touches.items()},
            "passed_s": {str(thing): seconds for thing, seconds in self.passed.items()},
        }


def objects_touched(recording: Recording) -> ObjectsTouched | None:
    """What the scene of a recording had; None where there was none, or nobody detected contact with it."""
    if "scene_1_thing" not in recording or not {"position_x", "detected_contact"} <= set(recording.columns):
        return None
    tip, contact, step = vector(recording, "position"), flag(recording, "detected_contact"), mean_step(recording)
    begins = [first for first, _ in stretches(contact)]
    touches = {thing: int(np.count_nonzero(at[begins])) for thing, at in _within(recording, tip, MARGIN).items()}
    within = _within(recording, tip, 0.0)
    passed = {thing: step * int(np.count_nonzero(at & ~contact)) for thing, at in within.items()}
    return ObjectsTouched(touches, {thing: seconds for thing, seconds in passed.items() if seconds > _PASSED_S})


def _within(recording: Recording, tip: Array, margin: float) -> dict[int, Flags]:
    """Of each object that is in a scene when the tip was below its top, and over its outline or so near to it [m]."""
    found: dict[int, Flags] = {}
    for row in range(1, MOST + 1):
        things, state = recording[f"scene_{row}_thing"], recording[f"scene_{row}_state"]
        over = np.ones(len(tip), dtype=bool)
        for k, (place, extent) in enumerate((("x", "along"), ("y", "across"))):
            off = np.abs(tip[:, k] - recording[f"scene_{row}_{place}"])
            over &= off <= 0.5 * recording[f"scene_{row}_{extent}"] + margin
        below = over & (tip[:, 2] < recording[f"scene_{row}_top"])
        there = (state != SeenState.NONE) & (state != SeenState.TAKEN_AWAY) & (state != SeenState.CARRIED)
        for thing in np.unique(things[things > 0.0]).astype(int).tolist():
            now = below & there & (things == thing)
            found[thing] = found[thing] | now if thing in found else now
    return dict(sorted(found.items()))
