"""An arrow in the scene, which is drawn once and from then on only moved and stretched."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mmt_drake.viewer.shapes import cylinder
from mmt_drake.viewer.viewer import Viewer

Array = NDArray[np.float64]

_HEAD = 0.25  # share of the arrow's length
_SHORTEST = 1e-3  # [m]; what is shorter is not shown


class Arrow:
    """An arrow of any length and direction.

    Args:
        viewer: where it is drawn.
        path: in the scene tree.
        radius: of its shaft [m].
        colour: of all of it, `#RRGGBB`.
    """

    def __init__(self, viewer: Viewer, path: str, radius: float, colour: str) -> None:
        self._viewer, self._path = viewer, path
        shaft = 1.0 - _HEAD
        viewer.set_object(f"{path}/shaft", cylinder(radius, shaft, colour))
        viewer.set_transform(f"{path}/shaft", placed(0.0, 0.0, 0.5 * shaft))
        viewer.set_object(f"{path}/head", cylinder(2.5 * radius, _HEAD, colour, top=0.0))
        viewer.set_transform(f"{path}/head", placed(0.0, 0.0, 1.0 - 0.5 * _HEAD))
        self._shown = True
        self.show(np.zeros(3), np.zeros(3))

    def show(self, foot: Sequence[float] | Array, vector: Sequence[float] | Array) -> None:
        """Have it stand at `foot` (3) and reach to `foot + vector` (3) [m], table frame.

        It is hidden while it is shorter than 1 mm, or a number is not finite.
        """
        matrix = stretched(foot, vector)
        if (matrix is not None) != self._shown:
            self._shown = matrix is not None
            self._viewer.set_property(self._path, "visible", self._shown)
        if matrix is not None:
            self._viewer.set_transform(self._path, matrix)


def placed(x: float, y: float, z: float) -> Array:
    """The (4, 4) matrix that moves by (x, y, z) [m]."""
    return np.array([[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def stretched(foot: Sequence[float] | Array, vector: Sequence[float] | Array) -> Array | None:
    """The (4, 4) matrix that takes the unit vector along z, at the origin, to `vector` (3) at `foot` (3).

    Across its axis nothing is stretched. None where the length is below 1 mm or anything is not finite.
    """
    x, y, z = (float(value) for value in vector)
    px, py, pz = (float(value) for value in foot)
    length = math.sqrt(x * x + y * y + z * z)
    if not (length >= _SHORTEST and math.isfinite(length + px + py + pz)):
        return None
    a, b, c = x / length, y / length, z / length
    # An orthonormal frame about (a, b, c) without a branch at the pole: Duff et al., JCGT 6(1), 2017.
    sign = math.copysign(1.0, c)
    p = -1.0 / (sign + c)
    q = a * b * p
    return np.array(
        [
            [1.0 + sign * a * a * p, q, x, px],
            [sign * q, sign + b * b * p, y, py],
            [-sign * a, -b, z, pz],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
