"""Two ends of a link that have met."""

import pytest
from link_samples import Pair


@pytest.fixture(scope="session", autouse=True)
def _needs_cryptography() -> None:
    pytest.importorskip("cryptography", reason="the extra `link` is not installed")


@pytest.fixture
def pair() -> Pair:
    made = Pair()
    made.connect()
    return made
