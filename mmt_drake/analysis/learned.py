"""Laws that came to be told while a run went on, and what that changed in what was felt."""

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from mmt_drake.analysis.signals import component, delayed, flag, mean_step
from mmt_drake.analysis.wording import percent
from mmt_drake.errors import BadInput, attempt
from mmt_drake.learner_status import LearnerStatus
from mmt_drake.model.message_layout import MESSAGE, SENSOR
from mmt_drake.model_message import NO_ERROR, ModelMessage, SensorError, ToldEffect
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording.recording import Recording
from mmt_drake.recording.two_recordings import told_delay
from mmt_drake.rendering.status import RENDERING

SETTLES_S: Final = 1.0
"""Once a message is rendered, in which the object's motion forgets what was rendered before; it counts neither as
before nor as after, as does the time until then."""
_STATUS: Final = "renderer_status"
_TAKES: Final = 2  # ticks until it shows that a message has come
_FIRST_S: Final = 0.5  # of the run's contact, which tells nothing of laws


class ForceOff(NamedTuple):
    """Error of the rendered force against the plant's, in contact; against the plant's without noise, where recorded.

    Attributes:
        surface: along x and y together; None: there was no contact.
        normal: along z, likewise.
    """

    surface: float | None = None
    normal: float | None = None

    @property
    def words(self) -> str:
        """For a person."""
        return f"{percent(self.surface)} along the surface, {percent(self.normal)} along the normal"


@dataclass(frozen=True)
class ToldModel:
    """One message of a run.

    Attributes:
        at: when it was taken up [s].
        contact: how much contact there had been [s].
        rendered: when the renderer had taken it up, laws and numbers, by its status where it has one [s]; None: never.
        effects: that it tells.
        sensor: what it tells of the force sensor.
        error: of the rendered force until the next message.
    """

    at: float
    contact: float
    rendered: float | None
    effects: tuple[ToldEffect, ...]
    sensor: SensorError
    error: ForceOff

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects, and of those of the force sensor."""
        told = zip(SENSOR, self.sensor, strict=True)
        return *(effect.name for effect in self.effects), *(name for name, value in told if value != 0.0)


@dataclass(frozen=True)
class ToldLaws:
    """The messages of a run.

    Attributes:
        before: error of the rendered force until the first.
        told: message by message.
    """

    before: ForceOff
    told: tuple[ToldModel, ...]

    def line(self) -> str:
        """For a terminal."""
        after = f"after {_FIRST_S:g} s of contact"
        parts = [] if self.before == ForceOff() else [f"rendered force off by {self.before.words}, {after}"]
        for model in self.told:
            laws = " and ".join([*(effect.words for effect in model.effects), *model.sensor.words]) or "no law"
            since = "never rendered" if model.rendered is None else f"rendered from {model.rendered:.2f} s on"
            parts.append(f"at {model.at:.2f} s {laws} ({since}): {model.error.words}")
        return f"told while it was felt: {'; '.join(parts)} (each from {SETTLES_S:g} s after it is rendered)"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        told = [
            {
                "at_s": model.at,
                "contact_s": model.contact,
                "rendered_s": model.rendered,
                "effects": [{"name": e.name, "parameters": e.parameters} for e in model.effects],
                "sensor": model.sensor._asdict(),
                "error": model.error.surface,
                "normal_error": model.error.normal,
            }
            for model in self.told
        ]
        return {"before": self.before.surface, "normal_before": self.before.normal, "told": told}


@dataclass(frozen=True)
class LearnerRecord:
    """A learner over a run.

    Attributes:
        looks: how often it looked into a contact.
        at_end: what it was about then.
    """

    looks: int
    at_end: LearnerStatus

    def line(self) -> str:
        """For a terminal."""
        return f"learner: looks at the contact {self.looks}; at the end {self.at_end.words}"

    def to_json(self) -> dict[str, Any]:
        """The same as data."""
        return {"looks": self.looks, "at_end": self.at_end.name.lower()}


def learner(recording: Recording) -> LearnerRecord | None:
    """What a learner was about in a recording; None where there was none.

    Raises:
        BadInput: its status at the end is none.
    """
    if "learner_status" not in recording:
        return None
    status = recording["learner_status"]
    begun = np.diff((status == LearnerStatus.LOOKING).astype(float), prepend=0.0) > 0.0
    if status[-1] not in tuple(LearnerStatus):
        expected = f"one of {', '.join(f'{known:d}' for known in LearnerStatus)}"
        raise BadInput(recording.source, at="learner_status", found=f"{status[-1]:g} at the end", expected=expected)
    return LearnerRecord(int(np.count_nonzero(begun)), LearnerStatus(int(status[-1])))


def learned(recording: Recording) -> ToldLaws | None:
    """What was told in a recording; None where nothing was that could be."""
    columns = [f"model_{name}" for name in MESSAGE]
    numbers = recording[columns[MESSAGE.index("number")]] if columns[0] in recording else np.zeros(1)
    if not numbers.any() or "in_contact" not in recording:
        return None
    step, contact = mean_step(recording), flag(recording, "in_contact")
    seconds = step * np.cumsum(contact)
    delay = told_delay(recording)
    late = round(delay / step)
    both = [attempt(_off, recording, delay, step, axes) for axes in ("xy", "z")]

    def error(samples: Flags) -> ForceOff:
        return ForceOff(*(None if off is None else _of_all(*(squares[samples] for squares in off)) for off in both))

    starts = np.flatnonzero(np.diff(numbers, prepend=0.0) != 0.0)
    ends = [*starts[1:].tolist(), len(numbers)]
    at = np.arange(len(numbers))
    told = []
    for start, end in zip(starts.tolist(), ends, strict=True):
        message = ModelMessage.from_vector(np.array([recording[column][start] for column in columns]))
        effects, sensor = ((), NO_ERROR) if message is None else (message.effects, message.sensor)
        rendered = _rendered(recording, start + late)
        settled = len(numbers) if rendered is None else rendered + late + round(SETTLES_S / step)
        samples = contact & (at >= settled) & (at < end) & (seconds > _FIRST_S)
        since = None if rendered is None else float(recording.time[rendered])
        at_s, of_contact = float(recording.time[start]), float(seconds[start])
        told.append(ToldModel(at_s, of_contact, since, effects, sensor, error(samples)))
    return ToldLaws(error(contact & (at < starts[0]) & (seconds > _FIRST_S)), tuple(told))


def _rendered(recording: Recording, arrived: int) -> int | None:
    """The row from which a message is rendered that arrives at a row; that row where no status tells."""
    if _STATUS not in recording:
        return arrived if arrived < len(recording) else None
    renders = np.flatnonzero(recording[_STATUS][arrived + _TAKES :] == RENDERING)
    return arrived + _TAKES + int(renders[0]) if len(renders) else None


def _of_all(left: Array, size: Array) -> float | None:
    """The error over some samples; None where there was no force."""
    whole = float(np.sum(size))
    return math.sqrt(float(np.sum(left)) / whole) if whole > 0.0 else None


def _off(recording: Recording, delay: float, step: float, axes: str) -> tuple[Array, Array]:
    """Squares of what the rendered force is off by, and of the plant's, (n,) [N^2], along some axes together."""
    reference = "true_force" if recording.has_vector("true_force") else "force"
    error, size = np.zeros(len(recording)), np.zeros(len(recording))
    for axis in axes:
        plant = component(recording, reference, axis)
        error += (delayed(component(recording, "rendered_force", axis), delay, step) - plant) ** 2
        size += plant**2
    return error, size
