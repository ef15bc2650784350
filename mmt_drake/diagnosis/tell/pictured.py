"""Recordings and axes of a diagnosis, measured and simulated, made ready to be drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy import signal

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.checks.preflight import Preflight
from mmt_drake.diagnosis.fit.box_tracks import NormalTrack
from mmt_drake.diagnosis.fit.errors import free_running, in_contact, intervals_of, noise_through
from mmt_drake.diagnosis.fit.surface_track import SurfaceTrack
from mmt_drake.diagnosis.fit.tracks import STATES, Track
from mmt_drake.diagnosis.signals.clocks import clock_of, on_clock
from mmt_drake.diagnosis.tell.evidence import Evidence, Series, Spectrum
from mmt_drake.diagnosis.tell.force_curves import curves_of
from mmt_drake.errors import attempt
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model.structure import Structure
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import AXES

if TYPE_CHECKING:
    from mmt_drake.diagnosis.tell.outcome import Outcome


_SEGMENT_S = 4.0  # of the spectra


def pictures_of(outcome: Outcome) -> tuple[Evidence, ...]:
    """What the figures of a report are drawn from: one for each recording and each of its axes that moved.

    Raises:
        BadInput: the models do not fit the recordings.
    """
    prepared = outcome.prepared
    tracks = [()] * len(prepared.preflights) if prepared.problem is None else prepared.problem.by_recording()
    found = zip(prepared.preflights, tracks, strict=True)
    return tuple(piece for check, own in found for piece in _of_recording(outcome, check, own))


def _of_recording(outcome: Outcome, check: Preflight, tracks: Sequence[Track]) -> Iterator[Evidence]:
    models, recording, smoothed = outcome.models, check.recording, check.smoothed
    last = models[next(reversed(models))]
    simulated = {name: found for name, model in models.items() if (found := attempt(free_running, model, recording))}
    through = noise_through(last, recording, smoothed) if models.keys() <= simulated.keys() else {}
    counted = in_contact(recording) if isinstance(last, FlexibleBoxModel) else np.ones(len(recording), dtype=bool)
    columns = dict.fromkeys((*check.outputs, *(track.column for track in tracks)))
    for column in columns:
        axis = AXES[column]
        name = {"contact": f"force_{axis}", "single_axis": "force", "driven_body": "output"}[smoothed.kind]
        outputs = {model: columns[name] for model, columns in simulated.items()}
        residuals = {model: recording[name] - output for model, output in outputs.items()}
        sensor, passed = smoothed.noise[name], through.get(name)
        noise = sensor.std
        if passed is not None and (known := counted & np.isfinite(passed)).any():  # there is none beside the windows
            noise = math.hypot(noise, rms(passed[known]))
        track = next((t for t in tracks if t.column == column), None)
        restoring, friction = None, None
        if track is not None and not isinstance(track, NormalTrack | SurfaceTrack) and "refit" in models:
            skew = list(outcome.fits.values())[-1].skew
            restoring, friction = curves_of(track, models["refit"], models.get("augmented"), outcome.blocks, skew)
        yield Evidence(
            recording=Path(recording.source).name,
            axis=axis if smoothed.kind == "contact" else "",
            time=recording.time,
            measured=Series(name.partition("_")[0], last.unit("m" if name == "output" else "N"), recording[name]),
            counted=counted,
            heldout_s=() if track is None else intervals_of(track.time, track.heldout),
            models=outputs,
            noise=noise,
            states={} if track is None else _states(track, last, recording.time),
            restoring=restoring,
            friction=friction,
            spectrum=_spectrum(recording.time, residuals, counted, sensor.density, passed),
        )


def _states(track: Track, model: Structure, time: Array) -> dict[str, Series]:
    """The signals that the residual may depend on, at the recording's times [s]; each once under one name."""
    _, found = track.replay(model, coarse=1.0)
    states: dict[str, Series] = {}
    for name, values in found.items():
        if any(values is found[other] for other in states):
            continue
        _, label, unit = STATES[name]
        states[name] = Series(label, model.unit(unit), np.interp(time, track.time, values))
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
    return Spectrum(frequency, {name: of(values)[1] for name, values in residuals.items()}, noise)
