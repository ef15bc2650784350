"""Fixtures that more than one folder of tests uses."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from chromium import Chromium, find_chromium

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


@pytest.fixture
def browser() -> Iterator[Chromium]:
    """A Chromium without a window; a test that asks for it is skipped where there is none."""
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium on the path (MMT_CHROMIUM names one)")
    with Chromium(program) as chromium:
        yield chromium


ALONE = (
    "hw/franka/test_franka_driver",
    "hw/franka/test_franka_faults",
    "hw/franka/test_franka_telerobot",
    "hw/test_hand_and_arm",
    "hw/test_sliders_and_arm",
    "hw/test_twins",
    "hw/realsense/test_setup3",
    "cli/test_run_setup3",
    "cli/test_run_hardware",
    "cli/test_run_two_sides",
    "diagrams/proof/test_faults",
)
"""Files of tests by the wall clock, which others beside them would disturb."""
STUDIES = (
    "notebooks/",
    "arms/test_arm_effects_recovered",
    *("cli/test_bench.py", "cli/test_diagnose_cluster", "cli/test_diagnose_delivers", "cli/test_experiment"),
    *("cli/test_next_motion", "diagnosis/test_on_surface", "diagnosis/test_station_diagnosis"),
    *("diagnosis/test_transmission_diagnosis", "diagnosis/test_stiffness_map", "diagnosis/test_tool_offset"),
    *("diagnosis/test_frame_misalignment", "estimation/test_retold"),
    *("diagrams/proof/", "hw/omega/test_lifted_by_hand"),
    "test_documented_commands",
)
"""Files of tests that run experiments, trials, benches, notebooks and whole diagnoses: half of all the time."""
FIRST = (
    *("systems/test_contract", "effects/test_effects_contract", "diagnosis/test_diagnose"),
    *("cli/test_diagnose_delivers", "notebooks/"),
)
"""What compiles most kernels, those of a station beside those of a fit; then the longest, for no core to wait for."""


def place(path: Path) -> str:
    """Of a file, below this folder."""
    return path.relative_to(ROOT / "tests").as_posix()


def kind(path: Path) -> str:
    """The marker of a file's tests; none: ''."""
    name = place(path)
    return "realtime" if name.startswith(ALONE) else "study" if name.startswith(STUDIES) else ""


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """With one of the Makefile's `-m`, a file of another kind is not even imported."""
    wanted = {"realtime": "realtime", "study": "study", "not realtime and not study": ""}.get(config.option.markexpr)
    if wanted is None or not collection_path.name.startswith("test_"):
        return None
    return True if kind(collection_path) != wanted else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put `FIRST` first, and mark each by its kind."""
    places = {item: place(item.path) for item in items}
    items.sort(key=lambda item: next((i for i, name in enumerate(FIRST) if places[item].startswith(name)), len(FIRST)))
    for item in items:
        if marker := kind(item.path):
            item.add_marker(marker)
