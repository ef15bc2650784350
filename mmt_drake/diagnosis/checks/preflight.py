"""Before a recording is diagnosed: what its clock, sensors and motion are worth, and whether it can say anything."""

from dataclasses import dataclass, replace

import numpy as np

from mmt_drake.diagnosis.checks.alignment import (
    flag_findings,
    lag_findings,
    law_findings,
    law_fit,
    normal_fit,
    offset_findings,
)
from mmt_drake.diagnosis.checks.excitation import AxisMotion, excitation_findings, motions
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.checks.plausibility import drive_findings, sign_findings, unit_findings
from mmt_drake.diagnosis.checks.sensors import bias_findings, channel_findings, clock_findings, drowned, noise_findings
from mmt_drake.diagnosis.signals.columns import Columns, channels_of
from mmt_drake.diagnosis.signals.smoother import Smoothed, on_even_clock, smooth
from mmt_drake.diagnosis.signals.touches import raw_flags
from mmt_drake.errors import BadInput
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.structure import PositionOut
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model.transmission import TransmissionModel
from mmt_drake.model_files import Model
from mmt_drake.numeric.arrays import Array
from mmt_drake.recording import AXES, Recording
from mmt_drake.recording.check import completed
from mmt_drake.recording.signals import ORIENTATION
from mmt_drake.replay import check_load, replayed

_ENOUGH = 5000
_FOREIGN = 0.5  # of a rate's RMS: a column that is farther from it is the rate of something else


@dataclass(frozen=True)
class Preflight:
    """What was found before any fit.

    Attributes:
        recording: what was checked, and is to be diagnosed: as read, or without rates that are not its own.
        findings: what is worst first, else in the order of the checks.
        outputs: columns of `Smoothed.output` that belong to the tangential axes that move and whose force stands out of
            its noise, to the one axis or to the output of a driven body.
        motions: how each tangential axis, the one axis or the output moves.
        smoothed: the recording, as every check saw it.
        columns: of the recording, which that was made of.
    """

    recording: Recording
    findings: tuple[Finding, ...]
    outputs: tuple[int, ...]
    motions: tuple[AxisMotion, ...]
    smoothed: Smoothed
    columns: Columns

    @property
    def reason(self) -> str | None:
        """Why nothing can be said, in one line; None if something can."""
        reasons = [finding.text for finding in self.findings if finding.severity == "refuse"]
        return " ".join(reasons) or None

    @property
    def is_too_short(self) -> bool:
        """Whether nothing can be said for want of samples alone."""
        return {finding.code for finding in self.findings if finding.severity == "refuse"} == {"too_short"}


def check_belongs(recording: Recording, model: Model) -> None:
    """Whether a model is of a structure that this kind of recording can drive.

    Raises:
        BadInput: it is not.
    """
    if isinstance(model, PositionOut):
        good, wants = recording.kind == "driven_body", "time, input, output"
    elif isinstance(model, KelvinVoigt):
        good, wants = recording.kind == "single_axis", "time, position, force"
    elif isinstance(model, SurfaceContact):
        good, wants = recording.kind == "contact", "time, position_x, position_y ... force_x ..."
    else:
        good, wants = recording.kind in ("contact", "single_axis"), "time, position_x, position_y ... force_x ..."
    if not good:
        columns = ", ".join(name for name in recording.columns if name not in recording.derived)
        raise BadInput(recording.source, at="columns", found=columns, expected=f"{wants} for this structure of model")
    check_load(model, recording)


def preflight(recording: Recording, model: Model) -> Preflight:
    """Check a recording before it is diagnosed.

    Args:
        recording: as read.
        model: the nominal model; it tells units, signs and times that cannot be.

    Raises:
        BadInput: the model does not belong to this kind of recording, or `smooth` refuses it.
    """
    check_belongs(recording, model)
    encoded = isinstance(model, TransmissionModel)
    columns = on_even_clock(recording, encoded=encoded)
    smoothed = smooth(recording, columns=columns)
    foreign = _foreign_rates(recording, smoothed, columns.moving_rates)
    if foreign:
        recording = _without(recording, columns.moving_rates)
        columns = on_even_clock(recording, encoded=encoded)
        smoothed = smooth(recording, columns=columns)
    channels = columns.channels
    moved = motions(smoothed)
    axes = {"contact": AXES[:2], "single_axis": ("position",), "driven_body": ("output",)}[smoothed.kind]
    used = tuple(i for i, motion in enumerate(moved) if motion.moves)
    findings = foreign + clock_findings(smoothed) + excitation_findings(smoothed, moved, axes)
    if used:
        answers = tuple(channels.outputs[i] for i in used)
        if isinstance(model, SurfaceContact):
            answers = channels.outputs[2:]  # a tip that glides freely over a level surface feels nothing else
        channel = dict.fromkeys(answers, True) | ({"force_z": False} if smoothed.kind == "contact" else {})
        sensors = channel_findings(recording, channel, raw_flags(recording, smoothed.noise))
        without = drowned(smoothed, channels.outputs, answers)
        conventions = _conventions(recording, model, smoothed, used, sensors)
        findings += conventions + sensors
        if not _out_of_step(conventions):  # else free space is none, and what is read off it misleads
            findings += bias_findings(smoothed, channels.outputs)
            findings += noise_findings(smoothed, channels.outputs, answers, without)
        used = tuple(i for i in used if channels.outputs[i] not in without) or used
    order = ("refuse", "warn", "note")
    findings.sort(key=lambda finding: order.index(finding.severity))
    return Preflight(recording, tuple(findings), used, moved, smoothed, columns)


def _foreign_rates(recording: Recording, smoothed: Smoothed, names: tuple[str, ...]) -> list[Finding]:
    """Of a recorded rate that is not the rate of what was recorded beside it: zeros, another unit, another sign."""
    if smoothed.uses_velocity or not names or not smoothed.top_hz.any():
        return []
    driven = smoothed.kind == "driven_body"
    true = np.gradient(smoothed.output, smoothed.time, axis=0) if driven else smoothed.input_rate
    size = np.sqrt(np.mean(true**2, axis=0))
    main = int(np.argmax(size))
    given = smoothed.filter(np.interp(smoothed.time, recording.time, recording[names[main]]))
    off = float(np.sqrt(np.mean((given - true[:, main]) ** 2)) / max(float(size[main]), 1e-300))
    if off <= _FOREIGN:
        return []
    text = (
        f"{names[main]} is not the rate of what moves: it is off by {100 * off:.3g} %. Rates are derived instead; "
        "leave such columns out, and `mmt-drake simulate` gives the figures said here."
    )
    return [Finding("foreign_rate", "warn", text, {"off": off})]


def _without(recording: Recording, rates: tuple[str, ...]) -> Recording:
    dropped = recording.derived.union(rates)
    own = {name: values for name, values in recording.columns.items() if name not in dropped}
    bare = completed(recording.time, own, recording.source, constants=recording.constants)
    return replace(bare, clouds=recording.clouds, notes=(*recording.notes, *bare.notes))


def _conventions(
    recording: Recording, model: Model, smoothed: Smoothed, used: tuple[int, ...], sensors: list[Finding]
) -> list[Finding]:
    """Signs, times and units, each by what touches, the law of the kind and the nominal model say of them."""
    nominal = _nominal(recording, model, smoothed)
    clipped = any(finding.code == "saturation" and "force_z" in finding.text for finding in sensors)
    fit, law = None if clipped else normal_fit(smoothed), law_fit(smoothed)
    findings = sign_findings(smoothed, fit, law, nominal, used)
    findings += drive_findings(model, law, nominal, smoothed.output)
    findings += offset_findings(fit, smoothed.clock.step) + flag_findings(recording, smoothed)
    if not _out_of_step(findings):
        findings += law_findings(smoothed, law) or lag_findings(smoothed, nominal, used)
    return findings + unit_findings(smoothed, model, nominal, used, fit)


def _out_of_step(findings: list[Finding]) -> bool:
    return any(finding.code in ("swapped_sign", "misaligned") for finding in findings)


def _nominal(recording: Recording, model: Model, smoothed: Smoothed) -> Array | None:
    """What the nominal model answers, (n, k), filtered as the recording is; None where it runs away.

    Of a driven body only the beginning, `_ENOUGH` samples: it serves for orders of magnitude alone.
    """
    channels = channels_of(recording)
    columns = dict(zip(channels.inputs, smoothed.input.T, strict=True))
    if smoothed.kind == "driven_body":
        columns["output"] = smoothed.output[:, 0]
        if "load" in recording:
            columns["load"] = np.interp(smoothed.time, recording.time, recording["load"])
    else:
        rates = (name.replace("position", "velocity") for name in channels.inputs)
        columns |= dict(zip(rates, smoothed.input_rate.T, strict=True))
        columns["in_contact"] = smoothed.in_contact.astype(np.float64)
        columns |= dict(zip(channels.outputs, smoothed.output.T, strict=True))
        if any(model.additions.tool) and smoothed.hand is not None:
            columns |= zip(ORIENTATION, smoothed.hand.quaternion.T, strict=True)
    count = min(len(smoothed.time), _ENOUGH) if smoothed.kind == "driven_body" else len(smoothed.time)
    part = {name: values[:count] for name, values in columns.items()}
    driven = Recording(smoothed.time[:count], part, recording.source, constants=recording.constants)
    try:
        answer = replayed(model, driven)
    except RuntimeError:  # of the kernels, about numbers that are absurd
        return None
    table = np.column_stack([answer[name] for name in channels.outputs])
    return smoothed.filter(table) if np.isfinite(table).all() else None
