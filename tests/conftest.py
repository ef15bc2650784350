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
    *("arms/test_arm_cli", "arms/test_arm_effects_recovered", "arms/test_exciting_motion"),
    *("cli/test_bench.py", "cli/test_demo", "cli/test_diagnose", "cli/test_experiment", "cli/test_join"),
    "cli/test_next_motion",
    *("diagnosis/test_base", "diagnosis/test_blocks", "diagnosis/test_bootstrap", "diagnosis/test_confidence"),
    *("diagnosis/test_diagnose", "diagnosis/test_dilution", "diagnosis/test_first_model", "diagnosis/test_hidden"),
    *("diagnosis/test_frame_misalignment", "diagnosis/test_in_plane", "diagnosis/test_learn", "diagnosis/test_machine"),
    *("diagnosis/test_minima", "diagnosis/test_moments", "diagnosis/test_name", "diagnosis/test_normal_axis"),
    *("diagnosis/test_on_surface", "diagnosis/test_prescribe", "diagnosis/test_station_diagnosis"),
    *("diagnosis/test_stiffness_map", "diagnosis/test_tool_offset", "diagnosis/test_transmission_diagnosis"),
    *("diagrams/proof/", "diagrams/test_alike_objects", "diagrams/test_station_held_body"),
    *("diagrams/test_station_learning", "diagrams/test_two_sides"),
    *("estimation/test_force_lateness", "estimation/test_known_laws", "estimation/test_model_adequacy"),
    *("estimation/test_noise_of_the_motion", "estimation/test_other_searches", "estimation/test_retold"),
    "estimation/test_unsure_touches",
    *("hw/omega/test_lifted_by_hand", "learning/test_law_learner", "recording/test_long_recordings"),
    *("rendering/test_held_body", "rendering/test_laws", "test_documented_commands", "test_tutorials"),
)
"""Files of tests that run experiments, trials, benches, notebooks, whole fits and diagnoses: most of all the time. One
test among short ones is marked `study` where it stands."""
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
    of_the_file = kind(collection_path)
    has_one = wanted == "study" and of_the_file == "" and "mark.study" in collection_path.read_text()
    return True if of_the_file != wanted and not has_one else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put `FIRST` first, and mark each by its kind."""
    places = {item: place(item.path) for item in items}
    items.sort(key=lambda item: next((i for i, name in enumerate(FIRST) if places[item].startswith(name)), len(FIRST)))
    for item in items:
        if marker := kind(item.path):
            item.add_marker(marker)
