"""The emulated arm: one process for all tests, which speaks the robot's protocol on loopback."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from hw.franka.emulator import EmulatedFranka
from hw.franka.sdk import load_franky
from hw.franka.trial.rig import Rig
from mmt_drake.errors import MissingDependency


def _emulated() -> EmulatedFranka:
    try:
        load_franky()
        return EmulatedFranka()
    except MissingDependency as error:
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def emulator() -> Iterator[EmulatedFranka]:
    with _emulated() as franka:
        yield franka


@pytest.fixture
def franka(emulator: EmulatedFranka) -> EmulatedFranka:
    """The emulated arm, whole, where it began."""
    emulator.reset()
    return emulator


@pytest.fixture
def mortal_franka() -> Iterator[EmulatedFranka]:
    """One of its own, to be killed."""
    with _emulated() as franka:
        yield franka


@pytest.fixture
def rig(franka: EmulatedFranka) -> Iterator[Rig]:
    rig = Rig(franka)
    yield rig
    rig.driver.close()
