"""The emulated device (`tests/hw/conftest.py`), and a second one."""

from pathlib import Path

import pytest

from mmt_drake.hw.omega.emulator import EmulatedOmega


@pytest.fixture
def second_omega(library: Path) -> EmulatedOmega:
    """The second one."""
    return EmulatedOmega(library, 1)
