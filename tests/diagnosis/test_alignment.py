"""What is said of clocks by a fit whose figures are given."""

import re

import numpy as np
import pytest

from mmt_drake.diagnosis.checks.alignment import offset_findings
from mmt_drake.diagnosis.signals.lags import LagFit

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
