"""Fixtures of the diagnosis's tests."""

import pytest
from diagnosis_samples import contact_recording
from report_samples import evidence_with_friction

from mmt_drake.diagnosis.tell.evidence import Evidence
from mmt_drake.recording import Recording


@pytest.fixture(scope="session")
def evidence() -> Evidence:
    """A body dragged with friction that the models lack, as a report has it."""
    return evidence_with_friction()


@pytest.fixture(scope="session")
def strokes() -> Recording:
    """A known object under strokes."""
    return contact_recording()
