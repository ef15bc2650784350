"""Whether forces have the sign and the unit that the nominal model and the probe's work ask for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mmt_drake.diagnosis.alignment import NormalFit, likeness
from mmt_drake.diagnosis.result import Finding
from mmt_drake.diagnosis.smoother import Smoothed

Array = NDArray[np.float64]

_UNLIKE = 0.3
_RESISTS = 0.3


def sign_findings(
    smoothed: Smoothed, fit: NormalFit | None, nominal: Array | None, used: tuple[int, ...]
) -> list[Finding]:
    """Forces with the other sign: those that the probe exerts on the object.

    Pressed down, the force on the probe points up. A passive object takes work from the probe: force and velocity
    disagree in sign. The nominal model has to speak against the recording, too, for a delayed stiff object may
    return work.

    Args:
        smoothed: the recording.
        fit: of the normal force, if there was a touch.
        nominal: (n, k) what the nominal model answers, filtered; None where it cannot be simulated.
        used: outputs of the axes that count.
    """
    counts = smoothed.in_contact & (smoothed.weight > 0.0)
    if smoothed.kind == "driven_body" or not counts.any():
        return []
    if smoothed.kind == "contact":
        pressed = float(np.mean(smoothed.output[counts, 2]))
        noise = float(smoothed.output_noise[2])
        by_fit = fit is not None and fit.explained > 0.5 and fit.k < 0.0
        if pressed < -5.0 * noise and (by_fit or fit is None or np.mean(smoothed.output[counts, 2] < 0.0) > 0.9):
            text = (
                f"force_z is {pressed:.3g} N on average while the probe presses down, where it must be positive: the "
                "forces are those on the object, not on the probe; change their sign."
            )
            return [Finding("swapped_sign", "refuse", text, {"mean_force_z": pressed})]
    force = smoothed.output[counts][:, used]
    work = likeness(force, smoothed.input_rate[counts][:, used])
    against = nominal is None or likeness(force, nominal[counts][:, used]) < -_UNLIKE
    if work > _RESISTS and against:
        text = (
            f"The force pushes the way the probe moves (correlation {work:.2f}), so the object would do work on it: "
            "the forces are those on the object, not on the probe; change their sign."
        )
        return [Finding("swapped_sign", "refuse", text, {"correlation": work})]
    return []


@dataclass(frozen=True)
class _Unit:
    ratio: float
    within: float
    hint: str


_UNITS = (
    _Unit(1e3, 4.0, "are forces in mN, or positions in km?"),
    _Unit(1e-3, 4.0, "are positions in mm, or forces in kN?"),
    _Unit(1e6, 4.0, "are forces in uN?"),
    _Unit(1e-6, 4.0, "are positions in um?"),
    _Unit(1.0 / 9.80665e-3, 1.4, "are forces in gram-force?"),
    _Unit(1e-2, 1.4, "are positions in cm?"),
)
_IMPLAUSIBLE = 30.0


def unit_findings(smoothed: Smoothed, nominal: Array | None, used: tuple[int, ...]) -> list[Finding]:
    """A recording that is as many times stronger than the nominal model as one unit is greater than another."""
    if nominal is None or not smoothed.in_contact.any():
        return []
    counts = smoothed.in_contact[: len(nominal)]
    measured, simulated = smoothed.output[: len(nominal)][counts][:, used], nominal[counts][:, used]
    if smoothed.kind == "driven_body":
        measured, simulated = measured - measured.mean(axis=0), simulated - simulated.mean(axis=0)
    strength, expected = float(np.linalg.norm(measured)), float(np.linalg.norm(simulated))
    if expected == 0.0 or strength == 0.0 or not math.isfinite(expected):
        return []
    ratio = strength / expected
    if 1.0 / _IMPLAUSIBLE < ratio < _IMPLAUSIBLE:
        return []
    what = "output" if smoothed.kind == "driven_body" else "force"
    text = f"The recorded {what} is {ratio:.3g} times what the model answers to this motion"
    figures = {"ratio": ratio}
    for unit in _UNITS:
        if 1.0 / unit.within < ratio / unit.ratio < unit.within and abs(likeness(measured, simulated)) > _UNLIKE:
            hint = "is its unit that of the model?" if smoothed.kind == "driven_body" else unit.hint
            return [Finding("units", "refuse", f"{text}: {hint}", figures)]
    return [
        Finding("magnitude", "warn", f"{text}: does the model belong to this object, and are the units SI?", figures)
    ]
