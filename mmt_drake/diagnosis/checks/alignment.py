"""Check of the times of forces against those of the motion beside them."""

import math
from dataclasses import replace

import numpy as np

from mmt_drake.analysis.nrmse import rms
from mmt_drake.diagnosis.checks.finding import Finding
from mmt_drake.diagnosis.signals.clocks import near
from mmt_drake.diagnosis.signals.lags import LagFit, best_lag, products
from mmt_drake.diagnosis.signals.smoother import Smoothed
from mmt_drake.diagnosis.signals.touches import contact_of
from mmt_drake.numeric.arrays import Array, Flags
from mmt_drake.recording import Recording

_SEARCH_S = 0.6  # offsets that touches are asked for
_LATEST_S = 0.25  # an answer may be so late and still be a delay
_EARLY_TOUCH_S = 3e-3  # a force that comes so long before the touch that causes it is no physics
_EARLY_S = 0.02  # ... and without a touch to tell by
_RESOLUTION_S = 1.5e-3  # how far off zero recordings without any offset were seen: a touch rounds off the height
_SIGMAS = 3.0
_BETTER = 1.2  # times as much left with no offset as with it: one that explains no more is a damper, taken for one
_EXPLAINED = 0.9  # of the normal force, for the offset to be told
_WELL = 0.98  # of the variance: what a law explains so well as recorded is where it belongs
_MOSTLY, _SHARPER = 0.8, 7.0  # without a touch: explained at the offset, and how much more is left with none
_ALIKE, _UNLIKE = 0.8, 0.3
_RIVAL = 0.9
_LONGEST_LAG_S = 2.0
_SAME_PEAK_S = 0.25
_SCATTER = 0.5  # of how late a flag is, over all its changes: more is a surface that is elsewhere
_ENOUGH = 20_000  # samples that tell an offset
_SLOW = 0.1  # of the RMS speed: below it friction does not tell its direction


def normal_fit(smoothed: Smoothed) -> LagFit | None:
    """The normal contact and the clock offset from all touches together; None where there is no touch or release.

    F_z = -k z - b v_z, position and velocity cut off by contact and through the filter of the force; the coefficients
    are k and b, of these alone. Of all offsets to 0.6 s the one of least squares counts, the nearer to nothing of two:
    that one, and with the simplest of what else would pass for an offset left free: a spring and a damper that grow
    with the depth, what of the forces along x and y a sensor that is askew reads along z, and the inertia of what the
    sensor carries, in contact or not. An offset shows in both.
    What is explained is of the fit whose offset counts, where k and b alone explain the force; else of these alone.
    """
    if smoothed.kind != "contact" or len(smoothed.contact.changes) == 0 or not smoothed.in_contact.any():
        return None
    touching = smoothed.contact.share(smoothed.time, 1.0 / smoothed.rate_hz)
    height = np.column_stack([smoothed.input[:, 2], smoothed.input_rate[:, 2]])
    causes = smoothed.filter(-touching[:, np.newaxis] * height)
    growing = smoothed.filter(touching[:, np.newaxis] * height * height[:, :1])
    inertia = smoothed.filter(np.gradient(smoothed.input_rate[:, 2], 1.0 / smoothed.rate_hz))
    beside = np.column_stack([growing, smoothed.output[:, :2], inertia])
    beside = beside[:, np.any(beside != 0.0, axis=0)]
    how = _SEARCH_S, smoothed.rate_hz, smoothed.low_pass.band_hz, _recorded(smoothed)
    plain = best_lag(causes, smoothed.output[:, 2], *how)
    free = best_lag(np.column_stack([causes, beside]), smoothed.output[:, 2], *how)
    if plain is None or free is None:
        return plain
    freed = replace(plain, offset=free.offset, standard_error=free.standard_error)
    if plain.explained >= _EXPLAINED:  # then how much better it is with the offset goes by the fit that it is of
        freed = replace(freed, explained=free.explained, explained_unshifted=free.explained_unshifted)
    return min(plain, freed, key=lambda fit: abs(fit.offset))


def law_fit(smoothed: Smoothed) -> LagFit | None:
    """The answer of one axis, or of a driven body, by the simplest law of its kind, fitted with any offset to 2 s.

    One axis: F = -k x - b v about their means; the coefficients are k and b. A driven body, the law solved for its
    input: m a + b v + F_c sgn v + k x + constant; the coefficients are those, the sign rounded off at slow speed.
    None for a contact in three axes, whose touches tell more (`normal_fit`), and for an input that never changes.
    """
    some = slice(0, _ENOUGH)
    rate, band, counts = smoothed.rate_hz, smoothed.low_pass.band_hz, _recorded(smoothed)[some]
    if smoothed.kind == "single_axis":
        x, v, force = smoothed.input[some, 0], smoothed.input_rate[some, 0], smoothed.output[some, 0]
        causes = smoothed.filter(-np.column_stack([x - x.mean(), v]))
        return best_lag(causes, force - force.mean(), _LONGEST_LAG_S, rate, band, counts)
    if smoothed.kind != "driven_body" or np.ptp(smoothed.input[some, 0]) == 0.0:
        return None
    x = smoothed.output[some, 0]
    v = np.gradient(x, 1.0 / rate)
    a = np.gradient(v, 1.0 / rate)
    slow = _SLOW * rms(v)
    if slow == 0.0:
        return None
    terms = np.column_stack([a, v, smoothed.filter(np.tanh(v / slow)), x - x.mean(), np.ones(len(x))])
    drive = smoothed.filter(smoothed.input[some, 0])
    fit = best_lag(terms, drive - drive.mean(), _LONGEST_LAG_S, rate, band, counts)
    # The input is the cause here, and the output what may be late.
    return None if fit is None else replace(fit, offset=-fit.offset)


def _recorded(smoothed: Smoothed) -> Flags:
    """Samples (n,) whose filtered output knows nothing of gaps, where it is made up."""
    return ~near(smoothed.time, smoothed.clock.gaps, smoothed.low_pass.half_length_s)


def offset_findings(fit: LagFit | None, step: float) -> list[Finding]:
    """The offset of the clocks of force and position, where touches tell it.

    Args:
        fit: of the normal force.
        step: of the recording [s].
    """
    if fit is None or fit.explained < _EXPLAINED or fit.coefficients[0] <= 0.0:
        return []
    if fit.coefficients[1] < -_EARLY_TOUCH_S * fit.coefficients[0]:  # no contact pumps: the offset stands for a law
        return []
    figures = {"offset_s": fit.offset, "standard_error_s": fit.standard_error}
    said = f"{1e3 * abs(fit.offset):.2f} +- {1e3 * fit.standard_error:.2f} ms"
    if 1.0 - fit.explained_unshifted < _BETTER * (1.0 - fit.explained):
        text = f"Force and position share a clock: an offset of {said} would explain touches no better than none."
        return [Finding("offset", "note", text, figures)]
    unsure = _SIGMAS * fit.standard_error
    if fit.offset + unsure < -max(_EARLY_TOUCH_S, 2.0 * step) or fit.offset > _LATEST_S:
        way = "before" if fit.offset < 0.0 else "after"
        text = f"The force comes {said} {way} the motion that causes it: the two are misaligned; shift one of them."
        return [Finding("misaligned", "refuse", text, figures)]
    if abs(fit.offset) < max(_RESOLUTION_S, step, unsure):
        return [Finding("offset", "note", f"Force and position share a clock: touches agree to {said}.", figures)]
    way = "earlier" if fit.offset < 0.0 else "later"
    return [Finding("offset", "warn", f"At touches the force is {said} {way} than the position.", figures)]


def flag_findings(recording: Recording, smoothed: Smoothed) -> list[Finding]:
    """A recorded contact that goes by the force: later than the height's crossings of 0 by the same time at each.

    A surface that is elsewhere makes one of touch and release late and the other early.

    Args:
        recording: as read.
        smoothed: the same.
    """
    if smoothed.kind != "contact" or "in_contact" not in recording or "in_contact" in recording.derived:
        return []
    time, flags = recording.time, recording["in_contact"] != 0.0
    height = np.interp(time, smoothed.time, smoothed.input[:, 2])
    new = np.flatnonzero(flags[1:] != flags[:-1]) + 1
    changed = 0.5 * (time[new - 1] + time[new])
    lags = changed - contact_of(time, flags, height, _SEARCH_S).changes
    late = float(np.median(lags)) if len(new) > 1 else 0.0
    if min(lags, default=0.0) <= max(_EARLY_TOUCH_S, 2.0 * smoothed.clock.step) or np.ptp(lags) > _SCATTER * late:
        return []
    text = (
        f"in_contact changes {1e3 * late:.2g} ms after position_z crosses 0, at each of its {len(new)} changes: it "
        "goes by the force and not by the probe. Leave that column out, and contact is where position_z < 0."
    )
    return [Finding("late_flag", "warn", text, {"late_s": late})]


def law_findings(smoothed: Smoothed, fit: LagFit | None) -> list[Finding]:
    """An answer that the simplest law explains at another time, and several times worse as it was recorded.

    Physics that such a law leaves out moves its best offset by some hundredths of a second and hardly makes it better.

    Args:
        smoothed: the recording.
        fit: of its law.
    """
    if fit is None or fit.explained < _MOSTLY or -_EARLY_S <= fit.offset <= _LATEST_S:
        return []
    if fit.explained_unshifted > _WELL or 1.0 - fit.explained_unshifted < _SHARPER * (1.0 - fit.explained):
        return []
    answer, cause = ("output", "input") if smoothed.kind == "driven_body" else ("force", "motion")
    way = "before" if fit.offset < 0.0 else "after"
    text = (
        f"The {answer} comes {abs(fit.offset):.2f} s {way} the {cause} that causes it: the two are misaligned; shift "
        "one of them."
    )
    return [Finding("misaligned", "refuse", text, {"offset_s": fit.offset})]


def likeness(measured: Array, simulated: Array) -> float:
    """Correlation of two signals (n, k), their means not removed."""
    size = math.sqrt(float(np.sum(measured**2)) * float(np.sum(simulated**2)))
    return float(np.sum(measured * simulated)) / size if size > 0.0 else 0.0


def lag_findings(smoothed: Smoothed, nominal: Array | None, used: tuple[int, ...]) -> list[Finding]:
    """An output that is like the nominal model's, but at another time.

    Only where the two are unlike as recorded, much alike at one offset, and nowhere else nearly so: a periodic motion
    is like itself again a period later.
    """
    if nominal is None or smoothed.kind == "driven_body":
        return []
    measured, expected = smoothed.output[:, used], nominal[:, used]
    now = likeness(measured, expected)
    if now > _UNLIKE:
        return []
    scan = products(expected, measured, _LONGEST_LAG_S, smoothed.rate_hz, _recorded(smoothed))
    size = np.sqrt(scan.power * np.trace(scan.gram, axis1=1, axis2=2))
    alike = np.divide(np.trace(scan.cross, axis1=1, axis2=2), size, out=np.zeros_like(size), where=size > 0.0)
    best = int(np.argmax(alike))
    offset = float(scan.lags[best])
    apart = np.abs(scan.lags - offset) > _SAME_PEAK_S
    rival = float(alike[apart].max()) if apart.any() else 0.0
    if alike[best] < _ALIKE or rival > _RIVAL * alike[best]:
        return []
    if -_EARLY_S <= offset <= _LATEST_S:
        return []
    way = "before" if offset < 0.0 else "after"
    text = (
        f"The force looks like the model's {abs(offset):.2f} s {way} the motion (correlation {alike[best]:.2f}, "
        f"{now:.2f} as recorded): the two are misaligned; shift one of them."
    )
    return [Finding("misaligned", "refuse", text, {"offset_s": offset, "correlation": float(alike[best])})]
