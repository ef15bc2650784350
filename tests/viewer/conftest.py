"""Fixtures of the viewer's tests."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from pydrake.geometry import Meshcat, MeshcatParams


@pytest.fixture
def meshcat() -> Iterator[Meshcat]:
    """A Meshcat of this machine's own."""
    yield Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
