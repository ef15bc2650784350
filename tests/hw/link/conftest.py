"""Two ends of a link that have met."""

import pytest
from link_samples import Pair


@pytest.fixture
def pair() -> Pair:
    made = Pair()
    made.connect()
    return made
