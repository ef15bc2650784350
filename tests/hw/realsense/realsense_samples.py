"""Depth images in closed form, recordings of them, and a camera that shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from hw.realsense.depth import Intrinsics
from hw.realsense.extrinsics import Extrinsics

UNIT = 1e-4  # [m]


def plane_depth(camera: Intrinsics, where: Extrinsics, height: float = 0.0) -> np.ndarray:
    """(height, width) depth [m] of the plane z = height, from the ray equation."""
    ahead = camera.rays() @ where.rotation().T
    return (height - where.position[2]) / ahead[..., 2]


def told(depth: np.ndarray, unit: float = UNIT) -> np.ndarray:
    return np.round(depth / unit).astype(np.uint16)


def record(software: Any, path: Path, images: Sequence[np.ndarray]) -> Path:
    """What librealsense records of depth images, (height, width) in units, that a software device shows."""
    recorder = software.sdk.recorder(str(path), software.device)
    sensor, queue = recorder.query_sensors()[0], software.sdk.frame_queue(20)
    sensor.open(sensor.get_stream_profiles()[0])
    sensor.start(queue)
    for image in images:
        software.show(image)
        assert queue.wait_for_frame(1000)
    sensor.stop()
    sensor.close()
    return path


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


def software_camera(sdk: ModuleType, seen: Intrinsics) -> SoftwareCamera:
    """One that sees as these intrinsics say."""
    device = sdk.software_device()
    sensor = device.add_sensor("Depth")
    i = sdk.intrinsics()
    i.width, i.height, i.model = seen.width, seen.height, sdk.distortion.none
    i.fx, i.fy, i.ppx, i.ppy = seen.fx, seen.fy, seen.cx, seen.cy
    i.coeffs = [0.0] * 5
    stream = sdk.video_stream()
    stream.type, stream.index, stream.uid, stream.fmt = sdk.stream.depth, 0, 1, sdk.format.z16
    stream.width, stream.height, stream.fps, stream.bpp, stream.intrinsics = i.width, i.height, 30, 2, i
    profile = sensor.add_video_stream(stream)
    sensor.add_read_only_option(sdk.option.depth_units, UNIT)
    return SoftwareCamera(sdk, device, sensor, profile)
