"""Rough numbers of a model, from a recording alone: where a fit that believes nothing yet begins."""

from typing import Literal, cast, get_args

import numpy as np

from mmt_drake.diagnosis.signals.smoother import Smoothed, smooth
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

StructureName = Literal["flexible_box", "kelvin_voigt", "driven_body", "surface_contact"]

_USUAL: dict[str, StructureName] = {
    "contact": "flexible_box",
    "single_axis": "kelvin_voigt",
    "driven_body": "driven_body",
}
_LEAST = 0.03
"""A coefficient is taken for at least this part of what alone would explain all: nothing begins at 0."""


def usual_structure(recording: Recording) -> StructureName:
    """The structure that a recording with these columns is of, unless somebody says otherwise."""
    return _USUAL[recording.kind]


def rough_model(recording: Recording, structure: str | None = None) -> Model:
    """A model whose numbers have the size that the recording suggests: none is 0, none is more than that.

    Linear least squares where the law is linear in what was recorded (`kelvin_voigt`, `driven_body`), else the ratios
    of force to motion.

    Args:
        recording: as read.
        structure: of model files; by default what goes with the columns.

    Raises:
        BadInput: no such structure, or one that does not belong to such a recording; a driven body whose input never
            changes; a recording that is too short to be smoothed.
    """
    structure = usual_structure(recording) if structure is None else structure
    kinds = {
        "flexible_box": ("contact", "single_axis"),
        "kelvin_voigt": ("single_axis",),
        "surface_contact": ("contact",),
    }
    if structure not in get_args(StructureName):
        raise BadInput("--structure", found=repr(structure), expected=f"one of {', '.join(get_args(StructureName))}")
    if recording.kind not in kinds.get(structure, ("driven_body",)):
        fitting = [name for name in get_args(StructureName) if recording.kind in kinds.get(name, ("driven_body",))]
        if recording.kind == "contact":
            fitting.append("with --axis kelvin_voigt")
        found = f"{structure} for a {recording.kind.replace('_', ' ')} recording"
        raise BadInput(recording.source, at="--structure", found=found, expected=" or ".join(fitting))
    smoothed = smooth(recording)
    counts = smoothed.in_contact & (smoothed.weight > 0.0)
    moving = (
        smoothed.output if structure == "driven_body" else smoothed.input[:, : 2 if smoothed.kind == "contact" else 1]
    )
    spread = np.ptp(moving[counts], axis=0) if counts.any() else np.zeros(1)
    if not spread.max() > 0.0:
        still: dict[str, Model] = {
            "driven_body": DrivenBodyModel(m=1.0),
            "kelvin_voigt": KelvinVoigt(k=1.0),
            "surface_contact": SurfaceContact(k=1.0, b=0.0),
        }
        return still.get(structure, FlexibleBoxModel(in_plane=None))
    if structure == "surface_contact":
        return _surface_contact(smoothed, counts)
    if structure == "driven_body":
        return _driven_body(recording, smoothed, counts)
    if structure == "kelvin_voigt":
        return _kelvin_voigt(smoothed, counts)
    return _flexible_box(smoothed, counts, int(np.argmax(spread)))


def _driven_body(recording: Recording, smoothed: Smoothed, counts: Flags) -> DrivenBodyModel:
    if np.ptp(recording["input"]) == 0.0:
        found = f"an input of {recording['input'][0]:g} throughout"
        expected = "one that varies: free motion tells ratios alone; give a model with the mass that you know"
        raise BadInput(recording.source, at="column 'input'", found=found, expected=expected)
    x = smoothed.output[:, 0]
    v = np.gradient(x, smoothed.time)
    causes = np.column_stack([np.gradient(v, smoothed.time), v, x - x[counts].mean(), np.sign(v), np.ones_like(v)])
    m, b, k, Fc, offset = _coefficients(causes[counts], smoothed.filter(smoothed.input)[counts, 0])
    return DrivenBodyModel(m=abs(m), b=abs(b), k=abs(k), Fc=abs(Fc), offset=offset)


def _kelvin_voigt(smoothed: Smoothed, counts: Flags) -> KelvinVoigt:
    causes = np.column_stack([-smoothed.input[:, 0], -smoothed.input_rate[:, 0], np.ones(len(smoothed.time))])
    k, b, F0 = _coefficients(smoothed.filter(causes)[counts], smoothed.output[counts, 0])
    return KelvinVoigt(k=abs(k), b=abs(b), F0=F0)


def _surface_contact(smoothed: Smoothed, counts: Flags) -> SurfaceContact:
    """By the rates of force and height: quick presses tell them, and least of the slope of an unknown surface."""
    rates = np.gradient(np.column_stack([-smoothed.input[:, 2], -smoothed.input_rate[:, 2]]), smoothed.time, axis=0)
    k, b = _coefficients(rates[counts], np.gradient(smoothed.output[:, 2], smoothed.time)[counts])
    return SurfaceContact(k=abs(k), b=abs(b))


def _flexible_box(smoothed: Smoothed, counts: Flags, lively: int) -> FlexibleBoxModel:
    rate = smoothed.input_rate[:, lively]
    force, speed = _rms(smoothed.output[counts, lively]), _rms(rate[counts])
    m = force / _rms(np.gradient(rate, smoothed.time)[counts])
    k, b = force / float(np.std(smoothed.input[counts, lively])), force / speed
    normal = NormalContact(0.0, 0.0)
    if smoothed.kind == "contact":
        height = -np.column_stack([smoothed.input[:, 2], smoothed.input_rate[:, 2]])
        own = _coefficients(height[counts], smoothed.output[counts, 2])
        normal = NormalContact(*(abs(number) for number in own))
        k = max(k, normal.k)  # what is alike in all directions is as stiff along the surface
    parameters = BoxParameters(m=m, k1=0.1 * k, k2=k, b1=b, b2=b, Fc=0.3 * force)
    return FlexibleBoxModel(parameters=parameters, normal=normal, in_plane=None)


def _coefficients(causes: Array, effect: Array) -> list[float]:
    """Of least squares, none smaller than `_LEAST` of what alone would explain the effect."""
    found = np.linalg.lstsq(causes, effect, rcond=None)[0]
    least = _LEAST * _rms(effect) / np.maximum(np.sqrt(np.mean(causes**2, axis=0)), 1e-300)
    return cast(list[float], np.where(np.abs(found) < least, np.copysign(least, found), found).tolist())


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
