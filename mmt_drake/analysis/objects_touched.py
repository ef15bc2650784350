"""Objects on the telerobot's table that were touched in a run, and those that the tip only passed through."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from mmt_drake.analysis.signals import flag, mean_step, stretches, vector
from mmt_drake.errors import BadInput
from mmt_drake.model.scene_layout import MARGIN, MOST, SeenState, is_there
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording.recording import Recording

THINGS: Final = "things"
"""Key of `Recording.made_by`: names of the simulated objects, in the order of their places, as a list in JSON."""
_READ = "thing", "state", "x", "y", "top", "along", "across"
_PASSED_S = 0.05  # that a tip is within an object and does not touch it
_SEEN_LOW = 5e-4  # [m] a top may be, by the camera's noise, where the tip touches it


@dataclass(frozen=True)
class ObjectsTouched:
    """What a scene had and what of it was touched, by identity.

    Attributes:
        touches: of each object that was seen, how often it was touched, as the telerobot detected it.
        passed: for how long the tip was below the top of each without touching it [s], where that was long.
        names: of those that are simulated, in their scenario.
        unseen: names of simulated objects that the camera never saw.
    """

    touches: Mapping[int, int]
    passed: Mapping[int, float]
    names: Mapping[int, str]
    unseen: Sequence[str]

    def line(self) -> str:
        """For a terminal."""
        touched = [f"{self._called(thing)} ({count}x)" for thing, count in self.touches.items() if count]
        untouched = [self._called(thing) for thing, count in self.touches.items() if not count]
        parts = [f"{len(self.touches)} seen, touched: {', '.join(touched) or 'none'}"]
        parts += [f"never touched: {', '.join(untouched)}"] if touched and untouched else []
        parts += [f"NEVER SEEN by the camera: {', '.join(self.unseen)}"] if self.unseen else []
        parts += [
            f"NOT TOUCHED although the tip was below the top of {self._called(thing)} for {seconds:.2f} s: "
            "it did not come from above"
            for thing, seconds in self.passed.items()
        ]
        return f"objects: {'; '.join(parts)}"

    def _called(self, thing: int) -> str:
        """Its name; with its identity where several have that name, or instead of one."""
        name = self.names.get(thing)
        if name is None:
            return str(thing)
        return name if list(self.names.values()).count(name) == 1 else f"{name} as {thing}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {
            "touches": {str(thing): count for thing, count in self.touches.items()},
            "passed_s": {str(thing): seconds for thing, seconds in self.passed.items()},
            "names": {str(thing): name for thing, name in self.names.items()},
            "unseen": list(self.unseen),
        }


def objects_touched(recording: Recording) -> ObjectsTouched | None:
    """What the scene of a recording had; None where there was none, or nobody detected contact with it.

    Raises:
        BadInput: names of its objects that are no list in JSON.
    """
    if "scene_1_thing" not in recording or not {"position_x", "detected_contact"} <= set(recording.columns):
        return None
    tip, contact, step = vector(recording, "position"), flag(recording, "detected_contact"), mean_step(recording)
    begins = [first for first, _ in stretches(contact)]
    near, within = _beyond(recording, tip, _SEEN_LOW), _beyond(recording, tip)
    touches = {thing: int(np.count_nonzero(off[begins] <= MARGIN)) for thing, off in near.items()}
    passed = {thing: step * int(np.count_nonzero((off <= 0.0) & ~contact)) for thing, off in within.items()}
    things = _things(recording)
    names = _names(recording, things)
    unseen = [name for name in things if name not in names.values()]
    return ObjectsTouched(
        touches, {thing: seconds for thing, seconds in passed.items() if seconds > _PASSED_S}, names, unseen
    )


def _things(recording: Recording) -> list[str]:
    """Names of the simulated objects whose places it knows."""
    told = recording.made_by.get(THINGS, "[]")
    if "places_1_x" not in recording:
        return []
    try:
        return [str(name) for name in json.loads(told)]
    except ValueError:
        raise BadInput(recording.source, at=THINGS, found=told, expected="a list of names in JSON") from None


def _names(recording: Recording, things: Sequence[str]) -> dict[int, str]:
    """Identity -> the name of the object that stands where it was first seen."""
    names = dict[int, str]()
    if not things:
        return names
    for entry in _entries(recording):
        for thing in _identities(entry):
            first = int(np.argmax(entry["thing"] == thing))
            if thing in names:
                continue
            off = [
                max(abs(recording[f"places_{i}_{axis}"][first] - entry[axis][first]) for axis in "xy")
                for i in range(1, len(things) + 1)
            ]
            if min(off) <= 0.5 * max(entry["along"][first], entry["across"][first]) + MARGIN:
                names[thing] = things[int(np.argmin(off))]
    return dict(sorted(names.items()))


def _entries(recording: Recording) -> Iterator[dict[str, Array]]:
    """The rows of the scene."""
    return ({name: recording[f"scene_{row}_{name}"] for name in _READ} for row in range(1, MOST + 1))


def _identities(entry: Mapping[str, Array]) -> list[int]:
    """What a row of the scene was, one after the other."""
    found: list[int] = np.unique(entry["thing"][entry["thing"] > 0.0]).astype(int).tolist()
    return found


def _beyond(recording: Recording, tip: Array, above: float = 0.0) -> dict[int, Array]:
    """Of each object how far the tip was beyond its outline [m], negative over it; inf where it was not below its top.

    Nor is it below that of one that is not there, or off the table.

    Args:
        recording, tip: the run, and its tip's positions.
        above: what still counts as below the top [m].
    """
    found: dict[int, Array] = {}
    for entry in _entries(recording):
        x = np.abs(tip[:, 0] - entry["x"]) - 0.5 * entry["along"]
        y = np.abs(tip[:, 1] - entry["y"]) - 0.5 * entry["across"]
        there = is_there(entry["state"]) & (entry["state"] != SeenState.CARRIED)
        off = np.where(there & (tip[:, 2] < entry["top"] + above), np.maximum(x, y), np.inf)
        for thing in _identities(entry):
            now = np.where(entry["thing"] == thing, off, np.inf)
            found[thing] = np.minimum(found[thing], now) if thing in found else now
    return dict(sorted(found.items()))
