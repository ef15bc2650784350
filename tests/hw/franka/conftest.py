"""The emulated arm (`tests/hw/conftest.py`), one to be killed, and one with its driver."""

from collections.abc import Iterator

import pytest

from mmt_drake.diagrams.proof.faults.franka import FrankaRig
from mmt_drake.hw.franka.emulator import EmulatedFranka


@pytest.fixture
def mortal_franka(emulator: EmulatedFranka) -> Iterator[EmulatedFranka]:
    """One of its own, to be killed."""
    with EmulatedFranka() as mortal:
        yield mortal


@pytest.fixture
def rig(franka: EmulatedFranka) -> Iterator[FrankaRig]:
    rig = FrankaRig(franka)
    yield rig
    rig.driver.close()
