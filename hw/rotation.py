"""The rotation of a device's frame against the table's."""

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RollPitchYaw


def rotation_matrix(degrees: tuple[float, float, float]) -> NDArray[np.float64]:
    """(3, 3) R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch and yaw [deg]."""
    matrix: NDArray[np.float64] = RollPitchYaw(np.deg2rad(degrees)).ToRotationMatrix().matrix()
    return matrix
