"""Fixtures of the diagnosis's tests."""

import pytest
from report_samples import evidence_with_friction

from mmt_drake.diagnosis.tell.evidence import Evidence


@pytest.fixture(scope="session")
def evidence() -> Evidence:
    """A body dragged with friction that the models lack, as a report has it."""
    return evidence_with_friction()
