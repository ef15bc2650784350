"""What is missing is told in one line, with where to get it."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
from mmt_drake.errors import MissingDependency
from mmt_drake.hw.omega.operator import OmegaOperator
try:
    OmegaOperator()
except MissingDependency as error:
    print(error)
"""

OLD = """
#include <stddef.h>
void dhdGetSDKVersion(int *a, int *b, int *c, int *d) { *a = 3; *b = 9; *c = *d = 0; }
"""


WITHOUT_BINDINGS = """
import importlib.util
real = importlib.util.find_spec
importlib.util.find_spec = lambda name, *more: None if name == 'forcedimension_core' else real(name, *more)
"""


def told(checkout: Path, before: str = "", **environ: str) -> tuple[str, str]:
    """What a program that asks for a device says on both streams."""
    path = os.pathsep.join([str(checkout), os.environ.get("PYTHONPATH", "")])
    environ = {**os.environ, "PYTHONPATH": path, "HOME": str(checkout / "nobody"), **environ}
    done = subprocess.run(
        [sys.executable, "-c", before + PROGRAM], env=environ, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip(), done.stderr


def test_without_the_bindings_the_extra_is_named(checkout: Path) -> None:
    line, noise = told(checkout, WITHOUT_BINDINGS)
    assert line.startswith("omega: Python package forcedimension-core not found")
    assert "pip install 'mmt_drake[omega]'" in line and "\n" not in line and not noise


bindings = pytest.mark.skipif(
    importlib.util.find_spec("forcedimension_core") is None, reason="forcedimension-core is not installed"
)


@bindings
def test_without_the_vendors_library_its_address_is_named(checkout: Path, tmp_path: Path) -> None:
    line, noise = told(checkout, FDSDK=str(tmp_path))
    assert line.startswith("omega: Force Dimension SDK 3.16 or newer not found (Could not find libdrd")
    assert "forcedimension.com" in line and "FDSDK" in line and "\n" not in line and not noise


@bindings
def test_a_library_that_is_too_old_is_told_as_that(checkout: Path, tmp_path: Path, library: Path) -> None:
    folder = tmp_path / "lib" / "release" / library.parent.name
    folder.mkdir(parents=True)
    (tmp_path / "old.c").write_text(OLD)
    subprocess.run(
        ["cc", "-shared", "-fPIC", str(tmp_path / "old.c"), "-o", str(folder / library.name)], check=True, timeout=60
    )
    line, noise = told(checkout, FDSDK=str(tmp_path))
    assert "Invalid version. v3.9.0" in line and not noise


LIVE = """
import time
from mmt_drake.hw.omega.device import OmegaDevice
from mmt_drake.hw.omega.settings import OmegaSettings
device = OmegaDevice(OmegaSettings(device=1, watchdog=None))
fault, seen, start = device.start(), [], time.monotonic()
while time.monotonic() < start + 0.4:
    fault = device.read() or device.set_force((0.0, 0.0, 0.0)) or fault
    seen.append(device.reading[0])
    time.sleep(1e-3)
print(device.name, max(seen) - min(seen), fault)
device.close()
"""


def test_a_program_that_only_has_the_librarys_address_finds_a_hand_that_moves(checkout: Path, library: Path) -> None:
    path = os.pathsep.join([str(checkout), os.environ.get("PYTHONPATH", "")])
    environ = {**os.environ, "PYTHONPATH": path, "FDSDK": str(library.parents[3])}
    environ["EMULATED_OMEGA"] = "swing_x=0.03 swing_hz=3.0 hand_stiffness=2000.0 hand_damping=40.0"
    done = subprocess.run(
        [sys.executable, "-c", LIVE], env=environ, capture_output=True, text=True, check=True, timeout=120
    )
    *name, moved, fault = done.stdout.split()
    assert name == ["emulated", "omega.7"] and float(moved) > 0.02 and float(fault) == 0.0
