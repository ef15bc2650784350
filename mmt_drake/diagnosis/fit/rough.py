"""Rough numbers of a model, from a recording alone: where a fit that believes nothing yet begins."""

from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.signals.smoother import Smoothed, smooth
from mmt_drake.errors import BadInput
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.kelvin_voigt import KelvinVoigt
from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel, NormalContact
from mmt_drake.model.surface_contact import SurfaceContact
from mmt_drake.model_files import Model
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

_LEAST = 0.03
"""A coefficient is taken for at least this part of what alone would explain all: nothing begins at 0."""


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
    structure = _USUAL[recording.kind] if structure is None else structure
    if structure not in _STRUCTURES:
        raise BadInput("--structure", found=repr(structure), expected=f"one of {', '.join(_STRUCTURES)}")
    kinds, still, guess = _STRUCTURES[structure]
    if recording.kind not in kinds:
        fitting = [name for name, own in _STRUCTURES.items() if recording.kind in own.kinds]
        if recording.kind == "contact":
            fitting.append("with --axis kelvin_voigt")
        found = f"{structure} for a {recording.kind.replace('_', ' ')} recording"
        raise BadInput(recording.source, at="--structure", found=found, expected=" or ".join(fitting))
    smoothed = smooth(recording)
    counts = smoothed.in_contact & (smoothed.weight > 0.0)
    moving = smoothed.output if structure == "driven_body" else _along(smoothed)
    moves = counts.any() and np.ptp(moving[counts], axis=0).max() > 0.0
    return guess(recording, smoothed, counts) if moves else still


def _along(smoothed: Smoothed) -> Array:
    """(n, k) position along the surface, or of the one axis [m]."""
    return smoothed.input[:, : 2 if smoothed.kind == "contact" else 1]


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


def _kelvin_voigt(_: Recording, smoothed: Smoothed, counts: Flags) -> KelvinVoigt:
    causes = np.column_stack([-smoothed.input[:, 0], -smoothed.input_rate[:, 0], np.ones(len(smoothed.time))])
    k, b, F0 = _coefficients(smoothed.filter(causes)[counts], smoothed.output[counts, 0])
    return KelvinVoigt(k=abs(k), b=abs(b), F0=F0)


def _surface_contact(_: Recording, smoothed: Smoothed, counts: Flags) -> SurfaceContact:
    """By the rates of force and height: quick presses tell them, and least of the slope of an unknown surface."""
    rates = np.gradient(np.column_stack([-smoothed.input[:, 2], -smoothed.input_rate[:, 2]]), smoothed.time, axis=0)
    k, b = _coefficients(rates[counts], np.gradient(smoothed.output[:, 2], smoothed.time)[counts])
    return SurfaceContact(k=abs(k), b=abs(b))


def _flexible_box(_: Recording, smoothed: Smoothed, counts: Flags) -> FlexibleBoxModel:
    lively = int(np.argmax(np.ptp(_along(smoothed)[counts], axis=0)))
    rate = smoothed.input_rate[:, lively]
    force, speed = rms(smoothed.output[counts, lively]), rms(rate[counts])
    m = force / rms(np.gradient(rate, smoothed.time)[counts])
    k, b = force / float(np.std(smoothed.input[counts, lively])), force / speed
    normal = NormalContact(0.0, 0.0)
    if smoothed.kind == "contact":
        height = -np.column_stack([smoothed.input[:, 2], smoothed.input_rate[:, 2]])
        own = _coefficients(height[counts], smoothed.output[counts, 2])
        normal = NormalContact(*(abs(number) for number in own))
        k = max(k, normal.k)  # what is alike in all directions is as stiff along the surface
    parameters = BoxParameters(m=m, k1=0.1 * k, k2=k, b1=b, b2=b, Fc=0.3 * force)
    return FlexibleBoxModel(parameters=parameters, normal=normal, in_plane=None)


class _Guess(NamedTuple):
    """How a structure's numbers are guessed: of which kinds of recordings, a model of what stands still, and how."""

    kinds: tuple[str, ...]
    still: Model
    of: Callable[[Recording, Smoothed, Flags], Model]


_STRUCTURES = {
    "flexible_box": _Guess(("contact", "single_axis"), FlexibleBoxModel(in_plane=None), _flexible_box),
    "kelvin_voigt": _Guess(("single_axis",), KelvinVoigt(k=1.0), _kelvin_voigt),
    "driven_body": _Guess(("driven_body",), DrivenBodyModel(m=1.0), _driven_body),
    "surface_contact": _Guess(("contact",), SurfaceContact(k=1.0, b=0.0), _surface_contact),
}
_USUAL = {"contact": "flexible_box", "single_axis": "kelvin_voigt", "driven_body": "driven_body"}
"""Kind of a recording -> the structure that it is of, unless somebody says otherwise."""


def _coefficients(causes: Array, effect: Array) -> list[float]:
    """Of least squares, none smaller than `_LEAST` of what alone would explain the effect."""
    found = np.linalg.lstsq(causes, effect, rcond=None)[0]
    least = _LEAST * rms(effect) / np.maximum(np.sqrt(np.mean(causes**2, axis=0)), 1e-300)
    return cast(list[float], np.where(np.abs(found) < least, np.copysign(least, found), found).tolist())
