"""The emulated device: a library compiled once a session, which the real bindings load in place of the vendor's."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from hw.omega.emulator import EmulatedOmega, load_emulated
from mmt_drake.errors import MissingDependency

sys.path.append(str(Path(__file__).resolve().parents[2] / "systems"))


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


@pytest.fixture
def second_omega(library: Path) -> EmulatedOmega:
    """The second one."""
    return EmulatedOmega(library, 1)
