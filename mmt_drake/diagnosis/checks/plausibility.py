"""Check that forces have the sign and the unit that the nominal model and the probe's work ask for."""

import math

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.checks.alignment import likeness
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.signals.lags import LagFit
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.model.driven_model import DrivenBodyModel
from mmt_drake.model.parameters import FlexibleBoxModel
from mmt_drake.model_files import Model
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import AXES

_UNLIKE = 0.3
_RESISTS = 0.3
_MIRRORED = 0.8
_IN_STEP_S = 0.05  # a periodic force that is late by half a period looks mirrored, too
_LAWFUL = 0.8  # share of the power that a law explains, for the signs of its coefficients to count
_OTHER_SIDE = 3.0  # times stronger than on the side where contact should be

_ON_THE_OBJECT = "the forces are those on the object, not on the probe; change their sign (--map force=-COLUMN)."


def sign_findings(
    smoothed: Smoothed, fit: LagFit | None, law: LagFit | None, nominal: Array | None, used: tuple[int, ...]
) -> list[Finding]:
    """Forces with the other sign, those that the probe exerts on the object; heights that count downwards.

    Pressed down, the force on the probe points up. A passive object takes work from the probe: force and velocity
    disagree in sign. The nominal model has to speak against the recording, too, for a delayed stiff object may
    return work.

    Args:
        smoothed: the recording.
        fit: of the normal force, if there was a touch.
        law: of one axis (`alignment.law_fit`).
        nominal: (n, k) what the nominal model answers, filtered; None where it cannot be simulated.
        used: outputs of the axes that count.
    """
    counts = smoothed.in_contact & (smoothed.weight > 0.0)
    if smoothed.kind == "driven_body" or not counts.any():
        return []
    if smoothed.kind == "contact":
        found = _downward(smoothed) or _pressed(smoothed, counts, fit)
        if found is not None:
            return [found]
    in_step = fit is None or abs(fit.offset) < _IN_STEP_S
    axes = (_pushing(smoothed, counts, law, nominal, axis, in_step) for axis in used)
    return [finding for finding in axes if finding is not None]


def _pushing(
    smoothed: Smoothed, counts: Flags, law: LagFit | None, nominal: Array | None, axis: int, in_step: bool
) -> Finding | None:
    """A force along the motion with the other sign, by its law, its likeness to the model's, or the work it does."""
    name = f"force_{AXES[axis]}" if smoothed.kind == "contact" else "force"
    force, rate = smoothed.output[counts][:, [axis]], smoothed.input_rate[counts][:, [axis]]
    agrees = 0.0 if nominal is None else likeness(force, nominal[counts][:, [axis]])
    if law is not None and law.explained_unshifted > _LAWFUL and (law.unshifted < 0.0).all() and agrees < -_UNLIKE:
        k, b = map(float, law.unshifted)
        text = f"{name} would be that of a spring of {k:.3g} N/m and a damper of {b:.3g} N s/m: {_ON_THE_OBJECT}"
        return Finding("swapped_sign", "refuse", text, {"k": k, "b": b})
    if agrees < -_MIRRORED and in_step:
        text = f"{name} is the model's with the other sign (correlation {agrees:.2f}): {_ON_THE_OBJECT}"
        return Finding("swapped_sign", "refuse", text, {"correlation": agrees})
    work = likeness(force, rate)
    if work > _RESISTS and (nominal is None or agrees < -_UNLIKE):
        text = (
            f"{name} pushes the way the probe moves (correlation {work:.2f}), so the object would do work on it: "
            f"{_ON_THE_OBJECT}"
        )
        return Finding("swapped_sign", "refuse", text, {"correlation": work})
    return None


def _pressed(smoothed: Smoothed, counts: Flags, fit: LagFit | None) -> Finding | None:
    """Normal forces with the other sign."""
    normal = smoothed.output[counts, 2]
    pressed = float(np.mean(normal))
    by_fit = fit is not None and fit.explained > 0.5 and fit.coefficients[0] < 0.0
    if pressed >= -5.0 * float(smoothed.output_noise[2]):
        return None
    if not (by_fit or fit is None or np.mean(normal < 0.0) > 0.9):
        return None
    text = (
        f"force_z is {pressed:.3g} N on average while the probe presses down, where it must be positive: "
        f"{_ON_THE_OBJECT}"
    )
    return Finding("swapped_sign", "refuse", text, {"mean_force_z": pressed})


def _downward(smoothed: Smoothed) -> Finding | None:
    """Heights with the other sign: the normal force grows with z, and the more so above the surface."""
    z, force, rated = smoothed.input[:, 2], smoothed.output[:, 2], smoothed.weight > 0.0
    above, below = rated & (z > 0.0), rated & (z < 0.0)
    noise = float(smoothed.output_noise[2])
    strong = rms(force[above])
    if strong < 5.0 * noise or strong < _OTHER_SIDE * rms(force[below]) or likeness(force[above], z[above]) < _LAWFUL:
        return None
    text = (
        f"force_z is {strong:.3g} N RMS above the surface and grows with z, where the probe touches nothing: does z "
        "point down, or does it not count from the surface? Contact is z < 0."
    )
    return Finding("swapped_sign", "refuse", text, {"rms_force_z": strong})


def drive_findings(model: Model, law: LagFit | None, nominal: Array | None, output: Array) -> list[Finding]:
    """A driven body whose input has the other sign: it accelerates, and has friction, against it.

    Args:
        model: nominal; of its gain the sign counts.
        law: of the body (`alignment.law_fit`).
        nominal: (n, 1) what the nominal model answers; None where it cannot be simulated.
        output: (m, 1) measured, m >= n.
    """
    if not isinstance(model, DrivenBodyModel) or law is None or nominal is None or law.explained_unshifted < _LAWFUL:
        return []
    moving = math.copysign(1.0, model.gain) * law.unshifted[:3]
    # Rates, for a model that nothing holds may drift either way.
    agrees = likeness(np.diff(output[: len(nominal)], axis=0), np.diff(nominal, axis=0))
    if (moving >= 0.0).any() or agrees > -_MIRRORED:
        return []
    text = (
        "The output accelerates against the input, and goes the other way than the model's (correlation "
        f"{agrees:.2f}): one of the two has the other sign; change it."
    )
    return [Finding("swapped_sign", "refuse", text, {"correlation": agrees})]


# Of wrong units: the ratio of the recorded force to the true one, the factor by which wrong parameters may change that,
# and what to ask.
_UNITS = (
    (1e3, 4.0, "are forces in mN, or positions in km?"),
    (1e-3, 4.0, "are positions in mm, or forces in kN?"),
    (1e6, 4.0, "are forces in uN?"),
    (1e-6, 4.0, "are positions in um?"),
    (1.0 / 9.80665e-3, 1.4, "are forces in gram-force?"),
    (1e-2, 1.4, "are positions in cm?"),
    (1.0 / 9.80665, 1.15, "are forces in kilogram-force, or is the object another one?"),
    (1.0 / 4.4482216, 1.15, "are forces in pound-force, or is the object another one?"),
)
_IMPLAUSIBLE = 30.0  # times the model's answer, whatever it looks like
_ANOTHER_OBJECT = 12.0  # ... if it looks alike: a crude model may be ten times off
_ALIKE = 0.9


def unit_findings(
    smoothed: Smoothed, model: Model, nominal: Array | None, used: tuple[int, ...], fit: LagFit | None
) -> list[Finding]:
    """A recording that is as many times stronger than the nominal model as one unit is greater than another.

    A small factor is that of a unit only where the normal axis has the same one.

    Args:
        smoothed: the recording.
        model: nominal.
        nominal: (n, k) what it answers, filtered; None where it cannot be simulated.
        used: outputs of the axes that count.
        fit: of the normal force, if there was a touch.
    """
    if nominal is None or not smoothed.in_contact.any():
        return []
    driven = smoothed.kind == "driven_body"
    counts = smoothed.in_contact[: len(nominal)]
    measured, simulated = smoothed.output[: len(nominal)][counts][:, used], nominal[counts][:, used]
    if smoothed.kind != "contact":  # where zero lies is a matter of convention
        measured, simulated = measured - measured.mean(axis=0), simulated - simulated.mean(axis=0)
    strength, expected = float(np.linalg.norm(measured)), float(np.linalg.norm(simulated))
    if expected == 0.0 or strength == 0.0 or not math.isfinite(expected):
        return []
    ratio, alike = strength / expected, abs(likeness(measured, simulated))
    implausible = not 1.0 / _IMPLAUSIBLE < ratio < _IMPLAUSIBLE
    # What is driven runs away from a model that lacks some friction, and yet looks alike.
    another = alike > _ALIKE and (implausible if driven else not 1.0 / _ANOTHER_OBJECT < ratio < _ANOTHER_OBJECT)
    shared = alike > _ALIKE and _close(ratio, _normal_ratio(model, fit), 1.25)
    if not (implausible or another or shared):
        return []
    figures = {"ratio": ratio}
    if driven and ratio > _IMPLAUSIBLE and np.ptp(smoothed.input[:, 0]) == 0.0:
        text = f"The input reads {smoothed.input[0, 0]:g} throughout while the output moves: is the input connected?"
        return [Finding("magnitude", "refuse", text, figures)]
    text = f"The recorded {'output' if driven else 'force'} is {ratio:.3g} times what the model answers to this motion"
    for of_unit, within, question in _UNITS:
        if driven and 1.0 / _IMPLAUSIBLE < of_unit < _IMPLAUSIBLE:
            continue
        if _close(ratio, of_unit, within) and alike > _UNLIKE:
            hint = "is its unit that of the model?" if driven else question
            # What nothing holds runs away from its body if it is a little off: a lift by its weight.
            runs_away = isinstance(model, DrivenBodyModel) and model.k == 0.0 and ratio < 1.0
            return [Finding("units", "warn" if runs_away else "refuse", f"{text}: {hint}", figures)]
    if not (implausible or another):
        return []
    text += ": does the model belong to this object, and are the units SI?"
    # What is driven may run away from its model, so that a ratio alone proves nothing.
    return [Finding("magnitude", "warn" if driven and not another else "refuse", text, figures)]


def _close(ratio: float, to: float, within: float) -> bool:
    return to > 0.0 and 1.0 / within < ratio / to < within


def _normal_ratio(model: Model, fit: LagFit | None) -> float:
    """Stiffness of the normal axis over the model's; 0 where it is not known."""
    if fit is None or not isinstance(model, FlexibleBoxModel) or model.normal.k <= 0.0 or fit.explained < _ALIKE:
        return 0.0
    return max(float(fit.coefficients[0]) / model.normal.k, 0.0)
