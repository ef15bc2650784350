"""Two ends of a link that have met."""

from __future__ import annotations

import pytest
from link_samples import Pair


@pytest.fixture
def pair() -> Pair:
    made = Pair()
    made.connect()
    return made
