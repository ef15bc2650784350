"""Depth images in closed form, and recordings of them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mmt_drake.hw.realsense.depth import Intrinsics
from mmt_drake.hw.realsense.emulator import UNIT
from mmt_drake.hw.realsense.extrinsics import Extrinsics


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
