"""Evidence of a diagnosis, from which its pictures are drawn: arrays, with their names and units."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.fit.errors import within
from mmt_drake.errors import BadInput
from mmt_drake.numeric.arrays import Array, Flags


@dataclass(frozen=True)
class Series:
    """Values with what they are called and their unit: (n,) `values`, `label` without unit, `unit` SI."""

    label: str
    unit: str
    values: Array


@dataclass(frozen=True)
class Curve:
    """A force over the signal that it is thought to depend on, one sample per instant, in order of time.

    Attributes:
        over: (k,) the signal, e.g. the sliding velocity.
        force: (k,) the force read off the recording, every other term of the model taken away.
        models: `refit`, `augmented` -> (k,) the same force in the model without and with the effects found.
    """

    over: Series
    force: Series
    models: Mapping[str, Array]

    def __post_init__(self) -> None:
        _same_length("curve", len(self.over.values), force=self.force.values, **self.models)


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral densities of the residuals, (m,) each, in unit²/Hz of the output.

    Attributes:
        frequency: (m,) [Hz].
        residuals: of measured minus simulated, by the model's name as in `Evidence.models`.
        noise: of the sensor's noise, what no model can remove.
    """

    frequency: Array
    residuals: Mapping[str, Array]
    noise: Array | None = None

    def __post_init__(self) -> None:
        _same_length("spectrum", len(self.frequency), **self.residuals, noise=self.noise)


@dataclass(frozen=True)
class Evidence:
    """One axis of one recording, measured and simulated. Pieces that are None were not computed.

    Attributes:
        recording: its name.
        axis: `x`, `y` or `z`; empty for a single axis or a driven body.
        time: (n,) [s].
        measured: (n,) the output as recorded: a force on the probe [N], or a body's position.
        counted: (n,) samples that enter the errors: those in contact.
        heldout_s: blocks (from, to) [s] that nothing was fitted to.
        models: name -> (n,) the output of each model that was run, free-running, in this order: `nominal`, the model
            handed in; `refit`, the same with its parameters fitted; `augmented`, that with the effects found.
        noise: standard deviation of the output's noise, its unit.
        states: name -> (n,) signal that the residual may depend on.
        restoring: contact or spring force over deflection.
        friction: friction force over sliding velocity.
        spectrum: of the residuals.

    Raises:
        BadInput: arrays of different lengths.
    """

    recording: str
    axis: str
    time: Array
    measured: Series
    counted: Flags
    heldout_s: tuple[tuple[float, float], ...] = ()
    models: Mapping[str, Array] = field(default_factory=dict)
    noise: float | None = None
    states: Mapping[str, Series] = field(default_factory=dict)
    restoring: Curve | None = None
    friction: Curve | None = None
    spectrum: Spectrum | None = None

    def __post_init__(self) -> None:
        states = {name: signal.values for name, signal in self.states.items()}
        arrays = {"measured": self.measured.values, "counted": self.counted, **self.models, **states}
        _same_length("evidence", len(self.time), **arrays)

    @property
    def label(self) -> str:
        """The recording's name, with the axis if there are several."""
        return f"{self.recording}, {self.axis}" if self.axis else self.recording

    @property
    def residuals(self) -> dict[str, Array]:
        """Name -> (n,) measured minus simulated, in the order of `models`."""
        return {name: self.measured.values - output for name, output in self.models.items()}

    @property
    def errors(self) -> dict[str, Array]:
        """The same where samples count; NaN elsewhere."""
        return {name: np.where(self.counted, values, np.nan) for name, values in self.residuals.items()}

    @property
    def heldout(self) -> Flags:
        """(n,) samples in held-out blocks, both ends included."""
        return within(self.time, self.heldout_s)


def worst_windows(
    evidence: Evidence, count: int = 3, length_s: float = 2.0, *, of: str | None = None
) -> list[tuple[float, float]]:
    """The windows (from, to) [s] in which a model is furthest off, worst first.

    It is the model `of` that name, else the refitted one where there is one, else the nominal. Samples that count add
    their squared error. Windows do not overlap, and lie in held-out blocks where any is long enough; there are fewer
    than `count` where nothing else has an error to show.
    """
    residuals = evidence.residuals
    if not residuals:
        return []
    error = residuals.get(of or "refit", next(iter(residuals.values())))
    energy = np.concatenate([[0.0], np.cumsum(np.where(evidence.counted, error**2, 0.0))])
    fitted = np.concatenate([[0], np.cumsum(~evidence.heldout)])
    ends = np.searchsorted(evidence.time, evidence.time + length_s)
    score = np.where(ends < len(evidence.time), energy[ends] - energy[:-1], 0.0)
    untouched = (fitted[ends] == fitted[:-1]) & (score > 0.0)
    score = np.where(untouched, score, 0.0) if np.any(untouched) else score
    found: list[tuple[float, float]] = []
    while len(found) < count and np.any(score > 0.0):
        start = float(evidence.time[int(np.argmax(score))])
        found.append((start, start + length_s))
        score[np.abs(evidence.time - start) < length_s] = 0.0
    return found


def _same_length(what: str, expected: int, **arrays: NDArray[np.generic] | None) -> None:
    for name, values in arrays.items():
        if values is not None and values.shape != (expected,):
            raise BadInput(what, at=name, found=f"shape {values.shape}", expected=f"({expected},)")
