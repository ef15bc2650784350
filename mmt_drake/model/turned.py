"""A force sensor that is mounted askew: how the frame of forces is turned against that of positions.

With R the rotation from the force frame to the position frame, the sensor reads R^T F of a force F. R turns about x by
rx, then about y by ry, then about z by rz, the axes those of the position frame: R = Rz(rz) Ry(ry) Rx(rx) (Craig 2005,
Introduction to Robotics, section 2.8: X-Y-Z fixed angles).
"""

import numpy as np
from numba import njit

from mmt_drake.numeric.arrays import Array

TURN_SIZE = 9
"""Of a rotation in a kernel vector: its rows one after the other."""


def rotation(rx: float, ry: float, rz: float) -> Array:
    """(9,) the rows of R for angles about x, y and z [rad]."""
    (cx, cy, cz), (sx, sy, sz) = np.cos([rx, ry, rz]), np.sin([rx, ry, rz])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return (about_z @ about_y @ about_x).ravel()


@njit(error_model="numpy", forceinline=True)
def in_force_frame(p: Array, at: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """R^T F of a force [N], R standing at `at` in the kernel vector p."""
    return (
        p[at] * x + p[at + 3] * y + p[at + 6] * z,
        p[at + 1] * x + p[at + 4] * y + p[at + 7] * z,
        p[at + 2] * x + p[at + 5] * y + p[at + 8] * z,
    )
