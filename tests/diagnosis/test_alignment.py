"""What is said of clocks by a fit whose figures are given."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_samples import Strokes, contact_recording
from trial_samples import changed

from mmt_drake.diagnosis.checks.alignment import flag_findings, normal_fit, offset_findings
from mmt_drake.diagnosis.signals.lags import LagFit
from mmt_drake.diagnosis.signals.smoother import smooth

STEP = 1e-3


def fitted(
    offset: float, explained: float = 0.999, unshifted: float = 0.9, k: float = 500.0, b: float = 60.0
) -> LagFit:
    """A fit of the normal force, known to 0.2 ms."""
    return LagFit(np.array([k, b]), offset, 2e-4, explained, np.array([k, b]), unshifted)


@pytest.mark.parametrize(
    ("fit", "code", "severity", "words"),
    [
        (fitted(0.0002), "offset", "note", "share a clock"),
        (fitted(0.02), "offset", "warn", "20.00 \\+- 0.20 ms later"),
        (fitted(-0.02), "misaligned", "refuse", "20.00 \\+- 0.20 ms before"),
        (fitted(0.4), "misaligned", "refuse", "after"),
        (fitted(-0.02, 0.95, 0.945), "offset", "note", "offset of 20.00 .* no better than none"),
    ],
    ids=["none", "late", "before its cause", "later than any delay", "explains no more"],
)
def test_an_offset_is_told_where_it_explains_more(fit: LagFit, code: str, severity: str, words: str) -> None:
    (found,) = offset_findings(fit, STEP)
    assert (found.code, found.severity) == (code, severity)
    assert re.search(words, found.text)


@pytest.mark.parametrize(
    "fit",
    [None, fitted(-0.02, explained=0.85), fitted(-0.02, k=-10.0), fitted(-0.08, b=-480.0)],
    ids=["no touch", "explains little", "no spring", "a damper that pumps"],
)
def test_nothing_is_said_where_the_offset_stands_for_something_else(fit: LagFit | None) -> None:
    assert offset_findings(fit, STEP) == []


def test_a_spring_that_hardens_and_relaxes_on_one_clock_is_not_called_late() -> None:
    recording, tau = contact_recording(), 0.1
    t = recording.time
    depth = np.maximum(-Strokes().z(t), 0.0)
    relaxed = np.zeros(len(t))
    for i in range(1, len(t)):
        relaxed[i] = relaxed[i - 1] + (t[i] - t[i - 1]) / tau * (depth[i] ** 3 - relaxed[i - 1])
    fit = normal_fit(smooth(changed(recording, force_z=1e8 * depth**3 - 8e7 * relaxed * (depth > 0.0))))
    assert fit is not None and fit.offset > 0.02, "two laws in one look late to a spring and a damper"
    assert offset_findings(fit, STEP) == []


def test_the_inertia_of_what_a_sensor_carries_is_not_called_early() -> None:
    recording = contact_recording()
    bounce = np.gradient(np.gradient(Strokes().z(recording.time), recording.time), recording.time)
    carried = changed(recording, force_z=recording["force_z"] - 0.4 * bounce)
    fit = normal_fit(smooth(carried))
    assert fit is not None and abs(fit.offset) < 2e-3
    assert all(finding.severity == "note" for finding in offset_findings(fit, STEP))


@pytest.mark.parametrize(
    ("late", "lower", "said"),
    [(0.014, 0.0, "14 ms after position_z crosses 0"), (0.0, 0.0, None), (0.002, 0.0, None), (0.0, 3e-4, None)],
    ids=["late with the force", "right", "late by two samples", "a surface that is elsewhere"],
)
def test_a_contact_that_is_recorded_late_is_told(late: float, lower: float, said: str | None) -> None:
    recording = contact_recording()
    height = Strokes().z(recording.time - late)
    flagged = changed(recording, in_contact=(height < -lower).astype(float))
    flagged = replace(flagged, derived=recording.derived - {"in_contact"})
    found = flag_findings(flagged, smooth(flagged))
    assert [finding.severity for finding in found] == (["warn"] if said else [])
    assert said is None or said in found[0].text


def test_a_contact_that_goes_by_the_height_is_never_late() -> None:
    recording = contact_recording()
    assert flag_findings(replace(recording, derived=recording.derived | {"in_contact"}), smooth(recording)) == []
