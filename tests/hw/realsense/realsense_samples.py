"""Depth images in closed form."""

from __future__ import annotations

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
