"""Emulated devices, one a process: a library that the real bindings load, an arm behind its own protocol."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from mmt_drake.errors import MissingDependency
from mmt_drake.hw.franka.emulator import EmulatedFranka
from mmt_drake.hw.franka.sdk import load_franky
from mmt_drake.hw.omega.emulator import EmulatedOmega, load_emulated

sys.path.append(str(Path(__file__).resolve().parents[1] / "systems"))  # the contract test's helpers


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The emulator's library, which the bindings of this process have loaded."""
    try:
        return load_emulated(tmp_path_factory.mktemp("sdk"))
    except MissingDependency as error:
        pytest.skip(str(error))


@pytest.fixture
def omega(library: Path) -> EmulatedOmega:
    """The first emulated device, fresh."""
    return EmulatedOmega(library, 0)


@pytest.fixture(scope="session")
def emulator() -> Iterator[EmulatedFranka]:
    try:
        load_franky()
        emulated = EmulatedFranka()
    except MissingDependency as error:
        pytest.skip(str(error))
    with emulated:
        yield emulated


@pytest.fixture
def franka(emulator: EmulatedFranka) -> EmulatedFranka:
    """The emulated arm, whole, where it began."""
    emulator.reset()
    return emulator
