"""What is said of clocks by a fit whose figures are given."""

import re

import numpy as np
import pytest
from diagnosis_samples import Strokes, contact_recording
from trial_samples import changed

from mmt_drake.diagnosis.checks.alignment import normal_fit, offset_findings
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
        (fitted(-0.02, 0.95, 0.945), "offset", "note", "as well as with 20.00"),
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
