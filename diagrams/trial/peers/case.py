"""A case as every package gets it: one axis of a recording of the flexible box, touch by touch, and its model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.prepare import prepare
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.diagrams.trial.peers.result import Stopwatch
from mmt_drake.diagrams.trial.sealed import MODEL, RECORDING
from mmt_drake.effects import LIBRARY
from mmt_drake.errors import BadInput
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import load_model
from mmt_drake.recording import Recording, load

Array = NDArray[np.float64]

FRICTION = LIBRARY["coulomb_friction"]
"""The single effect that is made free: the one of the library that all packages have."""

SHORTEST_TOUCH_S = 0.2
"""A shorter touch says nothing that a longer one does not; it is left out."""


@dataclass(frozen=True)
class Touch:
    """One stretch of contact, as recorded.

    Attributes:
        first: index of its first sample in the recording.
        time: (n,) since its first sample [s].
        stretch: (n,) probe position less where the probe touched [m].
        velocity: (n,) of the probe [m/s].
        force: (n,) of the object on the probe [N].
    """

    first: int
    time: Array
    stretch: Array
    velocity: Array
    force: Array


@dataclass(frozen=True)
class PeerCase:
    """A case of the trial.

    Attributes:
        recording: as read.
        model: nominal, as handed in.
        problem: the axis that moves most, as the project's own fit gets it.
        skew: the largest skew of clocks that its fit leaves open [s].
        touches: the same axis, as recorded.
        preparation_seconds: processor time from the recording as read to `problem`.
    """

    recording: Recording
    model: FlexibleBoxModel
    problem: Problem
    skew: float
    touches: tuple[Touch, ...]
    preparation_seconds: float

    @property
    def track(self) -> Track:
        """The axis, smoothed."""
        return self.problem.tracks[0]

    @property
    def rate_hz(self) -> float:
        """Samples per second as recorded."""
        return self.track.smoothed.clock.rate_hz

    @property
    def friction_is_missing(self) -> bool:
        """Whether the model has no Coulomb friction, so that it can be added."""
        return self.model.parameters.Fc == 0.0


def read_case(folder: Path) -> PeerCase:
    """Read a case's folder.

    Raises:
        BadInput: files that cannot be read, another structure than the flexible box, a ground spring in it, a recording
            that cannot be fitted.
    """
    recording, model = load(folder / RECORDING), load_model(folder / MODEL)
    if not isinstance(model, FlexibleBoxModel):
        raise BadInput(folder / MODEL, at="structure", found=model.NAME, expected=FlexibleBoxModel.NAME)
    if model.parameters.k1 != 0.0:
        # Other packages get every touch by itself; where a ground spring is at rest they would have to be told.
        raise BadInput(folder / MODEL, at="parameters: k1", found=model.parameters.k1, expected="0, for comparison")
    prepared = prepare([recording], model)
    if prepared.problem is None:
        raise BadInput(recording.source, found=prepared.reason, expected="a recording that can be fitted")
    track = max(prepared.problem.tracks, key=lambda t: float(np.std(t.measured)))
    touches = _touches(recording, track)
    if not touches:
        raise BadInput(recording.source, found="no touch", expected=f"one of {SHORTEST_TOUCH_S:g} s or longer")
    with Stopwatch() as taken:
        prepare([recording], model)  # once more, everything compiled
    return PeerCase(recording, model, Problem((track,)), prepared.skew, touches, taken.cpu_seconds)


def _touches(recording: Recording, track: Track) -> tuple[Touch, ...]:
    contact, axis = track.smoothed.contact, track.axis
    names = [f"{name}_{axis}" if axis else name for name in ("position", "velocity", "force")]
    position, velocity, force = (recording[name] for name in names)
    begins = np.array([*([recording.time[0]] if contact.starts_in else []), *contact.touches])
    found = []
    for first, last in runs(contact.at(recording.time)):
        time = recording.time[first:last]
        if time[-1] - time[0] < SHORTEST_TOUCH_S:
            continue
        # The probe may be faster than a sample is short: where it touched lies between two of them.
        at = begins[np.searchsorted(begins, time[0], side="right") - 1]
        stretch = position[first:last] - np.interp(at, recording.time, position)
        found.append(Touch(first, time - time[0], stretch, velocity[first:last], force[first:last]))
    return tuple(found)


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """(first, one past the last) index of every stretch of true flags (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
