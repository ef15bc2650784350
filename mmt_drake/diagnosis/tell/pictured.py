"""What a diagnosis rests on, made ready to be drawn: every recording and axis, measured and simulated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from mmt_drake.diagnosis.checks.preflight import Preflight
from mmt_drake.diagnosis.fit.errors import free_running, in_contact, intervals_of, noise_through
from mmt_drake.diagnosis.fit.prepare import with_normal
from mmt_drake.diagnosis.fit.tracks import Track
from mmt_drake.diagnosis.signals.clocks import clock_of, on_clock
from mmt_drake.diagnosis.tell.evidence import Evidence, Series, Spectrum
from mmt_drake.diagnosis.tell.force_curves import Curves, curves_of
from mmt_drake.errors import MmtError
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.recording import Recording

if TYPE_CHECKING:
    from mmt_drake.diagnosis.tell.outcome import Outcome

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_SEGMENT_S = 4.0  # of the spectra
_STATES = {
    "sliding_velocity": ("sliding velocity", "m/s"),
    "deflection": ("deflection", "m"),
    "deflection_rate": ("deflection rate", "m/s"),
    "position": ("body position", "m"),
    "load": ("normal load", "N"),
    "input": ("input", ""),
}


@dataclass(frozen=True)
class _Models:
    """The models of an outcome, those that there are in the order of `evidence.MODELS`.

    Attributes:
        named: name -> model.
        blocks: that the effects found act in.
        skew: of the output's clock in the model shown last [s].
    """

    named: Mapping[str, Structure]
    blocks: frozenset[str]
    skew: float

    @classmethod
    def of(cls, outcome: Outcome) -> _Models:
        normal = None if outcome.normal is None else outcome.normal.normal
        named, blocks, skew = {"nominal": outcome.nominal}, frozenset[str](), 0.0
        if outcome.refit is not None:
            named["refit"], skew = with_normal(outcome.refit.model, normal), outcome.refit.skew
        if outcome.best is not None and outcome.best.hypothesis.effects:
            named["augmented"], skew = with_normal(outcome.best.model, normal), outcome.best.skew
            values = outcome.best.hypothesis.effect_values(outcome.best.x)
            blocks = frozenset(
                effect.block if effect.block_of is None else effect.block_of(values[effect.name])
                for effect in outcome.best.hypothesis.effects
            )
        return cls(named, blocks, skew)

    @property
    def last(self) -> Structure:
        """The one with most in it."""
        return self.named[tuple(self.named)[-1]]


def pictures_of(outcome: Outcome) -> tuple[Evidence, ...]:
    """What the figures of a report are drawn from: one for each recording and each of its axes that moved.

    Raises:
        BadInput: the models do not fit the recordings.
    """
    models = _Models.of(outcome)
    prepared = outcome.prepared
    tracks = [()] * len(prepared.recordings) if prepared.problem is None else prepared.problem.by_recording()
    found = zip(prepared.recordings, prepared.preflights, tracks, strict=True)
    return tuple(piece for recording, check, own in found for piece in _of_recording(recording, check, own, models))


def _of_recording(recording: Recording, check: Preflight, tracks: Sequence[Track], models: _Models) -> list[Evidence]:
    simulated = {name: found for name, model in models.named.items() if (found := _simulated(model, recording))}
    through: Mapping[str, Array] = {}
    if models.named.keys() <= simulated.keys():
        through = noise_through(models.last, recording, check.smoothed)
    result = []
    for axis, column in zip(check.axes, check.outputs, strict=True):
        contact = recording.kind == "contact"
        name = {"contact": f"force_{axis}", "single_axis": "force", "driven_body": "output"}[check.smoothed.kind]
        track = next((t for t in tracks if t.column == column), None)
        outputs = {model: columns[name] for model, columns in simulated.items()}
        result.append(
            _of_axis(recording, axis if contact else "", name, outputs, through.get(name), check, track, models)
        )
    return result


def _of_axis(
    recording: Recording,
    axis: str,
    name: str,
    outputs: Mapping[str, Array],
    through: Array | None,
    check: Preflight,
    track: Track | None,
    models: _Models,
) -> Evidence:
    is_box = isinstance(models.last, FlexibleBoxModel)
    counted = in_contact(recording) if is_box else np.ones(len(recording), dtype=bool)
    sensor = check.smoothed.noise[name]
    noise = sensor.std
    if through is not None and (known := counted & np.isfinite(through)).any():  # there is none beside the windows
        noise = math.hypot(noise, float(np.sqrt(np.mean(through[known] ** 2))))
    measured = Series("output", "", recording[name]) if name == "output" else Series("force", "N", recording[name])
    residuals = {model: recording[name] - output for model, output in outputs.items()}
    states, curves = {}, Curves()
    if track is not None:
        states = _states(track, models.last, recording.time)
        if "refit" in models.named:
            curves = curves_of(track, models.named["refit"], models.named.get("augmented"), models.blocks, models.skew)
    return Evidence(
        recording=Path(recording.source).name,
        axis=axis,
        time=recording.time,
        measured=measured,
        counted=counted,
        heldout_s=() if track is None else intervals_of(track.time, track.heldout),
        noise=noise,
        states=states,
        restoring=curves.restoring,
        friction=curves.friction,
        spectrum=_spectrum(recording.time, residuals, counted, sensor.density, through),
        **outputs,
    )


def _simulated(model: Structure, recording: Recording) -> dict[str, Array] | None:
    """What a model answers; None where it runs away."""
    try:
        return free_running(model, recording)
    except MmtError:
        return None


def _states(track: Track, model: Structure, time: Array) -> dict[str, Series]:
    """The signals that the residual may depend on, at the recording's times [s]; each once under one name."""
    _, found = track.replay(model, coarse=1.0)
    states: dict[str, Series] = {}
    for name, values in found.items():
        if any(values is found[other] for other in states):
            continue
        label, unit = _STATES[name]
        unit = unit if track.smoothed.kind != "driven_body" else ""
        states[name] = Series(label, unit, np.interp(time, track.time, values))
    return states


def _spectrum(
    time: Array, residuals: Mapping[str, Array], counted: Flags, density: float, through: Array | None
) -> Spectrum | None:
    """Welch's densities over the samples that count and are known; the others are 0, and made up for."""
    if not counted.any() or not residuals:
        return None
    clock = clock_of(time)
    length = min(clock.count, max(8, round(_SEGMENT_S * clock.rate_hz)))

    def of(values: Array) -> tuple[Array, Array]:
        known = counted & np.isfinite(values)
        even = on_clock(time, np.where(known, values, 0.0)[:, np.newaxis], clock)[:, 0]
        frequency, power = signal.welch(even, clock.rate_hz, nperseg=length)
        return frequency, power / max(float(np.mean(known)), 1.0 / len(known))

    frequency = of(next(iter(residuals.values())))[0]
    noise = np.full(len(frequency), density)
    if through is not None:
        noise += of(through)[1]
    return Spectrum(frequency, noise=noise, **{name: of(values)[1] for name, values in residuals.items()})
