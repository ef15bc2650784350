"""Fixtures that more than one folder of tests uses."""

import os
from pathlib import Path

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")  # no test opens a window

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


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The longest first, so that no core waits for them at the end; those by the wall clock are marked."""
    items.sort(key=lambda item: item.path.parent.name != "notebooks")
    for item in items:
        if item.path.relative_to(ROOT / "tests").as_posix().startswith(ALONE):
            item.add_marker("realtime")
