"""Fixtures that more than one folder of tests uses."""

import os
from pathlib import Path

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")  # no test opens a window
if "PYTEST_XDIST_WORKER" in os.environ:  # the processors are busy: more processes would only stand in each other's way
    os.environ.setdefault("MMT_JOBS", "1")

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def checkout() -> Path:
    """The folder that holds pyproject.toml."""
    return ROOT


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of public recordings; a test that asks for it is skipped where there is none."""
    folder = Path(os.environ.get("MMT_RECORDINGS", ROOT.parent / "shared" / "recordings"))
    if not folder.is_dir():
        pytest.skip(f"no public recordings at {folder} (MMT_RECORDINGS names the folder)")
    return folder


ALONE = (
    "hw/franka",
    "hw/test_",
    "hw/realsense/test_setup3",
    "cli/test_run_setup3",
    "cli/test_run_hardware",
    "cli/test_run_two_sides",
    "diagrams/test_faults",
)
"""Tests by the wall clock, which others beside them would disturb."""
FIRST = ("systems/test_contract", "effects/test_effects_contract", "notebooks/")
"""What compiles most kernels, for the processes of the notebooks to find; then the longest, for no core to wait for."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put `FIRST` first, and mark those by the wall clock."""
    places = {item: item.path.relative_to(ROOT / "tests").as_posix() for item in items}
    items.sort(key=lambda item: next((i for i, name in enumerate(FIRST) if places[item].startswith(name)), len(FIRST)))
    for item, place in places.items():
        if place.startswith(ALONE):
            item.add_marker("realtime")
