"""A scene and a camera that more than one file of tests looks through."""

import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from realsense_samples import record
from scipy.spatial.transform import Rotation

from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.emulator import SoftwareCamera, software_camera
from mmt_drake.hw.realsense.extrinsics import Extrinsics


@pytest.fixture(scope="session")
def small_camera() -> Intrinsics:
    return Intrinsics(160, 120, 150.0, 150.0, 79.5, 59.5)


@pytest.fixture(scope="session")
def tilted() -> Extrinsics:
    """25 deg from straight down, rolled and turned a little, 0.4 m above the table frame's origin."""
    turned = Rotation.from_euler("ZX", [20.0, 180.0 + 25.0], degrees=True)
    away = turned.as_matrix()[:, 2]
    return Extrinsics.from_matrix(turned.as_matrix(), -away * 0.4 / math.cos(math.radians(25.0)))


@pytest.fixture(scope="session")
def realsense() -> ModuleType:
    return pytest.importorskip("pyrealsense2", reason="the extra `realsense` is not installed")


@pytest.fixture
def software(realsense: ModuleType, small_camera: Intrinsics) -> SoftwareCamera:
    return software_camera(small_camera)


@pytest.fixture
def recorded(software: SoftwareCamera, tmp_path: Path) -> Path:
    """A recording of 12 frames; frame k shows k + 1000 units everywhere."""
    return record(software, tmp_path / "table.db3", [np.full((120, 160), 1000 + k, np.uint16) for k in range(12)])
