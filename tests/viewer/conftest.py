"""Fixtures of the viewer's tests."""

from collections.abc import Iterator

import pytest

from mmt_drake.viewer.charts import page
from mmt_drake.viewer.viewer import Viewer


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    """A viewer of this test's own."""
    with Viewer(page()) as opened:
        yield opened
