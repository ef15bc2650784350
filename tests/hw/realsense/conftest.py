"""A scene and a camera that more than one file of tests looks through."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from realsense_samples import UNIT, record
from scipy.spatial.transform import Rotation

from hw.realsense.depth import Intrinsics
from hw.realsense.extrinsics import Extrinsics


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


@dataclass
class SoftwareCamera:
    """librealsense's software device with one depth stream, fed by the test."""

    sdk: ModuleType
    device: Any
    sensor: Any
    profile: Any
    unit: float = UNIT
    number: int = 0

    def show(self, depth: np.ndarray) -> None:
        frame = self.sdk.software_video_frame()
        frame.stride, frame.bpp = depth.shape[1] * 2, 2
        frame.timestamp, frame.domain = 1000.0 + self.number * 1e3 / 30.0, self.sdk.timestamp_domain.hardware_clock
        self.number += 1
        frame.frame_number, frame.depth_units = self.number, self.unit
        frame.profile, frame.pixels = self.profile.as_video_stream_profile(), np.ascontiguousarray(depth)
        self.sensor.on_video_frame(frame)


@pytest.fixture
def software(realsense: ModuleType, small_camera: Intrinsics) -> SoftwareCamera:
    device = realsense.software_device()
    sensor = device.add_sensor("Depth")
    i = realsense.intrinsics()
    i.width, i.height, i.model = small_camera.width, small_camera.height, realsense.distortion.none
    i.fx, i.fy, i.ppx, i.ppy = small_camera.fx, small_camera.fy, small_camera.cx, small_camera.cy
    i.coeffs = [0.0] * 5
    stream = realsense.video_stream()
    stream.type, stream.index, stream.uid, stream.fmt = realsense.stream.depth, 0, 1, realsense.format.z16
    stream.width, stream.height, stream.fps, stream.bpp, stream.intrinsics = i.width, i.height, 30, 2, i
    profile = sensor.add_video_stream(stream)
    sensor.add_read_only_option(realsense.option.depth_units, UNIT)
    return SoftwareCamera(realsense, device, sensor, profile)


@pytest.fixture
def recorded(software: SoftwareCamera, tmp_path: Path) -> Path:
    """A recording of 12 frames; frame k shows k + 1000 units everywhere."""
    return record(software, tmp_path / "table.db3", [np.full((120, 160), 1000 + k, np.uint16) for k in range(12)])
